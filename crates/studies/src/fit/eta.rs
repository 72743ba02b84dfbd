//! Estimates of eta for every participant and for all, from the steps at which they switched.
//!
//! An episode gives the set of eta that switch at that step, or never (bounded from below only). In the
//! model, a participant's eta is constant and lies in the intersection of all sets. If any participant's sets
//! have an empty intersection, eta is taken to scatter log-normally from episode to episode, for every
//! participant with several episodes. All participants are draws from one log-normal distribution. Each draw
//! is known up to the intersection of its episodes or, where eta scatters, up to the remaining uncertainty
//! given the common scatter.

use super::Switch;
use super::lognormal::{self, LogNormal, NoInterval};
use super::set::{Set, hull, intersection};
use serde::Serialize;
use std::collections::BTreeMap;

/// The number of participants who switched, besides others who did not, up to which the interval of the median
/// is wider than it need be.
const FEW_BOUNDED: usize = 4;

/// A participant's eta.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Eta {
    /// The participant.
    pub participant: String,
    /// Number of episodes.
    pub episodes: usize,
    /// Number of episodes with a switch.
    pub switches: usize,
    /// Number of episodes with a switch that no eta explains, because there was no discomfort yet. They are
    /// left out.
    pub unexplained: usize,
    /// The kind of evidence.
    pub evidence: Evidence,
    /// The estimate; `None` without an upper bound.
    pub eta: Option<f64>,
    /// The interval; `None` if the episodes do not determine it. The upper end is infinite (in JSON null) for
    /// a participant who never switched.
    pub interval: Option<[f64; 2]>,
    /// The reason for the missing interval, where eta scatters.
    pub no_interval: Option<NoInterval>,
    /// Standard deviation of ln(eta) between episodes that contradict each other.
    pub log_scatter: Option<f64>,
    /// The eta that agree with each informative episode.
    pub bounds: Vec<Set>,
}

/// The kind of evidence for a participant's eta.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evidence {
    /// All episodes agree: eta lies in the intersection of their sets.
    Bounded,
    /// The participant never switched: eta has a lower bound only.
    Censored,
    /// eta scatters between episodes: a median with a 95 % interval.
    Scattered,
    /// No episode is informative.
    Nothing,
}

impl Evidence {
    /// Name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bounded => "bounded",
            Self::Censored => "censored",
            Self::Scattered => "scattered",
            Self::Nothing => "nothing",
        }
    }
}

/// The fit of eta.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EtaFit {
    /// Participants in the order of the file.
    pub participants: Vec<Eta>,
    /// The distribution over all participants; `None` if they do not determine it.
    pub overall: Option<LogNormal>,
    /// The 95 % interval of its median; `None` if the participants do not determine it.
    pub median_interval: Option<[f64; 2]>,
    /// The reason for the missing interval.
    pub no_interval: Option<NoInterval>,
    /// Whether the interval rests on so few participants who switched that it contains the median more often
    /// than in 95 % of the studies (`book/src/results.md`, "Coverage of the fits").
    pub is_cautious: bool,
    /// Whether any participant's episodes contradict each other. eta is then not taken to be constant between
    /// episodes.
    pub is_scattered: bool,
    /// Lines of switches that no eta explains.
    pub unexplained_lines: Vec<u64>,
}

/// Fits eta to all episodes.
pub fn fit_eta(switches: &[Switch]) -> EtaFit {
    let (mut names, mut episodes) = (Vec::new(), Vec::<Vec<&Switch>>::new());
    let mut known: BTreeMap<&str, usize> = BTreeMap::new();
    for switch in switches {
        let participant = *known.entry(&switch.participant).or_insert_with(|| {
            names.push(switch.participant.as_str());
            episodes.push(Vec::new());
            episodes.len() - 1
        });
        episodes[participant].push(switch);
    }
    let is_scattered = episodes.iter().any(|own| {
        let sets = informative_sets(own);
        !sets.is_empty() && intersection(&sets).is_empty()
    });
    let participants: Vec<Eta> =
        names.into_iter().zip(&episodes).map(|(name, own)| participant(name, own, is_scattered)).collect();
    let known: Vec<Vec<Set>> =
        episodes.iter().map(|own| informative_sets(own)).filter(|sets| !sets.is_empty()).collect();
    let fitted = match is_scattered {
        true => lognormal::fit_repeated(&known),
        false => lognormal::fit(&known.iter().map(|sets| intersection(sets)).collect::<Vec<_>>()),
    };
    let (overall, interval) = match fitted {
        Ok((overall, interval)) => (Some(overall), interval),
        Err(reason) => (None, Err(reason)),
    };
    let bounded = known.iter().filter(|sets| sets.iter().any(lognormal::is_bounded)).count();
    EtaFit {
        participants,
        overall,
        is_cautious: interval.is_ok() && bounded < known.len() && bounded <= FEW_BOUNDED,
        median_interval: interval.ok(),
        no_interval: interval.err(),
        is_scattered,
        unexplained_lines: switches.iter().filter(|s| s.etas.is_empty()).map(|s| s.line).collect(),
    }
}

/// The sets of the informative episodes.
fn informative_sets(switches: &[&Switch]) -> Vec<Set> {
    switches.iter().map(|s| s.etas.clone()).filter(|set| !set.is_empty()).collect()
}

fn participant(name: &str, switches: &[&Switch], is_scattered: bool) -> Eta {
    let mut eta = Eta {
        participant: name.to_owned(),
        episodes: switches.len(),
        switches: switches.iter().filter(|s| s.step.is_some()).count(),
        unexplained: switches.iter().filter(|s| s.etas.is_empty()).count(),
        evidence: Evidence::Nothing,
        eta: None,
        interval: None,
        no_interval: None,
        log_scatter: None,
        bounds: informative_sets(switches),
    };
    if eta.bounds.is_empty() {
        return eta;
    }
    if eta.bounds.iter().all(|set| hull(set).is_some_and(|[_, high]| high.is_infinite())) {
        eta.evidence = Evidence::Censored;
        eta.interval = hull(&intersection(&eta.bounds));
    } else if is_scattered && eta.bounds.len() > 1 {
        eta.evidence = Evidence::Scattered;
        match lognormal::fit(&eta.bounds) {
            Ok((found, interval)) => {
                eta.eta = Some(found.median);
                eta.log_scatter = Some(found.log_std);
                eta.interval = interval.ok();
                eta.no_interval = interval.err();
            }
            Err(reason) => eta.no_interval = Some(reason),
        }
    } else {
        eta.evidence = Evidence::Bounded;
        eta.interval = hull(&intersection(&eta.bounds));
        eta.eta = eta.interval.map(|[low, high]| (low + high) / 2.0);
    }
    eta
}

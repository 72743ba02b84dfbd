//! What episodes tell of eta in; eta of every participant, and of all, out.
//!
//! phi(k) grows without chance once world, belief and the robot's way are settled, so an episode bounds eta from both sides, or from below if
//! nobody switched. A participant's eta lies in all intervals. Where these have nothing in common, the participant's eta is taken to scatter
//! from episode to episode, log-normally: the likeliest median, with its 95 % profile likelihood interval. All participants together are
//! described by the likeliest log-normal distribution of their etas, each known up to its interval, those who never switched from below.

use super::lognormal::intersection;
use super::{LogNormal, Switch};
use serde::Serialize;

/// What is known of a participant's eta.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Eta {
    /// Who.
    pub participant: String,
    /// Episodes.
    pub episodes: usize,
    /// Episodes with a switch.
    pub switches: usize,
    /// Episodes with a switch that no eta explains, left out: there was no discomfort yet.
    pub unexplained: usize,
    /// How it is known.
    pub evidence: Evidence,
    /// The estimate; none if there is no upper bound.
    pub eta: Option<f64>,
    /// Where it lies; none if nothing is known. The upper end is infinite (in JSON null) for who never switched.
    pub interval: Option<[f64; 2]>,
    /// Standard deviation of ln(eta) between episodes, where these contradict each other.
    pub log_scatter: Option<f64>,
    /// The bounds of each episode that has any.
    pub bounds: Vec<[f64; 2]>,
}

/// How a participant's eta is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evidence {
    /// All episodes agree: it lies in what their bounds have in common.
    Bounded,
    /// They never switched: it lies above.
    Censored,
    /// Episodes contradict each other: the likeliest median, with a 95 % interval.
    Scattered,
    /// No episode tells anything.
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

/// eta, fitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EtaFit {
    /// In the order of the file.
    pub participants: Vec<Eta>,
    /// Of all participants; none if all are censored.
    pub overall: Option<LogNormal>,
    /// The 95 % interval of its median: what the participants have in common, if they have anything in common.
    pub median_interval: Option<[f64; 2]>,
    /// Lines of switches that no eta explains.
    pub unexplained_lines: Vec<u64>,
}

/// Fits eta to the episodes of everyone.
pub fn fit_eta(switches: &[Switch]) -> EtaFit {
    let mut names: Vec<&str> = Vec::new();
    for switch in switches {
        if !names.contains(&switch.participant.as_str()) {
            names.push(&switch.participant);
        }
    }
    let of = |name: &str| {
        let own: Vec<&Switch> = switches.iter().filter(|s| s.participant == name).collect();
        participant(name, &own)
    };
    let participants: Vec<Eta> = names.into_iter().map(of).collect();
    let known: Vec<[f64; 2]> = participants.iter().filter_map(|p| p.interval).collect();
    let overall = LogNormal::fit(&known);
    EtaFit {
        overall: overall.map(|o| o.0),
        median_interval: overall.map(|o| o.1),
        unexplained_lines: switches.iter().filter(|s| s.bounds.is_none()).map(|s| s.line).collect(),
        participants,
    }
}

fn participant(name: &str, switches: &[&Switch]) -> Eta {
    let bounds: Vec<[f64; 2]> = switches.iter().filter_map(|s| s.bounds).collect();
    let mut eta = Eta {
        participant: name.to_owned(),
        episodes: switches.len(),
        switches: switches.iter().filter(|s| s.step.is_some()).count(),
        unexplained: switches.len() - bounds.len(),
        evidence: Evidence::Nothing,
        eta: None,
        interval: None,
        log_scatter: None,
        bounds,
    };
    if eta.bounds.is_empty() {
        return eta;
    }
    match LogNormal::fit(&eta.bounds) {
        None => {
            eta.evidence = Evidence::Censored;
            eta.interval = intersection(&eta.bounds);
        }
        Some((found, interval)) => {
            let is_scattered = found.log_std > 0.0;
            eta.evidence = if is_scattered { Evidence::Scattered } else { Evidence::Bounded };
            eta.eta = Some(found.median);
            eta.interval = Some(interval);
            eta.log_scatter = is_scattered.then_some(found.log_std);
        }
    }
    eta
}

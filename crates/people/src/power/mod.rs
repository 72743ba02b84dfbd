//! How many participants a study needs: by simulated studies, whose people are those of `cocarry study
//! simulate`.

mod page;
#[cfg(test)]
mod tests;

pub use page::power_document;

use crate::simulate::{chosen, drawn, stop};
use crate::study::{PeopleStudy, StudyWorld};
use cocarry::Error;
use cocarry::episode::EpisodeSettings;
use cocarry::learning::standard_normal;
use cocarry::preference::RISK_WEIGHT;
use cocarry_studies::fit::{
    ChoiceEvidence, ChosenWorlds, Executed, Guidance, InferenceModel, InferenceSettings, Situation, Switch,
    fit_eta,
};
use cocarry_studies::parallel::{OnDone, in_parallel};
use cocarry_studies::statistics::{Moments, Paired, quantiles, wilson};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// The level of a test.
const LEVEL: f64 = 0.05;

/// What a study shall find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// A 95 % interval of eta's median of at most this width, planning steps.
    Eta(f64),
    /// A 95 % interval of the mean of alpha over people of at most this width.
    Alpha(f64),
    /// The same of gamma.
    Gamma(f64),
    /// A difference between two methods within participants: its mean over the standard deviation of the
    /// differences (d), found by a paired t-test.
    Difference(f64),
}

impl Effect {
    /// Its name in arguments.
    fn name(self) -> &'static str {
        match self {
            Self::Eta(_) => "eta",
            Self::Alpha(_) => "alpha",
            Self::Gamma(_) => "gamma",
            Self::Difference(_) => "difference",
        }
    }

    /// Its size.
    fn size(self) -> f64 {
        let (Self::Eta(size) | Self::Alpha(size) | Self::Gamma(size) | Self::Difference(size)) = self;
        size
    }

    /// What is found, in words.
    fn words(self, comparisons: u64) -> String {
        let size = self.size();
        match self {
            Self::Eta(_) => format!("a 95 % interval of eta's median of at most {size} planning steps"),
            Self::Alpha(_) => format!("a 95 % interval of the mean of alpha over people of at most {size}"),
            Self::Gamma(_) => format!("a 95 % interval of the mean of gamma over people of at most {size}"),
            Self::Difference(_) if comparisons > 1 => format!(
                "a difference of d = {size} within participants, as the smallest p-value of {comparisons} comparisons (Holm)"
            ),
            Self::Difference(_) => format!("a difference of d = {size} within participants (p < {LEVEL})"),
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}={}", self.name(), self.size())
    }
}

impl FromStr for Effect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form =
            "must be eta=WIDTH, alpha=WIDTH, gamma=WIDTH or difference=D, such as eta=3 or difference=0.5";
        let (name, size) = text.split_once('=').ok_or(form)?;
        let number = size.parse().ok().filter(|size: &f64| *size > 0.0 && size.is_finite());
        let size = number.ok_or_else(|| format!("{form}: {size:?} must be a number above 0"))?;
        match name {
            "eta" => Ok(Self::Eta(size)),
            "alpha" => Ok(Self::Alpha(size)),
            "gamma" => Ok(Self::Gamma(size)),
            "difference" => Ok(Self::Difference(size)),
            _ => Err(form.to_owned()),
        }
    }
}

/// Settings of the simulated studies.
#[derive(Clone, Debug)]
pub struct PowerSettings {
    /// The numbers of participants.
    pub participants: Vec<u64>,
    /// Simulated studies.
    pub studies: usize,
    /// The number of comparisons in the table in which a difference shall be found.
    pub comparisons: u64,
    /// The power that is wanted, 0 to 1.
    pub power: f64,
    /// Seed of everything random.
    pub seed: u64,
}

/// What studies with a number of participants find.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerRow {
    /// Number of participants.
    pub participants: u64,
    /// Number of simulated studies, and of those that found the effect.
    pub studies: usize,
    /// See `studies`.
    pub found: usize,
    /// The share that found it, and its 95 % Monte-Carlo interval (Wilson).
    pub power: f64,
    /// See `power`.
    pub interval: [f64; 2],
    /// Width of the studies' intervals: 10 %, 50 % and 90 % quantile; `None` where more than half have none.
    pub widths: Option<[f64; 3]>,
    /// Number of studies that do not determine the interval.
    pub undetermined: usize,
}

/// Simulates studies: a row for each number of participants. The people of a study are the first of its
/// largest number, so that rows differ by their number and not by chance.
///
/// # Errors
/// The study has no world for it.
pub fn power(
    study: &PeopleStudy,
    effect: Effect,
    settings: &PowerSettings,
    on_done: OnDone,
) -> Result<Vec<PowerRow>, Error> {
    let worlds = &study.worlds[..study.measured_worlds()];
    let simulated = match effect {
        Effect::Eta(_) => etas(worlds, settings, on_done),
        Effect::Alpha(_) => perceptions(worlds, 0, settings, on_done)?,
        Effect::Gamma(_) => perceptions(worlds, 2, settings, on_done)?,
        Effect::Difference(d) => differences(d, settings, on_done),
    };
    let row = |(at, participants): (usize, &u64)| {
        let studies = simulated.len();
        let widths: Vec<f64> = simulated.iter().filter_map(|study| study[at].width).collect();
        let is_found = |found: &SimulatedStudy| match effect {
            Effect::Difference(_) => found.p_value.is_some_and(|p| p < LEVEL / settings.comparisons as f64),
            _ => found.width.is_some_and(|width| width <= effect.size()),
        };
        let found = simulated.iter().filter(|study| is_found(&study[at])).count();
        let undetermined = studies - widths.len();
        // a study without an interval counts as one of infinite width
        let all: Vec<f64> = widths.into_iter().chain(std::iter::repeat_n(f64::MAX, undetermined)).collect();
        let widths = quantiles(all, [0.1, 0.5, 0.9]).filter(|widths| is_width(widths[1]));
        PowerRow {
            participants: *participants,
            studies,
            found,
            power: found as f64 / studies as f64,
            interval: wilson(found, studies),
            widths,
            undetermined,
        }
    };
    Ok(settings.participants.iter().enumerate().map(row).collect())
}

/// What a simulated study finds.
#[derive(Clone, Copy, Debug, Default)]
struct SimulatedStudy {
    width: Option<f64>,
    p_value: Option<f64>,
}

/// Whether a width is one: that of a study without an interval is larger than any.
fn is_width(width: f64) -> bool {
    width < 1e100
}

/// The generator of a person of a simulated study. The people of the first study are those of `simulate`.
fn person(settings: &PowerSettings, study: usize, person: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    rng.set_stream(((study as u64) << 32) + person);
    rng
}

/// The largest number of participants.
fn most(settings: &PowerSettings) -> u64 {
    settings.participants.iter().copied().max().unwrap_or(0)
}

fn etas(worlds: &[StudyWorld], settings: &PowerSettings, on_done: OnDone) -> Vec<Vec<SimulatedStudy>> {
    let walk = |world: &StudyWorld, option: usize| {
        let walk = Guidance::along_option(&world.set, &EpisodeSettings::default(), option)?;
        Some((world.name.clone(), Executed::Option(world.options[option].clone()), walk))
    };
    let walks: Vec<_> = worlds
        .iter()
        .flat_map(|world| (0..world.options.len()).filter_map(move |option| walk(world, option)))
        .collect();
    in_parallel(settings.studies, on_done, |study| {
        let mut switches = Vec::new();
        for number in 0..most(settings) {
            let (_, eta) = drawn(&mut person(settings, study, number));
            for (world, executed, walk) in &walks {
                let step = stop(walk, eta);
                switches.push(Switch {
                    line: 0,
                    participant: number.to_string(),
                    world: world.clone(),
                    executed: executed.clone(),
                    step,
                    etas: walk.etas(step),
                });
            }
        }
        let width = |participants: &u64| {
            let fit = fit_eta(&switches[..*participants as usize * walks.len()]);
            SimulatedStudy { width: fit.median_interval.map(|[low, high]| high - low), p_value: None }
        };
        settings.participants.iter().map(width).collect()
    })
}

/// The mean of alpha (0) or of gamma (2) over people.
fn perceptions(
    worlds: &[StudyWorld],
    which: usize,
    settings: &PowerSettings,
    on_done: OnDone,
) -> Result<Vec<Vec<SimulatedStudy>>, Error> {
    let model = InferenceModel {
        belief: EpisodeSettings::default().predictor.belief().clone(),
        risk_weight: RISK_WEIGHT,
    };
    let situations = worlds.iter().map(|world| Situation::new(world.name.clone(), &world.set)).collect();
    let inferred = ChosenWorlds::new(situations, &model, &InferenceSettings::default())?;
    let answers = |study: usize| -> Vec<Vec<usize>> {
        let answered = |number: u64| {
            let rng = &mut person(settings, study, number);
            let (perception, _) = drawn(rng);
            worlds.iter().map(|world| chosen(world, perception, rng)).collect()
        };
        (0..most(settings)).map(answered).collect()
    };
    let all: Vec<Vec<Vec<usize>>> = (0..settings.studies).map(answers).collect();
    // people answer in few different ways
    let mut ways: Vec<&Vec<usize>> = all.iter().flatten().collect();
    ways.sort();
    ways.dedup();
    let evidence = in_parallel(ways.len(), &|| (), |way| inferred.evidence(ways[way]));
    let evidence: Vec<ChoiceEvidence> = evidence.into_iter().collect::<Result<_, _>>()?;
    let known: BTreeMap<&Vec<usize>, &ChoiceEvidence> = ways.into_iter().zip(&evidence).collect();
    Ok(in_parallel(settings.studies, on_done, |study| {
        let width = |participants: &u64| {
            let mut counts: BTreeMap<&Vec<usize>, usize> = BTreeMap::new();
            all[study][..*participants as usize].iter().for_each(|way| *counts.entry(way).or_default() += 1);
            let people: Vec<_> = counts.into_iter().map(|(way, count)| (known[way], count)).collect();
            let width = inferred.posterior(&people, which).map(|f| f.interval[1] - f.interval[0]);
            SimulatedStudy { width, p_value: None }
        };
        settings.participants.iter().map(width).collect()
    }))
}

/// Differences within participants: normal, of mean d and standard deviation 1.
fn differences(d: f64, settings: &PowerSettings, on_done: OnDone) -> Vec<Vec<SimulatedStudy>> {
    in_parallel(settings.studies, on_done, |study| {
        let draw = |number: u64| d + standard_normal(&mut person(settings, study, number));
        let values: Vec<f64> = (0..most(settings)).map(draw).collect();
        let tested = |participants: &u64| {
            let mut moments = Moments::default();
            values[..*participants as usize].iter().for_each(|value| moments.add(*value, value.abs()));
            let paired = Paired::of(&moments, true);
            let width = paired.and_then(|paired| paired.difference.interval).map(|[low, high]| high - low);
            SimulatedStudy { width, p_value: paired.and_then(|paired| paired.p_value) }
        };
        settings.participants.iter().map(tested).collect()
    })
}

//! A world and what the robot does in it in; the discomfort of eq. (5) on the way, and which eta switches at which step, out.

use crate::coordination::{self, Mode, is_misaligned};
use crate::episode::{Episode, Settings, prospects};
use crate::experiments::paper::EXAMPLE_HUMAN;
use crate::math;
use crate::options::OptionSet;
use crate::policy::Method;
use crate::preference::ChoiceDistribution;

/// How a robot leads a participant through a world, and what that tells of eta.
///
/// phi(k) = phi(0) exp(g(k) / eta) passes 1 when g(k) passes eta ln(1 / phi(0)): a switch at step k says that eta lies between what g(k - 1) and
/// what g(k) allow, and none that it is at least what the last g allows.
#[derive(Clone, Debug)]
pub enum Guidance {
    /// The robot walks one option from start to end, whatever the human thinks: g(k) is the same for everyone.
    Option {
        /// g(k) by step.
        discomfort: Vec<f64>,
        /// ln(1 / phi(0)).
        patience: f64,
    },
    /// The robot chooses by eq. (6) with the human's own phi(k), so that g(k) depends on eta.
    Mutual {
        /// Values of eta, ascending, and the step at which each switches; the largest number if it does not.
        scanned: Vec<(f64, u64)>,
        /// Steps of an episode in which the robot leads to the end.
        steps: u64,
    },
}

/// Stands for the step of a switch that does not happen.
const NEVER: u64 = u64::MAX;
/// Values of eta tried: so many, in equal ratios, between these times 1 / ln(1 / phi(0)).
const TRIED: usize = 241;
const DISCOMFORTS: [f64; 2] = [0.05, 1000.0];

impl Guidance {
    /// The robot walks an option (an index) from start to end. `None` where there is no way.
    pub fn along_option(set: &OptionSet, settings: &Settings, option: usize) -> Option<Self> {
        let mut progress = set.begin();
        let path = set.path(&progress, option)?;
        let mut predictor = settings.predictor.clone();
        let mut choice = ChoiceDistribution::default();
        let (mut discomfort, mut g, mut along) = (Vec::new(), 0.0, 0.0);
        loop {
            if !discomfort.is_empty() {
                predictor.predict(&prospects(set, &progress), &mut choice);
                let toward = set.next(&progress, option);
                let misaligned = |o: usize| is_misaligned(toward, set.next(&progress, o));
                let p = choice.probabilities().iter().enumerate();
                g += p.map(|(o, p)| if misaligned(o) { *p } else { 0.0 }).fold(0.0, |sum, p| sum + p);
            }
            discomfort.push(g);
            along += settings.speed * settings.period;
            if along >= path.length() - 1e-9 {
                break;
            }
            set.advance(&mut progress, path.point_at(along)?);
        }
        Some(Self::Option { discomfort, patience: patience(settings) })
    }

    /// The robot leads by eq. (6), knowing the human's phi(k).
    pub fn mutual(set: &OptionSet, settings: &Settings) -> Self {
        let tried = |i: usize| {
            let ratio = DISCOMFORTS[1] / DISCOMFORTS[0];
            DISCOMFORTS[0] * math::pow(ratio, i as f64 / (TRIED - 1) as f64) / patience(settings)
        };
        let scanned = (0..TRIED).map(tried).map(|eta| (eta, switch(set, settings, eta))).collect();
        let coordination = settings.coordination;
        let led = Settings { method: Method::ROBOT_LED, coordination, ..settings.clone() };
        let mut episode = Episode::new(set, &led, EXAMPLE_HUMAN);
        while episode.step().is_none() {}
        Self::Mutual { scanned, steps: episode.summary().steps }
    }

    /// How many steps there are.
    pub fn steps(&self) -> u64 {
        match self {
            Self::Option { discomfort, .. } => discomfort.len() as u64,
            Self::Mutual { steps, .. } => *steps,
        }
    }

    /// The bounds of the eta that switch at `step`, or never; the upper one is infinite for the latter. Who asks at a step that switches nobody, since
    /// discomfort did not grow, is taken to have noticed late: the last step before that does. `None` if there is none: no discomfort so far.
    pub fn bounds(&self, set: &OptionSet, settings: &Settings, step: Option<u64>) -> Option<[f64; 2]> {
        match self {
            Self::Option { discomfort, patience } => {
                let Some(step) = step else {
                    return Some([discomfort.last()? / patience, f64::INFINITY]);
                };
                let g = discomfort.get(step as usize)?;
                let before = discomfort.iter().rev().find(|before| *before < g)?;
                Some([before / patience, g / patience])
            }
            Self::Mutual { scanned, .. } => {
                let mut step = step.unwrap_or(NEVER);
                let reached = |(at, tried): (usize, bool)| tried.then_some(at);
                loop {
                    let first = scanned.iter().map(|s| s.1 >= step).enumerate().find_map(reached);
                    let last = scanned.iter().map(|s| s.1 <= step).enumerate().rev().find_map(reached);
                    // below the least eta tried, discomfort at all is enough
                    let last = last?;
                    let lower = match first {
                        Some(0) => 0.0,
                        Some(first) => divided(scanned, first, |eta| switch(set, settings, eta) >= step),
                        None => scanned[last].0,
                    };
                    let upper = match step {
                        NEVER => f64::INFINITY,
                        _ if last + 1 == scanned.len() => f64::INFINITY,
                        _ => divided(scanned, last + 1, |eta| switch(set, settings, eta) > step),
                    };
                    if upper > lower * (1.0 + 1e-9) {
                        return Some([lower, upper]);
                    }
                    step = switch(set, settings, lower * (1.0 - 1e-9)).min(step.checked_sub(1)?);
                }
            }
        }
    }
}

/// ln(1 / phi(0)).
fn patience(settings: &Settings) -> f64 {
    -math::ln(settings.coordination.initial_stubbornness)
}

/// The step at which a human of this eta takes over from a robot that knows it.
fn switch(set: &OptionSet, settings: &Settings, eta: f64) -> u64 {
    let coordination = coordination::Settings { eta, ..settings.coordination };
    let settings = Settings { method: Method::MUTUAL, coordination, ..settings.clone() };
    let mut episode = Episode::new(set, &settings, EXAMPLE_HUMAN);
    while episode.step().is_none() {
        if episode.tick().mode == Mode::HumanLed {
            return episode.tick().step;
        }
    }
    NEVER
}

/// The eta between the one at `index` and the one before at which `is_beyond` turns true.
fn divided(scanned: &[(f64, u64)], index: usize, is_beyond: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (scanned[index - 1].0, scanned[index].0);
    while high > low * (1.0 + 1e-12) {
        let middle = (low + high) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        if is_beyond(middle) { high = middle } else { low = middle }
    }
    high
}

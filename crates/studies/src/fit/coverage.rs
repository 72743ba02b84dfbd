//! How often the intervals of the fits hold what simulated studies were made from.

use super::{
    Answers, EtaFit, Evidence, Executed, RiskWeightSettings, Situation, Switch, fit_eta, fit_risk_weight,
};
use crate::paper::ENVIRONMENTS;
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The median of eta in the simulated studies.
pub const MEDIAN: f64 = 10.0;

/// Studies of eta that are alike but for chance. ln(eta) is normally distributed about ln([`MEDIAN`]).
#[derive(Clone, Copy, Debug)]
pub struct EtaDesign {
    /// Number of participants.
    pub people: usize,
    /// Episodes of each.
    pub episodes: usize,
    /// The longest episode: one with an eta more standard deviations above the median than this ends without
    /// a switch. Infinite: every episode has one.
    pub longest: f64,
    /// Standard deviation of ln(eta) between people.
    pub spread: f64,
    /// Standard deviation of ln(eta) between the episodes of a person.
    pub scatter: f64,
    /// The difference of ln(eta) from one step to the next.
    pub resolution: f64,
}

/// Studies, by what became of their interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Studies with an interval.
    pub stated: usize,
    /// Intervals that hold the true value.
    pub holds: usize,
    /// Intervals above it.
    pub above: usize,
    /// Intervals below it.
    pub below: usize,
}

impl Coverage {
    fn add(&mut self, [low, high]: [f64; 2], truth: f64) {
        self.stated += 1;
        let count = match (truth < low, truth > high) {
            (true, _) => &mut self.above,
            (_, true) => &mut self.below,
            _ => &mut self.holds,
        };
        *count += 1;
    }

    /// The share of the intervals that hold the true value, percent. NaN without an interval.
    pub fn percent(&self) -> f64 {
        100.0 * self.holds as f64 / self.stated as f64
    }
}

/// A standard normal number, by Box and Muller.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let [u, v]: [f64; 2] = rng.random();
    (-2.0 * math::ln_1p(-u)).sqrt() * math::cos(TAU * v)
}

impl EtaDesign {
    /// A study of this design, and the median of each person.
    pub fn study(&self, seed: u64) -> (EtaFit, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let longest = math::ln(MEDIAN) + self.longest * math::hypot(self.spread, self.scatter);
        let offset: f64 = rng.random();
        let (mut switches, mut medians) = (Vec::new(), Vec::new());
        for person in 0..self.people {
            let median = math::ln(MEDIAN) + self.spread * normal(&mut rng);
            medians.push(math::exp(median));
            for line in 0..self.episodes {
                let eta = median + self.scatter * normal(&mut rng);
                let step = (eta < longest).then(|| (eta / self.resolution + offset).floor());
                let ends = match step {
                    Some(step) => {
                        let low = (step - offset) * self.resolution;
                        [low, (low + self.resolution).min(longest)]
                    }
                    None => [longest, f64::INFINITY],
                };
                switches.push(Switch {
                    line: line as u64,
                    participant: person.to_string(),
                    world: "simulated".to_owned(),
                    executed: Executed::Mutual,
                    step: step.map(|step| step.max(0.0) as u64),
                    etas: vec![ends.map(math::exp)],
                });
            }
        }
        (fit_eta(&switches), medians)
    }

    /// The intervals of the median of all, and those of the medians of participants whose eta scatters.
    pub fn coverage(&self, studies: usize, on_done: OnDone) -> [Coverage; 2] {
        let fits = in_parallel(studies, on_done, |seed| self.study(seed as u64));
        let mut found = [Coverage::default(); 2];
        for (fit, medians) in fits {
            if let Some(interval) = fit.median_interval {
                found[0].add(interval, MEDIAN);
            }
            let scattered =
                fit.participants.iter().zip(medians).filter(|(p, _)| p.evidence == Evidence::Scattered);
            for (participant, median) in scattered {
                if let Some(interval) = participant.interval {
                    found[1].add(interval, median);
                }
            }
        }
        found
    }
}

/// Number of participants in a simulated study of c_r.
const PEOPLE: usize = 20;
/// Choices of which a participant says the shares.
const CHOICES: usize = 20;
/// Bootstrap resamples of a simulated study of c_r.
const RESAMPLES: usize = 80;
/// The probability that an answer is any at all.
pub const DIFFUSE: f64 = 0.3;

/// The intervals of c_r by likelihood and by least squares, in studies of 20 people who choose 20 times in
/// each of the paper's environments, but give any answer at all with a probability of [`DIFFUSE`].
///
/// # Errors
/// An error of a built-in world, or of a fit.
pub fn risk_weight_coverage(
    risk_weight: f64,
    studies: usize,
    on_done: OnDone,
) -> Result<[Coverage; 2], Error> {
    let default = Predictor::default();
    let situation = |environment: &crate::paper::Environment| {
        let set = OptionSet::new(&environment.world()?, default.risk_weight())?;
        Ok::<_, Error>(Situation::new(environment.name.to_owned(), &set))
    };
    let situations = ENVIRONMENTS.iter().map(situation).collect::<Result<Vec<_>, _>>()?;
    let truth = Predictor::new(default.belief().clone(), risk_weight)?;
    let settings = RiskWeightSettings { resamples: RESAMPLES, ..RiskWeightSettings::default() };
    let fits = in_parallel(studies, on_done, |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed as u64);
        fit_risk_weight(&diffuse_answers(&situations, &truth, &mut rng), &default, &settings, &|| ())
    });
    let mut found = [Coverage::default(); 2];
    for fit in fits {
        let fit = fit?;
        for (found, estimate) in found.iter_mut().zip([fit.likelihood, fit.least_squares]) {
            if let Some(interval) = estimate.interval {
                found.add(interval, risk_weight);
            }
        }
    }
    Ok(found)
}

fn diffuse_answers(situations: &[Situation], truth: &Predictor, rng: &mut ChaCha8Rng) -> Answers {
    let mut truth = truth.clone();
    let mut choice = ChoiceDistribution::default();
    let mut answer = |situation: &Situation| {
        truth.predict(&situation.prospects, &mut choice);
        let p = choice.probabilities();
        let weights: Vec<f64> = if rng.random_bool(DIFFUSE) {
            // uniform over all shares
            p.iter().map(|_| -math::ln_1p(-rng.random::<f64>())).collect()
        } else {
            let mut counts = vec![0.0; p.len()];
            for _ in 0..CHOICES {
                let mut left: f64 = rng.random();
                let chosen = p.iter().position(|p| {
                    left -= p;
                    left < 0.0
                });
                counts[chosen.unwrap_or(0)] += 1.0;
            }
            counts
        };
        let sum: f64 = weights.iter().sum();
        Some(weights.into_iter().map(|weight| weight / sum).collect())
    };
    Answers {
        file: "simulated".to_owned(),
        situations: situations.to_vec(),
        participants: (0..PEOPLE).map(|person| person.to_string()).collect(),
        shares: (0..PEOPLE).map(|_| situations.iter().map(&mut answer).collect()).collect(),
        scaled: Vec::new(),
    }
}

//! Simulation-based calibration of what the robot learns (Talts et al. 2018, arXiv:1804.06788).
//!
//! Humans are drawn from the prior and observed as the model says. For a calibrated belief, the posterior
//! probability up to a parameter's true value is uniform on [0, 1] over the replications, and regions of 50,
//! 80 and 95 % contain the truth that often. A belief that is too certain, too vague or off to one side
//! fails.

use super::Guidance;
use crate::parallel::{OnDone, in_parallel};
use cocarry::episode::{self, prospects};
use cocarry::learning::{Learner, LearningError, LearningSettings, discomfort_limit, eta_interval};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::preference::{Perception, Ways, human_choice};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The parameters, as in outputs.
pub const PARAMETERS: [&str; 3] = ["alpha", "gamma", "eta"];

/// The probabilities of the regions whose coverage is counted.
pub const LEVELS: [f64; 3] = [0.5, 0.8, 0.95];

/// The probability with which a calibrated belief fails one of its checks by chance.
const FALSE_ALARM: f64 = 1e-3;

/// Parts of the way along an option at which the human is looked at.
const PLACES: u32 = 20;

/// A calibration: how humans are, and how the robot takes them to be.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The belief, c_r, phi(0) and the walk.
    pub settings: episode::EpisodeSettings,
    /// How humans really lapse and change.
    pub truth: LearningSettings,
    /// How the robot assumes that they do.
    pub assumed: LearningSettings,
    /// Number of humans.
    pub replications: u64,
    /// Sightings of each human under their lead.
    pub sightings: u32,
    /// Tasks under the robot's lead with each human.
    pub tasks: u32,
    /// The seed of all draws.
    pub seed: u64,
}

impl Default for Calibration {
    fn default() -> Self {
        let (settings, truth) = (episode::EpisodeSettings::default(), LearningSettings::default());
        Self { settings, truth, assumed: truth, replications: 10_000, sightings: 8, tasks: 2, seed: 0 }
    }
}

/// One human.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Replication {
    /// The true alpha, gamma and eta.
    pub truth: [f64; 3],
    /// Their posterior means.
    pub means: [f64; 3],
    /// The posterior probability up to each.
    pub ranks: [f64; 3],
    /// The probability of the densities above that of the true (alpha, gamma). In parts of equal density the
    /// place is drawn.
    pub credibility: f64,
}

/// A check of the ranks of one parameter, or of the regions of (alpha, gamma).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The name of the check.
    pub name: &'static str,
    /// The largest distance of the empirical distribution from the uniform one.
    pub distance: f64,
    /// The distance that a calibrated belief exceeds with probability 0.001 (Kolmogorov's distribution).
    pub band: f64,
    /// Share of truths within the regions of [`LEVELS`]: central intervals of a parameter, regions of highest
    /// density of (alpha, gamma).
    pub coverage: [f64; 3],
    /// Correlation of truth and posterior mean; `None` for regions.
    pub recovery: Option<f64>,
    /// Whether the distance is within the band.
    pub is_calibrated: bool,
}

/// The worlds in which humans are observed, with the guidance along every option.
struct Watched<'a> {
    set: &'a OptionSet,
    guidances: Vec<Option<Guidance>>,
}

impl Calibration {
    /// Runs all replications, on all threads; the result does not depend on their number. `sets` are the
    /// options of the worlds, at least one.
    ///
    /// # Errors
    /// [`LearningError`]: numbers of `truth` or `assumed` are out of their ranges.
    pub fn run(&self, sets: &[OptionSet], on_done: OnDone) -> Result<Vec<Replication>, LearningError> {
        self.truth.check()?;
        let learner = self.learner()?;
        let watched: Vec<_> = sets.iter().map(|set| self.watched(set)).collect();
        Ok(in_parallel(self.replications as usize, on_done, |index| {
            self.replication(&watched, learner.clone(), index as u64)
        }))
    }

    fn watched<'a>(&self, set: &'a OptionSet) -> Watched<'a> {
        let guidance = |option| Guidance::along_option(set, &self.settings, option);
        Watched { set, guidances: (0..set.options().len()).map(guidance).collect() }
    }

    fn learner(&self) -> Result<Learner, LearningError> {
        let (predictor, phi) = (&self.settings.predictor, self.settings.coordination.initial_stubbornness);
        Learner::new(self.assumed, predictor.belief().clone(), predictor.risk_weight(), phi)
    }

    fn replication(&self, worlds: &[Watched<'_>], mut learner: Learner, index: u64) -> Replication {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(index);
        let belief = self.settings.predictor.belief();
        let mut human = belief.sample(&mut rng);
        let eta = self.truth.tolerance.sample(&mut rng);
        for task in 0..self.tasks {
            if task > 0 {
                learner.begin_task();
            }
            let lapses = rng.random_bool(self.truth.lapse_rate);
            let eta = if lapses { self.truth.tolerance.sample(&mut rng) } else { eta };
            self.lead(worlds, &mut learner, eta, &mut rng);
        }
        for _ in 0..self.sightings {
            if rng.random_bool(self.truth.change_rate) {
                human = belief.sample(&mut rng);
            }
            self.sight(worlds, &mut learner, human, &mut rng);
        }
        let density = learner.density(human);
        let [above, from] = learner.perception().credibility(density);
        let ranks = learner.perception().marginals(human);
        let eta_rank = learner.tolerance().probability_up_to(eta);
        let [alpha, gamma] = learner.perception_mut().mean();
        Replication {
            truth: [human.alpha, human.gamma, eta],
            means: [alpha, gamma, learner.tolerance().moments()[0]],
            ranks: [ranks[0], ranks[1], eta_rank],
            credibility: above + (from - above) * rng.random::<f64>(),
        }
    }

    /// The robot walks an option until the human takes over, if ever.
    fn lead(&self, worlds: &[Watched<'_>], learner: &mut Learner, eta: f64, rng: &mut ChaCha8Rng) {
        let world = &worlds[rng.random_range(0..worlds.len())];
        let option = rng.random_range(0..world.guidances.len());
        let Some(Guidance::Option { discomfort, .. }) = &world.guidances[option] else { return };
        let limit = discomfort_limit(self.settings.coordination.initial_stubbornness);
        let mut before = 0.0;
        for &g in discomfort {
            let takes_over = eta < eta_interval(g, None, limit)[0];
            learner.observe_led_step(g - before, takes_over);
            if takes_over {
                return;
            }
            before = g;
        }
    }

    /// A sighting of the human, who leads somewhere along an option.
    fn sight(&self, worlds: &[Watched<'_>], learner: &mut Learner, human: Perception, rng: &mut ChaCha8Rng) {
        let set = worlds[rng.random_range(0..worlds.len())].set;
        let count = set.options().len();
        let mut progress = set.begin();
        // the place says nothing about the human: it is on any option
        let walked = rng.random_range(0..count);
        let part = f64::from(rng.random_range(0..PLACES)) / f64::from(PLACES);
        if let Some(path) = set.path(&progress, walked) {
            let steps = (part * path.length() / 0.5).floor() as u32;
            for step in 1..=steps {
                if let Some(point) = path.point_at(0.5 * f64::from(step)) {
                    set.advance(&mut progress, point);
                }
            }
        }
        let options = prospects(set, &progress);
        let risk_weight = self.settings.predictor.risk_weight();
        let lapses = rng.random_bool(self.truth.lapse_rate);
        let any = rng.random_range(0..count);
        let chosen = if lapses { any } else { human_choice(&options, risk_weight, human, None) };
        let toward = set.next(&progress, chosen);
        let is_consistent = (0..count).map(|option| set.next(&progress, option) == toward);
        // impossible only if no lapse is assumed: then nothing is learned from it
        drop(learner.observe_sighting(&options, &Ways::default(), is_consistent));
    }
}

/// The checks of all parameters, then that of the regions.
pub fn checks(replications: &[Replication]) -> Vec<Check> {
    let mut checks: Vec<Check> = (0..PARAMETERS.len())
        .map(|i| {
            let ranks = replications.iter().map(|r| r.ranks[i]).collect();
            let is_within = |rank: f64, level: f64| (rank - 0.5).abs() <= 0.5 * level;
            let pairs: Vec<_> = replications.iter().map(|r| (r.truth[i], r.means[i])).collect();
            check(PARAMETERS[i], ranks, &is_within, Some(correlation(&pairs)))
        })
        .collect();
    let ranks = replications.iter().map(|r| r.credibility).collect();
    checks.push(check("alpha-gamma region", ranks, &|rank, level| rank <= level, None));
    checks
}

fn check(
    name: &'static str,
    mut ranks: Vec<f64>,
    is_within: &dyn Fn(f64, f64) -> bool,
    recovery: Option<f64>,
) -> Check {
    let n = ranks.len().max(1) as f64;
    let coverage = LEVELS.map(|level| ranks.iter().filter(|r| is_within(**r, level)).count() as f64 / n);
    ranks.sort_unstable_by(f64::total_cmp);
    let distance = ranks.iter().enumerate().map(|(i, rank)| {
        let i = i as f64;
        (rank - i / n).abs().max((rank - (i + 1.0) / n).abs())
    });
    let distance = distance.fold(0.0, f64::max);
    // P(sqrt(n) distance > x) is about 2 exp(-2 x^2)
    let band = (0.5 * math::ln(2.0 / FALSE_ALARM) / n).sqrt();
    Check { name, distance, band, coverage, recovery, is_calibrated: distance <= band }
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len().max(1) as f64;
    let mean = |value: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
    covariance / (mean(&|p| math::squared(p.0 - x)) * mean(&|p| math::squared(p.1 - y))).sqrt()
}

//! The noisy-rational (Boltzmann) human, who chooses options of lower cost with higher probability.

use super::model::{HumanModel, Participant, PreferenceChange, bad_arguments};
use super::{Human, HumanDecision, HumanView, PreferenceHuman};
use crate::math;
use crate::preference::{Perception, subjective_cost};
use crate::saved::{RestoreError, Saved};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The stream of the episode's generator from which the choice is drawn.
const STREAM: u64 = 2;

/// The model's entry in the list.
pub(super) const MODEL: HumanModel = HumanModel {
    name: "boltzmann",
    form: "boltzmann(RATIONALITY)",
    about: "Chooses with probability proportional to exp(-RATIONALITY * subjective cost)",
    make: |arguments, participant| {
        let rationality = arguments.parse().ok().filter(|r: &f64| *r > 0.0 && *r <= 1e6);
        let expected = "boltzmann(RATIONALITY), for example boltzmann(2), with a number greater than 0 and at most 1000000";
        let rationality = rationality.ok_or_else(|| bad_arguments(expected))?;
        Ok(Box::new(Boltzmann::new(participant, rationality)))
    },
};

/// A human who chooses option o with probability exp(-beta J^_o) / sum_p exp(-beta J^_p), where J^ is the
/// subjective cost of eq. (2) and beta the rationality. beta = 0 is chance, beta = infinity is eq. (3).
///
/// The choice is that of a random utility model (McFadden 1974). Every option has a Gumbel disturbance, drawn
/// once per episode, and the human prefers the option with the least beta J^_o minus its disturbance. Choice
/// probabilities are therefore Boltzmann's at every position, and the human does not waver between steps.
#[derive(Clone, Debug)]
pub struct Boltzmann {
    rationality: f64,
    disturbances: Vec<f64>,
    human: PreferenceHuman,
}

impl Boltzmann {
    /// The human at the start, with this rationality (beta > 0).
    pub fn new(participant: &Participant<'_>, rationality: f64) -> Self {
        let disturbances = disturbances(participant.seed, participant.options.options().len());
        Self { rationality, disturbances, human: PreferenceHuman::of(participant) }
    }
}

/// The Gumbel disturbances of a seed's human, one for each of `options` options.
pub fn disturbances(seed: u64, options: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(STREAM);
    (0..options).map(|_| -math::ln(-math::ln(rng.random_range(f64::MIN_POSITIVE..1.0)))).collect()
}

impl Human for Boltzmann {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let perception = self.human.perceive(view.step);
        let mut best = (0, f64::INFINITY);
        for (option, (prospect, disturbance)) in view.prospects.iter().zip(&self.disturbances).enumerate() {
            let cost =
                self.rationality * subjective_cost(*prospect, view.risk_weight, perception) - disturbance;
            if cost < best.1 || (cost == best.1 && view.executed == Some(option)) {
                best = (option, cost);
            }
        }
        HumanDecision::new(best.0, self.human.accumulate(view), Some(perception))
    }

    fn set_preference(&mut self, preference: Perception) {
        self.human.set_preference(preference);
    }

    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        self.human.change(step)
    }

    fn save(&self) -> Saved {
        self.human.save()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.human.restore(saved)
    }
}

//! The inputs of an inference: settings, the belief, and the participants' actions besides answers.

use crate::fit::Switch;
use cocarry::episode::Sighting;
use cocarry::learning::{self, TolerancePrior};
use cocarry::preference::Belief;

/// Settings of an inference.
#[derive(Clone, Copy, Debug)]
pub struct InferenceSettings {
    /// The probability that an answer, or a time of taking over, says nothing about its participant.
    pub lapse_rate: f64,
    /// The prior of eta.
    pub tolerance: TolerancePrior,
    /// Whether participants are drawn from a common population; otherwise each has the belief as prior.
    pub has_population: bool,
    /// Draws of each of four chains.
    pub draws: usize,
    /// Whether the draws are part of the inference. Without them it takes little memory for every participant.
    pub keeps_draws: bool,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for InferenceSettings {
    fn default() -> Self {
        let learning::LearningSettings { lapse_rate, tolerance, .. } = learning::LearningSettings::default();
        Self { lapse_rate, tolerance, has_population: true, draws: 1000, keeps_draws: true, seed: 0 }
    }
}

/// The belief about people before their answers, and c_r.
#[derive(Clone, Debug)]
pub struct InferenceModel {
    /// The prior of every participant; of a population, its ranges.
    pub belief: Belief,
    /// c_r, m.
    pub risk_weight: f64,
}

/// The switches of a file.
#[derive(Clone, Copy, Debug)]
pub struct Switches<'a> {
    /// The file.
    pub file: &'a str,
    /// Its episodes.
    pub switches: &'a [Switch],
}

/// The observations of a participant in one episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The recording.
    pub file: String,
    /// The participant.
    pub participant: String,
    /// Sightings under the human's lead.
    pub sightings: Vec<Sighting>,
    /// The eta that agree with when they took over, or did not.
    pub etas: [f64; 2],
}

//! Errors in the parameters of the preference model, each with its numbers.

use super::perception::MAX_PERCEPTION;
use thiserror::Error;

/// The largest lapse rate.
pub const MAX_LAPSE_RATE: f64 = 0.5;

/// The largest rationality of a belief. Beyond it, costs would have to be exact to more digits than they
/// have, and choices are those of eq. (3).
pub const MAX_RATIONALITY: f64 = 1000.0;

/// Checks the probability of a lapse: of a choice, or of a time of taking over, that says nothing about the
/// human.
///
/// # Errors
/// [`PreferenceError::Rate`].
pub(crate) fn check_lapse_rate(value: f64) -> Result<(), PreferenceError> {
    match (0.0..=MAX_LAPSE_RATE).contains(&value) {
        true => Ok(()),
        false => Err(PreferenceError::Rate { name: "lapse rate", value, least: 0.0, most: MAX_LAPSE_RATE }),
    }
}

impl From<PreferenceError> for crate::error::Error {
    fn from(error: PreferenceError) -> Self {
        Self::new(error.to_string())
    }
}

/// An invalid belief or risk weight. Options never cause an error: see [`Prospect`](super::Prospect).
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PreferenceError {
    /// The bounds of a marginal are not `0 < lower < upper <= 10`.
    #[error("bounds [{lower}, {upper}] must satisfy 0 < lower < upper <= {MAX_PERCEPTION}")]
    Bounds {
        /// Lower bound given.
        lower: f64,
        /// Upper bound given.
        upper: f64,
    },
    /// The shape of a truncated normal is not a finite mean with a positive finite standard deviation.
    #[error(
        "normal distribution with mean {mean} and standard deviation {std}: the mean must be finite, the deviation positive"
    )]
    Shape {
        /// Mean given (of the normal before truncation).
        mean: f64,
        /// Standard deviation given (of the normal before truncation).
        std: f64,
    },
    /// A truncated normal has no representable probability between its bounds.
    #[error(
        "normal distribution with mean {mean} and standard deviation {std} has no probability in [{lower}, {upper}]"
    )]
    NoMass {
        /// Mean given.
        mean: f64,
        /// Standard deviation given.
        std: f64,
        /// Lower bound given.
        lower: f64,
        /// Upper bound given.
        upper: f64,
    },
    /// Text that is not a marginal.
    #[error("`{text}` is not a distribution: write uniform(lower,upper) or normal(mean,std,lower,upper)")]
    Syntax {
        /// The text given.
        text: String,
    },
    /// A set of samples without a sample.
    #[error("a belief needs at least one sample")]
    NoSamples,
    /// A sample whose parameters are not positive and at most 10, or whose weight is not positive and finite.
    #[error(
        "sample {index} (alpha {alpha}, gamma {gamma}, weight {weight}): all three must be positive and finite, alpha and gamma at most {MAX_PERCEPTION}"
    )]
    Sample {
        /// Position in the list given, from 0.
        index: usize,
        /// Distance perception of the sample.
        alpha: f64,
        /// Risk perception of the sample.
        gamma: f64,
        /// Weight of the sample.
        weight: f64,
    },
    /// A risk weight `c_r` that is negative or not finite.
    #[error("risk weight c_r = {risk_weight} m must be finite and not negative")]
    RiskWeight {
        /// Risk weight given, metres.
        risk_weight: f64,
    },
    /// A rationality that is not positive, or too large.
    #[error("rationality {value} must be a number greater than 0 and at most {MAX_RATIONALITY}")]
    Rationality {
        /// The value given.
        value: f64,
    },
    /// The likelihoods of an observation are not one finite number of at least 0 for every option.
    #[error(
        "an observation of {options} options has {given} likelihoods, the first bad one {bad}: every option needs a finite one of at least 0"
    )]
    Likelihoods {
        /// Number of options.
        options: usize,
        /// Number of likelihoods given.
        given: usize,
        /// The first that is negative or not finite; NaN if only their number is wrong.
        bad: f64,
    },
    /// An observation has probability 0 under the belief.
    #[error(
        "the observation is impossible under the belief: set a lapse rate above 0, or check the participant's name"
    )]
    Impossible,
    /// A rate that is not a probability.
    #[error("{name} {value} must be a number from {least} to {most}")]
    Rate {
        /// Its name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The least value allowed.
        least: f64,
        /// The largest value allowed.
        most: f64,
    },
}

//! Choice probabilities and expected costs of the options, from their remaining lengths and risks and a
//! belief over human perception.
//!
//! A human perceives a length `D` as `D^alpha` (Stevens) and a risk `S` as `exp(-(-ln S)^gamma)` (Prelec),
//! and takes the option with the lowest subjective cost (eqs. 2 and 3). The robot knows `alpha` and `gamma`
//! only as a [`Belief`]. A [`Predictor`] turns it into the probability (eq. 4) and the expected subjective
//! cost (eq. 6) of every option.
//!
//! ```
//! use cocarry::preference::{Belief, ChoiceDistribution, Predictor, Prospect};
//!
//! let options = [Prospect::new(17.4, 0.36), Prospect::new(14.3, 0.55), Prospect::new(21.4, 0.25)];
//! let mut predictor = Predictor::new(Belief::default(), 10.0)?;
//! let mut choice = ChoiceDistribution::default();
//! predictor.predict(&options, &mut choice);
//! assert!((choice.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-12);
//! assert_eq!(choice.most_likely(), 0);
//! # Ok::<(), cocarry::Error>(())
//! ```

mod alternatives;
mod belief;
mod choice;
mod curve;
mod envelope;
mod expectation;
mod limits;
mod margin;
mod marginal;
mod perception;
mod posterior;
mod predictor;
#[cfg(test)]
mod reference;
mod regions;
mod rule;
mod softmax;
mod strips;
mod ties;

pub use alternatives::{
    ALTERNATIVES, CONDITIONAL_VALUE_AT_RISK, CUMULATIVE_PROSPECT, ChoiceGroup, EXPECTED_RISK, RiskParameter,
    RiskPerception, StevensPrelec,
};
pub use belief::{Belief, SampleSet, WeightedSample};
pub use choice::{ChoiceDistribution, with_lapses};
pub(crate) use limits::check_lapse_rate;
use limits::check_rate;
pub use limits::{MAX_LAPSE_RATE, MAX_RATIONALITY};
pub use marginal::Marginal;
pub(crate) use perception::PerceivedRisks;
pub use perception::{
    MAX_PERCEPTION, Perception, Prospect, human_choice, objective_cost, perceived_distance, perceived_risk,
    subjective_cost,
};
pub use posterior::{Estimate, Learned, Posterior};
pub use predictor::{Predictor, RISK_WEIGHT};
pub use regions::{Region, Regions};
pub use ties::Ways;

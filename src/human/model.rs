//! A human model by its name, and the data that it creates a human from.

use super::Human;
use crate::coordination;
use crate::error::Error;
use crate::options::OptionSet;
use crate::preference::Perception;
use serde::{Deserialize, Serialize};

/// A human, or the reason why the model cannot be created.
type Made = Result<Box<dyn Human>, Error>;

/// A model of human decisions.
#[derive(Debug)]
pub struct HumanModel {
    /// Name.
    pub name: &'static str,
    /// The name with its arguments, as in `boltzmann(RATIONALITY)`.
    pub form: &'static str,
    /// A description in one sentence.
    pub about: &'static str,
    /// Creates the human from the arguments between the parentheses.
    pub(super) make: fn(&str, &Participant<'_>) -> Made,
}

/// The data of one human, known before the episode.
#[derive(Clone, Copy, Debug)]
pub struct Participant<'a> {
    /// alpha and gamma at the start.
    pub perception: Perception,
    /// Preference changes.
    pub changes: &'a [PreferenceChange],
    /// phi(0) and eta.
    pub stubbornness: coordination::StubbornnessSettings,
    /// The episode's seed.
    pub seed: u64,
    /// The options of the world.
    pub options: &'a OptionSet,
}

/// The error of arguments that do not fit a model, with what to write instead.
pub(super) fn bad_arguments(expected: &str) -> Error {
    Error::new(format!("expected {expected}"))
}

/// A preference change: from a step on, the human perceives risk and distance differently. The robot is not
/// told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "ChangeFields", into = "ChangeFields")]
pub struct PreferenceChange {
    /// k of the step at whose beginning the change happens, from 0.
    pub step: u64,
    /// alpha and gamma from this step on.
    pub perception: Perception,
}

/// A change as it is serialised.
#[derive(Serialize, Deserialize)]
#[serde(rename = "change", deny_unknown_fields)]
struct ChangeFields {
    step: u64,
    alpha: f64,
    gamma: f64,
}

impl From<ChangeFields> for PreferenceChange {
    fn from(ChangeFields { step, alpha, gamma }: ChangeFields) -> Self {
        Self { step, perception: Perception { alpha, gamma } }
    }
}

impl From<PreferenceChange> for ChangeFields {
    fn from(PreferenceChange { step, perception: Perception { alpha, gamma } }: PreferenceChange) -> Self {
        Self { step, alpha, gamma }
    }
}

impl std::fmt::Display for PreferenceChange {
    /// `STEP:ALPHA,GAMMA`, with every number exact to the last bit.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Perception { alpha, gamma } = self.perception;
        write!(f, "{}:{alpha},{gamma}", self.step)
    }
}

impl PreferenceChange {
    /// The changes of a list that take effect, ordered by step. Of several at the same step, the last one
    /// applies.
    pub fn in_force(changes: &[Self]) -> Vec<Self> {
        let mut active: Vec<Self> = Vec::with_capacity(changes.len());
        let mut by_step = changes.to_vec();
        by_step.sort_by_key(|change| change.step);
        for change in by_step {
            match active.last_mut().filter(|last| last.step == change.step) {
                Some(last) => *last = change,
                None => active.push(change),
            }
        }
        active
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(step: u64, alpha: f64) -> PreferenceChange {
        PreferenceChange { step, perception: Perception { alpha, gamma: 1.0 } }
    }

    #[test]
    fn closed_form_the_last_change_of_a_step_is_in_force() {
        let given = [change(7, 0.1), change(3, 0.2), change(7, 0.3), change(0, 0.4), change(3, 0.5)];
        let active = PreferenceChange::in_force(&given);
        assert_eq!(active, [change(0, 0.4), change(3, 0.5), change(7, 0.3)]);
        assert!(PreferenceChange::in_force(&[]).is_empty());
    }
}

//! What a human is to make of risk and distance from a step on, in; the one in force at a step out.

use crate::preference::Perception;
use serde::{Deserialize, Serialize};

/// A human changes their mind: from a step on they perceive risk and distance differently. The robot is not told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Row", into = "Row")]
pub struct PreferenceChange {
    /// k of the step at whose beginning it happens, from 0.
    pub step: u64,
    /// alpha and gamma from there on.
    pub perception: Perception,
}

/// A change as it is written down.
#[derive(Serialize, Deserialize)]
#[serde(rename = "change", deny_unknown_fields)]
struct Row {
    step: u64,
    alpha: f64,
    gamma: f64,
}

impl From<Row> for PreferenceChange {
    fn from(Row { step, alpha, gamma }: Row) -> Self {
        Self { step, perception: Perception { alpha, gamma } }
    }
}

impl From<PreferenceChange> for Row {
    fn from(PreferenceChange { step, perception: Perception { alpha, gamma } }: PreferenceChange) -> Self {
        Self { step, alpha, gamma }
    }
}

impl std::fmt::Display for PreferenceChange {
    /// `STEP:ALPHA,GAMMA`, every number to the last bit.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Perception { alpha, gamma } = self.perception;
        write!(f, "{}:{alpha},{gamma}", self.step)
    }
}

impl PreferenceChange {
    /// Those of a list that stand, by their steps: of several at the same step, the last.
    pub fn standing(changes: &[Self]) -> Vec<Self> {
        let mut standing: Vec<Self> = Vec::with_capacity(changes.len());
        let mut by_step = changes.to_vec();
        by_step.sort_by_key(|change| change.step);
        for change in by_step {
            match standing.last_mut().filter(|last| last.step == change.step) {
                Some(last) => *last = change,
                None => standing.push(change),
            }
        }
        standing
    }

    /// The one that happens at a step, among those that [stand](Self::standing).
    pub(super) fn at(standing: &[Self], step: u64) -> Option<&Self> {
        standing.binary_search_by_key(&step, |change| change.step).ok().map(|i| &standing[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(step: u64, alpha: f64) -> PreferenceChange {
        PreferenceChange { step, perception: Perception { alpha, gamma: 1.0 } }
    }

    #[test]
    fn closed_form_the_last_of_a_step_stands() {
        let given = [change(7, 0.1), change(3, 0.2), change(7, 0.3), change(0, 0.4), change(3, 0.5)];
        let standing = PreferenceChange::standing(&given);
        assert_eq!(standing, [change(0, 0.4), change(3, 0.5), change(7, 0.3)]);
        assert_eq!(PreferenceChange::at(&standing, 3), Some(&change(3, 0.5)));
        assert_eq!(PreferenceChange::at(&standing, 4), None);
        assert!(PreferenceChange::standing(&[]).is_empty());
    }
}

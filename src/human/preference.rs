//! The paper's human, who chooses by eq. (3) and takes the lead by eq. (5).

use super::model::{HumanModel, ModelError};
use super::{Human, HumanDecision, HumanView};
use crate::coordination::{Settings, Stubbornness};
use crate::preference::{Perception, human_choice};
use crate::saved::{NotRestored, Saved};
use serde::{Deserialize, Serialize};

/// The model's entry in the list.
pub(super) const MODEL: HumanModel = HumanModel {
    name: "preference",
    form: "preference",
    about: "Prefers the option of least subjective cost, eq. (3)",
    make: |arguments, participant| match arguments {
        "" => Ok(Box::new(participant.preference_human())),
        _ => Err(ModelError::Arguments { expected: "no arguments" }),
    },
};

/// A human who prefers the option of least subjective cost with the current alpha and gamma, eq. (3).
/// Stubbornness grows by eq. (5).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PreferenceHuman {
    perception: Perception,
    /// Ordered by step, at most one per step.
    #[serde(skip)]
    changes: Vec<PreferenceChange>,
    stubbornness: Stubbornness,
}

impl PreferenceHuman {
    /// A human without preference changes.
    pub fn new(perception: Perception, stubbornness: Settings) -> Self {
        Self { perception, changes: Vec::new(), stubbornness: Stubbornness::new(stubbornness) }
    }

    /// The same human with preference changes, in any order. Of several at the same step, the last one
    /// applies.
    #[must_use]
    pub fn with_changes(self, changes: &[PreferenceChange]) -> Self {
        Self { changes: PreferenceChange::in_force(changes), ..self }
    }

    /// alpha and gamma at a step, after all changes up to it.
    pub(super) fn perceive(&mut self, step: u64) -> Perception {
        if let Some(change) = self.change(step) {
            self.perception = change.perception;
        }
        self.perception
    }

    /// The stubbornness including this step.
    pub(super) fn accumulate(&mut self, view: &HumanView) -> &Stubbornness {
        view.accumulate(&mut self.stubbornness);
        &self.stubbornness
    }
}

impl Human for PreferenceHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let perception = self.perceive(view.step);
        let option = human_choice(view.prospects, view.risk_weight, perception, view.executed);
        HumanDecision::new(option, self.accumulate(view), Some(perception))
    }

    fn set_preference(&mut self, preference: Perception) {
        self.perception = preference;
    }

    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        self.changes.binary_search_by_key(&step, |change| change.step).ok().map(|i| &self.changes[i])
    }

    fn save(&self) -> Saved {
        Saved::of(self)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        let changes = std::mem::take(&mut self.changes);
        *self = saved.read("human")?;
        self.changes = changes;
        Ok(())
    }
}

/// A preference change: from a step on, the human perceives risk and distance differently. The robot is not
/// told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Row", into = "Row")]
pub struct PreferenceChange {
    /// k of the step at whose beginning the change happens, from 0.
    pub step: u64,
    /// alpha and gamma from this step on.
    pub perception: Perception,
}

/// A change as it is serialised.
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

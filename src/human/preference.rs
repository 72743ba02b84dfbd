//! The paper's human, who chooses by eq. (3) and takes the lead by eq. (5).

use super::model::{HumanModel, Participant, PreferenceChange, bad_arguments};
use super::{Human, HumanDecision, HumanView};
use crate::coordination::{Stubbornness, StubbornnessSettings};
use crate::preference::{PerceivedRisks, Perception};
use crate::saved::{RestoreError, Saved};
use serde::{Deserialize, Serialize};

/// The model's entry in the list.
pub(super) const MODEL: HumanModel = HumanModel {
    name: "preference",
    form: "preference",
    about: "Prefers the option of least subjective cost, eq. (3)",
    make: |arguments, participant| match arguments {
        "" => Ok(Box::new(PreferenceHuman::of(participant))),
        _ => Err(bad_arguments("preference, with no arguments")),
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
    #[serde(skip)]
    perceived: PerceivedRisks,
}

impl PreferenceHuman {
    /// A human without preference changes.
    pub fn new(perception: Perception, stubbornness: StubbornnessSettings) -> Self {
        Self {
            perception,
            changes: Vec::new(),
            stubbornness: Stubbornness::new(stubbornness),
            perceived: PerceivedRisks::default(),
        }
    }

    /// This participant as the paper's human.
    pub(super) fn of(participant: &Participant<'_>) -> Self {
        Self::new(participant.perception, participant.stubbornness).with_changes(participant.changes)
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
        let Self { perceived, .. } = self;
        let option = perceived.human_choice(view.prospects, view.risk_weight, perception, view.executed);
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

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        let changes = std::mem::take(&mut self.changes);
        *self = saved.read("human")?;
        self.changes = changes;
        Ok(())
    }
}

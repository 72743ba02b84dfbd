//! The robot's learning about the human in a step.

use super::evaluated::Prediction;
use super::now::Now;
use super::{Episode, Tick};
use crate::coordination::{Mode, is_misaligned, misalignment};
use crate::human::{HumanDecision, Stance};
use crate::learning::Learner;
use crate::policy::Lead;

/// Whether a human on each option would walk as this human does in a step; `None` where the human does not
/// choose the way.
pub(super) fn is_consistent(tick: &Tick, lead: Lead) -> Option<impl Iterator<Item = bool> + '_> {
    let is_free = match lead {
        Lead::Robot(_) => false,
        Lead::Human => true,
        // the option was chosen at the start
        Lead::HumanKeepingOption => tick.step == 0,
    };
    let toward = tick.options[tick.executed].remaining.next;
    let is_consistent = tick.options.iter().map(move |o| !is_misaligned(toward, o.remaining.next));
    (is_free && tick.reverses_for.is_none()).then_some(is_consistent)
}

impl<'a> Episode<'a> {
    /// The same episode with a robot that starts from `learner`. Call it before the
    /// first step; the learner's next task begins.
    #[must_use]
    pub fn with_learner(mut self, mut learner: Learner) -> Self {
        learner.begin_task();
        self.learner = Some(Box::new(learner));
        self
    }

    /// The robot's belief about the human; `None` if it does not learn.
    pub fn learner(&self) -> Option<&Learner> {
        self.learner.as_deref()
    }

    /// The robot's belief about the human, taken out of the episode.
    pub fn into_learner(self) -> Option<Learner> {
        self.learner.map(|learner| *learner)
    }

    /// Learns from the last step, if the human led it: its direction is that of every option with the same
    /// next waypoint.
    pub(super) fn learn_from_walk(&mut self) {
        let Some(learner) = self.learner.as_deref_mut() else { return };
        let Some((_, decision)) = &self.decided else { return };
        let Some(is_consistent) = is_consistent(&self.tick, decision.lead) else { return };
        // impossible only without lapses: such a sighting is then left out
        drop(learner.observe_walk(&self.prospects, &self.ways, is_consistent));
    }

    /// Learns from the human's response to the robot's lead. Returns phi(k) as the robot takes it: the
    /// human's, or its mean over what was learned about eta.
    pub(super) fn learn_from_lead(&mut self, now: Now, human: &HumanDecision, prior: &Prediction) -> f64 {
        let Some(learner) = self.learner.as_deref_mut() else { return human.stubbornness };
        if now.mode == Mode::RobotLed && now.executed.is_some() {
            learner.observe_led_step(misalignment(&prior.options), human.stance == Stance::TakeOver);
        }
        learner.stubbornness()
    }
}

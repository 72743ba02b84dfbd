//! What the human and the robot's policy see in a step, and their decisions.

use super::Episode;
use super::evaluated::{Evaluated, Prediction};
use super::step::Begun;
use crate::coordination::Mode;
use crate::human::{HumanDecision, HumanView};
use crate::options::{OptionSet, Progress};
use crate::plant::Seen;
use crate::policy::{Decision, RobotView};

/// The beginning of a step.
#[derive(Clone, Copy)]
pub(super) struct Now {
    /// k, from 0.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// The mode of the last step.
    pub mode: Mode,
    /// The option executed in the last step; none before the first.
    pub executed: Option<usize>,
}

impl Episode<'_> {
    /// The beginning of the present step.
    pub(super) fn now(&self) -> Now {
        let step = self.summary.steps;
        let time = step as f64 * self.settings.period;
        match step {
            0 => Now { step, time, mode: self.policy.initial_mode(), executed: None },
            _ => Now { step, time, mode: self.tick.mode, executed: Some(self.tick.executed) },
        }
    }

    /// The human's decision.
    pub(super) fn ask_human(&mut self, now: Now, evaluated: &Evaluated, prior: &Prediction) -> HumanDecision {
        let Now { step, time, mode, executed } = now;
        let bodies = self.plant.observe().bodies;
        self.human.decide(&HumanView {
            step,
            time,
            position: self.progress.position,
            options: self.options,
            prospects: &evaluated.prospects,
            evaluated: &prior.options,
            risk_weight: self.predictor.risk_weight(),
            executed,
            mode,
            hand: bodies.map(|bodies| &bodies.hand),
            wrench: bodies.map(|bodies| &bodies.hand_grip.mean),
        })
    }

    /// The view of the robot's policy in a step that has begun; `None` between steps.
    pub fn robot_view(&self) -> Option<RobotView<'_>> {
        let begun = self.begun.as_ref()?;
        Some(view(self.now(), begun, self.options, &self.progress, self.plant.observe()))
    }

    /// The decision of the episode's own policy in a step that has begun; between steps, to follow.
    pub fn ask_policy(&mut self) -> Decision {
        let now = self.now();
        let Some(begun) = &self.begun else { return Decision::follow() };
        self.policy.decide(&view(now, begun, self.options, &self.progress, self.plant.observe()))
    }
}

/// What the robot sees in a step.
pub(super) fn view<'v>(
    now: Now,
    begun: &'v Begun,
    options: &'v OptionSet,
    progress: &'v Progress,
    seen: Seen<'v>,
) -> RobotView<'v> {
    let Now { step, time, mode, executed } = now;
    let Seen { position: _, human: _, configuration, grasp, bodies } = seen;
    RobotView {
        step,
        time,
        position: progress.position,
        options,
        progress,
        evaluated: &begun.predicted.robots().options,
        executed,
        mode,
        stance: begun.human.stance,
        stubbornness: begun.stubbornness,
        discomfort: begun.human.discomfort,
        configuration,
        grasp,
        object: bodies.map(|bodies| &bodies.object),
        hand: bodies.map(|bodies| &bodies.hand),
        grip_wrench: bodies.map(|bodies| &bodies.grip.mean),
        hand_wrench: bodies.map(|bodies| &bodies.hand_grip.mean),
    }
}

//! The views of the human and of the robot's policy in a step, and their decisions.

use super::evaluated::{Evaluated, Prediction};
use super::now::Now;
use super::step::Begun;
use super::{Episode, EpisodeSettings};
use crate::human::{HumanDecision, HumanView};
use crate::options::{OptionSet, Progress};
use crate::plant::Seen;
use crate::policy::{Decision, RobotView};

impl Episode<'_> {
    /// The human's decision.
    pub(super) fn ask_human(&mut self, now: Now, evaluated: &Evaluated, prior: &Prediction) -> HumanDecision {
        let Now { step, time, mode, executed } = now;
        let bodies = self.plant.observe().bodies;
        self.human.decide(&HumanView {
            step,
            time,
            planning_step: self.settings.planning_step,
            position: self.progress.position,
            options: self.options,
            progress: &self.progress,
            prospects: &evaluated.prospects,
            evaluated: &prior.options,
            risk_weight: self.predictor.risk_weight(),
            executed,
            mode,
            hand: bodies.map(|bodies| &bodies.hand),
            wrench: bodies.map(|bodies| &bodies.hand_grip.mean),
        })
    }

    /// The view of the robot's policy in a step that has begun; `None` between steps. While the step is carried
    /// out, bodies and forces are the present ones.
    pub fn robot_view(&self) -> Option<RobotView<'_>> {
        let begun = self.present()?;
        Some(view(self.now(), self.settings, begun, self.options, &self.progress, self.plant.observe()))
    }

    /// The present step; `None` between steps.
    pub(super) fn present(&self) -> Option<&Begun> {
        self.begun.as_ref().or(self.carried.as_ref().map(|carried| &carried.begun))
    }

    /// The decision of the episode's policy in a step that has begun; between steps, the decision to follow.
    pub fn ask_policy(&mut self) -> Decision {
        let now = self.now();
        let Some(begun) = &self.begun else { return Decision::follow() };
        self.policy.decide(&view(
            now,
            self.settings,
            begun,
            self.options,
            &self.progress,
            self.plant.observe(),
        ))
    }
}

/// The robot's view in a step.
pub(super) fn view<'v>(
    now: Now,
    settings: &EpisodeSettings,
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
        planning_step: settings.planning_step,
        position: progress.position,
        options,
        progress,
        evaluated: &begun.predicted.robots().options,
        prescribed: settings.lead_option.map(|number| number as usize - 1),
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

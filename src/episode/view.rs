//! What the human and the robot's policy see in a step, and their decisions.

use super::{Episode, Tick};
use crate::coordination::Mode;
use crate::human::{HumanDecision, HumanView};
use crate::options::{OptionSet, Progress};
use crate::policy::{Decision, RobotView};
use crate::team::Team;

impl Episode<'_> {
    /// The human's decision.
    pub(super) fn ask_human(&mut self) -> HumanDecision {
        let seen = self.team.observation();
        let decision = self.human.decide(&HumanView {
            step: self.tick.step,
            time: self.tick.time,
            position: self.tick.position,
            options: self.options,
            prospects: &self.prospects,
            evaluated: &self.tick.options,
            risk_weight: self.predictor.risk_weight(),
            executed: self.underway.then_some(self.tick.executed),
            mode: self.mode,
            hand: seen.map(|seen| &seen.hand),
            wrench: seen.map(|seen| &seen.hand_grip.mean),
        });
        let before = self.underway.then_some(self.tick.preferred);
        let has_changed = self.human.change(self.tick.step).is_some();
        self.summary.human.add(&decision, before, has_changed);
        self.tick.preferred = decision.option;
        self.tick.stubbornness = decision.stubbornness;
        self.tick.discomfort = decision.discomfort;
        decision
    }

    /// The view of the robot's policy in a step that has begun; `None` between steps.
    pub fn robot_view(&self) -> Option<RobotView<'_>> {
        let human = self.human_decision.as_ref()?;
        let executed = self.underway.then_some(self.tick.executed);
        Some(view(self.options, &self.progress, &self.tick, self.team.as_ref(), self.mode, executed, human))
    }

    /// The decision of the episode's own policy in a step that has begun; between steps, to follow.
    pub fn ask_policy(&mut self) -> Decision {
        let Some(human) = self.human_decision else { return Decision::follow() };
        let executed = self.underway.then_some(self.tick.executed);
        let (progress, team) = (&self.progress, self.team.as_ref());
        self.policy.decide(&view(self.options, progress, &self.tick, team, self.mode, executed, &human))
    }
}

/// What the robot sees in the step of `tick`.
fn view<'v>(
    options: &'v OptionSet,
    progress: &'v Progress,
    tick: &'v Tick,
    team: &'v dyn Team,
    mode: Mode,
    executed: Option<usize>,
    human: &'v HumanDecision,
) -> RobotView<'v> {
    RobotView {
        step: tick.step,
        time: tick.time,
        position: tick.position,
        options,
        progress,
        evaluated: &tick.options,
        executed,
        mode,
        human,
        configuration: team.configuration(),
        grasp: team.grasp(),
        seen: team.observation(),
    }
}

//! How a decision is carried out: the option executed, the path of a step, and where it led.

use super::Episode;
use super::now::Now;
use crate::coordination::Mode;
use crate::human::{HumanDecision, Stance};
use crate::policy::{Decision, Lead};
use crate::team::TurnOutcome;

impl Episode<'_> {
    /// Distance walked in a step, m.
    pub(super) fn per_step(&self) -> f64 {
        self.settings.speed * self.settings.period
    }

    /// Takes the path of the option that a decision asks for, or turns toward it. Returns the option executed,
    /// and the one for which the team reverses first.
    pub(super) fn execute(
        &mut self,
        now: Now,
        human: &HumanDecision,
        lead: &Decision,
    ) -> (usize, Option<usize>) {
        let option = self.option(now, human, lead);
        match now.executed {
            None => {
                let path = self.options.path(&self.progress, option).unwrap_or_default();
                self.route.begin(self.walk.walkable(path));
                (option, None)
            }
            Some(executed) if executed == option => {
                self.route.keep();
                (executed, None)
            }
            Some(executed) => {
                let walk = self.walk.as_mut();
                match self.route.turn_onto(option, walk, self.options, &self.progress) {
                    TurnOutcome::Turned => (option, None),
                    TurnOutcome::Reverses => (executed, Some(option)),
                    TurnOutcome::GoesOn => (executed, None),
                }
            }
        }
    }

    /// The option that a decision asks for.
    pub(super) fn option(&self, now: Now, human: &HumanDecision, lead: &Decision) -> usize {
        match lead.lead {
            Lead::Robot(option) => option.min(self.options.options().len() - 1),
            Lead::Human => human.option,
            Lead::HumanKeepingOption => now.executed.unwrap_or(human.option),
        }
    }

    /// The position along the path (m) at which a step should end.
    pub(super) fn to(&self, mode: Mode, human: &HumanDecision) -> f64 {
        let (from, length) = (self.route.along, self.route.path.length());
        let resists = human.stance == Stance::Resist && mode == Mode::RobotLed;
        let to = if resists { from } else { from + self.per_step() };
        // a remainder shorter than rounding is not a step of its own
        if to >= length - 1e-9 { length } else { to }
    }

    /// Brings the progress to where the team has come on its path, `along` (m), from `from` (m).
    pub(super) fn arrive(&mut self, from: f64, along: f64) {
        let came_on = (along - from).abs() > 0.1 * self.per_step();
        self.steps_without_progress = if came_on { 0 } else { self.steps_without_progress + 1 };
        let position = self.point_at(along);
        self.options.advance(&mut self.progress, position);
        self.route.along = along;
    }
}

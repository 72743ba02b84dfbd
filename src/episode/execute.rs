//! How a decision is carried out: the option executed, the path of a step, and where it led.

use super::Episode;
use super::now::Now;
use crate::coordination::Mode;
use crate::geometry::{PlanarPose, Point};
use crate::human::{HandView, HumanDecision, Stance};
use crate::policy::{Decision, Lead};
use crate::team::TurnOutcome;

impl Episode<'_> {
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
                let passing = self.walk.passing();
                let path = self.options.path_passing(&self.progress, option, passing).unwrap_or_default();
                self.route.begin(self.walk.begin(path));
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

    /// Where the human's hand goes by the end of a control period, if the human says so; only on plants with
    /// bodies.
    pub(super) fn hand(&mut self, decision: &HumanDecision, period: [u32; 2]) -> Option<Point> {
        let control_period = self.settings.control_period();
        let time = self.now().time + control_period * f64::from(period[0]);
        let bodies = self.plant.observe().bodies?;
        let PlanarPose { position: now, yaw: heading } = bodies.hand_planar;
        if period[0] == 0 {
            self.hand_from = now;
            self.hands.clear();
        }
        let (hand, wrench) = ([self.hand_from, now], Some(&bodies.hand_grip.mean));
        let view = HandView { time, period, control_period, decision, hand, heading, wrench };
        let own = self.human.hand(&view);
        if own.is_some() {
            self.hands.resize(period[0] as usize, None);
            self.hands.push(own);
        }
        own.or_else(|| view.toward_target())
    }

    /// The position along the path (m) at which a control period should end.
    pub(super) fn to(&self, mode: Mode, stance: Stance) -> f64 {
        let (from, length) = (self.route.along, self.route.path.length());
        let resists = stance == Stance::Resist && mode == Mode::RobotLed;
        let to = if resists { from } else { from + self.settings.speed * self.settings.control_period() };
        // a remainder shorter than rounding is not a step of its own
        if to >= length - 1e-9 { length } else { to }
    }

    /// Brings the progress to where the team has come on its path, `along` (m), which is `position`. Returns
    /// the distance walked, m.
    pub(super) fn come_to(&mut self, along: f64, position: Point) -> f64 {
        self.options.advance(&mut self.progress, position);
        (along - std::mem::replace(&mut self.route.along, along)).abs()
    }
}

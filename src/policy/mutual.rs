//! The paper's policy: the robot leads until the human's stubbornness exceeds 1, then follows.

use super::{Decision, MethodEntry, RobotPolicy, RobotView};
use crate::coordination::Mode;
use crate::human::Stance;

/// The policy's entry in the list.
pub(super) const METHOD: MethodEntry = MethodEntry {
    name: "mutual",
    about: "The robot leads until the human's stubbornness exceeds 1, then follows",
    make: || Box::new(Mutual),
};

/// A robot that leads by eq. (6) while phi(k) <= 1, then follows to the end. The transition happens once
/// (Sec. IV-B.2).
#[derive(Clone, Debug)]
struct Mutual;

impl RobotPolicy for Mutual {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        if view.mode == Mode::HumanLed || view.stance == Stance::TakeOver {
            return Decision::follow();
        }
        Decision::lead(view.best_option())
    }
}

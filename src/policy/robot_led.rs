//! The baseline of hypothesis H2 as worded: the robot leads from start to end.

use super::{Decision, MethodEntry, RobotPolicy, RobotView};

/// The policy's entry in the list.
pub(super) const METHOD: MethodEntry = MethodEntry {
    name: "robot-led",
    about: "The robot leads from start to end",
    make: || Box::new(RobotLed),
};

/// A robot that leads by eq. (6), whatever the human does.
#[derive(Clone, Debug)]
struct RobotLed;

impl RobotPolicy for RobotLed {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        Decision::lead(view.best_option())
    }
}

//! The setting of Table III: the human leads from start to end.

use super::{Decision, MethodEntry, RobotPolicy, RobotView};
use crate::coordination::Mode;

/// The policy's entry in the list.
pub(super) const METHOD: MethodEntry = MethodEntry {
    name: "human-led",
    about: "The human leads from start to end, choosing anew at every step",
    make: || Box::new(HumanLed),
};

/// A robot that follows the human, who may change option.
#[derive(Clone, Debug)]
struct HumanLed;

impl RobotPolicy for HumanLed {
    fn initial_mode(&self) -> Mode {
        Mode::HumanLed
    }

    fn decide(&mut self, _: &RobotView<'_>) -> Decision {
        Decision::follow()
    }
}

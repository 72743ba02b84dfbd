//! The baseline of Table II: the human leads from start to end, on the option preferred at the start.

use super::{Decision, Lead, MethodEntry, Motion, RobotPolicy, RobotView};
use crate::coordination::Mode;

/// The policy's entry in the list.
pub(super) const METHOD: MethodEntry = MethodEntry {
    name: "without-model",
    about: "The human leads from start to end, on the option preferred at the start",
    make: || Box::new(WithoutModel),
};

/// A robot that follows the human, who keeps the first option.
#[derive(Clone, Debug)]
struct WithoutModel;

impl RobotPolicy for WithoutModel {
    fn initial_mode(&self) -> Mode {
        Mode::HumanLed
    }

    fn decide(&mut self, _: &RobotView<'_>) -> Decision {
        Decision { lead: Lead::HumanKeepingOption, motion: Motion::Controlled }
    }
}

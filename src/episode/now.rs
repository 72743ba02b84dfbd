//! Where an episode is: k, and what the last step left.

use super::Episode;
use crate::coordination::Mode;

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
}

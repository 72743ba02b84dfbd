//! The end of an episode: when there is nothing more to step.

use super::{Episode, Outcome};

/// Number of steps without progress after which a team is stuck: ten seconds.
const STUCK_STEPS: u32 = 50;

impl Episode<'_> {
    /// The outcome of an episode that is over.
    pub(super) fn ended(&self) -> Option<Outcome> {
        if let Some(outcome) = self.summary.incident() {
            return Some(outcome);
        }
        if self.summary.steps > 0 && self.route.along >= self.route.path.length() {
            let at_target = (self.progress.position - self.options.target()).norm() < 1e-6;
            return Some(if at_target { Outcome::Arrived } else { Outcome::NoWay });
        }
        if self.steps_without_progress > STUCK_STEPS {
            return Some(Outcome::Stuck);
        }
        (self.summary.steps >= self.tick_limit).then_some(Outcome::OutOfTime)
    }
}

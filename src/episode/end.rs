//! The end of an episode: when there is nothing more to step.

use super::{Episode, Outcome};

/// Time without progress after which a team is stuck, s.
const STUCK_S: f64 = 10.0;

impl Episode<'_> {
    /// The outcome of an episode that is over; `None` while it goes on. Valid between steps only.
    pub fn ended(&self) -> Option<Outcome> {
        if let Some(outcome) = self.summary.incident() {
            return Some(outcome);
        }
        if self.summary.steps > 0 && self.route.along >= self.route.path.length() {
            let at_target = (self.progress.position - self.options.target()).norm() < 1e-6;
            return Some(if at_target { Outcome::Arrived } else { Outcome::NoWay });
        }
        if f64::from(self.steps_without_progress) * self.settings.planning_step > STUCK_S + 1e-9 {
            return Some(Outcome::Stuck);
        }
        (self.summary.steps >= self.tick_limit).then_some(Outcome::OutOfTime)
    }
}

//! How an episode ended, and what is worth knowing of it afterwards.

use crate::geometry::Point;

/// How an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The team stands at the target.
    Arrived,
    /// The tick limit passed before.
    OutOfTime,
    /// No way leads on from where the team stands.
    NoWay,
}

/// The one transition from robot-led to human-led.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// k at which phi first exceeded 1.
    pub step: u64,
    /// Where the team was, m, world frame.
    pub position: Point,
}

/// What is worth knowing of an episode afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// How it ended.
    pub outcome: Outcome,
    /// Planning steps taken.
    pub steps: u64,
    /// Way walked, m.
    pub walked: f64,
    /// Sum over the steps of J of the option executed, m.
    pub accumulated_cost: f64,
    /// The option executed first.
    pub first_option: usize,
    /// The option executed last.
    pub last_option: usize,
    /// How often the executed option changed.
    pub changes: u32,
    /// The transition of the mode, if there was one.
    pub transition: Option<Transition>,
}

impl Summary {
    pub(super) fn empty() -> Self {
        Self {
            outcome: Outcome::OutOfTime,
            steps: 0,
            walked: 0.0,
            accumulated_cost: 0.0,
            first_option: 0,
            last_option: 0,
            changes: 0,
            transition: None,
        }
    }
}

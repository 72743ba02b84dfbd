//! One planning step as data: observations, predictions and decisions.

use super::{EndMotions, RobotTick};
use crate::coordination::{Mode, OptionTick};
use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// The observations and decisions of one planning step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tick {
    /// k, from 0.
    pub step: u64,
    /// Simulated time at the beginning of the step, s.
    pub time: f64,
    /// Position of the team at the beginning of the step, m, world frame.
    pub position: Point,
    /// Direction of travel during the step, rad.
    pub heading: f64,
    /// Who leads.
    pub mode: Mode,
    /// phi(k).
    pub stubbornness: f64,
    /// g(k).
    pub discomfort: f64,
    /// The executed option.
    pub executed: usize,
    /// The option that this human would choose from this position.
    pub preferred: usize,
    /// The option for which the team reverses to a place with room to turn; only a team with bodies reverses.
    pub reverses_for: Option<usize>,
    /// J of the executed option, m.
    pub objective_cost: f64,
    /// Sum of `objective_cost` up to and including this step, m.
    pub accumulated_cost: f64,
    /// Every option evaluated at this position, in the order of the option set.
    pub options: Vec<OptionTick>,
    /// The robot's part, in an episode with a robot.
    pub robot: Option<RobotTick>,
    /// How both ends of the object moved, in an episode with a robot.
    pub ends: Option<EndMotions>,
}

impl Tick {
    pub(super) fn empty(position: Point) -> Self {
        Self {
            step: 0,
            time: 0.0,
            position,
            heading: 0.0,
            mode: Mode::RobotLed,
            stubbornness: 0.0,
            discomfort: 0.0,
            executed: 0,
            preferred: 0,
            reverses_for: None,
            objective_cost: 0.0,
            accumulated_cost: 0.0,
            options: Vec::new(),
            robot: None,
            ends: None,
        }
    }
}

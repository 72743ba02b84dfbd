//! One planning step as data: what was observed, predicted and decided.

use crate::coordination::{Mode, OptionTick};
use crate::geometry::Point;
use crate::team::RobotTick;
use serde::{Deserialize, Serialize};

/// What was observed and decided in one planning step.
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
    /// The option that is executed.
    pub executed: usize,
    /// The option that this human would choose from here.
    pub preferred: usize,
    /// The option for which the team steps back to where there is room to turn onto it: only a team with bodies does.
    pub steps_back_for: Option<usize>,
    /// J of the executed option, m.
    pub objective_cost: f64,
    /// Sum of `objective_cost` up to and with this step, m.
    pub accumulated_cost: f64,
    /// Every option as it is from here, in the order of the option set.
    pub options: Vec<OptionTick>,
    /// What the robot did, in an episode that has one.
    pub robot: Option<RobotTick>,
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
            steps_back_for: None,
            objective_cost: 0.0,
            accumulated_cost: 0.0,
            options: Vec::new(),
            robot: None,
        }
    }
}

//! One planning step as data: what was observed, predicted and decided.

use crate::coordination::Mode;
use crate::geometry::Point;
use crate::options::Remaining;

/// What was observed and decided in one planning step.
#[derive(Clone, Debug, PartialEq)]
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
    /// J of the executed option, m.
    pub objective_cost: f64,
    /// Sum of `objective_cost` up to and with this step, m.
    pub accumulated_cost: f64,
    /// Every option as it is from here, in the order of the option set.
    pub options: Vec<OptionTick>,
}

/// One option in one planning step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptionTick {
    /// D_o, S_o and the next waypoint.
    pub remaining: Remaining,
    /// J_o, eq. (1), m.
    pub objective: f64,
    /// J~_o, the expected subjective cost of eq. (6), m; evaluated while the robot leads, else NaN.
    pub expected: f64,
    /// P_o, eq. (4); NaN where it was not evaluated.
    pub probability: f64,
    /// omega_o: whether the team is moving toward something else than this option's next waypoint.
    pub misaligned: bool,
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
            objective_cost: 0.0,
            accumulated_cost: 0.0,
            options: Vec::new(),
        }
    }
}

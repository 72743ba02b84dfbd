//! The weights and choices of eqs. (7) and (8), with the paper's values as defaults.

use super::{Avoid, CandidateSet, PoseCriterion};
use serde::{Deserialize, Serialize};

/// Everything about the controller but the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Q = this times I_6.
    pub state_weight: f64,
    /// R = this times I.
    pub input_weight: f64,
    /// kappa of eq. (8).
    pub pose_weight: f64,
    /// Configurations that eq. (8) chooses among.
    pub candidates: CandidateSet,
    /// What it chooses by.
    pub criterion: PoseCriterion,
    /// Whether eq. (8) also chooses the configuration while the robot leads, for the way that it leads on. The paper's does not.
    pub prepare_while_leading: bool,
    /// What is kept out of obstacles. The paper's eq. (7) knows none.
    pub avoid: Avoid,
    /// How sharply a walking direction tells options apart: concentration of a von Mises distribution about an option's direction.
    pub direction_concentration: f64,
}

impl Default for Settings {
    /// Sec. V-C: Q = 1000 I_6, R = I_9, kappa = 1; |Q| = 15 arm configurations. Directions are taken as known to about 13 degrees.
    fn default() -> Self {
        Self {
            state_weight: 1000.0,
            input_weight: 1.0,
            pose_weight: 1.0,
            candidates: CandidateSet::Arm,
            criterion: PoseCriterion::Expected,
            prepare_while_leading: false,
            avoid: Avoid::Robot,
            direction_concentration: 20.0,
        }
    }
}

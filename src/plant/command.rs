//! The inputs of a plant in a control period: the controller's command, and the human's motion.

use crate::control::SolveOutcome;
use crate::geometry::{PlanarPose, Point};
use crate::robot::{Configuration, InputJacobian, InputVector};
use serde::{Deserialize, Serialize};

/// The robot's motion in a control period, and how the controller found it.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// q* of eq. (8), else the present configuration.
    pub target: Configuration,
    /// Mean rates over the period that lead there, as inputs.
    pub rates: InputVector,
    /// u of eq. (7), which is added to them.
    pub input: InputVector,
    /// How eq. (7) was solved.
    pub outcome: SolveOutcome,
    /// B(q*) of eq. (7); zeros where it was not asked.
    pub input_matrix: InputJacobian,
    /// The pose preparation of eq. (8), in a period that had one.
    pub preparation: Option<Preparation>,
    /// kappa ||q* - q_c||^2.
    pub pose_cost: f64,
}

/// The pose preparation (eq. 8) of one control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preparation {
    /// The option that the robot expects the human to walk; none while the robot leads.
    pub tracked: Option<usize>,
    /// The candidate that eq. (8) chose; 0 is the present configuration.
    pub candidate: usize,
    /// |Q|.
    pub candidates: usize,
    /// Number of eq. (8)'s problems that were solved with limits.
    pub constrained: usize,
}

/// The human's motion in a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumanMotion {
    /// Pose of the hand at the end of the period; none if the hand follows the object. Where the human has no
    /// body, it is the human's.
    pub hand: Option<PlanarPose>,
    /// Heading (rad) to which the body turns; none for the hand's.
    pub facing: Option<f64>,
}

impl Command {
    /// These inputs at a configuration, without pose optimisation.
    pub fn inputs(configuration: &Configuration, input: InputVector) -> Self {
        Self { target: *configuration, input, ..Self::none() }
    }

    /// The command to a team without a robot.
    pub fn none() -> Self {
        Self {
            target: Configuration {
                base: PlanarPose { position: Point::origin(), yaw: 0.0 },
                joints: Default::default(),
            },
            rates: InputVector::zeros(),
            input: InputVector::zeros(),
            outcome: SolveOutcome::Unconstrained,
            input_matrix: InputJacobian::zeros(),
            preparation: None,
            pose_cost: 0.0,
        }
    }
}

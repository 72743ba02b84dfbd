//! The robot's controller: MPC (eq. 7), pose optimisation (eq. 8), and the estimate of the human's intent.
//!
//! All quantities are relative to the grasp's present pose: x(0) = 0, and a reference s(t) is the difference
//! from that pose (translation in metres, rotation vector in radians, world axes).

mod active_set;
mod candidates;
mod closed_form;
mod follow;
mod holonomic;
mod intent;
mod limits;
mod manipulator;
mod mpc;
mod obstacles;
mod pose;
mod qp;
mod reaching;
mod rolling;
mod settings;

pub use candidates::{Candidate, CandidateSet, Neighbourhood};
pub use closed_form::{ClosedForm, ModalReference};
pub use follow::{
    Follower, GUIDE_PRICE, LOOK_OUT_TOLERANCE_M, TURN_PRICE, keep_near, rolled, seen_from_base, set_base,
    turn_toward_grasp,
};
pub use intent::Intent;
pub use limits::{BaseInputs, HalfPlane, Limits};
pub use manipulator::Manipulator;
pub use mpc::{Failure, Mpc, Plan, SolveOutcome};
pub use obstacles::{Avoid, RobotObstacles};
pub use pose::{
    CandidateCost, PoseChoice, PoseOptimiser, PoseProblem, least_singular_value, manipulability, motion_cost,
};
pub use qp::Qp;
pub use settings::{ControlSettings, GUIDE_WIDTH_M, PoseCriterion};

use crate::geometry::{PlanarPose, Pose};
use crate::robot::{MAX_INPUTS, pose_difference};
use nalgebra::SMatrix;

/// H of eq. (7).
pub const HORIZON: usize = 8;

/// s(1..H) of eq. (7): one column per step, relative to the grasp's present pose, world axes; m, then rad.
pub type Reference = SMatrix<f64, 6, HORIZON>;
/// u(0..H-1) of eq. (7): one column per step, rows as in [`InputVector`](crate::robot::InputVector).
pub type Inputs = SMatrix<f64, MAX_INPUTS, HORIZON>;

/// The reference for a grasp at `world_from_grasp` that carries level at `height` (m), from a nominal
/// trajectory (the poses after 1, 2, ... periods). After its end the trajectory stays at its last pose.
/// Without poses the grasp stays where it is.
pub fn reference(
    trajectory: impl Iterator<Item = PlanarPose>,
    world_from_grasp: &Pose,
    height: f64,
) -> Reference {
    let mut reference = Reference::zeros();
    let mut steps = 0;
    for (t, pose) in trajectory.take(HORIZON).enumerate() {
        reference.set_column(t, &pose_difference(&pose.at_height(height), world_from_grasp));
        steps = t + 1;
    }
    for t in steps.max(1)..HORIZON {
        let last = reference.column(t - 1).into_owned();
        reference.set_column(t, &last);
    }
    reference
}

/// A differential drive for tests.
#[cfg(test)]
const DIFFERENTIAL: crate::robot::Drive = crate::robot::Drive {
    kind: crate::robot::DriveKind::Differential,
    track: 0.37,
    wheel_radius: 0.06,
    rim_speed_limit: 1.0,
    turn_rate_limit: 2.0,
    base_radius: 0.25,
};

#[cfg(test)]
mod tests;

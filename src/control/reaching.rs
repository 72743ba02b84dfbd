//! Where points of the arm come to under the inputs that the robot would take.

use super::rolling::Rolling;
use super::{HORIZON, Inputs};
use crate::geometry::{PlanarPose, Point, Vector};
use crate::robot::{Drive, JointVector, MAX_JOINTS};
use nalgebra::{Rotation2, SMatrix};

/// How a point seen from above moves with the joints of the arm.
pub(super) type ArmJacobian = SMatrix<f64, 2, MAX_JOINTS>;

/// Where an arm's joints go: on a base that rolls, linear in the joints' rates.
pub(super) struct Reaching<'r> {
    base: PlanarPose,
    pub rolling: Rolling<'r>,
    /// How far each joint has moved after each step, rad (m).
    moved: [JointVector; HORIZON],
}

impl<'r> Reaching<'r> {
    pub fn new(drive: &Drive, base: &PlanarPose, inputs: &'r Inputs, period: f64) -> Self {
        let mut so_far = JointVector::zeros();
        let moved = std::array::from_fn(|t| {
            so_far += inputs.fixed_view::<MAX_JOINTS, 1>(2, t) * period;
            so_far
        });
        Self { base: *base, rolling: Rolling::new(drive, base, inputs, period), moved }
    }

    /// How far the base has turned after the step `t`.
    pub fn turned(&self, t: usize) -> Rotation2<f64> {
        Rotation2::new(self.rolling.pose(t).yaw - self.base.yaw)
    }

    /// Where a point is after the step `t` that is `carried` away from the base (m) and moves with `arm`: as seen from the base, and in the world.
    pub fn place(&self, carried: Vector, arm: &ArmJacobian, t: usize) -> (Vector, Point) {
        let from_base = self.turned(t) * (carried + arm * self.moved[t]);
        (from_base, self.rolling.pose(t).position + from_base)
    }
}

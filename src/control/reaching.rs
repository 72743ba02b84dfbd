//! Predicted positions of points of the arm under given inputs.

use super::rolling::Rolling;
use super::{HORIZON, Inputs};
use crate::geometry::{PlanarPose, Point, Vector};
use crate::robot::{Drive, JointVector, MAX_JOINTS};
use nalgebra::{Rotation2, SMatrix};

/// The Jacobian of a point seen from above with respect to the arm's joints.
pub(super) type ArmJacobian = SMatrix<f64, 2, MAX_JOINTS>;

/// The prediction for points of the arm: on a rolling base, linear in the joint rates.
pub(super) struct Reaching<'r> {
    base: PlanarPose,
    pub rolling: Rolling<'r>,
    /// The displacement of each joint after each step, rad (m).
    moved: [JointVector; HORIZON],
}

impl<'r> Reaching<'r> {
    pub fn new(drive: &Drive, base: &PlanarPose, inputs: &'r Inputs, period: f64) -> Self {
        let mut so_far = JointVector::zeros();
        let moved = std::array::from_fn(|t| {
            so_far += inputs.fixed_view::<MAX_JOINTS, 1>(drive.inputs(), t) * period;
            so_far
        });
        Self { base: *base, rolling: Rolling::new(drive, base, inputs, period), moved }
    }

    /// The rotation of the base after step `t`.
    pub fn turned(&self, t: usize) -> Rotation2<f64> {
        Rotation2::new(self.rolling.pose(t).yaw - self.base.yaw)
    }

    /// The position of a point after step `t`, relative to the base and in the world. `carried` is its offset
    /// from the base (m), `arm` its Jacobian.
    pub fn place(&self, carried: Vector, arm: &ArmJacobian, t: usize) -> (Vector, Point) {
        let from_base = self.turned(t) * (carried + arm * self.moved[t]);
        (from_base, self.rolling.pose(t).position + from_base)
    }
}

//! Arms that cannot place their grasp in any pose, such as those of fewer than six joints: joint positions that
//! hold it level, in the sense of least squares.

use super::{JointVector, MAX_JOINTS, Robot};
use crate::geometry::rotation_vector;
use nalgebra::{Matrix6, Rotation3, SMatrix, Vector4, Vector6};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::PI;

/// Degrees of freedom of an arm that can place its grasp in any pose.
pub(super) const FULL: usize = 6;
/// The least singular value (m or rad for a unit joint rate) of a direction in which an arm can move its grasp:
/// calibrated URDFs have axes that are not quite parallel, and that is not a freedom.
pub(super) const MIN_FREE: f64 = 0.01;
/// The number of random configurations in which the freedom is counted.
const SAMPLES: usize = 16;
/// How far the grasp of such an arm may be from its height (m) and from its orientation (rad) in a posture:
/// calibrated URDFs have axes that are not quite parallel.
pub(super) const HEIGHT_TOLERANCE_M: f64 = 0.002;
pub(super) const TURN_TOLERANCE_RAD: f64 = 0.005;

/// Iterations of the least squares, at most.
const STEPS: usize = 100;
/// Damping, far below the square of any singular value that matters.
const DAMPING: f64 = 1e-9;
/// The largest change of a joint in an iteration, rad or m.
const MAX_STEP: f64 = 0.4;
/// A step below which the search has converged, rad or m.
const CONVERGED: f64 = 1e-11;

impl Robot {
    /// The number of directions, of six, in which the arm can move and turn its grasp.
    pub(super) fn freedom(&self) -> usize {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let free = (0..SAMPLES).map(|_| {
            let squares = self.squared_singular_values(&self.random_joints(&mut rng));
            squares.iter().filter(|square| **square > MIN_FREE * MIN_FREE).count()
        });
        free.max().unwrap_or(0)
    }

    /// Squares of the singular values of the arm's Jacobian, largest first.
    pub(super) fn squared_singular_values(&self, joints: &JointVector) -> Vector6<f64> {
        let arm = self.arm_jacobian(&self.kinematics(&Self::at_origin(joints)).jacobian);
        let gram: Matrix6<f64> = arm * arm.transpose();
        let mut squares = gram.symmetric_eigenvalues();
        squares.as_mut_slice().sort_unstable_by(|a, b| b.total_cmp(a));
        squares
    }

    /// Random joint positions, within the limits and a turn.
    pub(super) fn random_joints(&self, rng: &mut ChaCha8Rng) -> JointVector {
        let mut joints = JointVector::zeros();
        for (at, joint) in joints.iter_mut().zip(&self.joints) {
            let (lower, upper) = (joint.lower.max(-PI), joint.upper.min(PI));
            *at = lower + (upper - lower).max(0.0) * rng.random::<f64>();
        }
        joints
    }

    /// Joint positions near `joints`, within the limits, with the grasp at `height` (m) and of this
    /// orientation in the drive's frame; where it is in the plane is free. Gauss and Newton's least squares.
    /// `None` if the grasp stays farther off than the tolerances.
    pub(super) fn level(
        &self,
        mut joints: JointVector,
        height: f64,
        turn: &Rotation3<f64>,
    ) -> Option<JointVector> {
        for _ in 0..STEPS {
            let kinematics = self.kinematics(&Self::at_origin(&joints));
            let turned = rotation_vector(&(turn * kinematics.grasp.rotation.inverse()));
            let off = Vector4::new(height - kinematics.grasp.translation.z, turned.x, turned.y, turned.z);
            let arm = self.arm_jacobian(&kinematics.jacobian).fixed_rows::<4>(2).into_owned();
            let gram = arm.tr_mul(&arm) + SMatrix::<f64, MAX_JOINTS, MAX_JOINTS>::identity() * DAMPING;
            let step: JointVector = gram.cholesky()?.solve(&arm.tr_mul(&off));
            let before = joints;
            joints += step * (MAX_STEP / step.amax().max(MAX_STEP));
            for (at, joint) in joints.iter_mut().zip(&self.joints) {
                *at = at.clamp(joint.lower, joint.upper);
            }
            if (joints - before).amax() <= CONVERGED {
                let is_level = off.x.abs() <= HEIGHT_TOLERANCE_M && turned.norm() <= TURN_TOLERANCE_RAD;
                return is_level.then_some(joints);
            }
        }
        None
    }
}

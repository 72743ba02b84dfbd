//! The grasp's pose and the whole-body Jacobian at a [`Configuration`]. No allocation.

use super::{Configuration, InputJacobian, InputVector, MAX_JOINTS, Motion, PointJacobian, Robot};
use crate::geometry::{Pose, direction, left_of};
use nalgebra::{Rotation3, Vector3};

/// The pose of the grasp and its Jacobian at one configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// `world_from_grasp`.
    pub grasp: Pose,
    /// The whole-body Jacobian J(q); B(q) of eq. (7) is the control period times it.
    pub jacobian: InputJacobian,
}

/// A moving joint of the chain, in world axes.
#[derive(Clone, Copy)]
struct Axis {
    /// The input that moves it.
    column: usize,
    motion: Motion,
    origin: Vector3<f64>,
    /// The axis times the joint's ratio.
    direction: Vector3<f64>,
}

impl Axis {
    const NONE: Self = Self {
        column: 0,
        motion: Motion::Revolute,
        origin: Vector3::new(0.0, 0.0, 0.0),
        direction: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Number of points on a link with this offset between its joints, the last one included.
fn points_of_link(link: &Pose, spacing: f64) -> usize {
    ((link.translation.vector.norm() / spacing).ceil() as usize).max(1)
}

impl Robot {
    /// `world_from_grasp` at a configuration.
    pub fn grasp_pose(&self, q: &Configuration) -> Pose {
        self.follow_chain(q, |_, _| ()).1
    }

    /// The grasp's pose and the whole-body Jacobian at a configuration.
    pub fn kinematics(&self, q: &Configuration) -> Kinematics {
        let (axes, grasp) = self.follow_chain(q, |_, _| ());
        let axes = &axes[..self.chain.len()];
        let mut jacobian = InputJacobian::zeros();
        jacobian.fixed_rows_mut::<3>(0).copy_from(&self.point_jacobian(q, &grasp.translation.vector, axes));
        for axis in axes.iter().filter(|a| a.motion == Motion::Revolute) {
            let mut angular = jacobian.fixed_view_mut::<3, 1>(3, axis.column);
            angular += axis.direction;
        }
        if self.drive.is_omnidirectional() {
            jacobian[(5, 2)] = 1.0;
        } else {
            jacobian[(5, 0)] = -1.0 / self.drive.track;
            jacobian[(5, 1)] = 1.0 / self.drive.track;
        }
        Kinematics { grasp, jacobian }
    }

    /// Calls `on_point` for every moving joint of the arm, from the base outward, and finally for the grasp;
    /// and for points between two of them, evenly spaced, where the link is longer than `spacing` (m). The
    /// arguments are the point's position (m, world frame) and the derivative of the position with respect to
    /// the inputs, one column per input as in [`InputVector`]. No allocation.
    pub fn arm_points(
        &self,
        q: &Configuration,
        spacing: f64,
        mut on_point: impl FnMut(Vector3<f64>, &PointJacobian),
    ) {
        let mut last = None;
        let mut on_link = |at: Vector3<f64>, link: &Pose, axes: &[Axis]| {
            let from = last.replace(at).unwrap_or(at);
            let parts = if from == at { 1 } else { points_of_link(link, spacing) };
            for part in 1..=parts {
                let point = if part < parts { from + (at - from) * (part as f64 / parts as f64) } else { at };
                on_point(point, &self.point_jacobian(q, &point, axes));
            }
        };
        let (axes, grasp) = self.follow_chain(q, |at, before| {
            on_link(at, &self.chain[before.len()].before_from_joint, before);
        });
        on_link(grasp.translation.vector, &self.last_from_grasp, &axes[..self.chain.len()]);
    }

    /// The largest number of points that [`Robot::arm_points`] has.
    pub fn arm_point_count(&self, spacing: f64) -> usize {
        let links = self.chain.iter().map(|link| &link.before_from_joint).chain([&self.last_from_grasp]);
        links.map(|link| points_of_link(link, spacing)).sum()
    }

    /// The axes of the chain's joints (as many as it has) and `world_from_grasp`. `on_joint` receives the
    /// position of each joint and the axes before it.
    fn follow_chain(
        &self,
        q: &Configuration,
        mut on_joint: impl FnMut(Vector3<f64>, &[Axis]),
    ) -> ([Axis; 2 * MAX_JOINTS], Pose) {
        let mut axes = [Axis::NONE; 2 * MAX_JOINTS];
        let first = self.drive.inputs();
        let mut frame = q.base.at_height(0.0);
        for (i, link) in self.chain.iter().enumerate() {
            frame *= link.before_from_joint;
            let origin = frame.translation.vector;
            on_joint(origin, &axes[..i]);
            let direction = frame.rotation * link.axis.into_inner();
            let position = link.ratio * q.joints[link.joint] + link.offset;
            let motion = link.motion;
            axes[i] = Axis { column: link.joint + first, motion, origin, direction: direction * link.ratio };
            match motion {
                Motion::Revolute => frame.rotation *= Rotation3::from_axis_angle(&link.axis, position),
                Motion::Prismatic => frame.translation.vector += direction * position,
            }
        }
        (axes, frame * self.last_from_grasp)
    }

    /// The Jacobian of a point at `at` (m, world frame) that the base and the joints of these axes carry.
    fn point_jacobian(&self, q: &Configuration, at: &Vector3<f64>, axes: &[Axis]) -> PointJacobian {
        let mut jacobian = PointJacobian::zeros();
        for axis in axes {
            let mut linear = jacobian.column_mut(axis.column);
            linear += match axis.motion {
                Motion::Revolute => axis.direction.cross(&(at - axis.origin)),
                Motion::Prismatic => axis.direction,
            };
        }
        let ahead = direction(q.base.yaw);
        let lever = at.xy() - q.base.position.coords;
        if self.drive.is_omnidirectional() {
            for (column, slope) in [ahead, left_of(ahead), left_of(lever)].iter().enumerate() {
                jacobian.fixed_view_mut::<2, 1>(0, column).copy_from(slope);
            }
            return jacobian;
        }
        for (column, side) in [(0, -1.0), (1, 1.0)] {
            let turn = side / self.drive.track;
            jacobian[(0, column)] = ahead.x / 2.0 - lever.y * turn;
            jacobian[(1, column)] = ahead.y / 2.0 + lever.x * turn;
        }
        jacobian
    }

    /// The configuration after `seconds` of constant input. The base moves on an exact arc; the joints move at
    /// constant rates.
    pub fn advance(&self, q: &Configuration, input: &InputVector, seconds: f64) -> Configuration {
        let joints = self.joint_rates(input) * seconds;
        Configuration {
            base: self.drive.roll(&q.base, &(self.base_input(input) * seconds)),
            joints: q.joints + joints,
        }
    }

    /// A configuration near `joints` whose grasp is at `world_from_grasp`, with the base left where it is.
    /// `None` if Newton's iteration does not come within `tolerance` (m and rad) in a few steps.
    pub fn close(&self, q: &Configuration, world_from_grasp: &Pose, tolerance: f64) -> Option<Configuration> {
        const STEPS: usize = 12;
        let mut q = *q;
        for _ in 0..STEPS {
            let Kinematics { grasp, jacobian } = self.kinematics(&q);
            let error = pose_difference(world_from_grasp, &grasp);
            if error.norm() <= tolerance {
                return Some(q);
            }
            let arm = self.arm_jacobian(&jacobian);
            // least-norm step; the damping is far below the square of any singular value that matters
            let gram = arm * arm.transpose() + nalgebra::Matrix6::identity() * 1e-12;
            q.joints += arm.transpose() * gram.cholesky()?.solve(&error);
        }
        None
    }
}

/// The difference of two poses: translation (m), then rotation vector (rad) of `to * from^-1`, in world axes.
pub fn pose_difference(to: &Pose, from: &Pose) -> nalgebra::Vector6<f64> {
    let linear = to.translation.vector - from.translation.vector;
    let angular = crate::geometry::rotation_vector(&(to.rotation * from.rotation.inverse()));
    nalgebra::Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

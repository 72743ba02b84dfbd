//! The grasp's pose and the whole-body Jacobian at a [`Configuration`]. No allocation.

use super::factor::Factor;
use super::{
    Configuration, InputJacobian, InputVector, JointVector, MAX_JOINTS, Motion, PointJacobian, Robot,
};
use crate::geometry::{Pose, Vector, left_of, turn_about_z};
use arrayvec::ArrayVec;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector1, Vector3};

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
    origin: Vector3<f64>,
    /// The axis times the joint's ratio.
    direction: Vector3<f64>,
}

impl Axis {
    /// The velocity of a point at `at` for a unit rate of the arm joint.
    fn velocity(&self, motion: Motion, at: &Vector3<f64>) -> Vector3<f64> {
        match motion {
            Motion::Revolute => self.direction.cross(&(at - self.origin)),
            Motion::Prismatic => self.direction,
        }
    }
}

/// The axes of a chain, or of its first joints.
type Axes = ArrayVec<Axis, { 2 * MAX_JOINTS }>;

/// `a * b`, written out: the chain is followed thousands of times in a second of simulation.
#[inline]
fn times(a: &Pose, b: &Pose) -> Pose {
    let turn = a.rotation.matrix();
    let (x, y, z) = (turn.column(0).into_owned(), turn.column(1).into_owned(), turn.column(2).into_owned());
    let turned = |v: &Vector3<f64>| x * v.x + y * v.y + z * v.z;
    let columns = b.rotation.matrix();
    let rotation = Matrix3::from_columns(&[
        turned(&columns.column(0).into_owned()),
        turned(&columns.column(1).into_owned()),
        turned(&columns.column(2).into_owned()),
    ]);
    let translation = turned(&b.translation.vector) + a.translation.vector;
    Pose::from_parts(translation.into(), Rotation3::from_matrix_unchecked(rotation))
}

/// Number of points on a link with this offset between its joints, the last one included.
fn points_of_link(link: &Pose, spacing: f64) -> usize {
    ((link.translation.vector.norm() / spacing).ceil() as usize).max(1)
}

impl Robot {
    /// `world_from_grasp` at a configuration.
    pub fn grasp_pose(&self, q: &Configuration) -> Pose {
        self.follow_chain(&q.base.at_height(0.0), &q.joints, &mut Axes::new(), |_, _| ())
    }

    /// The grasp's pose and the whole-body Jacobian at a configuration.
    pub fn kinematics(&self, q: &Configuration) -> Kinematics {
        self.kinematics_on(&q.base.at_height(0.0), &q.joints)
    }

    /// The same for a base at `world_from_drive`.
    fn kinematics_on(&self, world_from_drive: &Pose, joints: &JointVector) -> Kinematics {
        let mut axes = Axes::new();
        let grasp = self.follow_chain(world_from_drive, joints, &mut axes, |_, _| ());
        let mut there = Kinematics { grasp, jacobian: InputJacobian::zeros() };
        let (jacobian, first) = (&mut there.jacobian, self.drive.inputs());
        for (link, axis) in self.chain.iter().zip(&axes) {
            let linear = axis.velocity(link.motion, &grasp.translation.vector);
            let angular = if link.motion == Motion::Revolute { axis.direction } else { Vector3::zeros() };
            for row in 0..3 {
                jacobian[(row, first + link.joint)] += linear[row];
                jacobian[(row + 3, first + link.joint)] += angular[row];
            }
        }
        let slopes = self.base_slopes(world_from_drive, &grasp.translation.vector);
        for (column, slope) in slopes.iter().enumerate().take(first) {
            jacobian[(0, column)] = slope.x;
            jacobian[(1, column)] = slope.y;
        }
        if self.drive.is_omnidirectional() {
            jacobian[(5, 2)] = 1.0;
        } else {
            jacobian[(5, 0)] = -1.0 / self.drive.track;
            jacobian[(5, 1)] = 1.0 / self.drive.track;
        }
        there
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
        let base = q.base.at_height(0.0);
        let mut last = None;
        let mut on_link = |at: Vector3<f64>, link: &Pose, axes: &[Axis]| {
            let from = last.replace(at).unwrap_or(at);
            let parts = if from == at { 1 } else { points_of_link(link, spacing) };
            for part in 1..=parts {
                let point = if part < parts { from + (at - from) * (part as f64 / parts as f64) } else { at };
                on_point(point, &self.point_jacobian(&base, &point, axes));
            }
        };
        let mut axes = Axes::new();
        let grasp = self.follow_chain(&base, &q.joints, &mut axes, |at, before| {
            on_link(at, &self.chain[before.len()].before_from_joint, before);
        });
        on_link(grasp.translation.vector, &self.last_from_grasp, &axes);
    }

    /// The largest number of points that [`Robot::arm_points`] has.
    pub fn arm_point_count(&self, spacing: f64) -> usize {
        let links = self.chain.iter().map(|link| &link.before_from_joint).chain([&self.last_from_grasp]);
        links.map(|link| points_of_link(link, spacing)).sum()
    }

    /// `world_from_grasp`, and the axes of the chain's joints into `axes`. `on_joint` receives the position of
    /// each joint and the axes before it.
    fn follow_chain(
        &self,
        world_from_drive: &Pose,
        joints: &JointVector,
        axes: &mut Axes,
        mut on_joint: impl FnMut(Vector3<f64>, &[Axis]),
    ) -> Pose {
        let mut frame = *world_from_drive;
        for link in &self.chain {
            frame = times(&frame, &link.before_from_joint);
            let origin = frame.translation.vector;
            on_joint(origin, axes);
            let direction = frame.rotation.matrix().column(2).into_owned();
            let position = link.ratio * joints[link.joint] + link.offset;
            axes.push(Axis { origin, direction: direction * link.ratio });
            match link.motion {
                Motion::Revolute => turn_about_z(&mut frame.rotation, position),
                Motion::Prismatic => frame.translation.vector += direction * position,
            }
        }
        times(&frame, &self.last_from_grasp)
    }

    /// The Jacobian of a point at `at` (m, world frame) that the base and the joints of these axes carry.
    fn point_jacobian(&self, base: &Pose, at: &Vector3<f64>, axes: &[Axis]) -> PointJacobian {
        let (mut jacobian, first) = (PointJacobian::zeros(), self.drive.inputs());
        for (link, axis) in self.chain.iter().zip(axes) {
            let mut linear = jacobian.column_mut(first + link.joint);
            linear += axis.velocity(link.motion, at);
        }
        for (column, slope) in self.base_slopes(base, at).iter().enumerate().take(first) {
            jacobian.fixed_view_mut::<2, 1>(0, column).copy_from(slope);
        }
        jacobian
    }

    /// How a point at `at` (m, world frame) that the base carries moves with each of the base's inputs; with a
    /// differential drive the third is 0.
    fn base_slopes(&self, base: &Pose, at: &Vector3<f64>) -> [Vector; 3] {
        let ahead = Vector::new(base.rotation[(0, 0)], base.rotation[(1, 0)]);
        let lever = (at - base.translation.vector).xy();
        if self.drive.is_omnidirectional() {
            return [ahead, left_of(ahead), left_of(lever)];
        }
        let rim = |side: f64| {
            let turn = side / self.drive.track;
            Vector::new(ahead.x / 2.0 - lever.y * turn, ahead.y / 2.0 + lever.x * turn)
        };
        [rim(-1.0), rim(1.0), Vector::zeros()]
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

    /// A configuration near `q` whose grasp is at `world_from_grasp`, with the base left where it is, and the
    /// kinematics there. `None` if Newton's iteration does not come within `tolerance` (m and rad) in a few
    /// steps.
    pub fn close(
        &self,
        q: &Configuration,
        world_from_grasp: &Pose,
        tolerance: f64,
    ) -> Option<(Configuration, Kinematics)> {
        const STEPS: usize = 12;
        let (mut q, base) = (*q, q.base.at_height(0.0));
        for _ in 0..STEPS {
            let there = self.kinematics_on(&base, &q.joints);
            let error = pose_difference(world_from_grasp, &there.grasp);
            if error.norm() <= tolerance {
                return Some((q, there));
            }
            // least-norm step; the damping is far below the square of any singular value that matters
            let arm = self.arm_jacobian(&there.jacobian);
            let mut gram = Matrix6::zeros();
            for column in arm.column_iter().take(self.joints.len()) {
                for j in 0..6 {
                    for i in j..6 {
                        gram[(i, j)] += column[i] * column[j];
                    }
                }
            }
            let factor = Factor::new(1e-12, &Vector1::new(1.0), &gram);
            if !factor.is_definite() {
                return None;
            }
            q.joints += arm.tr_mul(&factor.solve(&error.transpose()).transpose());
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

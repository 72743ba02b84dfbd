//! What an arm at rest can hold: the efforts J^T F of its motors under a load at the grasp. The arm's own
//! weight is taken as compensated, as on the physical plant.

use super::{JointVector, Robot};
use nalgebra::Vector6;

/// Gravity, m/s^2.
pub(crate) const GRAVITY: f64 = 9.81;

/// The joint whose motor a load takes nearest to its effort limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakestJoint<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its effort limit, Nm or N.
    pub limit: f64,
    /// The unit of its limit.
    pub unit: &'static str,
    /// The load at the grasp that its motor holds at its limit, kg.
    pub payload: f64,
}

impl Robot {
    /// Efforts of the joints' motors (Nm or N) that hold a load of `mass` kg at the grasp, at rest: J^T F.
    pub fn holding_efforts(&self, joints: &JointVector, mass: f64) -> JointVector {
        let kinematics = self.kinematics(&Robot::at_origin(joints));
        let lift = Vector6::new(0.0, 0.0, mass * GRAVITY, 0.0, 0.0, 0.0);
        self.arm_jacobian(&kinematics.jacobian).tr_mul(&lift)
    }

    /// The joint that limits what the arm holds at rest in these positions (rad or m): the load at the grasp,
    /// kg.
    /// `None` if no motor with a limit bears any of it.
    pub fn weakest_joint(&self, joints: &JointVector) -> Option<WeakestJoint<'_>> {
        let per_kilogram = self.holding_efforts(joints, 1.0);
        let of_joints = self.joints.iter().zip(per_kilogram.iter()).map(|(joint, effort)| WeakestJoint {
            name: &joint.name,
            limit: joint.effort_limit,
            unit: joint.motion.effort_unit(),
            payload: joint.effort_limit / effort.abs(),
        });
        of_joints.filter(|joint| joint.payload.is_finite()).min_by(|a, b| a.payload.total_cmp(&b.payload))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakest_joint_of_a_stretched_arm_is_the_one_with_the_longest_lever_per_limit() {
        let robot = Robot::built_in().unwrap();
        let joints = robot.postures[0].joints;
        let efforts = robot.holding_efforts(&joints, 2.0);
        let weakest = robot.weakest_joint(&joints).unwrap();
        // a motor at its limit holds exactly the payload
        let at_payload = robot.holding_efforts(&joints, weakest.payload);
        let shares =
            at_payload.iter().zip(&robot.joints).map(|(effort, joint)| effort.abs() / joint.effort_limit);
        assert!((shares.fold(0.0, f64::max) - 1.0).abs() < 1e-12);
        assert!((at_payload / weakest.payload * 2.0 - efforts).amax() < 1e-12);
    }

    #[test]
    fn closed_form_a_lever_about_a_level_axis() {
        // J^T F by the work of lifting: the effort of a joint is the change of the load's height per change of
        // the joint
        let robot = Robot::built_in().unwrap();
        let joints = robot.postures[0].joints;
        let efforts = robot.holding_efforts(&joints, 3.0);
        for i in 0..robot.joint_count() {
            let height = |by: f64| {
                let mut moved = joints;
                moved[i] += by;
                robot.drive_from_grasp(&moved).translation.z
            };
            let slope = (height(1e-6) - height(-1e-6)) / 2e-6;
            assert!((efforts[i] - 3.0 * GRAVITY * slope).abs() < 1e-6, "joint {i}");
        }
    }
}

//! The paper's plant without dynamics: x+ = x + B(q) u, integrated exactly.

use crate::geometry::{PlanarPose, Pose};
use crate::math;
use crate::robot::{Configuration, InputVector, JointVector, Robot};

/// A robot that follows its inputs exactly.
#[derive(Clone, Debug)]
pub struct KinematicPlant<'a> {
    robot: &'a Robot,
    configuration: Configuration,
}

impl<'a> KinematicPlant<'a> {
    /// A robot with these joint positions whose grasp is level at `grasp`, at its carrying height. Postures
    /// of a [`Robot`] hold the grasp level and ahead, so this is exact for them.
    pub fn place(robot: &'a Robot, joints: &JointVector, grasp: &PlanarPose) -> Self {
        let at_origin = PlanarPose { position: Default::default(), yaw: 0.0 };
        let drive_from_grasp = robot.grasp_pose(&Configuration { base: at_origin, joints: *joints });
        let world_from_drive = grasp.at_height(robot.grasp_height) * drive_from_grasp.inverse();
        let ahead = world_from_drive.rotation * nalgebra::Vector3::x();
        let base = PlanarPose {
            position: world_from_drive.translation.vector.xy().into(),
            yaw: math::atan2(ahead.y, ahead.x),
        };
        Self { robot, configuration: Configuration { base, joints: *joints } }
    }

    /// A robot at a given configuration.
    pub fn at(robot: &'a Robot, configuration: Configuration) -> Self {
        Self { robot, configuration }
    }

    /// The present configuration.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// `world_from_grasp`.
    pub fn grasp(&self) -> Pose {
        self.robot.grasp_pose(&self.configuration)
    }

    /// Moves the robot by one period (s): to `configuration` and by `input` at the same time. On this plant
    /// the first motion is instantaneous.
    pub fn step(&mut self, configuration: &Configuration, input: &InputVector, period: f64) {
        self.configuration = self.robot.advance(configuration, input, period);
    }
}

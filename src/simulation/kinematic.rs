//! The paper's plant, without dynamics: x+ = x + B(q) u, integrated exactly.

use crate::geometry::{PlanarPose, Pose};
use crate::math;
use crate::robot::{Configuration, InputVector, JointVector, Robot};

/// A robot that moves exactly as it is told.
#[derive(Clone, Debug)]
pub struct KinematicPlant<'a> {
    robot: &'a Robot,
    configuration: Configuration,
}

impl<'a> KinematicPlant<'a> {
    /// A robot with these joint positions, standing such that its grasp is level at `grasp`, at the height that it carries at. Postures of a
    /// [`Robot`] hold the grasp level and ahead, so that this is exact for them.
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

    /// A robot that is there already.
    pub fn at(robot: &'a Robot, configuration: Configuration) -> Self {
        Self { robot, configuration }
    }

    /// Where the robot is.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// `world_from_grasp`.
    pub fn grasp(&self) -> Pose {
        self.robot.grasp_pose(&self.configuration)
    }

    /// One period (s): the robot goes over to `configuration` and moves by `input` at the same time. On this plant, the first is instant.
    pub fn step(&mut self, configuration: &Configuration, input: &InputVector, period: f64) {
        self.configuration = self.robot.advance(configuration, input, period);
    }
}

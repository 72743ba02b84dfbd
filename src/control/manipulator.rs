//! The robot of a team with the settings of its controller.

use super::{ControlSettings, RobotObstacles};
use crate::robot::{JointVector, Robot};

/// The robot, its starting posture and its controller's settings.
#[derive(Clone, Copy, Debug)]
pub struct Manipulator<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its joint positions at the start.
    pub posture: JointVector,
    /// The weights and choices of eqs. (7) and (8).
    pub control: ControlSettings,
    /// The obstacles of the world.
    pub obstacles: &'a RobotObstacles,
}

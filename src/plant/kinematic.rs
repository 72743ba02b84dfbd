//! The kinematic plant, as in the paper's simulations: the human's state is the reference, and the robot
//! follows its inputs exactly.

use super::{Command, HumanMotion, Plant, Seen};
use crate::geometry::{PlanarPose, Pose};
use crate::robot::{Configuration, JointVector, Robot};
use crate::saved::{RestoreError, Saved};
use crate::simulation::KinematicPlant;

/// Human and robot without dynamics.
#[derive(Clone, Debug)]
pub struct Kinematic<'a> {
    robot: &'a Robot,
    plant: KinematicPlant<'a>,
    /// `world_from_grasp`.
    grasp: Pose,
    /// s(k): the human's state, as the pose that the grasp should have.
    human: PlanarPose,
}

impl<'a> Kinematic<'a> {
    /// A robot with these joint positions and its grasp at `start`, where the human is.
    pub fn new(robot: &'a Robot, posture: &JointVector, start: PlanarPose) -> Self {
        let plant = KinematicPlant::place(robot, posture, &start);
        Self { robot, grasp: plant.grasp(), plant, human: start }
    }
}

impl Plant for Kinematic<'_> {
    fn observe(&self) -> Seen<'_> {
        Seen {
            position: self.human.position,
            configuration: Some(self.plant.configuration()),
            grasp: Some(self.grasp),
            human: Some(self.human),
            bodies: None,
        }
    }

    fn step(&mut self, command: &Command, human: &HumanMotion, period: f64) {
        self.human = human.hand.unwrap_or(self.human);
        self.plant.step(&command.target, &command.input, period);
        self.grasp = self.plant.grasp();
    }

    fn save(&self) -> Saved {
        Saved::of(&(self.human, self.plant.configuration()))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        let (human, configuration): (PlanarPose, Configuration) = saved.read("plant")?;
        self.human = human;
        self.plant = KinematicPlant::at(self.robot, configuration);
        self.grasp = self.plant.grasp();
        Ok(())
    }
}

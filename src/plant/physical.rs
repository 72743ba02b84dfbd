//! The physical plant: robot, object and human as bodies in rapier.

use super::{Command, HumanMotion, Plant, Seen, on_floor};
use crate::geometry::{PlanarPose, Pose};
use crate::robot::{JointVector, Robot};
use crate::saved::{NotRestored, Saved};
use crate::simulation::{HumanCommand, Observation, PhysicalPlant, PhysicsError, PhysicsSettings};
use crate::world::World;

/// Robot, object and human with dynamics and contacts.
#[derive(Clone)]
pub struct Physical<'a> {
    robot: &'a Robot,
    plant: PhysicalPlant,
    seen: Observation,
}

impl<'a> Physical<'a> {
    /// A team at rest with the object's centre at `start`. `seed` determines the gait.
    ///
    /// # Errors
    /// As [`PhysicalPlant::new`].
    pub fn new(
        world: &World,
        robot: &'a Robot,
        posture: &JointVector,
        start: &PlanarPose,
        settings: &PhysicsSettings,
        seed: u64,
    ) -> Result<Self, PhysicsError> {
        let plant = PhysicalPlant::new(world, robot, posture, start, settings, seed)?;
        Ok(Self { robot, seen: plant.observe(), plant })
    }
}

impl Plant for Physical<'_> {
    fn observe(&self) -> Seen<'_> {
        let configuration = &self.seen.configuration;
        Seen {
            position: on_floor(&self.seen.object),
            configuration: Some(configuration),
            grasp: Some(self.robot.grasp_pose(configuration)),
            human: None,
            bodies: Some(&self.seen),
        }
    }

    fn step(&mut self, command: &Command, human: &HumanMotion, period: f64) {
        let hand = human.hand.map_or(HumanCommand::Follow, |hand| HumanCommand::Walk { hand });
        self.plant.face(human.facing);
        self.seen = self.plant.step(&(command.rates + command.input), &hand, period);
    }

    fn link_poses(&self) -> Option<Vec<Pose>> {
        Some(self.plant.link_poses())
    }

    fn save(&self) -> Saved {
        Saved::of(&(&self.plant, &self.seen))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        (self.plant, self.seen) = saved.read("plant")?;
        Ok(())
    }
}

impl std::fmt::Debug for Physical<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Physical").field("seen", &self.seen).finish_non_exhaustive()
    }
}

//! The physical plant: robot, object and human as bodies in rapier.

use super::{Command, HumanMotion, Plant, Seen, on_floor};
use crate::error::Error;
use crate::geometry::{PlanarPose, Pose};
use crate::robot::{JointVector, Robot};
use crate::saved::{RestoreError, Saved};
use crate::simulation::{HumanCommand, Observation, PhysicalPlant, PhysicsSettings, PhysicsStep};
use crate::world::World;
use serde::{Deserialize, Serialize};

/// What is called after every physics step of a plant. It is no part of the plant's state.
pub type StepObserver<'a> = Box<dyn FnMut(&PhysicsStep) + Send + Sync + 'a>;

/// Robot, object and human with dynamics and contacts.
pub struct Physical<'a> {
    robot: &'a Robot,
    state: PhysicalState,
    observer: Option<StepObserver<'a>>,
}

#[derive(Clone, Serialize, Deserialize)]
struct PhysicalState {
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
    ) -> Result<Self, Error> {
        let plant = PhysicalPlant::new(world, robot, posture, start, settings, seed)?;
        Ok(Self { robot, state: PhysicalState { seen: plant.observe(), plant }, observer: None })
    }

    /// The same plant with an observer of its physics steps, or without one.
    #[must_use]
    pub fn observed_by(self, observer: Option<StepObserver<'a>>) -> Self {
        Self { observer, ..self }
    }
}

impl Clone for Physical<'_> {
    /// A copy that continues independently and identically. It has no observer.
    fn clone(&self) -> Self {
        Self { robot: self.robot, state: self.state.clone(), observer: None }
    }
}

impl Plant for Physical<'_> {
    fn observe(&self) -> Seen<'_> {
        let PhysicalState { seen, .. } = &self.state;
        let configuration = &seen.configuration;
        Seen {
            position: on_floor(&seen.object),
            configuration: Some(configuration),
            grasp: Some(self.robot.grasp_pose(configuration)),
            human: None,
            bodies: Some(seen),
        }
    }

    fn begin(&mut self) {
        self.state.plant.begin();
    }

    fn step(&mut self, command: &Command, human: &HumanMotion, period: f64) {
        let hand = human.hand.map_or(HumanCommand::Follow, |hand| HumanCommand::Walk { hand });
        let PhysicalState { plant, seen } = &mut self.state;
        plant.face(human.facing);
        let observer = self.observer.as_mut().map(|observer| &mut **observer as &mut dyn FnMut(&PhysicsStep));
        *seen = plant.advance_observed(&(command.rates + command.input), &hand, period, observer);
    }

    fn link_poses(&self) -> Option<Vec<Pose>> {
        Some(self.state.plant.link_poses())
    }

    fn save(&self) -> Saved {
        Saved::of(&self.state)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.state = saved.read("plant")?;
        Ok(())
    }
}

impl std::fmt::Debug for Physical<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Physical").field("seen", &self.state.seen).finish_non_exhaustive()
    }
}

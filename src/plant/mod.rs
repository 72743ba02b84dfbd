//! The plant: the bodies of a team, which a controller's command and a human's motion move.
//!
//! Implement [`Plant`] to carry with your own simulator; the walk, the human, the policy and the controller
//! stay. Pass it to an episode with
//! [`EpisodeBuilder::with_plant`](crate::episode::EpisodeBuilder::with_plant).

mod command;
mod kinematic;
mod physical;
mod point;

pub use command::{Command, HumanMotion, Preparation};
pub use kinematic::Kinematic;
pub use physical::{Physical, StepObserver};
pub use point::PointPlant;

use crate::geometry::{PlanarPose, Point, Pose};
use crate::robot::Configuration;
use crate::saved::{RestoreError, Saved};
use crate::simulation::Observation;

/// The bodies of a team. A clone continues independently and identically.
pub trait Plant: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The present state, as far as it can be seen.
    fn observe(&self) -> Seen<'_>;

    /// Begins a planning step: forces and contacts seen later are those since then.
    fn begin(&mut self) {}

    /// Moves all bodies by one control period (s).
    fn step(&mut self, command: &Command, human: &HumanMotion, period: f64);

    /// `world_from_link` of every link of the robot, in the order of
    /// [`Robot::links`](crate::robot::Robot::links); by default, the poses in the configuration seen.
    fn link_poses(&self) -> Option<Vec<Pose>> {
        None
    }

    /// The state that later steps depend on.
    fn save(&self) -> Saved;

    /// Restores what [`Plant::save`] returned.
    ///
    /// # Errors
    /// [`RestoreError`] if the state belongs to another plant.
    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError>;
}

dyn_clone::clone_trait_object!(Plant);

/// The observation of a team at the beginning of a control period.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'p> {
    /// Position of the team, m: the object's centre; the human's where the object has no body.
    pub position: Point,
    /// The robot's base and joints; none without a robot.
    pub configuration: Option<&'p Configuration>,
    /// `world_from_grasp` by the robot's kinematics; none without a robot.
    pub grasp: Option<Pose>,
    /// s, the human's state as the pose that the grasp should have; only where the human has no body.
    pub human: Option<PlanarPose>,
    /// Bodies and forces; only on plants with dynamics.
    pub bodies: Option<&'p Observation>,
}

impl Seen<'_> {
    /// Position of the human's body, m.
    pub fn body(&self) -> Point {
        self.bodies.map_or_else(|| self.human_position(), |bodies| on_floor(&bodies.torso))
    }

    /// Position of the human's hand, m.
    pub fn hand(&self) -> Point {
        self.bodies.map_or_else(|| self.human_position(), |bodies| on_floor(&bodies.hand))
    }

    fn human_position(&self) -> Point {
        self.human.map_or(self.position, |human| human.position)
    }
}

/// Position seen from above, m.
pub(crate) fn on_floor(world_from_it: &Pose) -> Point {
    world_from_it.translation.vector.xy().into()
}

//! The robot and the bodies that its controller moves: what the kinematic and the physical plant share.

use super::team_path::{FreeSpace, Turned};
use super::{PhysicsTick, Situation, Step, Travel, Walk};
use crate::control::{self, BaseInputs, Candidate, Intent, Reference, RobotObstacles};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::robot::{Configuration, InputVector, JointVector, Robot};
use crate::saved::{NotRestored, Saved};
use crate::simulation::Observation;
use nalgebra::Vector6;

/// The robot, its starting posture and its controller.
#[derive(Clone, Copy, Debug)]
pub struct Manipulator<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its joint positions at the start.
    pub posture: JointVector,
    /// The controller.
    pub control: control::Settings,
    /// The obstacles of the world.
    pub obstacles: &'a RobotObstacles,
}

/// The bodies that a controller acts on: those of the kinematic or of the physical plant.
pub(super) trait Bodies: Clone + std::fmt::Debug + Send + Sync {
    /// The robot's base and joints.
    fn configuration(&self) -> &Configuration;

    /// s: the pose on the floor that the grasp should have, given the human's.
    fn grasp_goal(&self) -> PlanarPose;

    /// Position of the human's body, m.
    fn body(&self) -> Point;

    /// Position of the human's hand, m.
    fn hand(&self) -> Point;

    /// How far a leading human is ahead of the object along the path, m.
    fn lead(&self, path: &Path, along: f64) -> f64;

    /// Observed walking speed of the human, m/s; negative when reversing.
    fn observed_speed(&self, intent: &Intent, travel: Travel, walk: &Walk) -> f64;

    /// Replaces `path`, the remainder of an option for a point, by the path that the robot expects the human
    /// to walk onto it.
    fn expect_path(&mut self, situation: &Situation, path: &mut Path, free_space: FreeSpace);

    /// s(1..H) of the grasp along a path at this speed (m/s), relative to the grasp.
    fn reference(&self, path_ahead: &PathAhead, speed: f64, walk: &Walk, grasp: &Pose) -> Reference;

    /// Inputs with which the base follows the path of the grasp; none where the base is free.
    fn base_on_path(
        &mut self,
        path_ahead: &PathAhead,
        speed: f64,
        manipulator: &Manipulator,
        walk: &Walk,
    ) -> Option<BaseInputs>;

    /// See [`super::Team::walkable`].
    fn walkable(&self, path: Path, free_space: FreeSpace) -> Path;

    /// See [`super::Team::turn`].
    fn turn(&mut self, path: &Path, along: f64, next: Path, free_space: FreeSpace) -> Option<Turned>;

    /// See [`super::Team::place_to_turn`].
    fn place_to_turn(
        &self,
        path: &Path,
        range: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        free_space: FreeSpace,
    ) -> Option<f64>;

    /// Moves all bodies by one period.
    fn step(&mut self, target: &Candidate, input: &InputVector, step: &Step, walk: &Walk) -> Moved;

    /// `world_from_link` of every link.
    fn link_poses(&self) -> Vec<Pose>;

    /// See [`super::Team::observation`].
    fn observation(&self) -> Option<&Observation> {
        None
    }

    /// See [`super::Team::human`].
    fn human(&self) -> Option<&PlanarPose> {
        None
    }

    /// The state that later steps depend on.
    fn save(&self) -> Saved;

    /// Restores a saved state.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored>;
}

/// The path ahead of the team.
#[derive(Clone, Copy)]
pub(super) struct PathAhead<'s> {
    pub mode: Mode,
    pub travel: Travel,
    /// The present path, and the team's position along it, m.
    pub path: &'s Path,
    pub along: f64,
    /// How far the hand is ahead of that position, m ([`Bodies::lead`]).
    pub lead: f64,
    /// The path to turn onto, if any. On the physical plant, it begins at the human's body.
    pub turn: Option<&'s Path>,
}

/// The result of a step.
pub(super) struct Moved {
    /// The team's position along the present path, m.
    pub along: f64,
    /// s - x after the step: the difference between the grasp's target and the grasp, m and rad.
    pub error: Vector6<f64>,
    pub physics: Option<PhysicsTick>,
}

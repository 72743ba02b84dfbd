//! How a team walks: its path, its turns onto another path, and the motion that whoever leads intends.
//!
//! A team without extent walks its path exactly ([`OnPath`]). Bodies walk [`InTandem`]: the human ahead, the
//! object, and the robot behind.

mod base_room;
mod ends;
mod in_tandem;
mod object_room;
mod on_path;
mod pace;
mod route;
mod start;
mod team_path;

pub use in_tandem::InTandem;
pub use on_path::OnPath;
pub(crate) use pace::TEAM_ACCELERATION;
pub use pace::{Pace, Travel, slow_drive};
pub use route::{Route, TurnOutcome};
pub use start::Surroundings;
pub use team_path::Turned;

use crate::control::{Intent, Reference};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, Widening};
use crate::human::Stance;
use crate::options::Passing;
use crate::plant::{HumanMotion, Seen};
use crate::saved::{RestoreError, Saved};

/// A team has arrived when it is this near (m) to the end of its path.
const ARRIVAL_TOLERANCE_M: f64 = 0.05;

/// How a team walks a path, and what its controller may expect of that.
pub trait Walk: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The path that this team walks for `path`, which is planned for a point.
    fn walkable(&self, path: Path) -> Path {
        path
    }

    /// Where the paths of this team go through gaps between pillars.
    fn passing(&self) -> Passing {
        Passing::Shortest
    }

    /// The way onto the first path, which begins where the team stands.
    fn begin(&mut self, path: Path) -> Turned {
        Turned { path: self.walkable(path), until: 0.0 }
    }

    /// Leaves the present path at the position `along` (m) for `next`, which begins there. `None` if there is
    /// no room to turn.
    fn turn(&mut self, path: &Path, along: f64, next: Path) -> Option<Turned> {
        let _ = (path, along);
        Some(Turned { path: next, until: 0.0 })
    }

    /// The position along `path` (m), no farther back than `least`, to which a team without room to turn at
    /// `along` should reverse. `None` if it may as well go on. `next` gives the path to turn onto from a
    /// position.
    fn place_to_turn(
        &self,
        path: &Path,
        [least, along]: [f64; 2],
        next: &dyn Fn(Point) -> Path,
    ) -> Option<f64> {
        let _ = (path, least, along, next);
        None
    }

    /// s: the pose on the floor that the grasp should have now.
    fn grasp_goal(&self, seen: &Seen<'_>) -> PlanarPose;

    /// The grasp's pose for a human who walks on without waiting for the robot; by default,
    /// [`Walk::grasp_goal`].
    fn intended_grasp(&self, step: &Step<'_>, seen: &Seen<'_>) -> PlanarPose {
        let _ = step;
        self.grasp_goal(seen)
    }

    /// Advances the intention of whoever leads by one period. Returns the human's motion in it.
    fn advance(&mut self, step: &Step<'_>, seen: &Seen<'_>) -> HumanMotion;

    /// Where the team has come on its path by the end of the period.
    fn locate(&self, step: &Step<'_>, seen: &Seen<'_>) -> Place;

    /// How far the hand of a leading human is ahead of the team along the path, m.
    fn lead(&self, seen: &Seen<'_>, path: &Path, along: f64) -> f64 {
        let _ = (seen, path, along);
        0.0
    }

    /// Walking speed of the human as the robot takes it, m/s; negative when reversing.
    fn observed_speed(&self, seen: &Seen<'_>, intent: &Intent, travel: Travel) -> f64;

    /// Replaces `next`, the remainder of an option for a point, by the path that the human is expected to walk
    /// onto it from the position `along` (m) on `path`.
    fn expect(&self, path: &Path, along: f64, next: &mut Path, widened: &mut Widened) {
        let _ = (path, along, next, widened);
    }

    /// s(1..H) of the grasp along a path at this speed (m/s), relative to the grasp, which carries level at
    /// `height` (m).
    fn reference(
        &self,
        seen: &Seen<'_>,
        ahead: &PathAhead<'_>,
        speed: f64,
        grasp: &Pose,
        height: f64,
    ) -> Reference;

    /// Writes the way of the grasp, from behind the robot to where the grasp should be: points
    /// [`Follower::STEP`](crate::control::Follower::STEP) apart, m. Returns its present and its target speed,
    /// m/s. `None` where the base is free.
    fn grasp_way(
        &self,
        seen: &Seen<'_>,
        ahead: &PathAhead<'_>,
        speed: f64,
        way: &mut Vec<Point>,
    ) -> Option<[f64; 2]> {
        let _ = (seen, ahead, speed, way);
        None
    }

    /// The state that later steps depend on; empty by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Restores what [`Walk::save`] returned.
    ///
    /// # Errors
    /// [`RestoreError`] if the state belongs to another team.
    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        saved.is_empty("walk")
    }
}

dyn_clone::clone_trait_object!(Walk);

/// The walk of one period.
#[derive(Clone, Copy, Debug)]
pub struct Step<'s> {
    /// Who leads.
    pub mode: Mode,
    /// The team's direction of travel along its path.
    pub travel: Travel,
    /// The human's response to the robot's lead.
    pub stance: Stance,
    /// Where the human's own hand goes by the end of the period, m, world frame; none: with the leader.
    pub hand: Option<Point>,
    /// The present path.
    pub path: &'s Path,
    /// The team's position along it, m.
    pub from: f64,
    /// Its position along the path after a period at walking speed, m.
    pub to: f64,
    /// The point of the path at `to`.
    pub position: Point,
}

/// Where a team is on its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position along the path, m: its length once the team has arrived.
    pub along: f64,
    /// How far the leader's intended position is ahead of the object, m.
    pub path_lead: f64,
}

/// The path ahead of the team.
#[derive(Clone, Copy, Debug)]
pub struct PathAhead<'s> {
    /// Who leads.
    pub mode: Mode,
    /// The team's direction of travel.
    pub travel: Travel,
    /// The present path.
    pub path: &'s Path,
    /// The team's position along it, m.
    pub along: f64,
    /// How far the hand is ahead of that position, m ([`Walk::lead`]).
    pub lead: f64,
    /// The path to turn onto, if any ([`Walk::expect`]).
    pub turn: Option<&'s Path>,
}

/// Memory for a path as the team walks it.
#[derive(Clone, Debug)]
pub struct Widened {
    path: Path,
    widening: Widening,
}

impl Default for Widened {
    fn default() -> Self {
        Self { path: Path::with_capacity(64), widening: Widening::default() }
    }
}

//! Teams of human, object and robot: how they walk a path, how they turn onto another, and how the robot is
//! controlled.
//!
//! [`Team`] is the plant that the loop acts on. A [`PointTeam`] walks its path exactly and has no robot: the
//! planning level. On the kinematic plant, the human walks exactly and the robot follows its inputs. On the
//! physical plant, robot, object and human are bodies.

mod bodies;
mod carrying;
mod kinematic;
mod physical;
mod plants;
mod point;
mod route;
mod team_path;
mod tick;

pub use bodies::Manipulator;
pub use carrying::Considerations;
pub use plants::{kinematic, physical};
pub use point::PointTeam;
pub use route::{Route, Travel, TurnOutcome};
pub use team_path::Turned;
pub use tick::{PhysicsTick, Preparation, RobotTick};

use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::human::HumanDecision;
use crate::options::{OptionSet, Progress};
use crate::policy::Motion;
use crate::preference::ChoiceDistribution;
use crate::robot::Configuration;
use crate::saved::{NotRestored, Saved};
use crate::simulation::Observation;

/// The plant: all bodies of the team, and the robot's controller.
///
/// In every control period, the loop asks it to [control](Team::control) and then to [walk](Team::walk). A
/// clone continues independently and identically.
pub trait Team: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The path that this team walks for `path`, which is planned for a point.
    fn walkable(&self, path: Path, options: &OptionSet) -> Path {
        let _ = options;
        path
    }

    /// Leaves the present path at the position `along` (m) for `next`, which begins there. `None` if there is
    /// no room to turn.
    fn turn(&mut self, path: &Path, along: f64, next: Path, options: &OptionSet) -> Option<Turned> {
        let _ = (path, along, options);
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
        options: &OptionSet,
    ) -> Option<f64> {
        let _ = (path, least, along, next, options);
        None
    }

    /// Whether the robot's controller needs P_o while the human leads.
    fn anticipates(&self) -> bool {
        false
    }

    /// The robot's configuration q* (eq. 8) and inputs u (eq. 7) for this period; none without a robot.
    fn control(&mut self, situation: &Situation<'_>) -> Option<RobotTick> {
        let _ = situation;
        None
    }

    /// Moves all bodies by one period, adds the costs of the step to `tick`, and returns the team's position
    /// along the path, m.
    fn walk(&mut self, step: &Step<'_>, tick: Option<&mut RobotTick>) -> f64;

    /// The basis of the controller's last decision; none without a controller.
    fn considerations(&self) -> Option<Considerations<'_>> {
        None
    }

    /// The robot's base and joints; none without a robot.
    fn configuration(&self) -> Option<&Configuration> {
        None
    }

    /// `world_from_grasp`; none without a robot.
    fn grasp(&self) -> Option<Pose> {
        None
    }

    /// `world_from_link` of every link of the robot, in the order of
    /// [`Robot::links`](crate::robot::Robot::links); none without a robot.
    fn link_poses(&self) -> Option<Vec<Pose>> {
        None
    }

    /// The observation of bodies and forces on the physical plant.
    fn observation(&self) -> Option<&Observation> {
        None
    }

    /// s, the pose that the grasp should have, on plants where the human has no other state.
    fn human(&self) -> Option<&PlanarPose> {
        None
    }

    /// The state that later steps depend on; empty by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Restores what [`Team::save`] returned.
    ///
    /// # Errors
    /// [`NotRestored`] if the state belongs to another plant.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        saved.is_empty("plant")
    }
}

dyn_clone::clone_trait_object!(Team);

/// The team's walking parameters, which the robot knows.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Control period, s.
    pub period: f64,
    /// Walking speed, m/s.
    pub speed: f64,
    /// Largest yaw rate of the human, rad/s.
    pub yaw_rate: f64,
}

/// The controller's knowledge in a control period.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'s> {
    /// Who leads.
    pub mode: Mode,
    /// The team's direction of travel along its path.
    pub travel: Travel,
    /// The options of the world.
    pub options: &'s OptionSet,
    /// The team's progress on each option.
    pub progress: &'s Progress,
    /// P_o at this position.
    pub choice: &'s ChoiceDistribution,
    /// The present path, which the robot knows while it leads.
    pub path: &'s Path,
    /// The team's position along it, m.
    pub along: f64,
    /// The motion that the robot's policy has chosen.
    pub motion: &'s Motion,
}

/// The walk of one period.
#[derive(Clone, Copy, Debug)]
pub struct Step<'s> {
    /// Who leads.
    pub mode: Mode,
    /// The team's direction of travel along its path.
    pub travel: Travel,
    /// The human's decision.
    pub human: &'s HumanDecision,
    /// The present path.
    pub path: &'s Path,
    /// The team's position along it, m.
    pub from: f64,
    /// Its position along the path after a period at walking speed, m.
    pub to: f64,
    /// The point of the path at `to`.
    pub position: Point,
}

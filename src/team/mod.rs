//! Teams of human, object and robot: how they walk a path, turn onto another, and what the robot does meanwhile.
//!
//! [`Team`] is the plant that the loop acts on. A [`PointTeam`] walks its path exactly and has no robot: the planning level. On the
//! kinematic plant the human walks exactly, and the robot moves as its inputs say. On the physical plant robot, object and human are bodies.

mod carrying;
mod kinematic;
mod physical;
mod point;
mod route;
mod team_path;
mod tick;

pub use carrying::{Considerations, Manipulator};
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
use crate::simulation::{Observation, PhysicsError, PhysicsSettings};
use crate::world::World;

/// The plant: all bodies of the team, and the robot's controller.
///
/// Every control period, the loop asks it to [control](Team::control) and then to [walk](Team::walk). A clone goes on independently and
/// identically.
pub trait Team: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// `path`, made for a point, as this team walks it.
    fn walkable(&self, path: Path, options: &OptionSet) -> Path {
        let _ = options;
        path
    }

    /// Leaves the path under way, `along` (m) on it, for `next`, which begins there. `None` if there is no room to turn.
    fn turn(&mut self, path: &Path, along: f64, next: Path, options: &OptionSet) -> Option<Turned> {
        let _ = (path, along, options);
        Some(Turned { path: next, until: 0.0 })
    }

    /// Where along `path` (m) a team without room to turn here, `along` it, had better reverse to: no farther than `least`. `None` if going on
    /// is as good. `next` is the path to turn onto, from the place that it is asked for.
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

    /// The robot's configuration q* (eq. 8) and inputs u (eq. 7) of this period; none without a robot.
    fn control(&mut self, situation: &Situation<'_>) -> Option<RobotTick> {
        let _ = situation;
        None
    }

    /// Moves everybody by one period, books in `tick` what the step cost, and returns how far along the path the team is then, m.
    fn walk(&mut self, step: &Step<'_>, tick: Option<&mut RobotTick>) -> f64;

    /// What the controller decided the last step from; none without one.
    fn considerations(&self) -> Option<Considerations<'_>> {
        None
    }

    /// The robot's base and joints; none without one.
    fn configuration(&self) -> Option<&Configuration> {
        None
    }

    /// `world_from_grasp`; none without a robot.
    fn grasp(&self) -> Option<Pose> {
        None
    }

    /// `world_from_link` of every link of the robot, in the order of [`Robot::links`](crate::robot::Robot::links); none without one.
    fn link_poses(&self) -> Option<Vec<Pose>> {
        None
    }

    /// What is seen of bodies and forces, on the physical plant.
    fn observation(&self) -> Option<&Observation> {
        None
    }

    /// s, the pose that the grasp should have, where that is all there is of the human.
    fn human(&self) -> Option<&PlanarPose> {
        None
    }

    /// What later steps depend on; nothing by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Takes over what [`Team::save`] returned.
    ///
    /// # Errors
    /// [`NotRestored`] if it is not of this plant.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        saved.is_empty("plant")
    }
}

dyn_clone::clone_trait_object!(Team);

/// How the team walks: what the robot knows of it.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Control period, s.
    pub period: f64,
    /// Walking speed, m/s.
    pub speed: f64,
    /// The fastest that the human turns, rad/s.
    pub yaw_rate: f64,
}

/// What the robot's controller knows in a control period.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'s> {
    /// Who leads.
    pub mode: Mode,
    /// Which way the team goes along its path.
    pub travel: Travel,
    /// The ways through the world.
    pub options: &'s OptionSet,
    /// Where the team is on each of them.
    pub progress: &'s Progress,
    /// P_o from here.
    pub choice: &'s ChoiceDistribution,
    /// The path under way, known to the robot while it leads.
    pub path: &'s Path,
    /// How far along it the team is, m.
    pub along: f64,
    /// How the robot's policy has it move.
    pub motion: &'s Motion,
}

/// One period's walk.
#[derive(Clone, Copy, Debug)]
pub struct Step<'s> {
    /// Who leads.
    pub mode: Mode,
    /// Which way the team goes along its path.
    pub travel: Travel,
    /// What the human does.
    pub human: &'s HumanDecision,
    /// The path under way.
    pub path: &'s Path,
    /// How far along it the team is, m.
    pub from: f64,
    /// How far it would be at walking speed, m, and where that is.
    pub to: f64,
    /// The point of the path after `to`.
    pub position: Point,
}

/// The team of the kinematic plant, its grasp at `start`.
pub fn kinematic<'a>(
    manipulator: Manipulator<'a>,
    walk: Walk,
    options: usize,
    start: PlanarPose,
) -> Box<dyn Team + 'a> {
    Box::new(carrying::Carrying::new(
        manipulator,
        walk,
        options,
        kinematic::Kinematic::new(&manipulator, start),
    ))
}

/// The team of the physical plant, at rest with the object's middle at `start`. `seed` is the gait's.
///
/// # Errors
/// [`PhysicsError`] if the team does not fit where it is to start, the human has no room at the end of an option, or a setting is out of its
/// range.
pub fn physical<'a>(
    manipulator: Manipulator<'a>,
    walk: Walk,
    options: &OptionSet,
    start: PlanarPose,
    world: &World,
    physics: &PhysicsSettings,
    seed: u64,
) -> Result<Box<dyn Team + 'a>, PhysicsError> {
    let team = physical::Physical::new(&manipulator, world, physics, seed, &start)?;
    team.check_ends(options, world, manipulator.obstacles)?;
    Ok(Box::new(carrying::Carrying::new(manipulator, walk, options.options().len(), team)))
}

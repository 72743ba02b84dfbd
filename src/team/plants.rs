//! The teams of the plants with a robot.

use super::carrying::Carrying;
use super::kinematic::Kinematic;
use super::physical::Physical;
use super::team_path::FreeSpace;
use super::{Manipulator, Team, Walk};
use crate::error::Error;
use crate::geometry::{Path, PlanarPose};
use crate::options::OptionSet;
use crate::simulation::PhysicsSettings;
use crate::world::World;

/// The team of the kinematic plant, with its grasp at `start`.
pub fn kinematic<'a>(
    manipulator: Manipulator<'a>,
    walk: Walk,
    options: usize,
    start: PlanarPose,
) -> Box<dyn Team + 'a> {
    Box::new(Carrying::new(manipulator, walk, options, Kinematic::new(&manipulator, start)))
}

/// The team of the physical plant, at rest at the beginning of the path `first`. `seed` determines the gait.
///
/// # Errors
/// The team does not fit at its start, the robot has no room on its way to the start or the human at the end
/// of an option, or a setting is out of its range.
pub fn physical<'a>(
    manipulator: Manipulator<'a>,
    walk: Walk,
    options: &OptionSet,
    first: &Path,
    world: &World,
    physics: &PhysicsSettings,
    seed: u64,
) -> Result<Box<dyn Team + 'a>, Error> {
    let free_space = FreeSpace { obstacles: manipulator.obstacles, options };
    let team = Physical::new(&manipulator, world, physics, seed, first, free_space)?;
    team.check_room(world, free_space)?;
    Ok(Box::new(Carrying::new(manipulator, walk, options.options().len(), team)))
}

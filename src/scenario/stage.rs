//! A scenario in; all that its episode borrows, and the episode, out.

use super::{Scenario, ScenarioError};
use crate::control::RobotObstacles;
use crate::episode::{Episode, Manipulator};
use crate::options::OptionSet;
use crate::robot::Robot;
use crate::world::World;

/// What is built from a scenario: it owns what its episode borrows.
#[derive(Clone, Debug)]
pub struct Stage {
    scenario: Scenario,
    world: World,
    options: OptionSet,
    robot: Option<Robot>,
    obstacles: RobotObstacles,
}

impl Scenario {
    /// Builds what the episode needs.
    ///
    /// # Errors
    /// [`ScenarioError`]: a number is out of its range, or world, options, robot or posture are not valid.
    pub fn prepare(self) -> Result<Stage, ScenarioError> {
        self.check()?;
        let world = World::parse(&self.world.file, &self.world.text)?;
        let options = OptionSet::new(&world, self.settings.predictor.risk_weight())?;
        let robot = match self.plant.carrier() {
            None => None,
            Some(carrier) => {
                let robot = Robot::parse(&carrier.robot)?;
                if robot.posture(&carrier.posture).is_none() {
                    let known: Vec<_> = robot.postures.iter().map(|p| format!("`{}`", p.name)).collect();
                    return Err(ScenarioError::Posture {
                        posture: carrier.posture.clone(),
                        file: carrier.robot.file.clone(),
                        known: known.join(", "),
                    });
                }
                Some(robot)
            }
        };
        let obstacles = RobotObstacles::new(&world);
        Ok(Stage { scenario: self, world, options, robot, obstacles })
    }
}

impl Stage {
    /// The scenario.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Its world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world's options.
    pub fn options(&self) -> &OptionSet {
        &self.options
    }

    /// The robot; none on the planning level alone. Its meshes are as the URDF names them.
    pub fn robot(&self) -> Option<&Robot> {
        self.robot.as_ref()
    }

    /// The robot as the episode takes it; none on the planning level alone.
    pub fn manipulator(&self) -> Option<Manipulator<'_>> {
        let (robot, carrier) = self.robot.as_ref().zip(self.scenario.plant.carrier())?;
        let posture = robot.posture(&carrier.posture)?.joints;
        Some(Manipulator { robot, posture, control: carrier.control, obstacles: &self.obstacles })
    }

    /// The episode, before its first step.
    ///
    /// # Errors
    /// [`ScenarioError::Physics`]: the team does not fit where it is to start.
    pub fn episode(&self) -> Result<Episode<'_>, ScenarioError> {
        let Self { scenario, world, options, .. } = self;
        let episode = Episode::new(options, &scenario.settings, scenario.human);
        let Some(manipulator) = self.manipulator() else { return Ok(episode) };
        match scenario.plant.physics() {
            None => Ok(episode.with_robot(manipulator)),
            Some(physics) => Ok(episode.with_physics(manipulator, world, physics, scenario.seed)?),
        }
    }
}

//! Prepared scenarios, which own everything that their episodes borrow.

use super::Scenario;
use crate::control::RobotObstacles;
use crate::episode::{Episode, EpisodeBuilder, Manipulator, PlaceMemory};
use crate::error::{Error, Place};
use crate::human::{Human, Participant};
use crate::options::OptionSet;
use crate::policy::RobotPolicy;
use crate::robot::{Robot, RobotWarning, SlowDrive, WeakestJoint};
use crate::team;
use crate::world::World;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// A scenario with its world, options and robot: it owns what its episode borrows.
#[derive(Clone, Debug)]
pub struct PreparedScenario {
    /// Its walking speed is at most that of the robot.
    scenario: Scenario,
    scene: Arc<Scene>,
    robot: Option<Arc<Robot>>,
    /// Told if the robot is slower than the walking speed that was asked for.
    slow_drive: Option<SlowDrive>,
    /// Shared with the scenarios that are prepared from this one.
    places: Option<Arc<PlaceMemory>>,
}

/// A world with the options and obstacles built from it and c_r.
#[derive(Debug)]
struct Scene {
    world: Arc<World>,
    options: Arc<OptionSet>,
    obstacles: RobotObstacles,
    /// The options for the world's own `robot_width_m`, where a wider robot takes its place; built on first
    /// use.
    as_written: OnceLock<Arc<OptionSet>>,
}

/// Share of an effort limit, to hold the object at rest, beyond which there is a warning.
const WARNING_SHARE: f64 = 0.8;

/// How an arm holds its part of the object at rest.
struct Holding<'a> {
    robot: &'a str,
    posture: &'a str,
    world: &'a str,
    /// Mass of the object, and of the arm's part, kg.
    object: f64,
    load: f64,
    weakest: WeakestJoint<'a>,
}

impl Holding<'_> {
    /// The share of its effort limit that the weakest joint exerts.
    fn share(&self) -> f64 {
        self.load / self.weakest.payload
    }
}

impl fmt::Display for Holding<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { robot, posture, world, object, load, weakest } = self;
        let WeakestJoint { name, limit, unit, payload } = weakest;
        let (needed, most) = (limit * self.share(), 2.0 * payload);
        write!(
            f,
            "robot `{robot}` in posture `{posture}`: to hold its half of the object at rest, {load:.2} kg of the {object:.2} kg in {world}, \
             joint `{name}` needs {needed:.1} {unit} of its effort limit of {limit:.1} {unit}; it "
        )?;
        match self.share() > 1.0 {
            true => write!(f, "can hold an object of {most:.2} kg ([object] mass_kg) at most"),
            false => write!(
                f,
                "holds objects up to {most:.2} kg ([object] mass_kg), but has little left to move them"
            ),
        }
    }
}

/// Partners in place of those of a scenario; `None` keeps the scenario's.
#[derive(Debug, Default)]
pub struct Partners<'a> {
    /// The human.
    pub human: Option<Box<dyn Human + 'a>>,
    /// The robot's policy.
    pub policy: Option<Box<dyn RobotPolicy + 'a>>,
}

impl Scenario {
    /// Builds the world, options and robot that the episode needs.
    ///
    /// # Errors
    /// A number is out of its range, or world, options, human model, robot or posture are not valid.
    pub fn prepare(self) -> Result<PreparedScenario, Error> {
        self.prepare_sharing(None)
    }

    /// As [`Scenario::prepare`], but shares equal worlds and robots with `other`.
    fn prepare_sharing(mut self, other: Option<&PreparedScenario>) -> Result<PreparedScenario, Error> {
        self.check()?;
        let robot = match self.plant.robot_setup() {
            None => None,
            Some(setup) => {
                let others = other.and_then(|other| other.scenario.plant.robot_setup());
                let shared = others.map(|others| &others.robot).filter(|robot| **robot == setup.robot);
                let robot = shared.unwrap_or(&setup.robot).robot()?;
                if robot.posture(&setup.posture).is_none() {
                    let known: Vec<_> = robot.postures.iter().map(|p| format!("`{}`", p.name)).collect();
                    return Err(Error::value(
                        Place::item("scenario", "posture"),
                        format_args!(
                            "{:?}: {} has no posture of that name; it has {}",
                            setup.posture,
                            setup.robot.texts().file,
                            known.join(", ")
                        ),
                    ));
                }
                Some(robot)
            }
        };
        let joints = robot.as_deref().zip(self.plant.robot_setup());
        let joints = joints.and_then(|(robot, setup)| Some((robot, robot.posture(&setup.posture)?.joints)));
        let has_bodies = self.plant.physics().is_some();
        let slow_drive = joints
            .and_then(|(robot, joints)| team::slow_drive(robot, &joints, self.settings.speed, has_bodies));
        if let Some(slow) = &slow_drive {
            self.settings.speed = slow.walked;
        }
        let width = joints.map_or(0.0, |(robot, joints)| robot.carrying_width(&joints));
        let places = other.and_then(|other| other.places.clone());
        let scene = match other.filter(|other| self.has_scene_of(other, width)) {
            Some(other) => Arc::clone(&other.scene),
            None => {
                let world = self.world.for_width(width)?;
                let risk_weight = self.settings.predictor.risk_weight();
                let options = match world.is_widened {
                    true => Arc::new(OptionSet::new(&world, risk_weight)?),
                    false => self.world.options(risk_weight)?,
                };
                let obstacles = RobotObstacles::new(&world);
                Arc::new(Scene { world, options, obstacles, as_written: OnceLock::new() })
            }
        };
        let prepared = PreparedScenario { scenario: self, scene, robot, slow_drive, places };
        prepared.check_lead_option()?;
        prepared.check_payload()?;
        prepared.human()?;
        Ok(prepared)
    }

    /// Whether this scenario with a robot of this width (m) has the same scene as another.
    fn has_scene_of(&self, other: &PreparedScenario, width: f64) -> bool {
        let risk_weight = |scenario: &Self| scenario.settings.predictor.risk_weight();
        let others = other.width();
        self.world == other.scenario.world
            && risk_weight(self) == risk_weight(&other.scenario)
            && width == others
    }
}

impl PreparedScenario {
    /// The scenario. Its walking speed is the team's: that of the robot where that is slower.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The same scenario, whose episodes share what they find at places through `memory`, also with the episodes
    /// of scenarios that are prepared from it: see [`EpisodeBuilder::with_places`].
    #[must_use]
    pub fn keeping_places(self, memory: Arc<PlaceMemory>) -> Self {
        Self { places: Some(memory), ..self }
    }

    /// Another scenario, prepared. It shares an equal world with its options, and an equal robot, with this
    /// one.
    ///
    /// # Errors
    /// As [`Scenario::prepare`].
    pub fn prepare(&self, scenario: Scenario) -> Result<Self, Error> {
        scenario.prepare_sharing(Some(self))
    }

    /// Its world.
    pub fn world(&self) -> &World {
        &self.scene.world
    }

    /// The world's options.
    pub fn options(&self) -> &OptionSet {
        &self.scene.options
    }

    /// The world's options for its own `robot_width_m`, which preference changes are drawn from: the human of
    /// a seed is the same whichever robot carries with them.
    ///
    /// # Errors
    /// As [`OptionSet::new`].
    pub fn options_as_written(&self) -> Result<&OptionSet, Error> {
        let Scene { world, options, as_written, .. } = self.scene.as_ref();
        if !world.is_widened {
            return Ok(options);
        }
        if let Some(made) = as_written.get() {
            return Ok(made);
        }
        let made = self.scenario.world.options(self.scenario.settings.predictor.risk_weight())?;
        Ok(as_written.get_or_init(|| made))
    }

    /// The robot; `None` on the planning level alone. Its meshes are as the URDF names them.
    pub fn robot(&self) -> Option<&Robot> {
        self.robot.as_deref()
    }

    /// The width that the robot needs, m; 0 without a robot.
    fn width(&self) -> f64 {
        self.manipulator().map_or(0.0, |manipulator| manipulator.robot.carrying_width(&manipulator.posture))
    }

    /// The robot's drive, if the team walks more slowly than it was asked to because of it.
    pub fn slow_drive(&self) -> Option<&SlowDrive> {
        self.slow_drive.as_ref()
    }

    /// Warnings about this robot in this world: that its width takes the place of the world's smaller one; that
    /// its arm hardly holds the object, or not at all on a plant without forces;
    /// and, on the plant with contacts, which shapes are missing and what collides in their place.
    pub fn robot_warnings(&self) -> Vec<String> {
        let Some(robot) = self.robot() else { return Vec::new() };
        let has_contacts = self.scenario.plant.physics().is_some();
        let widened = self.world().is_widened.then(|| {
            let (name, file, width) = (&robot.name, self.scenario.world.file(), self.width());
            let why = match width > robot.width() {
                true => format!(
                    "needs {width:.2} m, as its base moves with a lateral offset from the object's path"
                ),
                false => format!("is {width:.2} m wide (base_width_m)"),
            };
            format!(
                "robot `{name}` {why}, more than robot_width_m of {file}: its openings, \
                 their risks and all clearances are for {width:.2} m"
            )
        });
        let of_shapes =
            |note: &&RobotWarning| has_contacts && note.is_about_missing_shapes() && !note.is_about_file();
        let notes = robot.warnings.iter().filter(of_shapes);
        let holding = self.holding().filter(|holding| holding.share() > WARNING_SHARE);
        let holding = holding.map(|holding| holding.to_string());
        widened.into_iter().chain(notes.map(ToString::to_string)).chain(holding).collect()
    }

    /// How the arm holds its part of the object at rest in the posture of the start: the joint that limits it,
    /// and the share of that joint's effort limit that it takes. `None` without a robot, or without such
    /// limits.
    fn holding(&self) -> Option<Holding<'_>> {
        let (robot, setup) = self.robot.as_deref().zip(self.scenario.plant.robot_setup())?;
        let posture = robot.posture(&setup.posture)?;
        let object = self.world().object.mass;
        let weakest = robot.weakest_joint(&posture.joints)?;
        // at rest, both grips bear the same
        let (load, world) = (object / 2.0, self.scenario.world.file());
        Some(Holding { robot: &robot.name, posture: &posture.name, world, object, load, weakest })
    }

    /// On a plant with forces, the arm holds the object at rest.
    fn check_payload(&self) -> Result<(), Error> {
        let has_forces = self.scenario.plant.physics().is_some();
        match self.holding().filter(|holding| has_forces && holding.share() > 1.0) {
            Some(holding) => Err(Error::new(holding.to_string())),
            None => Ok(()),
        }
    }

    /// The robot in the form that an episode needs; `None` on the planning level alone.
    pub fn manipulator(&self) -> Option<Manipulator<'_>> {
        let (robot, setup) = self.robot.as_deref().zip(self.scenario.plant.robot_setup())?;
        let posture = robot.posture(&setup.posture)?.joints;
        Some(Manipulator { robot, posture, control: setup.control, obstacles: &self.scene.obstacles })
    }

    /// The option on which the robot shall lead is one of the world's.
    fn check_lead_option(&self) -> Result<(), Error> {
        let Some(number) = self.scenario.settings.lead_option else { return Ok(()) };
        let count = self.options().options().len();
        if (1..=count as u64).contains(&number) {
            return Ok(());
        }
        let expected =
            format!("from 1 to {count}, the number of an option of {}", self.scenario.world.file());
        Err(Error::number(Place::file("scenario"), "settings.lead_option", number as f64, &expected))
    }

    /// The episode, before its first step.
    ///
    /// # Errors
    /// The team does not fit at the start.
    pub fn episode(&self) -> Result<Episode<'_>, Error> {
        self.episode_of(Partners::default())
    }

    /// The episode of these partners, before its first step.
    ///
    /// # Errors
    /// As [`PreparedScenario::episode`].
    pub fn episode_of<'a>(&'a self, partners: Partners<'a>) -> Result<Episode<'a>, Error> {
        let mut builder = self.builder()?;
        if let Some(human) = partners.human {
            builder = builder.with_boxed_human(human);
        }
        if let Some(policy) = partners.policy {
            builder = builder.with_boxed_policy(policy);
        }
        builder.begin()
    }

    /// The parts of the episode, any of which may be replaced.
    ///
    /// # Errors
    /// The human model is not valid.
    pub fn builder(&self) -> Result<EpisodeBuilder<'_>, Error> {
        let Self { scenario, scene, .. } = self;
        let mut builder = Episode::builder(&scene.options, &scenario.settings, scenario.human)
            .with_boxed_human(self.human()?);
        if let Some(memory) = &self.places {
            builder = builder.with_places(memory);
        }
        Ok(match (self.manipulator(), scenario.plant.physics()) {
            (None, _) => builder,
            (Some(manipulator), None) => builder.with_robot(manipulator),
            (Some(manipulator), Some(physics)) => {
                builder.with_physics(manipulator, &scene.world, physics, scenario.seed)
            }
        })
    }

    /// The scenario's human, before the first step.
    ///
    /// # Errors
    /// The human model is not valid.
    pub fn human(&self) -> Result<Box<dyn Human>, Error> {
        let Scenario { human_model, human: perception, changes, settings, seed, .. } = &self.scenario;
        let (options, stubbornness) = (&self.scene.options, settings.coordination);
        let participant =
            Participant { perception: *perception, changes, stubbornness, seed: *seed, options };
        let human = human_model.make(&participant);
        human.map_err(|error| {
            let model = human_model.to_string();
            Error::value(Place::item("scenario", "human_model"), format_args!("{model:?}")).because(error)
        })
    }
}

//! The parts of an episode, put together in any order.

use super::view::view;
use super::{Episode, EpisodeSettings, Manipulator, PlaceMemory, Summary, Tick, prospects};
use crate::controller::{Controller, Guide, NoRobot, Predictive};
use crate::error::Error;
use crate::geometry::{Path, PlanarPose, direction};
use crate::human::{Human, PreferenceHuman};
use crate::options::{OptionSet, Passing};
use crate::plant::{Kinematic, Physical, Plant, PointPlant, StepObserver};
use crate::policy::RobotPolicy;
use crate::preference::{Perception, Ways};
use crate::simulation::{KinematicPlant, PhysicsSettings, PhysicsStep};
use crate::team::{InTandem, OnPath, Route, Surroundings, Walk};
use crate::world::World;

/// The parts of an episode. By default, the human is the paper's, the policy that of the settings' method,
/// and the team a point.
#[must_use]
pub struct EpisodeBuilder<'a> {
    options: &'a OptionSet,
    settings: &'a EpisodeSettings,
    human: Box<dyn Human + 'a>,
    policy: Box<dyn RobotPolicy + 'a>,
    team: Team<'a>,
    controller: Option<Box<dyn Controller + 'a>>,
    plant: Option<MakePlant<'a>>,
    observer: Option<StepObserver<'a>>,
    places: Option<&'a PlaceMemory>,
}

type MakePlant<'a> = Box<dyn FnOnce(&Start) -> Box<dyn Plant + 'a> + 'a>;

/// The kind of team.
#[derive(Clone, Copy)]
enum Team<'a> {
    Point,
    /// A robot whose grasp is where the human is.
    Robot(Manipulator<'a>),
    /// Human, object and robot with bodies.
    Bodies {
        manipulator: Manipulator<'a>,
        world: &'a World,
        physics: PhysicsSettings,
        seed: u64,
    },
}

/// Where a team lines up before the first step: at the beginning of its first path, facing along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Pose of the object's centre; where the object has no body, of the grasp.
    pub pose: PlanarPose,
}

/// A team that stands at its start.
struct LinedUp<'a> {
    walk: Box<dyn Walk + 'a>,
    controller: Box<dyn Controller + 'a>,
    plant: Box<dyn Plant + 'a>,
}

impl<'a> EpisodeBuilder<'a> {
    pub(super) fn new(options: &'a OptionSet, settings: &'a EpisodeSettings, human: Perception) -> Self {
        Self {
            options,
            settings,
            human: Box::new(PreferenceHuman::new(human, settings.coordination)),
            policy: settings.method.policy(),
            team: Team::Point,
            controller: None,
            plant: None,
            observer: None,
            places: None,
        }
    }

    /// Replaces the human.
    pub fn with_human(self, human: impl Human + 'a) -> Self {
        self.with_boxed_human(Box::new(human))
    }

    /// [`EpisodeBuilder::with_human`] for a human of a type known at run time.
    pub fn with_boxed_human(self, human: Box<dyn Human + 'a>) -> Self {
        Self { human, ..self }
    }

    /// Replaces the robot's policy.
    pub fn with_policy(self, policy: impl RobotPolicy + 'a) -> Self {
        self.with_boxed_policy(Box::new(policy))
    }

    /// [`EpisodeBuilder::with_policy`] for a policy of a type known at run time.
    pub fn with_boxed_policy(self, policy: Box<dyn RobotPolicy + 'a>) -> Self {
        Self { policy, ..self }
    }

    /// A robot at the other end of the object, on the kinematic plant.
    pub fn with_robot(self, manipulator: Manipulator<'a>) -> Self {
        Self { team: Team::Robot(manipulator), ..self }
    }

    /// Robot, object and human as bodies, on the physical plant. `seed` determines the gait.
    pub fn with_physics(
        self,
        manipulator: Manipulator<'a>,
        world: &'a World,
        physics: &PhysicsSettings,
        seed: u64,
    ) -> Self {
        Self { team: Team::Bodies { manipulator, world, physics: *physics, seed }, ..self }
    }

    /// Replaces the robot's controller.
    pub fn with_controller(self, controller: impl Controller + 'a) -> Self {
        Self { controller: Some(Box::new(controller)), ..self }
    }

    /// Replaces the plant, for the same team. `make` is called once it is known where the team lines up.
    pub fn with_plant<P: Plant + 'a>(self, make: impl FnOnce(&Start) -> P + 'a) -> Self {
        Self { plant: Some(Box::new(|start| Box::new(make(start)))), ..self }
    }

    /// An observer of every physics step; without effect on plants other than the physical one. Copies of the
    /// episode have none.
    pub fn with_step_observer(self, observer: impl FnMut(&PhysicsStep) + Send + Sync + 'a) -> Self {
        Self { observer: Some(Box::new(observer)), ..self }
    }

    /// Shares D_o, S_o, and P_o and J~_o of the belief before the episode, with other episodes through `memory`,
    /// by the place of the team. Results are the same bits; it saves time where many humans walk in one world.
    pub fn with_places(self, memory: &'a PlaceMemory) -> Self {
        Self { places: Some(memory), ..self }
    }

    /// The episode before its first step: the team stands at the start and faces its first path.
    ///
    /// # Errors
    /// A team of bodies does not fit at its start, the robot has no room on its way to the
    /// start or the human at the end of an option, or a setting is out of its range.
    pub fn begin(self) -> Result<Episode<'a>, Error> {
        let Self { options, settings, human, policy, team, controller, plant, observer, places } = self;
        settings.learning.map_or(Ok(()), |learning| learning.check())?;
        let mut episode = point_episode(options, settings, human, policy);
        episode.places = places.and_then(|memory| memory.of(options, &episode.predictor));
        let first = if let Team::Point = team { Path::default() } else { episode.first_path(team.passing()) };
        let LinedUp { walk, controller: built_in, plant } =
            team.line_up(options, settings, &first, plant, observer)?;
        episode.manipulator = team.manipulator();
        episode.walk = walk;
        episode.controller = controller.unwrap_or(built_in);
        episode.plant = plant;
        Ok(episode)
    }
}

impl<'a> Team<'a> {
    /// How the team passes gaps between pillars, by its walk from [`Team::line_up`].
    fn passing(self) -> Passing {
        match self {
            Self::Point | Self::Robot(_) => Passing::Shortest,
            Self::Bodies { .. } => InTandem::PASSING,
        }
    }

    fn manipulator(self) -> Option<Manipulator<'a>> {
        match self {
            Self::Point => None,
            Self::Robot(manipulator) | Self::Bodies { manipulator, .. } => Some(manipulator),
        }
    }

    /// The team at the beginning of the path `first`, on its own plant or on another one.
    fn line_up(
        self,
        options: &'a OptionSet,
        settings: &EpisodeSettings,
        first: &Path,
        plant: Option<MakePlant<'a>>,
        observer: Option<StepObserver<'a>>,
    ) -> Result<LinedUp<'a>, Error> {
        let (pace, count) = (settings.pace(), options.options().len());
        let yaw = first.heading_at(0.0).unwrap_or(0.0);
        let pose = PlanarPose { position: options.begin().position, yaw };
        let on_path = || Box::new(OnPath { pace });
        Ok(match self {
            Self::Point => LinedUp {
                walk: on_path(),
                controller: Box::new(NoRobot),
                plant: plant.map_or_else(
                    || Box::new(PointPlant::at(pose.position)) as _,
                    |make| make(&Start { pose }),
                ),
            },
            Self::Robot(robot) => LinedUp {
                walk: on_path(),
                controller: Box::new(Predictive::new(robot, pace, count, None)),
                plant: match plant {
                    None => Box::new(Kinematic::new(robot.robot, &robot.posture, pose)),
                    Some(make) => make(&Start { pose }),
                },
            },
            Self::Bodies { manipulator, world, physics, seed } => {
                let Manipulator { robot, posture, obstacles, .. } = manipulator;
                let half = world.object.size[0] / 2.0;
                let base = |pose: &PlanarPose| {
                    let grasp = PlanarPose { position: pose.position - direction(pose.yaw) * half, ..*pose };
                    KinematicPlant::place(robot, &posture, &grasp).configuration().base.position
                };
                let surroundings = Surroundings { world, options, obstacles, base: &base };
                let (walk, pose) = InTandem::starting(surroundings, first, pace)?;
                let plant: Box<dyn Plant + 'a> = match plant {
                    None => {
                        let plant = Physical::new(world, robot, &posture, &pose, &physics, seed)?;
                        Box::new(plant.observed_by(observer))
                    }
                    Some(make) => make(&Start { pose }),
                };
                walk.check_targets(world, settings.predictor.risk_weight())?;
                let guide = Guide::new(&manipulator, physics.rim_acceleration);
                let controller = Predictive::new(manipulator, pace, count, Some(guide));
                LinedUp { walk: Box::new(walk), controller: Box::new(controller), plant }
            }
        })
    }
}

/// The episode of a team that is a point.
pub(super) fn point_episode<'a>(
    options: &'a OptionSet,
    settings: &'a EpisodeSettings,
    human: Box<dyn Human + 'a>,
    policy: Box<dyn RobotPolicy + 'a>,
) -> Episode<'a> {
    let progress = options.begin();
    let per_step = settings.speed * settings.planning_step;
    let longest = prospects(options, &progress).iter().map(|p| p.length).fold(0.0, f64::max);
    let tick_limit = settings.tick_limit.unwrap_or((10.0 * longest / per_step).ceil() as u64 + 1);
    Episode {
        options,
        settings,
        human,
        policy,
        controller: Box::new(NoRobot),
        walk: Box::new(OnPath { pace: settings.pace() }),
        plant: Box::new(PointPlant::at(progress.position)),
        manipulator: None,
        predictor: settings.predictor.clone(),
        places: None,
        place_key: Vec::new(),
        learner: settings.learner(),
        route: Route::default(),
        tick_limit,
        tick: Tick::empty(progress.position),
        summary: Summary::empty(),
        begun: None,
        carried: None,
        carried_robot: None,
        decided: None,
        prospects: Vec::new(),
        ways: Ways::default(),
        hand_from: progress.position,
        hands: Vec::new(),
        memory: Default::default(),
        perceived: Default::default(),
        body_poses: Vec::new(),
        steps_without_progress: 0,
        ignores_loss: false,
        progress,
    }
}

impl Episode<'_> {
    /// The path on which the team will line up, from the first decisions of copies of the human and the
    /// policy: the robot, whose place follows from it, is not there yet.
    fn first_path(&mut self, passing: Passing) -> Path {
        let now = self.now();
        let copy = self.human.clone();
        let human = std::mem::replace(&mut self.human, copy);
        let begun = self.begin(now);
        self.human = human;
        let seen = view(now, self.settings, &begun, self.options, &self.progress, self.plant.observe());
        let lead = self.policy.clone().decide(&seen);
        let option = self.option(now, &begun.human, &lead);
        self.options.path_passing(&self.progress, option, passing).unwrap_or_default()
    }
}

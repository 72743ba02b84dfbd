//! One co-transportation episode, tick by tick.
//!
//! [`Episode::step`] is the paper's algorithm. It asks two parties and a plant: the [human](crate::human::Human), the robot's
//! [policy](crate::policy::RobotPolicy), and the [team](crate::team::Team) of bodies that both of them move.

mod outcome;
mod settings;
mod state;
mod step;
mod tick;

pub use crate::coordination::OptionTick;
pub use crate::human::PreferenceChange;
pub use crate::team::{Considerations, Manipulator, PhysicsTick, Preparation, RobotTick};
pub use outcome::{
    ControlSummary, GRASP_WARNING_RMS_M, HumanSummary, InteractionSummary, LOSS_DISTANCE_M, Loss, Outcome,
    Summary, Transition,
};
pub use settings::Settings;
pub use state::State;
pub use tick::Tick;

use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::human::{Human, PreferenceHuman};
use crate::options::{OptionSet, Progress, Remaining};
use crate::policy::RobotPolicy;
use crate::preference::{ChoiceDistribution, Perception, Predictor, Prospect};
use crate::robot::Configuration;
use crate::simulation::{Observation, PhysicsError, PhysicsSettings};
use crate::team::{PointTeam, Route, Team, Walk};
use crate::world::World;

/// Options longer than this (m), or without a way, are predicted as if they were this long: far beyond what anyone would choose.
const LONGEST_M: f64 = 1e6;

/// An episode under way. A clone goes on independently and identically.
#[derive(Clone, Debug)]
pub struct Episode<'a> {
    options: &'a OptionSet,
    settings: &'a Settings,
    human: Box<dyn Human + 'a>,
    policy: Box<dyn RobotPolicy + 'a>,
    team: Box<dyn Team + 'a>,
    predictor: Predictor,
    mode: Mode,
    progress: Progress,
    route: Route,
    tick_limit: u64,
    tick: Tick,
    summary: Summary,
    underway: bool,
    prospects: Vec<Prospect>,
    choice: ChoiceDistribution,
    expected: Vec<f64>,
    steps_without_progress: u32,
    /// Whether the episode goes on when the object is lost.
    ignores_loss: bool,
}

/// What is left of every option from where the team is, as it is perceived, in the order of the option set.
pub fn prospects(options: &OptionSet, progress: &Progress) -> Vec<Prospect> {
    (0..options.options().len()).map(|o| prospect(options.remaining(progress, o))).collect()
}

fn prospect(remaining: Remaining) -> Prospect {
    Prospect { length: remaining.length.min(LONGEST_M), risk: remaining.risk }
}

/// Runs an episode to its end; `on_tick` sees every step.
pub fn run(
    options: &OptionSet,
    settings: &Settings,
    human: Perception,
    mut on_tick: impl FnMut(&Tick),
) -> Summary {
    let mut episode = Episode::new(options, settings, human);
    while episode.step().is_none() {
        on_tick(episode.tick());
    }
    episode.summary
}

impl<'a> Episode<'a> {
    /// An episode of the paper's human and the settings' method, with a team that is a point.
    pub fn new(options: &'a OptionSet, settings: &'a Settings, human: Perception) -> Self {
        let n = options.options().len();
        let progress = options.begin();
        let per_step = settings.speed * settings.period;
        let longest = prospects(options, &progress).iter().map(|p| p.length).fold(0.0, f64::max);
        let tick_limit = settings.tick_limit.unwrap_or((10.0 * longest / per_step).ceil() as u64 + 1);
        let policy = settings.method.policy();
        Self {
            options,
            settings,
            human: Box::new(PreferenceHuman::new(human, settings.coordination)),
            team: Box::new(PointTeam),
            predictor: settings.predictor.clone(),
            mode: policy.initial_mode(),
            policy,
            route: Route::default(),
            tick_limit,
            tick: Tick::empty(progress.position),
            summary: Summary::empty(),
            underway: false,
            prospects: Vec::with_capacity(n),
            choice: ChoiceDistribution::default(),
            expected: Vec::with_capacity(n),
            steps_without_progress: 0,
            ignores_loss: false,
            progress,
        }
    }

    /// The same episode from here on with a human who perceives risk and distance like this. While the robot leads, it makes no difference.
    #[must_use]
    pub fn with_preference(mut self, preference: Perception) -> Self {
        self.human.set_preference(preference);
        self
    }

    /// The same episode with another human. Before a robot is given, whose start follows from the first decision.
    #[must_use]
    pub fn with_human(self, human: impl Human + 'a) -> Self {
        self.with_boxed_human(Box::new(human))
    }

    /// [`Episode::with_human`] for a human of a type known at run time.
    #[must_use]
    pub fn with_boxed_human(self, human: Box<dyn Human + 'a>) -> Self {
        Self { human, ..self }
    }

    /// The same episode with another policy of the robot. Before a robot is given, whose start follows from the first decision.
    #[must_use]
    pub fn with_policy(self, policy: impl RobotPolicy + 'a) -> Self {
        Self { mode: policy.initial_mode(), policy: Box::new(policy), ..self }
    }

    /// The same episode with a plant of one's own. Before the first step only.
    #[must_use]
    pub fn with_team(self, team: impl Team + 'a) -> Self {
        Self { team: Box::new(team), ..self }
    }

    /// The same episode with a robot at the other end of the object, on the kinematic plant. Before the first step only.
    #[must_use]
    pub fn with_robot(mut self, manipulator: Manipulator<'a>) -> Self {
        let (start, options) = (self.starting_pose(), self.options.options().len());
        self.team = crate::team::kinematic(manipulator, self.walk_settings(), options, start);
        self
    }

    /// The same episode with robot, object and human as bodies, on the physical plant. Before the first step only. `seed` is the gait's.
    ///
    /// # Errors
    /// [`PhysicsError`] if the team does not fit where it is to start, the human has no room at the end of an option, or a setting is out of
    /// its range.
    pub fn with_physics(
        mut self,
        manipulator: Manipulator<'a>,
        world: &World,
        physics: &PhysicsSettings,
        seed: u64,
    ) -> Result<Self, PhysicsError> {
        let (start, walk) = (self.starting_pose(), self.walk_settings());
        self.team = crate::team::physical(manipulator, walk, self.options, start, world, physics, seed)?;
        Ok(self)
    }

    /// The same episode, which goes on when the object is lost: the paper simulates no object, so that its tables have episodes in which the
    /// grasp is far off. [`ControlSummary::largest_error`] says so.
    #[must_use]
    pub fn ignoring_loss(self) -> Self {
        Self { ignores_loss: true, ..self }
    }

    /// The team faces the way that it will take.
    fn starting_pose(&self) -> PlanarPose {
        let mut planned = self.clone();
        planned.step();
        PlanarPose { position: self.progress.position, yaw: planned.tick.heading }
    }

    fn walk_settings(&self) -> Walk {
        let Settings { period, speed, yaw_rate, .. } = *self.settings;
        Walk { period, speed, yaw_rate }
    }
}

/// What is known of an episode.
impl Episode<'_> {
    /// Where the robot is; `None` without one.
    pub fn configuration(&self) -> Option<&Configuration> {
        self.team.configuration()
    }

    /// What is seen of the physical plant; `None` on others.
    pub fn observation(&self) -> Option<&Observation> {
        self.team.observation()
    }

    /// `world_from_link` of every link of the robot, in the order of [`Robot::links`](crate::robot::Robot::links); `None` without one.
    pub fn link_poses(&self) -> Option<Vec<Pose>> {
        self.team.link_poses()
    }

    /// s, the pose that the grasp should have, on the kinematic plant, where that is all there is of the human; `None` on others.
    pub fn human(&self) -> Option<&PlanarPose> {
        self.team.human()
    }

    /// What the robot's controller decided the last step from; `None` without one, and before the first step.
    pub fn considerations(&self) -> Option<Considerations<'_>> {
        self.team.considerations().filter(|considered| !considered.references.is_empty())
    }

    /// The path from where the executed option was last chosen to the target; empty before the first step.
    pub fn path(&self) -> &Path {
        &self.route.path
    }

    /// Where the team is, m.
    pub fn position(&self) -> Point {
        self.progress.position
    }

    /// Steps that the longest option takes: an episode without detours is not longer.
    pub fn expected_steps(&self) -> u64 {
        let per_step = self.settings.speed * self.settings.period;
        let options = 0..self.options.options().len();
        let lengths = options.map(|o| prospect(self.options.remaining(&self.progress, o)).length);
        (lengths.fold(0.0, f64::max) / per_step).ceil() as u64
    }

    /// The last step taken.
    pub fn tick(&self) -> &Tick {
        &self.tick
    }

    /// What is known of the episode so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The preference change with which the last step taken began; `None` if there was none.
    pub fn change(&self) -> Option<&PreferenceChange> {
        self.human.change(self.summary.steps.checked_sub(1)?)
    }
}

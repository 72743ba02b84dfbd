//! One co-transportation episode, tick by tick.
//!
//! [`Episode::step`] is the paper's algorithm. It asks two partners, the [human](crate::human::Human) and the
//! robot's [policy](crate::policy::RobotPolicy), and a plant, the [team](crate::team::Team) of bodies that
//! both of them move.

mod end;
mod learn;
mod outcome;
mod settings;
mod state;
mod step;
mod tick;
mod view;
mod watch;

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
pub use watch::{Look, Watch};

use crate::coordination::Mode;
use crate::error::Error;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::human::{Human, HumanDecision, PreferenceHuman};
use crate::learning::Learner;
use crate::options::{OptionSet, Progress, Remaining};
use crate::policy::{Decision, RobotPolicy};
use crate::preference::{ChoiceDistribution, Perception, Predictor, Prospect};
use crate::robot::Configuration;
use crate::simulation::{Observation, PhysicsSettings};
use crate::team::{PointTeam, Route, Team, Walk};
use crate::world::World;

/// The length (m) at which predictions cap an option, also one without a path. It is far beyond what a human
/// would choose.
const LONGEST_M: f64 = 1e6;

/// A running episode. A clone continues independently and identically.
#[derive(Clone, Debug)]
pub struct Episode<'a> {
    options: &'a OptionSet,
    settings: &'a Settings,
    human: Box<dyn Human + 'a>,
    policy: Box<dyn RobotPolicy + 'a>,
    team: Box<dyn Team + 'a>,
    predictor: Predictor,
    learner: Option<Box<Learner>>,
    mode: Mode,
    progress: Progress,
    route: Route,
    tick_limit: u64,
    tick: Tick,
    summary: Summary,
    underway: bool,
    /// The human's decision in a step that has begun and is not finished.
    human_decision: Option<HumanDecision>,
    /// The decisions of the last step.
    decided: Option<(HumanDecision, Decision)>,
    prospects: Vec<Prospect>,
    choice: ChoiceDistribution,
    expected: Vec<f64>,
    steps_without_progress: u32,
    /// Whether the episode continues after the loss of the object.
    ignores_loss: bool,
}

/// Remaining length and risk of every option from the team's position, in the order of the option set.
pub fn prospects(options: &OptionSet, progress: &Progress) -> Vec<Prospect> {
    (0..options.options().len()).map(|o| prospect(options.remaining(progress, o))).collect()
}

fn prospect(remaining: Remaining) -> Prospect {
    Prospect { length: remaining.length.min(LONGEST_M), risk: remaining.risk }
}

/// Runs an episode to its end and calls `on_tick` after every step.
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
    /// An episode with the paper's human, the settings' method and a point team.
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
            learner: settings.learner(),
            mode: policy.initial_mode(),
            policy,
            route: Route::default(),
            tick_limit,
            tick: Tick::empty(progress.position),
            summary: Summary::empty(),
            underway: false,
            human_decision: None,
            decided: None,
            prospects: Vec::with_capacity(n),
            choice: ChoiceDistribution::default(),
            expected: Vec::with_capacity(n),
            steps_without_progress: 0,
            ignores_loss: false,
            progress,
        }
    }

    /// The same episode with this alpha and gamma of the human from here on. While the robot leads, they make
    /// no difference.
    #[must_use]
    pub fn with_preference(mut self, preference: Perception) -> Self {
        self.human.set_preference(preference);
        self
    }

    /// The same episode with another human. Call it before adding a robot, whose start follows from the first
    /// decision.
    #[must_use]
    pub fn with_human(self, human: impl Human + 'a) -> Self {
        self.with_boxed_human(Box::new(human))
    }

    /// [`Episode::with_human`] for a human of a type known at run time.
    #[must_use]
    pub fn with_boxed_human(self, human: Box<dyn Human + 'a>) -> Self {
        Self { human, ..self }
    }

    /// The same episode with another robot policy. Call it before adding a robot, whose start follows from
    /// the first decision.
    #[must_use]
    pub fn with_policy(self, policy: impl RobotPolicy + 'a) -> Self {
        self.with_boxed_policy(Box::new(policy))
    }

    /// [`Episode::with_policy`] for a policy of a type known at run time.
    #[must_use]
    pub fn with_boxed_policy(self, policy: Box<dyn RobotPolicy + 'a>) -> Self {
        Self { mode: policy.initial_mode(), policy, ..self }
    }

    /// The same episode with another plant. Call it before the first step.
    #[must_use]
    pub fn with_team(self, team: impl Team + 'a) -> Self {
        Self { team: Box::new(team), ..self }
    }

    /// The same episode with a robot at the other end of the object, on the kinematic plant. Call it before
    /// the first step.
    #[must_use]
    pub fn with_robot(mut self, manipulator: Manipulator<'a>) -> Self {
        let (start, options) = (self.starting_pose(), self.options.options().len());
        self.team = crate::team::kinematic(manipulator, self.walk_settings(), options, start);
        self
    }

    /// The same episode with robot, object and human as bodies, on the physical plant. Call it before the
    /// first step. `seed` determines the gait.
    ///
    /// # Errors
    /// The team does not fit at its start, the robot has no room on its way to the start or the human at the end
    /// of an option, or a setting is out of its range.
    pub fn with_physics(
        mut self,
        manipulator: Manipulator<'a>,
        world: &World,
        physics: &PhysicsSettings,
        seed: u64,
    ) -> Result<Self, Error> {
        let (first, walk) = (self.planned().route.path, self.walk_settings());
        self.team = crate::team::physical(manipulator, walk, self.options, &first, world, physics, seed)?;
        Ok(self)
    }

    /// The same episode, which continues after the loss of the object. The paper simulates no object, so its
    /// tables include episodes in which the grasp is far off. [`ControlSummary::largest_error`] reports it.
    #[must_use]
    pub fn ignoring_loss(self) -> Self {
        Self { ignores_loss: true, ..self }
    }

    /// The starting pose of the team, which faces its first path.
    fn starting_pose(&self) -> PlanarPose {
        PlanarPose { position: self.progress.position, yaw: self.planned().tick.heading }
    }

    /// The same episode after its first step.
    fn planned(&self) -> Self {
        let mut planned = self.clone();
        planned.step();
        planned
    }

    fn walk_settings(&self) -> Walk {
        let Settings { period, speed, yaw_rate, .. } = *self.settings;
        Walk { period, speed, yaw_rate }
    }
}

/// Observers of an episode.
impl Episode<'_> {
    /// Configuration of the robot; `None` without a robot.
    pub fn configuration(&self) -> Option<&Configuration> {
        self.team.configuration()
    }

    /// The observation of the physical plant; `None` on others.
    pub fn observation(&self) -> Option<&Observation> {
        self.team.observation()
    }

    /// `world_from_link` of every link of the robot, in the order of
    /// [`Robot::links`](crate::robot::Robot::links); `None` without a robot.
    pub fn link_poses(&self) -> Option<Vec<Pose>> {
        self.team.link_poses()
    }

    /// s, the pose that the grasp should have, on the kinematic plant, where the human has no other state;
    /// `None` on others.
    pub fn human(&self) -> Option<&PlanarPose> {
        self.team.human()
    }

    /// The basis of the controller's last decision; `None` without a robot and before the first step.
    pub fn considerations(&self) -> Option<Considerations<'_>> {
        self.team.considerations().filter(|considered| !considered.references.is_empty())
    }

    /// The path from where the executed option was last chosen to the target; empty before the first step.
    pub fn path(&self) -> &Path {
        &self.route.path
    }

    /// The team's position along that path, m.
    pub fn along(&self) -> f64 {
        self.route.along
    }

    /// Position of the team, m.
    pub fn position(&self) -> Point {
        self.progress.position
    }

    /// Number of steps on the longest option. An episode without detours takes no more.
    pub fn expected_steps(&self) -> u64 {
        let per_step = self.settings.speed * self.settings.period;
        let options = 0..self.options.options().len();
        let lengths = options.map(|o| prospect(self.options.remaining(&self.progress, o)).length);
        (lengths.fold(0.0, f64::max) / per_step).ceil() as u64
    }

    /// The decisions of the human and of the robot's policy in the last step; `None` before the first.
    pub fn decided(&self) -> Option<&(HumanDecision, Decision)> {
        self.decided.as_ref()
    }

    /// The last step taken.
    pub fn tick(&self) -> &Tick {
        &self.tick
    }

    /// The summary so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The preference change at the beginning of the last step; `None` if there was none.
    pub fn change(&self) -> Option<&PreferenceChange> {
        self.human.change(self.summary.steps.checked_sub(1)?)
    }

    /// The point of the present path at `along` (m).
    fn point_at(&self, along: f64) -> Point {
        match self.route.path.point_at(along) {
            Some(_) if along == self.route.path.length() => self.options.target(),
            Some(point) => point,
            None => self.progress.position,
        }
    }
}

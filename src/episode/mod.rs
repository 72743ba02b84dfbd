//! One co-transportation episode, step by step.
//!
//! [`Episode::step`] is the paper's algorithm. It asks two partners, the [human](crate::human::Human) and the
//! robot's [policy](crate::policy::RobotPolicy), then the robot's [controller](crate::controller::Controller),
//! and moves a [plant](crate::plant::Plant). An [`EpisodeBuilder`] puts them together.

mod builder;
mod carry;
mod end;
mod evaluated;
mod execute;
mod human_observer;
mod learn;
mod motion;
mod now;
mod outcome;
mod places;
mod robot_tick;
mod settings;
mod state;
mod step;
mod tick;
mod view;

pub use crate::control::Manipulator;
pub use crate::controller::DecisionBasis;
pub use crate::coordination::OptionTick;
pub use crate::human::PreferenceChange;
pub use crate::plant::Preparation;
pub use builder::{EpisodeBuilder, Start};
pub use evaluated::prospects;
pub use human_observer::{HumanObserver, Sighting};
pub use motion::{EndMotion, EndMotions, EndSums, MotionSummary};
pub use outcome::{
    ControlSummary, GRASP_WARNING_RMS_M, HumanSummary, InteractionSummary, LOSS_DISTANCE_M, Loss, Outcome,
    Summary, Transition,
};
pub use places::PlaceMemory;
pub use robot_tick::{PhysicsTick, RobotTick};
pub use settings::EpisodeSettings;
pub use state::EpisodeState;
pub use tick::Tick;

use crate::controller::Controller;
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::human::{Human, HumanDecision, PreferenceHuman};
use crate::learning::Learner;
use crate::options::{OptionSet, Progress};
use crate::plant::Plant;
use crate::policy::{Decision, RobotPolicy};
use crate::preference::{PerceivedRisks, Perception, Predictor, Prospect, Ways};
use crate::robot::Configuration;
use crate::simulation::Observation;
use crate::team::{Route, Walk};
use carry::Carried;
use evaluated::{Evaluated, Predicted};
use places::Places;
use std::sync::Arc;
use step::Begun;

/// A running episode. A clone continues independently and identically.
#[derive(Clone, Debug)]
pub struct Episode<'a> {
    options: &'a OptionSet,
    settings: &'a EpisodeSettings,
    human: Box<dyn Human + 'a>,
    policy: Box<dyn RobotPolicy + 'a>,
    controller: Box<dyn Controller + 'a>,
    walk: Box<dyn Walk + 'a>,
    plant: Box<dyn Plant + 'a>,
    manipulator: Option<Manipulator<'a>>,
    predictor: Predictor,
    /// What other episodes found at places, if it is kept, and memory for the search.
    places: Option<Arc<Places>>,
    place_key: Vec<u64>,
    learner: Option<Box<Learner>>,
    progress: Progress,
    route: Route,
    tick_limit: u64,
    /// The last step.
    tick: Tick,
    summary: Summary,
    /// A step that has begun, before the decision of the robot's policy.
    begun: Option<Begun>,
    /// A step that is being carried out.
    carried: Option<Carried>,
    /// The robot in the control periods of that step that are done.
    carried_robot: Option<RobotTick>,
    /// The decisions of the last step.
    decided: Option<(HumanDecision, Decision)>,
    /// D_o and S_o in the last step.
    prospects: Vec<Prospect>,
    /// Which options had become one way in the last step.
    ways: Ways,
    /// Position of the hand at the beginning of the step, m, and the targets that the human gave for its
    /// control periods.
    hand_from: Point,
    hands: Vec<Option<Point>>,
    /// Memory for the next step, and for the poses of the robot's bodies.
    memory: (Evaluated, Predicted),
    perceived: PerceivedRisks,
    body_poses: Vec<Pose>,
    steps_without_progress: u32,
    /// Whether the episode continues after the loss of the object.
    ignores_loss: bool,
}

/// Runs an episode to its end and calls `on_tick` after every step.
pub fn run(
    options: &OptionSet,
    settings: &EpisodeSettings,
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
    /// An episode with the paper's human, the settings' method and a point as the team.
    ///
    /// # Panics
    /// Settings of learning are out of their ranges, which [`EpisodeBuilder::begin`] refuses.
    pub fn new(options: &'a OptionSet, settings: &'a EpisodeSettings, human: Perception) -> Self {
        let human = Box::new(PreferenceHuman::new(human, settings.coordination));
        builder::point_episode(options, settings, human, settings.method.policy())
    }

    /// The same with a choice of partners, controller and plant.
    pub fn builder(
        options: &'a OptionSet,
        settings: &'a EpisodeSettings,
        human: Perception,
    ) -> EpisodeBuilder<'a> {
        EpisodeBuilder::new(options, settings, human)
    }

    /// The same episode with this alpha and gamma of the human from here on. While the robot leads, they make
    /// no difference.
    #[must_use]
    pub fn with_preference(mut self, preference: Perception) -> Self {
        self.human.set_preference(preference);
        self
    }

    /// The same episode, which continues after the loss of the object. The paper simulates no object, so its
    /// tables include episodes in which the grasp is far off. [`ControlSummary::largest_error`] reports it.
    #[must_use]
    pub fn ignoring_loss(self) -> Self {
        Self { ignores_loss: true, ..self }
    }
}

/// Observers of an episode.
impl Episode<'_> {
    /// Configuration of the robot; `None` without a robot.
    pub fn configuration(&self) -> Option<&Configuration> {
        self.plant.observe().configuration
    }

    /// The observation of bodies and forces; `None` on plants without dynamics.
    pub fn observation(&self) -> Option<&Observation> {
        self.plant.observe().bodies
    }

    /// `world_from_link` of every link of the robot, in the order of
    /// [`Robot::links`](crate::robot::Robot::links); `None` without a robot.
    pub fn link_poses(&self) -> Option<Vec<Pose>> {
        let seen = || Some(self.manipulator?.robot.link_poses(self.configuration()?));
        self.plant.link_poses().or_else(seen)
    }

    /// s, the pose that the grasp should have, on plants with a robot where the human has no other state;
    /// `None` on others.
    pub fn human(&self) -> Option<PlanarPose> {
        self.plant.observe().human
    }

    /// The basis of the controller's last command; `None` without a robot and before the first step.
    pub fn decision_basis(&self) -> Option<DecisionBasis<'_>> {
        self.controller.decision_basis().filter(|basis| !basis.references.is_empty())
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
        let lengths = prospects(self.options, &self.progress).into_iter().map(|option| option.length);
        (lengths.fold(0.0, f64::max) / (self.settings.speed * self.settings.planning_step)).ceil() as u64
    }

    /// The decisions of the human and of the robot's policy in the last step; `None` before the first.
    pub fn decided(&self) -> Option<&(HumanDecision, Decision)> {
        self.decided.as_ref()
    }

    /// Which options have become one way, as of their last evaluation: at the beginning of the present step, or
    /// between steps of the last one.
    pub fn ways(&self) -> &Ways {
        self.present().map_or(&self.ways, |begun| &begun.evaluated.ways)
    }

    /// The targets of the human's hand in the control periods of the last step that [`Human::hand`] gave.
    pub fn hands(&self) -> &[Option<Point>] {
        &self.hands
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

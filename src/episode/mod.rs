//! A world's options, a human and settings in; one co-transportation episode, tick by tick, and its outcome out.
//!
//! [`Episode::step`] is the paper's algorithm: observe, evaluate the options, predict the choice, accumulate stubbornness, decide the mode,
//! choose the option, prepare the pose and control the robot, walk. Without a robot, the team is a point that walks its path exactly: the
//! planning level. With one, the human walks so, and the robot holds the other end.

mod carrier;
mod change;
mod outcome;
mod retreat;
mod settings;
mod state;
mod team;
mod tick;
mod way;

pub use carrier::{Decision, Manipulator};
pub use change::PreferenceChange;
pub use outcome::{
    ControlSummary, GRASP_WARNING_RMS_M, HumanSummary, InteractionSummary, LOSS_DISTANCE_M, Loss, Outcome,
    Summary, Transition,
};
pub use settings::Settings;
pub use state::{Misfit, State};
pub use tick::{OptionTick, PhysicsTick, Preparation, RobotTick, Tick};

use carrier::{Carrier, Situation};
use retreat::Retreat;
use team::{Gait, PhysicalTeam, Walk};
use way::{Ground, Turned};

use crate::coordination::{Coordinator, Method, Mode, is_misaligned, robot_choice};
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::options::{OptionSet, Progress, Remaining, Waypoint};
use crate::preference::{
    ChoiceDistribution, Perception, Predictor, Prospect, human_choice, objective_cost, subjective_cost,
};
use crate::robot::Configuration;
use crate::simulation::{Failure, Observation, Party, PhysicalPlant, PhysicsError, PhysicsSettings};
use crate::world::World;

/// On the physical plant, the team is there when the object's middle is this near (m) to the end of its way.
const THERE: f64 = 0.05;
/// Steps without progress after which a team is stuck: ten seconds.
const STUCK: u32 = 50;
/// Options longer than this (m), or without a way, are predicted as if they were this long: far beyond what anyone would choose.
const FARTHEST: f64 = 1e6;

/// An episode under way. A clone goes on independently and identically.
#[derive(Clone, Debug)]
pub struct Episode<'a> {
    options: &'a OptionSet,
    settings: &'a Settings,
    human: Perception,
    /// What the human makes of risk and distance later, by step; one a step.
    changes: Vec<PreferenceChange>,
    predictor: Predictor,
    coordinator: Coordinator,
    progress: Progress,
    /// The path under way and how far along it the team is, m.
    path: Path,
    along: f64,
    /// Until it is so far along it (m), it is turning onto it.
    turns_until: f64,
    tick_limit: u64,
    tick: Tick,
    summary: Summary,
    underway: bool,
    prospects: Vec<Prospect>,
    choice: ChoiceDistribution,
    expected: Vec<f64>,
    carrier: Option<Carrier<'a>>,
    /// Whether the episode goes on when the object is lost.
    ignores_loss: bool,
    /// Which way the team walks in this step, and what for.
    gait: Gait,
    retreat: Retreat,
    steps_without_progress: u32,
}

/// What is left of every option from where the team is, as it is perceived, in the order of the option set.
pub fn prospects(options: &OptionSet, progress: &Progress) -> Vec<Prospect> {
    (0..options.options().len()).map(|o| prospect(options.remaining(progress, o))).collect()
}

fn prospect(remaining: Remaining) -> Prospect {
    Prospect { length: remaining.length.min(FARTHEST), risk: remaining.risk }
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
    /// An episode that has not begun.
    pub fn new(options: &'a OptionSet, settings: &'a Settings, human: Perception) -> Self {
        let n = options.options().len();
        let progress = options.begin();
        let per_step = settings.speed * settings.period;
        let longest = prospects(options, &progress).iter().map(|p| p.length).fold(0.0, f64::max);
        let tick_limit = settings.tick_limit.unwrap_or((10.0 * longest / per_step).ceil() as u64 + 1);
        Self {
            options,
            settings,
            human,
            changes: Vec::new(),
            predictor: settings.predictor.clone(),
            coordinator: Coordinator::new(settings.coordination, settings.method),
            path: Path::default(),
            along: 0.0,
            turns_until: 0.0,
            tick_limit,
            tick: Tick::empty(progress.position),
            summary: Summary::empty(),
            underway: false,
            prospects: Vec::with_capacity(n),
            choice: ChoiceDistribution::default(),
            expected: Vec::with_capacity(n),
            carrier: None,
            ignores_loss: false,
            gait: Gait::Forward,
            retreat: Retreat::None,
            steps_without_progress: 0,
            progress,
        }
    }

    /// The same episode with a human who changes their mind, in whatever order the changes are listed; of several at the same step, the last
    /// stands. Before a robot is given, whose start follows from the way chosen first, and before the first step; or of an episode gone on
    /// with, before the next, which steps that are over no longer matter to.
    pub fn with_changes(mut self, changes: &[PreferenceChange]) -> Self {
        self.changes = PreferenceChange::standing(changes);
        self
    }

    /// The same episode with a robot at the other end of the object, on the kinematic plant. Before the first step only.
    pub fn with_robot(mut self, manipulator: Manipulator<'a>) -> Self {
        let start = self.starting_pose();
        let options = self.options.options().len();
        self.carrier = Some(Carrier::kinematic(manipulator, self.walk_settings(), options, start));
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
        let start = self.starting_pose();
        let Manipulator { robot, posture, .. } = manipulator;
        let plant = PhysicalPlant::new(world, robot, &posture, &start, physics, seed)?;
        let team = PhysicalTeam::new(plant, world, robot.grasp_height, &start);
        let ground = Ground { obstacles: manipulator.obstacles, options: self.options };
        for (o, option) in self.options.options().iter().enumerate() {
            let path = self.options.path(&self.progress, o).unwrap_or_default();
            team.check_end(&path, &option.name, world, ground)?;
        }
        let options = self.options.options().len();
        self.carrier = Some(Carrier::physical(manipulator, self.walk_settings(), options, team));
        Ok(self)
    }

    /// The same episode, which goes on as if nothing were when the object is lost: the paper simulates no object, so that its tables have
    /// episodes in which the grasp is far off. [`ControlSummary::largest_error`] says so.
    pub fn ignoring_loss(mut self) -> Self {
        self.ignores_loss = true;
        self
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

    /// Where the robot is; `None` without one.
    pub fn configuration(&self) -> Option<&Configuration> {
        self.carrier.as_ref().map(Carrier::configuration)
    }

    /// What is seen of the physical plant; `None` on others.
    pub fn observation(&self) -> Option<&Observation> {
        self.carrier.as_ref().and_then(Carrier::observation)
    }

    /// `world_from_link` of every link of the robot, in the order of [`Robot::links`](crate::robot::Robot::links); `None` without one.
    pub fn link_poses(&self) -> Option<Vec<Pose>> {
        self.carrier.as_ref().map(Carrier::link_poses)
    }

    /// s, the pose that the grasp should have, on the kinematic plant, where that is all there is of the human; `None` on others.
    pub fn human(&self) -> Option<&PlanarPose> {
        self.carrier.as_ref().and_then(Carrier::human)
    }

    /// What the robot decided the last step from; `None` without one, and before the first step.
    pub fn decision(&self) -> Option<Decision<'_>> {
        self.carrier.as_ref().map(Carrier::decision).filter(|decision| !decision.references.is_empty())
    }

    /// The way from where the executed option was last chosen to the target; empty before the first step.
    pub fn path(&self) -> &Path {
        &self.path
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

    /// The same episode from here on with another human. While the robot leads, the human's parameters make no difference.
    pub fn with_human(mut self, human: Perception) -> Self {
        self.human = human;
        self
    }

    /// The change of mind with which the last step taken began; `None` if there was none.
    pub fn change(&self) -> Option<&PreferenceChange> {
        let last = self.summary.steps.checked_sub(1)?;
        PreferenceChange::at(&self.changes, last)
    }

    /// Takes one planning step, or says how the episode ended.
    pub fn step(&mut self) -> Option<Outcome> {
        if let Some(outcome) = self.ended() {
            self.summary.outcome = outcome;
            return Some(outcome);
        }
        self.change_mind();
        self.observe();
        self.evaluate_options(); //             D_o, S_o, J_o          eq. (1)
        self.predict_choice(); //               P_o                    eq. (4)
        self.accumulate_stubbornness(); //      g(k), phi(k), mode     eq. (5)
        let option = self.choose(); //          o*(k) or o_h           eq. (6), (3)
        self.execute(option);
        self.control(); //                      q*, u                  eq. (8), (7)
        self.walk();
        None
    }

    fn ended(&self) -> Option<Outcome> {
        match &self.summary.failure {
            Some(Failure::NonFinite { .. }) => return Some(Outcome::NonFinite),
            Some(Failure::Dropped) => return Some(Outcome::Dropped),
            None => {}
        }
        if self.summary.collision.is_some() {
            return Some(Outcome::Collided);
        }
        if self.summary.loss.is_some() {
            return Some(Outcome::ObjectLost);
        }
        if self.underway && self.along >= self.path.length() {
            let at_target = (self.progress.position - self.options.target()).norm() < 1e-6;
            return Some(if at_target { Outcome::Arrived } else { Outcome::NoWay });
        }
        if self.steps_without_progress > STUCK {
            return Some(Outcome::Stuck);
        }
        (self.summary.steps >= self.tick_limit).then_some(Outcome::OutOfTime)
    }

    /// The human's alone: what the robot believes stays as it is.
    fn change_mind(&mut self) {
        if let Some(change) = PreferenceChange::at(&self.changes, self.summary.steps) {
            self.human = change.perception;
            self.summary.human.changes_of_mind += 1;
        }
    }

    fn observe(&mut self) {
        self.tick.step = self.summary.steps;
        self.tick.time = self.tick.step as f64 * self.settings.period;
        self.tick.position = self.progress.position;
    }

    fn evaluate_options(&mut self) {
        self.tick.options.clear();
        self.prospects.clear();
        for o in 0..self.options.options().len() {
            let remaining = self.options.remaining(&self.progress, o);
            let prospect = prospect(remaining);
            self.prospects.push(prospect);
            self.tick.options.push(OptionTick {
                remaining,
                objective: objective_cost(prospect, self.predictor.risk_weight()),
                expected: f64::NAN,
                probability: f64::NAN,
                misaligned: false,
            });
        }
    }

    fn predict_choice(&mut self) {
        let robot_leads = self.coordinator.mode() == Mode::RobotLed;
        if robot_leads || self.settings.predict_while_human_leads || self.carrier.is_some() {
            let current = self.underway.then_some(self.tick.executed);
            self.predictor.predict_from(&self.prospects, current, &mut self.choice);
            for (tick, p) in self.tick.options.iter_mut().zip(self.choice.probabilities()) {
                tick.probability = *p;
            }
        }
        if robot_leads {
            self.predictor.expected_costs(&self.prospects, &mut self.expected);
            for (tick, cost) in self.tick.options.iter_mut().zip(&self.expected) {
                tick.expected = *cost;
            }
        }
    }

    fn accumulate_stubbornness(&mut self) {
        // g(0) = 0: before the first step the team moves nowhere
        if self.underway && self.coordinator.mode() == Mode::RobotLed {
            let toward = self.team_waypoint();
            let mut misaligned = 0.0;
            for option in &mut self.tick.options {
                option.misaligned = is_misaligned(toward, option.remaining.next);
                misaligned += if option.misaligned { option.probability } else { 0.0 };
            }
            self.coordinator.accumulate(misaligned);
            if self.coordinator.mode() == Mode::HumanLed {
                let transition = Transition { step: self.tick.step, position: self.tick.position };
                self.summary.transition = Some(transition);
            }
        }
        self.tick.mode = self.coordinator.mode();
        self.tick.stubbornness = self.coordinator.stubbornness();
        self.tick.discomfort = self.coordinator.discomfort();
    }

    fn team_waypoint(&self) -> Waypoint {
        self.options.next(&self.progress, self.tick.executed)
    }

    fn choose(&mut self) -> usize {
        let current = self.underway.then_some(self.tick.executed);
        let (weight, human, before) = (self.predictor.risk_weight(), self.human, self.tick.preferred);
        self.tick.preferred = human_choice(&self.prospects, weight, human, current);
        let switched = current.is_some() && self.tick.preferred != before;
        self.summary.human.preference_switches += u32::from(switched);
        match (self.coordinator.mode(), self.coordinator.method()) {
            (Mode::RobotLed, _) => {
                let costs = self.tick.options.iter().map(|o| (o.objective, o.expected));
                robot_choice(costs, self.tick.stubbornness, current)
            }
            (Mode::HumanLed, Method::WithoutModel) => current.unwrap_or(self.tick.preferred),
            (Mode::HumanLed, _) => self.tick.preferred,
        }
    }

    fn execute(&mut self, option: usize) {
        self.gait = Gait::Forward;
        self.tick.steps_back_for = None;
        if option == self.tick.executed {
            self.retreat.call_off();
        }
        if !self.underway {
            let path = self.options.path(&self.progress, option).unwrap_or_default();
            self.path = match &self.carrier {
                None => path,
                Some(carrier) => carrier.wide(path, self.options),
            };
            self.tick.executed = option;
            self.summary.first_option = option;
            self.underway = true;
        } else if option != self.tick.executed && self.along >= self.turns_until {
            self.turn_onto(option);
        }
        let executed = self.tick.executed;
        self.tick.objective_cost = self.tick.options[executed].objective;
        self.tick.heading = self.path.heading_at(self.along).unwrap_or(self.tick.heading);
        self.summary.accumulated_cost += self.tick.objective_cost;
        self.tick.accumulated_cost = self.summary.accumulated_cost;
        self.summary.last_option = executed;
        let (human, weight) = (&mut self.summary.human, self.predictor.risk_weight());
        human.subjective_cost += subjective_cost(self.prospects[executed], weight, self.human);
        human.steps_off_preference += u64::from(executed != self.tick.preferred);
        (human.stubbornness, human.discomfort) = (self.tick.stubbornness, self.tick.discomfort);
    }

    /// A path under way is walked on as it is, until another option is chosen and, on the physical plant, the team has turned onto this one
    /// and there is room to turn, or else it has stepped back to where there is.
    fn turn_onto(&mut self, option: usize) {
        let next = self.options.path(&self.progress, option).unwrap_or_default();
        let turned = match &mut self.carrier {
            None => Some(Turned { path: next, until: 0.0 }),
            Some(carrier) => carrier.turn(&self.path, self.along, next, self.options),
        };
        if let Some(Turned { path, until }) = turned {
            self.path = path;
            self.along = 0.0;
            self.turns_until = until;
            self.tick.executed = option;
            self.summary.changes += 1;
            self.retreat = Retreat::None;
        } else {
            self.step_back(option);
        }
    }

    fn control(&mut self) {
        let Some(carrier) = &mut self.carrier else { return };
        self.tick.robot = Some(carrier.decide(&Situation {
            mode: self.tick.mode,
            gait: self.gait,
            options: self.options,
            progress: &self.progress,
            choice: &self.choice,
            path: &self.path,
            along: self.along,
        }));
    }

    fn walk(&mut self) {
        let length = self.path.length();
        let along = self.along + self.settings.speed * self.settings.period;
        // a last step shorter than rounding is not a step
        let mut along = if along >= length - 1e-9 { length } else { along };
        let mut to = self.point_at(along);
        if let (Some(carrier), Some(tick)) = (&mut self.carrier, &mut self.tick.robot) {
            let goal = (self.along, along, to);
            let reached = carrier.act((self.tick.mode, self.gait), &self.path, goal, tick);
            self.summary.control.get_or_insert_default().add(tick);
            if let Some(physics) = &tick.physics {
                self.summary.interaction.get_or_insert_default().add(physics);
                along = if reached >= length - THERE { length } else { reached };
            }
            to = self.point_at(along);
        }
        self.note_incidents();
        let came_on = (along - self.along).abs() > 0.1 * self.settings.speed * self.settings.period;
        self.steps_without_progress = if came_on { 0 } else { self.steps_without_progress + 1 };
        self.options.advance(&mut self.progress, to);
        self.summary.walked += (along - self.along).abs();
        self.along = along;
        self.summary.steps += 1;
    }

    /// The point of the path under way after `along` (m).
    fn point_at(&self, along: f64) -> Point {
        match self.path.point_at(along) {
            Some(_) if along == self.path.length() => self.options.target(),
            Some(point) => point,
            None => self.progress.position,
        }
    }

    /// A loss of the object, contacts with obstacles, and what broke.
    fn note_incidents(&mut self) {
        let hold = self.tick.robot.as_ref().map(RobotTick::worst_hold);
        if let Some((by, distance)) = hold.filter(|(_, distance)| *distance > LOSS_DISTANCE_M)
            && !self.ignores_loss
        {
            self.summary.loss = Some(Loss { by, step: self.tick.step, distance });
        }
        let Some(seen) = self.carrier.as_ref().and_then(Carrier::observation) else { return };
        let with_obstacle =
            seen.contacts.iter().find(|c| c.between.iter().any(|p| p.party == Party::Obstacle));
        self.summary.collision = with_obstacle.cloned();
        self.summary.failure.clone_from(&seen.failure);
    }
}

//! H4, which is not in the paper: does it pay that the robot learns who it carries with? One person carries
//! several times in a row with the same robot, which keeps what it has learned.
//!
//! Robots are compared with the same humans in the same worlds. Some humans are of the model that the robot
//! learns with, others are not.

mod control;
mod people;
mod rows;
pub mod section;

pub use control::{ControlRow, MAX_HUMANS, ROBOTS_WITH_ARM};
pub use people::{HumanKind, RATIONALITY};
pub use rows::{PersonRow, Task};

use super::h3::PoseMethod;
use super::prepared;
use crate::parallel::{OnDone, in_parallel};
use crate::statistics::{self, Paired, mean_and_std};
use cocarry::coordination::{self, Mode, robot_choice};
use cocarry::episode::{Episode, EpisodeSettings, Outcome, Tick};
use cocarry::learning::{self, Learner, LearningError, TolerancePrior};
use cocarry::math;
use cocarry::policy::Method;
use cocarry::preference::{Belief, Perception, Prospect, WeightedSample, subjective_cost};
use cocarry::scenario::{Partners, Plant, PreparedScenario, Scenario, WorldText};
use cocarry::world::BUILT_IN_WORLDS;
use cocarry::{Error, ErrorKind};
use people::{Person, outside};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rows::Setting;
use serde::Serialize;

/// Default number of humans of each kind in each group of worlds.
pub const HUMANS: usize = 200;
/// Default number of random worlds.
pub const WORLDS: usize = 20;
/// Default number of tasks in a row.
pub const TASKS: usize = 2;
/// The name of the group of random worlds.
pub const RANDOM_WORLDS: &str = "random worlds";
/// The name of all groups together.
pub const ALL_WORLDS: &str = "all";
/// A robot's knowledge about the person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RobotKind {
    /// The paper's: the prior of alpha and gamma, and phi(k), hence eta.
    Prior,
    /// It learns alpha, gamma and eta with the default rates.
    Learns,
    /// It learns with [`FORGETFUL`], a larger lapse rate and change rate.
    Forgets,
    /// It knows alpha, gamma and eta.
    Knows,
}

/// The rates of the robot that bears contradictions better, and forgets sooner.
pub const FORGETFUL: [f64; 2] = [0.2, 0.05];

impl RobotKind {
    /// All robots, the paper's first.
    pub const ALL: [Self; 4] = [Self::Prior, Self::Learns, Self::Forgets, Self::Knows];

    /// Name, as in `--json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Prior => "prior",
            Self::Learns => "learns",
            Self::Forgets => "forgets",
            Self::Knows => "knows",
        }
    }
}

/// The study.
#[derive(Clone, Copy, Debug)]
pub struct LearningStudy<'a> {
    /// The episode's settings; method, eta and belief are replaced.
    pub settings: &'a EpisodeSettings,
    /// The kinematic plant, for control costs.
    pub plant: &'a Plant,
    /// Humans of each kind in each group of worlds.
    pub humans: usize,
    /// Random worlds with two options or more; the humans of their group take them in turn.
    pub worlds: usize,
    /// Tasks in a row.
    pub tasks: usize,
    /// Seed of humans and worlds.
    pub seed: u64,
}

/// One robot with humans of one kind, in one of their tasks. Differences are to [`RobotKind::Prior`] with the
/// same humans, of those who arrive both times; they are corrected for all comparisons of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearningRow {
    /// The world, [`RANDOM_WORLDS`] or [`ALL_WORLDS`].
    pub world: String,
    /// The humans.
    pub humans: HumanKind,
    /// The task, from 1.
    pub task: usize,
    /// The robot.
    pub robot: RobotKind,
    /// Number of humans.
    pub episodes: usize,
    /// Episodes that did not arrive.
    pub not_arrived: usize,
    /// Mean regret: the sum over the steps that the robot leads of the cost of eq. (6) of the executed option
    /// minus the least one there, with the person's true alpha, gamma and phi(k).
    pub regret: f64,
    /// Standard deviation of the regret.
    pub regret_std: f64,
    /// The difference in regret.
    pub regret_against_prior: Option<Paired>,
    /// Mean of the sum of J^ of the executed option over the steps, with the person's alpha and gamma.
    pub human_cost: f64,
    /// The difference in that.
    pub human_cost_against_prior: Option<Paired>,
    /// Mean of the sum of J of the executed option over the steps, m.
    #[serde(rename = "objective_cost_m")]
    pub objective_cost: f64,
    /// The difference in that, m.
    #[serde(rename = "objective_cost_against_prior_m")]
    pub objective_cost_against_prior: Option<Paired>,
    /// Share of the steps on another option than the human prefers.
    pub share_off_preference: f64,
    /// Episodes in which the human took over.
    pub transitions: usize,
}

/// The rows of all tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Humans of the model, by world.
    pub by_world: Vec<LearningRow>,
    /// All worlds, by kind of human.
    pub by_human: Vec<LearningRow>,
    /// Humans of the model with a robot that has an arm, by method, pose optimisation and world.
    pub control: Vec<ControlRow>,
    /// Every person in every task with every robot, from which the other rows are computed.
    #[serde(skip)]
    pub people: Vec<PersonRow>,
}

/// Worlds of one group.
struct WorldGroup {
    name: String,
    worlds: Vec<PreparedScenario>,
}

/// The tasks of one person with each robot.
type Tasks = [Vec<Task>; RobotKind::ALL.len()];

/// The stream of a person of a group.
fn stream_of(group: usize, human: usize) -> u64 {
    ((group as u64 + 1) << 32) + human as u64
}

impl LearningStudy<'_> {
    /// Units of work, for a progress bar.
    pub fn units(&self) -> usize {
        self.group_count() * HumanKind::ALL.len() * self.humans + self.control_units()
    }

    fn group_count(&self) -> usize {
        BUILT_IN_WORLDS.len() + usize::from(self.worlds > 0)
    }

    /// Runs all tasks. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn run(&self, on_done: OnDone) -> Result<Findings, Error> {
        let groups = self.groups(Method::MUTUAL, &Plant::Point)?;
        let (kinds, n) = (HumanKind::ALL.len(), self.humans);
        let all = in_parallel(groups.len() * kinds * n, on_done, |i| {
            let (group, kind, human) = (i / n / kinds, i / n % kinds, i % n);
            let worlds = &groups[group].worlds;
            self.tasks_of(&worlds[human % worlds.len()], &self.person(group, HumanKind::ALL[kind], human))
        });
        let all = all.into_iter().collect::<Result<Vec<Tasks>, Error>>()?;
        let of = |group: usize, kind: usize| &all[(group * kinds + kind) * n..][..n];
        let mut by_world = Vec::new();
        for (g, group) in groups.iter().enumerate() {
            let people: Vec<_> = of(g, 0).iter().collect();
            by_world.extend(self.rows(&group.name, HumanKind::Model, &people));
        }
        let mut by_human = Vec::new();
        for (k, kind) in HumanKind::ALL.into_iter().enumerate() {
            let people: Vec<_> = (0..groups.len()).flat_map(|g| of(g, k)).collect();
            by_human.extend(self.rows(ALL_WORLDS, kind, &people));
        }
        for rows in [&mut by_world, &mut by_human] {
            statistics::correct(rows.iter_mut().flat_map(LearningRow::comparisons));
        }
        let mut people = Vec::new();
        for (i, tasks) in all.iter().enumerate() {
            let (group, kind, human) = (i / n / kinds, i / n % kinds, i % n);
            people.extend(self.person_rows(
                (Method::MUTUAL, None),
                &groups[group],
                self.person(group, HumanKind::ALL[kind], human),
                (group, human),
                tasks,
            ));
        }
        let control = self.control(&mut people, on_done)?;
        Ok(Findings { by_world, by_human, control, people })
    }

    /// The rows of one person.
    fn person_rows(
        &self,
        (method, pose): (Method, Option<PoseMethod>),
        group: &WorldGroup,
        person: Person,
        (number, human): (usize, usize),
        tasks: &Tasks,
    ) -> Vec<PersonRow> {
        let (world, world_number) = (group.name.as_str(), human % group.worlds.len());
        let setting = Setting { method, pose, world, world_number, stream: stream_of(number, human) };
        rows::rows(setting, &person, tasks).collect()
    }

    /// The built-in worlds, each by itself.
    fn built_in(&self, method: Method, plant: &Plant) -> Result<Vec<WorldGroup>, Error> {
        let worlds = BUILT_IN_WORLDS.iter().map(|world| {
            let text = (world.name.to_owned(), world.text.to_owned());
            Ok(WorldGroup { name: world.name.to_owned(), worlds: vec![self.prepared(text, method, plant)?] })
        });
        worlds.collect()
    }

    fn prepared(
        &self,
        (file, text): (String, String),
        method: Method,
        plant: &Plant,
    ) -> Result<PreparedScenario, Error> {
        let predict_while_human_leads = plant.robot_setup().is_some();
        let settings =
            EpisodeSettings { method, predict_while_human_leads, learning: None, ..self.settings.clone() };
        prepared(WorldText { file, text }, &settings, plant)
    }

    /// The built-in worlds and random ones. These are the same for every method and plant.
    fn groups(&self, method: Method, plant: &Plant) -> Result<Vec<WorldGroup>, Error> {
        let mut groups = self.built_in(method, plant)?;
        let mut rng = self.stream(0);
        let mut worlds = Vec::new();
        while worlds.len() < self.worlds {
            let text = (RANDOM_WORLDS.to_owned(), super::cycles::random_world(&mut rng));
            match self.prepared(text.clone(), Method::MUTUAL, &Plant::Point) {
                // the start or target is inside an obstacle, or enclosed
                Err(error) if error.kind() == ErrorKind::World => {}
                world => {
                    if world?.options().options().len() > 1 {
                        worlds.push(self.prepared(text, method, plant)?);
                    }
                }
            }
        }
        if !worlds.is_empty() {
            groups.push(WorldGroup { name: RANDOM_WORLDS.to_owned(), worlds });
        }
        Ok(groups)
    }

    fn stream(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }

    fn person(&self, group: usize, kind: HumanKind, human: usize) -> Person {
        // the same people for all kinds, as far as they can be
        let mut rng = self.stream(stream_of(group, human));
        let belief = self.settings.predictor.belief();
        let eta = TolerancePrior::default().sample(&mut rng);
        let [first, second] = [0; 2].map(|_| belief.sample(&mut rng));
        let seeds = (0..self.tasks).map(|_| rng.random()).collect();
        let first = if kind == HumanKind::OutsidePrior { outside(belief, &mut rng) } else { first };
        let changes = |task| kind == HumanKind::ChangeOfMind && 2 * task >= self.tasks;
        let perceptions = (0..self.tasks).map(|task| if changes(task) { second } else { first }).collect();
        Person { kind, eta, perceptions, seeds }
    }

    fn tasks_of(&self, world: &PreparedScenario, person: &Person) -> Result<Tasks, Error> {
        let mut all = Tasks::default();
        for (robot, tasks) in RobotKind::ALL.into_iter().zip(&mut all) {
            let mut learner = None;
            for task in 0..self.tasks {
                let knows = robot == RobotKind::Knows;
                if knows || learner.is_none() {
                    learner = self.learner(robot, person, task)?;
                }
                let base = world.scenario();
                let coordination =
                    coordination::StubbornnessSettings { eta: person.eta, ..base.settings.coordination };
                let settings = EpisodeSettings { coordination, ..base.settings.clone() };
                let human = person.perceptions[task];
                let prepared = world.prepare(Scenario { human, settings, ..base.clone() })?;
                let partners = Partners { human: Some(person.human(&prepared, task)), policy: None };
                // the paper simulates no object
                let mut episode = prepared.episode_of(partners)?.ignoring_loss();
                if let Some(learner) = learner.take() {
                    episode = episode.with_learner(learner);
                }
                tasks.push(carry(&mut episode, &prepared.scenario().settings, human));
                learner = episode.into_learner();
            }
        }
        Ok(all)
    }

    /// The robot before a task with a person that it has not met.
    fn learner(
        &self,
        robot: RobotKind,
        person: &Person,
        task: usize,
    ) -> Result<Option<Learner>, LearningError> {
        let (predictor, phi) = (&self.settings.predictor, self.settings.coordination.initial_stubbornness);
        let (default, prior) = (learning::LearningSettings::default(), predictor.belief().clone());
        let (settings, belief) = match robot {
            RobotKind::Prior => return Ok(None),
            RobotKind::Learns => (default, prior),
            RobotKind::Forgets => {
                let [lapse_rate, change_rate] = FORGETFUL;
                (learning::LearningSettings { lapse_rate, change_rate, ..default }, prior)
            }
            RobotKind::Knows => {
                let tolerance = TolerancePrior { median: person.eta, log_std: 1e-6 };
                let known = WeightedSample { perception: person.perceptions[task], weight: 1.0 };
                let known = Belief::samples(vec![known]).unwrap_or(prior);
                (learning::LearningSettings { tolerance, ..default }, known)
            }
        };
        Learner::new(settings, belief, predictor.risk_weight(), phi).map(Some)
    }

    fn rows(&self, world: &str, humans: HumanKind, people: &[&Tasks]) -> Vec<LearningRow> {
        let mut rows = Vec::new();
        for task in 0..self.tasks {
            let of = |robot: usize| people.iter().map(move |tasks| &tasks[robot][task]);
            for (robot, kind) in RobotKind::ALL.into_iter().enumerate() {
                let list = |value: fn(&Task) -> f64| of(robot).map(value).collect::<Vec<f64>>();
                let mean = |value| mean_and_std(&list(value)).0;
                let against_prior = |value: fn(&Task) -> f64| {
                    let both: Vec<_> = of(robot).zip(of(0)).filter(|(a, b)| a.arrived && b.arrived).collect();
                    let [first, second]: [Vec<f64>; 2] = [
                        both.iter().map(|p| value(p.0)).collect(),
                        both.iter().map(|p| value(p.1)).collect(),
                    ];
                    (robot > 0).then(|| Paired::of_lists(&first, &second, true)).flatten()
                };
                let (regret, regret_std) = mean_and_std(&list(|t| t.regret));
                rows.push(LearningRow {
                    world: world.to_owned(),
                    humans,
                    task: task + 1,
                    robot: kind,
                    episodes: people.len(),
                    not_arrived: of(robot).filter(|t| !t.arrived).count(),
                    regret,
                    regret_std,
                    regret_against_prior: against_prior(|t| t.regret),
                    human_cost: mean(|t| t.human_cost),
                    human_cost_against_prior: against_prior(|t| t.human_cost),
                    objective_cost: mean(|t| t.objective_cost),
                    objective_cost_against_prior: against_prior(|t| t.objective_cost),
                    share_off_preference: mean(|t| t.share_off_preference),
                    transitions: of(robot).filter(|t| t.took_over).count(),
                });
            }
        }
        rows
    }
}

impl LearningRow {
    fn comparisons(&mut self) -> impl Iterator<Item = &mut Paired> {
        let Self { regret_against_prior, human_cost_against_prior, objective_cost_against_prior, .. } = self;
        [regret_against_prior, human_cost_against_prior, objective_cost_against_prior]
            .into_iter()
            .filter_map(Option::as_mut)
    }
}

/// Runs a task.
fn carry(episode: &mut Episode, settings: &EpisodeSettings, human: Perception) -> Task {
    let mut regret = 0.0;
    let outcome = loop {
        if let Some(outcome) = episode.step() {
            break outcome;
        }
        if episode.tick().mode == Mode::RobotLed {
            regret += regret_of(episode.tick(), settings, human);
        }
    };
    let summary = episode.summary();
    Task {
        arrived: outcome == Outcome::Arrived,
        regret,
        human_cost: summary.human.subjective_cost.expect("the paper's human has alpha and gamma"),
        objective_cost: summary.accumulated_cost,
        share_off_preference: summary.human.share_off_preference(summary.steps),
        took_over: summary.transition.is_some(),
        control_cost: summary
            .control
            .map_or([0.0; 3], |control| [control.tracking, control.effort, control.pose]),
        lost_object: summary.has_lost_object(),
    }
}

/// The cost of eq. (6) of the executed option minus that of the option of a robot that knows the person.
fn regret_of(tick: &Tick, settings: &EpisodeSettings, human: Perception) -> f64 {
    let coordination::StubbornnessSettings { initial_stubbornness, eta } = settings.coordination;
    let phi = (initial_stubbornness * math::exp(tick.discomfort / eta)).min(1.0);
    let costs = || {
        tick.options.iter().map(|option| {
            let prospect = Prospect { length: option.remaining.length, risk: option.remaining.risk };
            (option.objective, subjective_cost(prospect, settings.predictor.risk_weight(), human))
        })
    };
    let weighed: Vec<f64> =
        costs().map(|(objective, subjective)| (1.0 - phi) * objective + phi * subjective).collect();
    weighed[tick.executed] - weighed[robot_choice(costs(), phi, Some(tick.executed))]
}

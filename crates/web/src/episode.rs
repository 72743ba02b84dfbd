//! An open episode: its steps, the decisions from outside, and what it answers.

use crate::state::{ShownState, StateLayout, current_options};
use crate::steering::{SteeredHuman, SteeredPolicy, Steering};
use crate::world::{evaluated, plane};
use cocarry::Error;
use cocarry::episode::{Episode, OptionTick, Outcome, Tick};
use cocarry::geometry::Point;
use cocarry::human::{HumanDecision, Stance};
use cocarry::policy::{Decision, Lead, RobotPolicy};
use cocarry::preference::Prospect;
use cocarry::quantities::{EPISODE, Event, Heading, LEARNED, QuantityKind, Severity, Value as Figure, View};
use cocarry::robot::Robot;
use cocarry::scenario::{
    Decisions, EpisodeLog, MAX_MOTION, Partners, PolicyLog, PreparedScenario, Scenario, Snapshot,
};
use cocarry::simulation::Part;
use cocarry_output::player;
use self_cell::self_cell;
use serde_json::{Value, json};

/// The episode is over.
pub const OVER: i32 = 0;
/// It goes on within a planning step.
pub const WITHIN_STEP: i32 = 1;
/// It goes on, and a planning step has just ended.
pub const STEP_DONE: i32 = 2;

/// The largest distance of the drawn path from the walked one, m.
const SAGITTA: f64 = 0.01;
/// The longest time of one call, s.
const MAX_SECONDS: f64 = 3600.0;

struct Running<'a>(Episode<'a>);

self_cell!(
    struct Cell {
        owner: PreparedScenario,
        #[covariant]
        dependent: Running,
    }
);

/// An open episode.
pub struct Open {
    cell: Cell,
    steering: Steering,
    state: ShownState,
    /// The options before the first step.
    at_start: Vec<OptionTick>,
    /// All decisions so far; `None` of an episode whose beginning is not known.
    decided: Option<Decisions>,
    digests: Vec<(u64, String)>,
    outcome: Option<Outcome>,
    events: Vec<Value>,
    /// The step before the last one, and the parts that touched in it.
    before: Option<Tick>,
    touching: Vec<[Part; 2]>,
}

impl Open {
    /// The episode of a scenario's text.
    ///
    /// # Errors
    /// As in the program.
    pub fn of_scenario(text: &str) -> Result<Self, Error> {
        Self::begin(Scenario::parse(text)?, Steering::default())
    }

    /// The episode that repeats a log.
    ///
    /// # Errors
    /// A part of the log is not valid.
    pub fn of_log(log: &EpisodeLog) -> Result<Self, Error> {
        let scenario = log.checked("the log")?;
        Self::begin(scenario, Steering::repeating(log.decisions.clone(), log.steps))
    }

    /// The episode in the state of a snapshot.
    ///
    /// # Errors
    /// The bytes are not a snapshot, or its state does not fit.
    pub fn of_snapshot(bytes: &[u8]) -> Result<Self, Error> {
        let Snapshot { scenario, state, .. } = Snapshot::parse("snapshot", bytes)?;
        let mut open = Self::begin(scenario, Steering::default())?;
        let steering = open.steering.clone();
        let prepared = open.cell.into_owner();
        open.cell = Cell::try_new(prepared, |prepared| {
            let episode = episode(prepared, &steering)?.resume(state)?;
            Ok::<_, Error>(Running(episode))
        })?;
        open.decided = None;
        open.outcome = open.cell.borrow_dependent().0.ended();
        open.before = (open.steps() > 0).then(|| open.cell.borrow_dependent().0.tick().clone());
        open.renew();
        Ok(open)
    }

    fn begin(scenario: Scenario, steering: Steering) -> Result<Self, Error> {
        let prepared = scenario.prepare()?;
        let policy = prepared.scenario().settings.method.policy();
        let cell = Cell::try_new(prepared, |prepared| {
            steering.now().is_trial = true;
            let episode = episode(prepared, &steering);
            steering.now().is_trial = false;
            Ok::<_, Error>(Running(episode?))
        })?;
        let policy = PolicyLog {
            initial_mode: policy.initial_mode(),
            predicts: policy.predicts(),
            trial: None,
            steps: Vec::new(),
        };
        let prepared = cell.borrow_owner();
        let layout = StateLayout::of(prepared);
        let at_start = evaluated(prepared.options(), &mut prepared.scenario().settings.predictor.clone());
        let mut open = Self {
            cell,
            steering,
            state: ShownState::new(layout),
            at_start,
            decided: Some(Decisions::new(true, Some(policy)).with_changes()),
            digests: Vec::new(),
            outcome: None,
            events: Vec::new(),
            before: None,
            touching: Vec::new(),
        };
        open.renew();
        Ok(open)
    }

    fn steps(&self) -> u64 {
        self.cell.borrow_dependent().0.summary().steps
    }

    /// The state, up to date.
    pub fn state(&self) -> &[f64] {
        self.state.numbers()
    }

    fn renew(&mut self) {
        let (prepared, episode) = (self.cell.borrow_owner(), &self.cell.borrow_dependent().0);
        self.state.write(prepared, episode, self.outcome, &self.steering, &self.at_start);
    }

    /// The human's decision from the next planning step on.
    ///
    /// # Errors
    /// There is no such option or stance.
    pub fn steer_human(&mut self, option: i32, stance: i32) -> Result<u32, Error> {
        let option = self.option(option)?;
        let stance = match stance {
            -1 => None,
            0 => Some(Stance::Follow),
            1 => Some(Stance::Resist),
            2 => Some(Stance::TakeOver),
            _ => {
                let sentence =
                    format!("stance = {stance}; it must be 0 follow, 1 resist, 2 take over, or -1");
                return Err(Error::new(sentence));
            }
        };
        let mut steered = self.steering.now();
        (steered.option, steered.stance) = (option, stance);
        Ok(1)
    }

    /// The target of the hand from the next control period on.
    ///
    /// # Errors
    /// It is too far away.
    pub fn steer_hand(&mut self, x: f64, y: f64) -> Result<u32, Error> {
        let is_none = x.is_nan() || y.is_nan();
        if !is_none && x.abs().max(y.abs()) > MAX_MOTION {
            let sentence = format!("the hand's target ({x}, {y}) m is beyond {MAX_MOTION} m");
            return Err(Error::new(sentence));
        }
        self.steering.now().hand = (!is_none).then(|| Point::new(x, y));
        self.renew();
        Ok(1)
    }

    /// Who leads from the next planning step on.
    ///
    /// # Errors
    /// There is no such leader or option.
    pub fn steer_policy(&mut self, lead: i32, option: i32) -> Result<u32, Error> {
        let lead = match (lead, self.option(option)?) {
            (-1, _) => None,
            (0, Some(option)) => Some(Lead::Robot(option)),
            (0, None) => return Err(Error::new("option = -1; a robot that leads needs an option")),
            (1, _) => Some(Lead::Human),
            (2, _) => Some(Lead::HumanKeepingOption),
            _ => {
                let sentence = format!(
                    "lead = {lead}; it must be 0 the robot, 1 the human, 2 the human on the first option, or -1"
                );
                return Err(Error::new(sentence));
            }
        };
        self.steering.now().lead = lead;
        Ok(1)
    }

    /// The option of an index, or -1.
    fn option(&self, option: i32) -> Result<Option<usize>, Error> {
        let count = self.cell.borrow_owner().options().options().len();
        match usize::try_from(option) {
            Err(_) if option == -1 => Ok(None),
            Ok(option) if option < count => Ok(Some(option)),
            _ => {
                let most = count - 1;
                Err(Error::new(format!("option = {option}; it must be an index from 0 to {most}, or -1")))
            }
        }
    }

    /// Moves everybody by a control period.
    pub fn period(&mut self) -> i32 {
        let progress = self.carry();
        self.renew();
        progress
    }

    /// Moves everybody to the end of the planning step.
    pub fn step(&mut self) -> i32 {
        let progress = loop {
            let progress = self.carry();
            if progress != WITHIN_STEP {
                break progress;
            }
        };
        self.renew();
        progress
    }

    /// Moves everybody by whole control periods.
    ///
    /// # Errors
    /// The time is not from 0 to 3600 s.
    pub fn run(&mut self, seconds: f64) -> Result<i32, Error> {
        if !(0.0..=MAX_SECONDS).contains(&seconds) {
            let sentence = format!("seconds = {seconds}; it must be from 0 to {MAX_SECONDS}");
            return Err(Error::new(sentence));
        }
        let period = self.cell.borrow_owner().scenario().settings.control_period();
        // the last period counts if rounding alone is left for it
        let count = (seconds / period - 1e-9).ceil().max(0.0) as u64;
        let mut progress = if self.outcome.is_some() { OVER } else { WITHIN_STEP };
        for _ in 0..count {
            progress = self.carry();
            if progress == OVER {
                break;
            }
        }
        self.renew();
        Ok(progress)
    }

    /// One control period.
    fn carry(&mut self) -> i32 {
        if self.outcome.is_some() {
            return OVER;
        }
        let goes_on = self.cell.with_dependent_mut(|_, Running(episode)| {
            if episode.periods() == [0; 2] {
                if episode.begin_step().is_some() {
                    return false;
                }
                let lead = episode.ask_policy();
                episode.lead_step(&lead);
            }
            episode.carry_period()
        });
        match goes_on {
            true => WITHIN_STEP,
            false => self.end_step(),
        }
    }

    /// What is noted at the end of a planning step.
    fn end_step(&mut self) -> i32 {
        let (prepared, Running(episode)) = (self.cell.borrow_owner(), self.cell.borrow_dependent());
        let (tick, options) = (episode.tick(), prepared.options());
        self.outcome = episode.ended();
        if let Some(decided) = &mut self.decided {
            decided.add(episode);
        }
        let steps = episode.summary().steps;
        if steps % steps_per_second(prepared) == 0 || self.outcome.is_some() {
            self.digests.push((steps, digest(episode)));
        }
        let mut events = Event::decided(self.before.as_ref(), tick, episode.change(), options);
        if let Some(seen) = episode.observation() {
            let new = seen.contacts.iter().filter(|contact| !self.touching.contains(&contact.between));
            events.extend(new.map(|contact| Event::contact(tick.step, contact)));
            self.touching = seen.contacts.iter().map(|contact| contact.between.clone()).collect();
        }
        if self.outcome.is_some() {
            events.extend(episode.summary().loss.as_ref().map(Event::loss));
            events.push(Event::end(&self.view()));
        }
        let step = prepared.scenario().settings.planning_step;
        self.events.extend(events.iter().map(|event| told(event, step)));
        self.before = Some(tick.clone());
        if self.outcome.is_some() { OVER } else { STEP_DONE }
    }

    fn view(&self) -> View<'_> {
        let (prepared, Running(episode)) = (self.cell.borrow_owner(), self.cell.borrow_dependent());
        View { outcome: self.outcome, ..View::new(prepared, episode) }
    }

    /// The events since the last call.
    pub fn events(&mut self) -> Value {
        Value::Array(std::mem::take(&mut self.events))
    }

    /// The path ahead.
    pub fn path(&self) -> Value {
        let Running(episode) = self.cell.borrow_dependent();
        let path = episode.path();
        let mut ahead = cocarry::geometry::Path::with_capacity(path.pieces().len());
        ahead.push_rest(path, episode.along());
        json!({ "points": ahead.polyline(SAGITTA).into_iter().map(player::point).collect::<Vec<_>>() })
    }

    /// The regions of the (alpha, gamma) plane for the options from where the team is.
    pub fn regions(&self) -> Value {
        let (prepared, Running(episode)) = (self.cell.borrow_owner(), self.cell.borrow_dependent());
        let options = current_options(episode, &self.at_start);
        let prospects = options.iter().map(|o| Prospect::new(o.remaining.length, o.remaining.risk));
        plane(&prospects.collect::<Vec<_>>(), episode.ways(), &prepared.scenario().settings.predictor)
    }

    /// Names, world, options, robot, warnings and the fields of the state.
    pub fn describe(&self) -> Value {
        let prepared = self.cell.borrow_owner();
        let (scenario, world, options) = (prepared.scenario(), prepared.world(), prepared.options());
        let settings = &scenario.settings;
        json!({
            "scenario": {
                "world": world.name,
                "plant": scenario.plant.name(),
                "method": settings.method.name(),
                "human_model": scenario.human_model.to_string(),
                "seed": scenario.seed,
                "alpha": scenario.human.alpha,
                "gamma": scenario.human.gamma,
                "eta": settings.coordination.eta,
                "robot": prepared.robot().map(|robot| &robot.name),
                "planning_step_s": settings.planning_step,
                "control_period_s": settings.control_period(),
                "speed_m_per_s": settings.speed,
                "learns": settings.learning.is_some(),
            },
            "world": player::world(world),
            "options": (0..options.options().len()).map(|o| player::option(o, options, world)).collect::<Vec<_>>(),
            "robot": prepared.robot().map(named),
            "warnings": ([world.warnings(), prepared.warnings()].concat()),
            "state": self.state.layout().describe(),
        })
    }

    /// The figures of the episode so far, with the program's words.
    pub fn summary(&self) -> Value {
        let view = self.view();
        let figures = view.read(EPISODE).into_iter().zip(EPISODE).map(|((key, value), quantity)| {
            // no outcome yet is not an interruption
            let value = if key == "outcome" && self.outcome.is_none() { Figure::Missing } else { value };
            let Heading { description, kind, .. } = Heading::from(quantity);
            let unit = if let QuantityKind::Number(unit) = kind { unit } else { "" };
            json!({ "key": key, "unit": unit, "description": description, "value": value })
        });
        let learned = view.read(LEARNED).into_iter().next().map(|(_, value)| json!(value));
        json!({
            "outcome": self.outcome.map(Outcome::name),
            "figures": figures.collect::<Vec<_>>(),
            "text": view.conclusion(),
            "warnings": view.warnings(),
            "learned": learned,
        })
    }

    /// The log, from which `cocarry replay` runs the episode again.
    ///
    /// # Errors
    /// The episode was not begun here.
    pub fn log(&self) -> Result<Value, Error> {
        let decided = self.decided.clone().ok_or_else(|| {
            Error::new("an episode of a snapshot has no log: the decisions before it are not known")
        })?;
        let steered = self.steering.now();
        let [human, policy] = steered.was_outside;
        let differs =
            |trial: &HumanDecision| decided.human(0, false).filter(|first| *first != trial).map(|_| *trial);
        let human_trial = steered.trial.0.as_ref().and_then(differs);
        let differs =
            |trial: &Decision| decided.policy(0, false).filter(|first| *first != trial).map(|_| *trial);
        let policy_trial: Option<Decision> = steered.trial.1.as_ref().and_then(differs);
        let decisions = decided.clone().with_trials(human_trial, policy_trial).only(human, policy);
        let log = EpisodeLog {
            version: EpisodeLog::VERSION,
            scenario: self.cell.borrow_owner().scenario().text()?,
            arithmetic: cocarry::arithmetic::stamp().to_owned(),
            decisions,
            digests: self.digests.clone(),
            steps: self.steps(),
            outcome: self.outcome.map(|outcome| outcome.name().to_owned()),
        };
        serde_json::to_value(log).map_err(|error| Error::new("the log cannot be written").because(error))
    }

    fn between_steps(&self) -> Result<&Episode<'_>, Error> {
        let Running(episode) = self.cell.borrow_dependent();
        match episode.periods() {
            [0, 0] => Ok(episode),
            [done, all] => Err(Error::new(format!(
                "the episode is within a planning step, after {done} of {all} control periods; step it to its end first"
            ))),
        }
    }

    /// The digest of the state.
    ///
    /// # Errors
    /// The episode is within a planning step.
    pub fn digest(&self) -> Result<String, Error> {
        self.between_steps().map(digest)
    }

    /// The bytes of a snapshot.
    ///
    /// # Errors
    /// The episode is within a planning step.
    pub fn snapshot(&self) -> Result<Vec<u8>, Error> {
        self.cell.borrow_owner().snapshot(self.between_steps()?).bytes()
    }
}

/// The episode with partners that can be steered.
fn episode<'a>(prepared: &'a PreparedScenario, steering: &Steering) -> Result<Episode<'a>, Error> {
    let human = SteeredHuman { human: prepared.human()?, steering: steering.clone() };
    let policy: Box<dyn RobotPolicy> = prepared.scenario().settings.method.policy();
    let policy = SteeredPolicy { policy, steering: steering.clone() };
    prepared.episode_of(Partners { human: Some(Box::new(human)), policy: Some(Box::new(policy)) })
}

fn digest(episode: &Episode) -> String {
    format!("{:016x}", episode.state().digest())
}

/// The number of planning steps in about a second.
fn steps_per_second(prepared: &PreparedScenario) -> u64 {
    (1.0 / prepared.scenario().settings.planning_step).round().max(1.0) as u64
}

fn told(event: &Event, planning_step: f64) -> Value {
    let severity = match event.severity {
        Severity::Info => "info",
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    json!({
        "step": event.step,
        "time_s": event.step as f64 * planning_step,
        "about": event.about,
        "severity": severity,
        "sentence": event.sentence,
        "position": event.position.map(player::point),
    })
}

/// The names of a robot's links and joints.
fn named(robot: &Robot) -> Value {
    let links = robot.links.iter().map(|link| &link.name);
    let joints = robot.joints.iter().map(|joint| &joint.name);
    json!({
        "name": robot.name,
        "links": links.collect::<Vec<_>>(),
        "joints": joints.collect::<Vec<_>>(),
    })
}

//! A lane: one environment, which draws its episodes from its own generator.

use super::rules::{Autoreset, Bound, BuiltIn, Rules, Task};
use crate::episode::Cell;
use crate::error::words;
use cocarry::coordination::Stubbornness;
use cocarry::episode::Outcome;
use cocarry::human::{Human, HumanDecision, HumanView, Stance};
use cocarry::preference::Perception;
use cocarry::quantities::{EPISODE, Record, View};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{GivenPerception, Partners, PreparedScenario, drawn_changes, drawn_human};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex, PoisonError};

/// The outcome of a lane's step besides its observation.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct StepResult {
    pub(super) reward: f64,
    pub(super) terminated: bool,
    pub(super) truncated: bool,
}

/// What is asked of all lanes at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Note {
    /// The number of options in the world of its episode; none before the first.
    pub(super) options: Option<usize>,
    pub(super) is_over: bool,
    pub(super) has_failed: bool,
}

/// What a caller sets for the next episode.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wish {
    pub(super) world: Option<usize>,
    pub(super) seed: Option<u64>,
    pub(super) alpha: Option<f64>,
    pub(super) gamma: Option<f64>,
}

/// A human whose decisions are actions. Stubbornness grows by eq. (5).
#[derive(Clone, Debug)]
struct ActedHuman {
    next: Next,
    perception: Perception,
    stubbornness: Stubbornness,
}

impl Human for ActedHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        view.accumulate(&mut self.stubbornness);
        let (option, stance) = *self.next.lock().unwrap_or_else(PoisonError::into_inner);
        let option = option.min(view.prospects.len().saturating_sub(1));
        HumanDecision { stance, ..HumanDecision::new(option, &self.stubbornness, Some(self.perception)) }
    }

    fn save(&self) -> Saved {
        Saved::of(&self.stubbornness)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.stubbornness = saved.read("human")?;
        Ok(())
    }
}

/// The next decision of a human whose decisions are actions.
pub(super) type Next = Arc<Mutex<(usize, Stance)>>;

/// The human whose decisions are actions, of a task that has one.
pub(super) fn acted(task: Task, next: &Next, prepared: &PreparedScenario) -> Option<Box<dyn Human>> {
    (task == Task::Both).then(|| {
        let scenario = prepared.scenario();
        let stubbornness = Stubbornness::new(scenario.settings.coordination);
        Box::new(ActedHuman { next: Arc::clone(next), perception: scenario.human, stubbornness })
            as Box<dyn Human>
    })
}

/// The responses of a human to the robot's lead, as actions.
pub(super) const STANCES: [Stance; 3] = [Stance::Follow, Stance::Resist, Stance::TakeOver];

/// One environment.
pub(super) struct Lane {
    pub(super) rng: ChaCha8Rng,
    pub(super) cell: Option<Cell>,
    pub(super) world: usize,
    /// The bound of the episode's cost, if its ending has a price.
    pub(super) bound: Option<Bound>,
    /// What the built-in controller would do in the step that has begun, if it is told.
    pub(super) built_in: BuiltIn,
    /// J^ up to the last step.
    pub(super) subjective: f64,
    /// J, J^ and C of the last step.
    pub(super) costs: [f64; 3],
    /// The next decision of the human of [`Task::Both`].
    pub(super) human: Next,
    pub(super) is_over: bool,
    /// Figures of the last episode that ended.
    pub(super) last: Option<Record>,
    /// Observation at the end of that episode.
    pub(super) last_observation: Vec<f64>,
    pub(super) error: Option<String>,
}

impl Lane {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            cell: None,
            world: 0,
            bound: None,
            built_in: BuiltIn::default(),
            subjective: 0.0,
            costs: [0.0; 3],
            human: Arc::new(Mutex::new((0, Stance::Follow))),
            is_over: true,
            last: None,
            last_observation: Vec::new(),
            error: None,
        }
    }

    pub(super) fn note(&self) -> Note {
        let options = self.cell.as_ref().map(|cell| cell.borrow_owner().options().options().len());
        Note { options, is_over: self.is_over, has_failed: self.error.is_some() }
    }

    /// Draws an episode and observes its beginning.
    pub(super) fn reset(&mut self, rules: &Rules, wish: Wish, observation: &mut [f64]) {
        // both are drawn even if one is wished for, so that later episodes are the same
        let (world, seed) = (self.rng.random_range(0..rules.bases.len()), self.rng.random::<u32>());
        self.world = wish.world.unwrap_or(world);
        let base = &rules.bases[self.world];
        let mut scenario = base.scenario().clone();
        scenario.seed = wish.seed.unwrap_or(u64::from(seed));
        let given = GivenPerception {
            alpha: wish.alpha.or(rules.given.alpha),
            gamma: wish.gamma.or(rules.given.gamma),
        };
        let (seed, settings) = (scenario.seed, &scenario.settings);
        let belief = settings.predictor.belief();
        scenario.human = drawn_human(belief, given, seed);
        if let Some(count) = rules.changes {
            scenario.changes = drawn_changes(count, belief, given, seed, base.options(), settings);
        }
        self.subjective = 0.0;
        *self.human.lock().unwrap_or_else(PoisonError::into_inner) = (0, Stance::Follow);
        let made = base.prepare(scenario).map_err(|error| words(&error)).and_then(|prepared| {
            let partners = Partners { human: acted(rules.task, &self.human, &prepared), policy: None };
            Cell::begin(Arc::new(prepared), partners, None).map_err(|error| words(&error))
        });
        match made {
            Ok(mut made) => {
                made.with_dependent_mut(|prepared, running| {
                    let bound = rules.bound(prepared);
                    running.outcome =
                        rules.begin(prepared, &mut running.episode, bound.as_ref(), observation);
                    self.bound = bound;
                    if rules.tells_built_in {
                        self.built_in = rules.built_in(prepared, &running.episode);
                    }
                });
                self.is_over = false;
                self.cell = Some(made);
            }
            Err(error) => {
                self.is_over = true;
                self.error = Some(error);
            }
        }
    }

    /// Takes a step by this action.
    pub(super) fn step(&mut self, rules: &Rules, action: &[f64], observation: &mut [f64]) -> StepResult {
        if self.is_over {
            // NEXT_STEP: the action after the end is ignored
            self.reset(rules, Wish::default(), observation);
            return StepResult::default();
        }
        let Some(cell) = self.cell.as_mut() else { return StepResult::default() };
        let (subjective, human, costs) = (&mut self.subjective, &self.human, &mut self.costs);
        let (bound, built_in) = (self.bound.as_ref(), &mut self.built_in);
        let (result, last) = cell.with_dependent_mut(|prepared, running| {
            let episode = &mut running.episode;
            if rules.task == Task::Both {
                let stance = STANCES[(action[2] as usize).min(STANCES.len() - 1)];
                *human.lock().unwrap_or_else(PoisonError::into_inner) = (action[1] as usize, stance);
                episode.begin_step();
            }
            let decision = rules.decision(episode, action);
            episode.finish_step(&decision);
            let tick = episode.tick();
            // 0 for a human without alpha and gamma
            let so_far = episode.summary().human.subjective_cost.unwrap_or(0.0);
            let control = tick.robot.as_ref().map_or(0.0, |robot| robot.cost());
            *costs = [tick.objective_cost, so_far - *subjective, control];
            *subjective = so_far;
            let ended = rules.begin(prepared, episode, bound, observation);
            let steps = episode.summary().steps;
            // time that runs out is charged like any failure, and so ends the task, unlike a caller's own limit
            let is_late = |bound: &Bound| ended == Some(Outcome::OutOfTime) || steps >= bound.steps;
            let terminated =
                bound.is_some_and(is_late) || ended.is_some_and(|outcome| outcome != Outcome::OutOfTime);
            let truncated = !terminated && (ended.is_some() || rules.is_long(steps, bound));
            let is_over = terminated || ended.is_some();
            let reward = rules.reward(*costs, bound, (steps, is_over, ended == Some(Outcome::Arrived)));
            running.outcome = ended;
            if rules.tells_built_in {
                *built_in = rules.built_in(prepared, episode);
            }
            let last = (terminated || truncated).then(|| View::new(prepared, &running.episode).read(EPISODE));
            (StepResult { reward, terminated, truncated }, last)
        });
        if let Some(last) = last {
            self.is_over = true;
            self.last = Some(last);
            if rules.autoreset == Some(Autoreset::SameStep) {
                self.last_observation.clear();
                self.last_observation.extend_from_slice(observation);
                self.reset(rules, Wish::default(), observation);
            }
        }
        result
    }
}

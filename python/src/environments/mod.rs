//! Environments for learners: episodes side by side, each step decided by actions, in preallocated arrays.
//!
//! A lane is one environment. Every lane draws its episodes from its own generator, so N lanes are equal to N
//! single environments bit for bit, for any number of threads.

mod lane;
mod rules;

use crate::episode::Cell;
use crate::error::{ActionError, ClosedError, Error, RecordingError, ScenarioError, guarded, words};
use crate::robot::input_limits;
use crate::scenario::Scenario;
use crate::value::{self, repr};
use cocarry::coordination::Stubbornness;
use cocarry::human::{Human, Stance};
use cocarry::preference::Perception;
use cocarry::scenario::{GivenPerception, PERCEPTION};
use cocarry_recording::recording::{Ending, Recorder};
use lane::{ActedHuman, Lane, STANCES, StepResult, Wish};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use rules::{Autoreset, Rules, Task};
use std::io::Cursor;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// Environments side by side.
#[pyclass(frozen, module = "cocarry._cocarry", name = "Lanes")]
pub struct Lanes {
    rules: Rules,
    lanes: Mutex<Vec<Lane>>,
    observations: Py<PyArray2<f64>>,
    rewards: Py<PyArray1<f64>>,
    terminated: Py<PyArray1<bool>>,
    truncated: Py<PyArray1<bool>>,
    /// The threads, and the process that has them; none for a single lane.
    pool: Option<(rayon::ThreadPool, u32)>,
    period: f64,
}

impl Lanes {
    fn lock(&self) -> PyResult<std::sync::MutexGuard<'_, Vec<Lane>>> {
        if let Some((_, process)) = &self.pool
            && *process != std::process::id()
        {
            return Err(ClosedError::new_err(format!(
                "this vector environment has its threads in process {process}, and this is process {}: make it in the process that uses it, or start that one by spawn or forkserver",
                std::process::id()
            )));
        }
        match self.lanes.try_lock() {
            Ok(lanes) => Ok(lanes),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(ClosedError::new_err("the environment is in a step in another thread"))
            }
        }
    }

    fn lane<T>(&self, index: usize, read: impl FnOnce(&Lane) -> PyResult<T>) -> PyResult<T> {
        let lanes = self.lock()?;
        match lanes.get(index) {
            Some(lane) => read(lane),
            None => Err(Error::new_err(format!("index = {index}; it must be less than {}", lanes.len()))),
        }
    }

    /// The actions as rows, one a lane.
    fn rows(&self, given: &Bound<'_, PyAny>, lanes: usize) -> PyResult<Vec<f64>> {
        if self.rules.task == Task::Options {
            let most = self.rules.options as i64;
            let found =
                given.extract::<PyReadonlyArray1<'_, i64>>().ok().map(|array| array.as_array().to_vec());
            let found =
                found.filter(|rows| rows.len() == lanes && rows.iter().all(|a| (0..=most).contains(a)));
            return match found {
                Some(found) => Ok(found.into_iter().map(|action| action as f64).collect()),
                None => Err(ActionError::new_err(format!(
                    "action {}; it must be {lanes} whole number(s) (int64) from 0 to {most}: an option to lead on, or {most} to follow",
                    repr(given)
                ))),
            };
        }
        if self.rules.task == Task::Both {
            let most = self.rules.options as i64;
            let found = given.extract::<PyReadonlyArray2<'_, i64>>().ok();
            let found = found.filter(|rows| rows.as_array().shape() == [lanes, 3]);
            let rows = found.map(|rows| rows.as_array().iter().copied().collect::<Vec<_>>());
            let fits = |row: &[i64]| {
                (0..=most).contains(&row[0])
                    && (0..most).contains(&row[1])
                    && (0..STANCES.len() as i64).contains(&row[2])
            };
            let rows = rows.filter(|rows| rows.chunks(3).all(fits));
            return match rows {
                Some(rows) => Ok(rows.into_iter().map(|number| number as f64).collect()),
                None => Err(ActionError::new_err(format!(
                    "actions {}; the robot's must be a whole number from 0 to {most}, the human's an option from 0 to {} and a response from 0 to 2",
                    repr(given),
                    most - 1
                ))),
            };
        }
        let width = self.rules.limits.len();
        let found = given.extract::<PyReadonlyArray2<'_, f64>>().ok();
        let found = found
            .filter(|rows| rows.as_array().shape() == [lanes, width])
            .map(|rows| rows.as_array().iter().copied().collect::<Vec<_>>());
        let found = found.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
        let found = found.ok_or_else(|| {
            ActionError::new_err(format!("action {}; it must be float64 numbers, all finite, {width} for each of {lanes} environment(s)", repr(given)))
        })?;
        Ok(found.chunks(width).flat_map(|row| row.iter().copied().chain([self.period])).collect())
    }

    /// Runs `work` for every lane and its part of the arrays, on all threads.
    fn each(
        &self,
        py: Python<'_>,
        actions: &[f64],
        work: impl Fn(&Rules, usize, &mut Lane, &[f64], &mut [f64]) -> StepResult + Sync + Send,
    ) -> PyResult<()> {
        let mut lanes = self.lock()?;
        let size = self.rules.size();
        let mut observations = self.observations.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut rewards = self.rewards.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut terminated = self.terminated.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut truncated = self.truncated.bind(py).try_readwrite().map_err(|_| in_use())?;
        let (observations, rewards) = (observations.as_slice_mut()?, rewards.as_slice_mut()?);
        let (terminated, truncated) = (terminated.as_slice_mut()?, truncated.as_slice_mut()?);
        let width = if actions.is_empty() { 0 } else { actions.len() / lanes.len() };
        let (rules, pool, lanes) = (&self.rules, self.pool.as_ref().map(|(pool, _)| pool), &mut *lanes);
        let one = |i: usize, lane: &mut Lane, (observation, reward, terminated, truncated): Places<'_>| {
            let result = work(rules, i, lane, &actions[i * width..(i + 1) * width], observation);
            (*reward, *terminated, *truncated) = (result.reward, result.terminated, result.truncated);
        };
        let error = py.detach(|| {
            guarded(|| {
                match pool {
                    None => {
                        let places =
                            observations.chunks_mut(size).zip(rewards).zip(terminated).zip(truncated);
                        for (i, (lane, (((o, r), t), u))) in lanes.iter_mut().zip(places).enumerate() {
                            one(i, lane, (o, r, t, u));
                        }
                    }
                    Some(pool) => pool.install(|| {
                        let places =
                            observations.par_chunks_mut(size).zip(rewards).zip(terminated).zip(truncated);
                        let all = lanes.par_iter_mut().zip(places).enumerate();
                        all.with_min_len(4)
                            .for_each(|(i, (lane, (((o, r), t), u)))| one(i, lane, (o, r, t, u)));
                    }),
                }
                lanes.iter_mut().find_map(|lane| lane.error.take())
            })
        })?;
        error.map_or(Ok(()), |error| Err(ScenarioError::new_err(error)))
    }
}

/// A lane's places in the arrays.
type Places<'p> = (&'p mut [f64], &'p mut f64, &'p mut bool, &'p mut bool);

fn in_use() -> PyErr {
    ClosedError::new_err("the environment's arrays are in use by another extension module")
}

#[pymethods]
impl Lanes {
    #[new]
    #[pyo3(signature = (count, task, scenarios, *, alpha = None, gamma = None, weights = (1.0, 1.0, 0.0),
        most_steps = None, autoreset = None, threads = None))]
    #[allow(clippy::too_many_arguments, reason = "keywords")]
    fn new(
        py: Python<'_>,
        count: usize,
        task: &str,
        scenarios: Vec<Py<Scenario>>,
        alpha: Option<f64>,
        gamma: Option<f64>,
        weights: (f64, f64, f64),
        most_steps: Option<u64>,
        autoreset: Option<&str>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let task = match task {
            "options" => Task::Options,
            "both" => Task::Both,
            "inputs" => Task::Inputs,
            "reference" => Task::Reference,
            other => {
                return Err(Error::new_err(format!(
                    "task = {other:?}; it must be one of: options, both, inputs, reference"
                )));
            }
        };
        if !(1..=100_000).contains(&count) {
            return Err(Error::new_err(format!("{count} environments; there must be 1 to 100000")));
        }
        for (key, value) in [("alpha", alpha), ("gamma", gamma)] {
            if let Some(wrong) = value.filter(|value| !PERCEPTION.contains(*value)) {
                return Err(Error::new_err(format!("{key} = {wrong}; it must be {PERCEPTION}")));
            }
        }
        let autoreset = match autoreset {
            None => None,
            Some("next-step") => Some(Autoreset::NextStep),
            Some("same-step") => Some(Autoreset::SameStep),
            Some(other) => {
                return Err(Error::new_err(format!(
                    "autoreset = {other:?}; it must be None or one of: next-step, same-step"
                )));
            }
        };
        let weights = [weights.0, weights.1, weights.2];
        if let Some(wrong) = weights.iter().find(|weight| !weight.is_finite()) {
            return Err(Error::new_err(format!(
                "a weight of the reward is {wrong}; it must be a finite number"
            )));
        }
        if most_steps == Some(0) {
            return Err(Error::new_err("the largest number of steps is 0; it must be at least 1"));
        }
        let bases =
            scenarios.iter().map(|scenario| scenario.get().prepared(py)).collect::<PyResult<Vec<_>>>()?;
        let Some(first) = bases.first() else {
            return Err(Error::new_err("there is no world; give at least one"));
        };
        let robot = first.robot();
        if matches!(task, Task::Inputs | Task::Reference) && robot.is_none() {
            return Err(Error::new_err(
                "this environment needs a robot; use plant=\"kinematic\" or plant=\"rapier\"",
            ));
        }
        let limits = match (task, robot) {
            (Task::Inputs, Some(robot)) => input_limits(robot),
            (Task::Reference, _) => vec![1.0, 1.0, 2.0],
            _ => Vec::new(),
        };
        let rules = Rules {
            task,
            given: GivenPerception { alpha, gamma },
            options: bases.iter().map(|base| base.options().options().len()).max().unwrap_or(0),
            joints: robot.map_or(0, |robot| robot.joints.len()),
            base: robot.map_or(2, |robot| robot.drive.inputs()),
            limits,
            weights,
            most_steps,
            autoreset,
            bases,
        };
        let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        let pool = match count.min(threads) {
            0 | 1 => None,
            threads => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                Some((
                    pool.map_err(|error| Error::new_err(format!("threads cannot be started: {error}")))?,
                    std::process::id(),
                ))
            }
        };
        Ok(Self {
            lanes: Mutex::new((0..count).map(|i| Lane::new(i as u64)).collect()),
            observations: PyArray2::zeros(py, [count, rules.size()], false).unbind(),
            rewards: PyArray1::zeros(py, count, false).unbind(),
            terminated: PyArray1::zeros(py, count, false).unbind(),
            truncated: PyArray1::zeros(py, count, false).unbind(),
            period: rules.bases[0].scenario().settings.planning_step,
            pool,
            rules,
        })
    }

    /// Seeds a lane's generator.
    fn seed(&self, index: usize, seed: u64) -> PyResult<()> {
        match self.lock()?.get_mut(index) {
            Some(lane) => {
                lane.rng = ChaCha8Rng::seed_from_u64(seed);
                Ok(())
            }
            None => Err(Error::new_err(format!("index = {index}; there are not so many environments"))),
        }
    }

    /// Begins a new episode in the lanes of the mask, or in all.
    #[pyo3(signature = (mask = None, *, world = None, seed = None, alpha = None, gamma = None))]
    fn reset(
        &self,
        py: Python<'_>,
        mask: Option<Vec<bool>>,
        world: Option<usize>,
        seed: Option<u64>,
        alpha: Option<f64>,
        gamma: Option<f64>,
    ) -> PyResult<()> {
        if let Some(wrong) = world.filter(|world| *world >= self.rules.bases.len()) {
            return Err(Error::new_err(format!(
                "world = {wrong}; it must be a whole number from 0 to {}",
                self.rules.bases.len() - 1
            )));
        }
        for (key, value) in [("alpha", alpha), ("gamma", gamma)] {
            if let Some(wrong) = value.filter(|value| !PERCEPTION.contains(*value)) {
                return Err(Error::new_err(format!("{key} = {wrong}; it must be {PERCEPTION}")));
            }
        }
        let count = self.lock()?.len();
        if mask.as_ref().is_some_and(|mask| mask.len() != count) {
            return Err(Error::new_err(format!("the mask must have {count} flags")));
        }
        let wish = Wish { world, seed, alpha, gamma };
        self.each(py, &[], |rules, i, lane, _, observation| {
            if mask.as_ref().is_none_or(|mask| mask[i]) {
                lane.reset(rules, wish, observation);
            }
            StepResult::default()
        })
    }

    /// Takes a step in every lane.
    fn step(&self, py: Python<'_>, actions: &Bound<'_, PyAny>) -> PyResult<()> {
        let count = {
            let lanes = self.lock()?;
            if lanes.iter().any(|lane| lane.cell.is_none()) {
                return Err(ClosedError::new_err("the environment has no episode; call reset() first"));
            }
            if self.rules.autoreset.is_none() && lanes.iter().any(|lane| lane.is_over) {
                return Err(ClosedError::new_err("the episode is over; call reset()"));
            }
            lanes.len()
        };
        let actions = self.rows(actions, count)?;
        self.each(py, &actions, |rules, _, lane, action, observation| lane.step(rules, action, observation))
    }

    #[getter]
    fn observations(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        self.observations.clone_ref(py)
    }

    #[getter]
    fn rewards(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.rewards.clone_ref(py)
    }

    #[getter]
    fn terminated(&self, py: Python<'_>) -> Py<PyArray1<bool>> {
        self.terminated.clone_ref(py)
    }

    #[getter]
    fn truncated(&self, py: Python<'_>) -> Py<PyArray1<bool>> {
        self.truncated.clone_ref(py)
    }

    /// The names of the numbers of an observation, with their least and largest values.
    #[getter]
    fn layout(&self) -> Vec<(String, (f64, f64))> {
        self.rules.layout().into_iter().map(|(name, [low, high])| (name, (low, high))).collect()
    }

    /// What actions of 1 stand for; none for options.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.rules.limits)
    }

    /// The largest number of options of a world.
    #[getter]
    fn options(&self) -> usize {
        self.rules.options
    }

    /// World, seed and human of a lane's episode.
    fn episode<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.lane(index, |lane| {
            let Some(cell) = &lane.cell else { return Ok(()) };
            let scenario = cell.borrow_owner().scenario();
            let Perception { alpha, gamma } = scenario.human;
            dict.set_item("world", lane.world)?;
            dict.set_item("seed", scenario.seed)?;
            dict.set_item("alpha", alpha)?;
            dict.set_item("gamma", gamma)?;
            dict.set_item("options", cell.borrow_owner().options().options().len())
        })?;
        Ok(dict)
    }

    /// The scenario of a lane's episode.
    fn scenario(&self, index: usize) -> PyResult<Option<Scenario>> {
        self.lane(index, |lane| {
            Ok(lane.cell.as_ref().map(|cell| Scenario::of(cell.borrow_owner().scenario().clone())))
        })
    }

    /// J (m), J^ and C of a lane's last step.
    fn costs(&self, index: usize) -> PyResult<(f64, f64, f64)> {
        self.lane(index, |lane| Ok((lane.costs[0], lane.costs[1], lane.costs[2])))
    }

    /// A lane's episode run again by these actions: its recording (MCAP). At least one step is taken.
    fn recording<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        actions: Vec<Vec<f64>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let prepared =
            self.lane(index, |lane| Ok(lane.cell.as_ref().map(|cell| Arc::clone(cell.borrow_owner()))))?;
        let prepared = prepared
            .ok_or_else(|| ClosedError::new_err("the environment has no episode; call reset() first"))?;
        let width = if self.rules.task == Task::Both { 3 } else { self.rules.limits.len().max(1) };
        if actions.iter().any(|action| action.len() != width) {
            return Err(ActionError::new_err(format!("every action must have {width} numbers")));
        }
        let recorded = py.detach(|| {
            guarded(|| {
                let next = Arc::new(Mutex::new((0, Stance::Follow)));
                let acted = (self.rules.task == Task::Both).then(|| {
                    let scenario = prepared.scenario();
                    let stubbornness = Stubbornness::new(scenario.settings.coordination);
                    let next = Arc::clone(&next);
                    Box::new(ActedHuman { next, perception: scenario.human, stubbornness }) as Box<dyn Human>
                });
                let mut cell = Cell::beginning(prepared, acted).map_err(|error| words(&error))?;
                cell.with_dependent_mut(|prepared, running| {
                    let episode = &mut running.episode;
                    let file = Cursor::new(Vec::new());
                    let mut recorder = Recorder::new(file, "the episode", prepared, episode)
                        .map_err(|error| words(&error))?;
                    if actions.is_empty() && episode.step().is_none() {
                        recorder.step(episode).map_err(|error| words(&error))?;
                    }
                    for action in &actions {
                        if let [_, option, stance] = action[..]
                            && self.rules.task == Task::Both
                        {
                            let stance = STANCES[(stance as usize).min(STANCES.len() - 1)];
                            *next.lock().unwrap_or_else(PoisonError::into_inner) = (option as usize, stance);
                        }
                        if episode.begin_step().is_some() {
                            break;
                        }
                        let action: Vec<f64> = action.iter().copied().chain([self.period]).collect();
                        let decision = self.rules.decision(episode, &action);
                        episode.finish_step(&decision);
                        recorder.step(episode).map_err(|error| words(&error))?;
                    }
                    let ending = episode.begin_step().map_or(Ending::Interrupted, Ending::Over);
                    recorder.finish(episode, ending).map(Cursor::into_inner).map_err(|error| words(&error))
                })
            })
        });
        Ok(PyBytes::new(py, &recorded?.map_err(RecordingError::new_err)?))
    }

    /// The figures of a lane's last episode that ended; None before.
    fn summary<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        let last = self.lane(index, |lane| Ok(lane.last.clone()))?;
        last.map(|record| value::record(py, record)).transpose()
    }

    /// The observation with which that episode ended, where the lane began anew in the same step.
    fn last_observation<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.lane(index, |lane| Ok(PyArray1::from_slice(py, &lane.last_observation)))
    }
}

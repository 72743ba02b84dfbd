//! Environments for learners: episodes side by side, each step decided by actions, in preallocated arrays.
//!
//! A lane is one environment. Every lane draws its episodes from its own generator, so N lanes are equal to N
//! single environments bit for bit, for any number of threads.

mod actions;
mod lane;
mod observation;
mod replay;
mod rules;
mod saved;
mod side_by_side;

use crate::arguments;
use crate::error::{ActionError, ClosedError, Error, RecordingError, guarded};
use crate::robot::input_limits;
use crate::scenario::{Scenario, counted_changes};
use crate::value::{Dictionaries, repr};
use cocarry::episode::PlaceMemory;
use cocarry::preference::Perception;
use cocarry::quantities::EPISODE;
use cocarry::scenario::{GivenPerception, PERCEPTION, PreparedScenario};
use cocarry::suggestion;
use lane::{Lane, StepResult, Wish};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rules::{Autoreset, Ending, Rules, TASKS, Task};
use side_by_side::SideBySide;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// Environments side by side.
#[pyclass(frozen, module = "cocarry._cocarry", name = "Lanes")]
pub struct Lanes {
    rules: Rules,
    lanes: Mutex<SideBySide>,
    observations: Py<PyArray2<f64>>,
    rewards: Py<PyArray1<f64>>,
    terminated: Py<PyArray1<bool>>,
    truncated: Py<PyArray1<bool>>,
    /// The threads beside the one that takes a step, and the process that has them; none for a single lane.
    pool: Option<(rayon::ThreadPool, u32)>,
    period: f64,
    summaries: Dictionaries,
    /// The number of numbers in an observation.
    size: usize,
}

impl Lanes {
    fn lock(&self) -> PyResult<MutexGuard<'_, SideBySide>> {
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

    /// The index of a world that is given by it or by its name.
    fn world_of(&self, given: &Bound<'_, PyAny>) -> PyResult<usize> {
        let bases = &self.rules.bases;
        let titled =
            |base: &PreparedScenario, name: &str| world_name(base) == name || base.world().name == name;
        let found = match given.extract::<String>() {
            Ok(name) => bases
                .iter()
                .position(|base| titled(base, &name))
                .ok_or_else(|| suggestion::hint(&name, bases.iter().map(|base| world_name(base)))),
            Err(_) => arguments::argument::<usize>("world", "", given)
                .ok()
                .filter(|index| *index < bases.len())
                .ok_or_else(String::new),
        };
        found.map_err(|hint| {
            let names = suggestion::listed(bases.iter().map(|base| world_name(base)), 12);
            Error::new_err(format!(
                "world = {}; it must be a whole number from 0 to {}, or one of {names}{hint}",
                repr(given),
                bases.len() - 1
            ))
        })
    }

    fn lane<T>(&self, index: usize, read: impl FnOnce(&Lane) -> PyResult<T>) -> PyResult<T> {
        let lanes = &self.lock()?.lanes;
        match lanes.get(index) {
            Some(lane) => read(lane),
            None => Err(Error::new_err(format!("index = {index}; it must be less than {}", lanes.len()))),
        }
    }
}

fn in_use() -> PyErr {
    ClosedError::new_err("the environment's arrays are in use by another extension module")
}

#[pymethods]
impl Lanes {
    #[new]
    #[pyo3(signature = (num_envs, task, scenarios, *, preference_changes = None, alpha = None, gamma = None, weights = None, max_steps = None,
        max_episode_steps = None, prices_ending = false, most_step_cost = None, action_scale = None,
        tells_built_in = false, autoreset = None, threads = None))]
    #[allow(clippy::too_many_arguments, reason = "keywords")]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::num_envs)] num_envs: usize,
        task: &str,
        scenarios: Vec<Py<Scenario>>,
        preference_changes: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given_alpha)] alpha: Option<f64>,
        #[pyo3(from_py_with = arguments::given_gamma)] gamma: Option<f64>,
        weights: Option<[Bound<'_, PyAny>; 3]>,
        #[pyo3(from_py_with = arguments::max_steps)] max_steps: Option<u64>,
        #[pyo3(from_py_with = arguments::max_episode_steps)] max_episode_steps: Option<u64>,
        prices_ending: bool,
        #[pyo3(from_py_with = arguments::most_step_cost)] most_step_cost: Option<f64>,
        #[pyo3(from_py_with = arguments::action_scale)] action_scale: Option<f64>,
        tells_built_in: bool,
        autoreset: Option<&str>,
        #[pyo3(from_py_with = arguments::threads)] threads: Option<usize>,
    ) -> PyResult<Self> {
        let refused = |key: &str, value: &dyn std::fmt::Display, expected: &str| {
            Err(Error::new_err(format!("{key} = {value}; it must be {expected}")))
        };
        let Some((_, task)) = TASKS.into_iter().find(|(name, _)| *name == task) else {
            let moving = "one of: inputs, reference, residual";
            return refused("action", &format_args!("{task:?}"), moving);
        };
        if !(1..=100_000).contains(&num_envs) {
            return refused("num_envs", &num_envs, "a whole number from 1 to 100000");
        }
        check_perception(alpha, gamma)?;
        let autoreset = match autoreset {
            None => None,
            Some("next-step") => Some(Autoreset::NextStep),
            Some("same-step") => Some(Autoreset::SameStep),
            Some(other) => {
                return refused("autoreset", &format_args!("{other:?}"), "None, next-step or same-step");
            }
        };
        let weights = match weights {
            None => [1.0, 1.0, 0.0],
            Some(given) => weights_of(&given, prices_ending)?,
        };
        for (key, steps) in [("max_steps", max_steps), ("max_episode_steps", max_episode_steps)] {
            if steps == Some(0) {
                return refused(key, &0, "a whole number of at least 1");
            }
        }
        if let Some(cost) = most_step_cost.filter(|cost| !(cost.is_finite() && *cost > 0.0)) {
            return refused("most_step_cost", &cost, "a number greater than 0");
        }
        let scale = action_scale.unwrap_or(1.0);
        if !(scale > 0.0 && scale <= 1.0) {
            return refused("action_scale", &scale, "a number greater than 0 and at most 1");
        }
        // what is found at a place does not depend on the human: all episodes share it
        let memory = Arc::new(PlaceMemory::default());
        let keeping = |scenario: &Py<Scenario>| -> PyResult<_> {
            let prepared = scenario.get().prepared(py)?;
            Ok(Arc::new(PreparedScenario::clone(&prepared).keeping_places(Arc::clone(&memory))))
        };
        let bases = scenarios.iter().map(keeping).collect::<PyResult<Vec<_>>>()?;
        let Some(first) = bases.first() else {
            return Err(Error::new_err("worlds has no world; it must have at least one"));
        };
        let limits = match (task, first.robot()) {
            (Task::Options | Task::Both, _) => Vec::new(),
            (_, None) => {
                return Err(Error::new_err(
                    "plant = \"point\" has no robot, which this environment needs; use plant=\"kinematic\" or plant=\"rapier\"",
                ));
            }
            (Task::Reference, _) => vec![1.0, 1.0, 2.0],
            (Task::Inputs | Task::Residual, Some(robot)) => input_limits(robot),
        };
        let rules = Rules {
            task,
            changes: preference_changes.map(counted_changes).transpose()?,
            given: GivenPerception { alpha, gamma },
            options: bases.iter().map(|base| base.options().options().len()).max().unwrap_or(0),
            limits: limits.into_iter().map(|limit| limit * scale).collect(),
            weights,
            max_steps,
            max_episode_steps,
            ending: prices_ending.then_some(Ending { most_step_cost }),
            tells_built_in,
            autoreset,
            bases,
        };
        if threads == Some(0) {
            return refused("threads", &0, "a whole number of at least 1");
        }
        let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        let pool = match num_envs.min(threads) {
            0 | 1 => None,
            threads => {
                // the thread that takes a step is one of them
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads - 1).build();
                Some((
                    pool.map_err(|error| Error::new_err(format!("threads cannot be started: {error}")))?,
                    std::process::id(),
                ))
            }
        };
        let size = rules.numbers().len();
        Ok(Self {
            lanes: Mutex::new(SideBySide::new(num_envs)),
            observations: PyArray2::zeros(py, [num_envs, size], false).unbind(),
            rewards: PyArray1::zeros(py, num_envs, false).unbind(),
            terminated: PyArray1::zeros(py, num_envs, false).unbind(),
            truncated: PyArray1::zeros(py, num_envs, false).unbind(),
            size,
            period: rules.bases[0].scenario().settings.planning_step,
            summaries: Dictionaries::new(py, EPISODE)?,
            pool,
            rules,
        })
    }

    /// Seeds a lane's generator.
    fn seed(
        &self,
        #[pyo3(from_py_with = arguments::index)] index: usize,
        #[pyo3(from_py_with = arguments::seed)] seed: u64,
    ) -> PyResult<()> {
        match self.lock()?.lanes.get_mut(index) {
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
        #[pyo3(from_py_with = arguments::reset_mask)] mask: Option<Vec<bool>>,
        world: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::other_seed)] seed: Option<u64>,
        #[pyo3(from_py_with = arguments::given_alpha)] alpha: Option<f64>,
        #[pyo3(from_py_with = arguments::given_gamma)] gamma: Option<f64>,
    ) -> PyResult<()> {
        let world = world.map(|given| self.world_of(given)).transpose()?;
        check_perception(alpha, gamma)?;
        let count = self.lock()?.lanes.len();
        if mask.as_ref().is_some_and(|mask| mask.len() != count) {
            return Err(Error::new_err(format!(
                "reset_mask must have {count} flags, one for each environment"
            )));
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
            let notes = &self.lock()?.notes;
            if notes.iter().any(|note| note.options.is_none()) {
                return Err(ClosedError::new_err("the environment has no episode; call reset() first"));
            }
            if self.rules.autoreset.is_none() && notes.iter().any(|note| note.is_over) {
                return Err(ClosedError::new_err("the episode is over; call reset()"));
            }
            notes.len()
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

    /// The numbers of an observation: name, unit, least and largest value.
    #[getter]
    fn layout(&self) -> Vec<(String, &'static str, (f64, f64))> {
        let numbers = self.rules.numbers().into_iter();
        numbers.map(|number| (number.name, number.unit, (number.bounds[0], number.bounds[1]))).collect()
    }

    /// The numbers of an action that moves a robot: name and unit.
    #[getter]
    fn action_layout(&self) -> Vec<(String, &'static str)> {
        self.rules.action_numbers().into_iter().map(|number| (number.name, number.unit)).collect()
    }

    /// The names of the worlds.
    #[getter]
    fn worlds(&self) -> Vec<String> {
        self.rules.bases.iter().map(|base| world_name(base).to_owned()).collect()
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

    /// Which actions each lane's episode has, (lanes, options + 1): 0 for options that its world does not have.
    #[getter]
    fn action_masks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i8>>> {
        let most = self.rules.options;
        let notes = &self.lock()?.notes;
        let mut flags = vec![1; notes.len() * (most + 1)];
        for (row, note) in flags.chunks_mut(most + 1).zip(notes) {
            row[note.options.unwrap_or(most)..most].fill(0);
        }
        PyArray1::from_vec(py, flags).reshape([notes.len(), most + 1])
    }

    /// World, seed and human of a lane's episode.
    fn episode<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.lane(index, |lane| {
            let Some(cell) = &lane.cell else { return Ok(()) };
            let scenario = cell.borrow_owner().scenario();
            let Perception { alpha, gamma } = scenario.human;
            dict.set_item("world", lane.world)?;
            dict.set_item("world_name", world_name(cell.borrow_owner()))?;
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
        let recorded =
            py.detach(|| guarded(|| replay::recording(&self.rules, self.period, prepared, &actions)));
        Ok(PyBytes::new(py, &recorded?.map_err(RecordingError::new_err)?))
    }

    /// The figures of a lane's last episode that ended; None before.
    fn summary<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.lane(index, |lane| lane.last.as_ref().map(|last| self.summaries.record(py, last)).transpose())
    }

    /// The observation with which that episode ended, where the lane began anew in the same step.
    fn last_observation<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.lane(index, |lane| Ok(PyArray1::from_slice(py, &lane.last_observation)))
    }

    /// What the built-in controller would do next in a lane: as an action, and as inputs u. None if it is not told.
    fn built_in<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<Option<[Bound<'py, PyArray1<f64>>; 2]>> {
        let told = self.lane(index, |lane| Ok(self.rules.tells_built_in.then(|| lane.built_in.clone())))?;
        Ok(told.map(|told| [told.action, told.inputs].map(|numbers| PyArray1::from_vec(py, numbers))))
    }

    /// N and m of a lane's episode: the most steps that it takes, and the most that a step costs. None without a price
    /// of its ending.
    fn bound(&self, index: usize) -> PyResult<Option<(u64, f64)>> {
        self.lane(index, |lane| Ok(lane.bound.map(|bound| (bound.steps, bound.step_cost))))
    }

    /// The state of all lanes, to be restored in environments made by the same arguments.
    #[pyo3(name = "save")]
    fn saved<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.save(py)?))
    }

    #[pyo3(name = "restore")]
    fn restored(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        self.restore(py, state)
    }
}

/// The name of a world: of a built-in one or its file.
fn world_name(prepared: &PreparedScenario) -> &str {
    prepared.scenario().world.file()
}

fn check_perception(alpha: Option<f64>, gamma: Option<f64>) -> PyResult<()> {
    for (key, value) in [("alpha", alpha), ("gamma", gamma)] {
        if let Some(wrong) = value.filter(|value| !PERCEPTION.contains(*value)) {
            return Err(Error::new_err(format!("{key} = {wrong}; it must be {PERCEPTION}")));
        }
    }
    Ok(())
}

/// The weights of J, J^ and C.
fn weights_of(given: &[Bound<'_, PyAny>; 3], prices_ending: bool) -> PyResult<[f64; 3]> {
    let expected = if prices_ending { "a finite number of at least 0" } else { "a finite number" };
    let mut weights = [0.0; 3];
    for (i, key) in ["objective_weight", "subjective_weight", "control_weight"].into_iter().enumerate() {
        let weight: f64 = arguments::argument(key, expected, &given[i])?;
        if !weight.is_finite() || (prices_ending && weight < 0.0) {
            return Err(Error::new_err(format!("{key} = {weight}; it must be {expected}")));
        }
        weights[i] = weight;
    }
    Ok(weights)
}

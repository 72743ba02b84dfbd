//! Episodes.

use crate::arguments;
use crate::error::{
    ClosedError, Error, RecordingError, ScenarioError, SnapshotError, guarded, no_such_key, raise,
};
use crate::partners::{Fault, Held, Own};
use crate::recording::{framed, page};
use crate::scenario::Scenario;
use crate::table::Table;
use crate::value;
use cocarry::episode::{self, Outcome};
use cocarry::quantities::{EPISODE, LEARNED, Record, TICK, View};
use cocarry::scenario::{Partners, PreparedScenario, Snapshot};
use cocarry::suggestion;
use cocarry_recording::recording::{self, Ending, FileRecorder, Recorder};
use numpy::PyArray1;
use pyo3::exceptions::PyStopIteration;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use pyo3::{PyTraverseError, PyVisit};
use self_cell::self_cell;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, TryLockError};

/// The number of steps between two looks at signals, where a step takes some microseconds.
const STEPS_BETWEEN_SIGNALS: usize = 256;

/// A running episode with its recorder.
pub struct Running<'a> {
    pub episode: episode::Episode<'a>,
    recorder: Option<FileRecorder<'a>>,
    pub outcome: Option<Outcome>,
}

self_cell!(
    /// An episode next to the prepared scenario that it borrows from.
    pub struct Cell {
        owner: Arc<PreparedScenario>,
        #[covariant]
        dependent: Running,
    }
);

impl Cell {
    /// The episode of a prepared scenario and its partners, before its first step or in a state.
    pub fn begin(
        prepared: Arc<PreparedScenario>,
        partners: Partners<'static>,
        state: Option<episode::EpisodeState>,
    ) -> Result<Self, cocarry::Error> {
        Self::try_new(prepared, |prepared| {
            let mut episode = prepared.episode_of(partners)?;
            if let Some(state) = state {
                episode = episode.resume(state)?;
            }
            Ok(Running { episode, recorder: None, outcome: None })
        })
    }
}

/// A running episode. Iterating takes steps and gives their ticks. Shows itself as the 3-D player in a
/// notebook.
///
/// An episode pickles and copies through snapshots, without its recording; a copy continues with the same
/// bits.
/// One thread at a time uses it; others get ClosedError at once.
///
/// The episode before its first step.
///
/// policy: a custom policy of the robot: a callable or an object with ``decide``, of a RobotView (see
///     cocarry.Policy), or a class of such objects. Its answer: an option to lead on, None to follow,
///     or a Decision.
/// human: a custom human: the same, of a HumanView (see cocarry.Human). Its answer: an option, or a
///     HumanDecision.
///
/// Raises ScenarioError: a part of the scenario is not valid. Exceptions of custom partners are raised by
/// the step.
#[pyclass(frozen, module = "cocarry", name = "Episode")]
pub struct Episode {
    scenario: Py<Scenario>,
    /// Copies of the custom partners as they were before the first step.
    pristine: Own,
    own: Own,
    fault: Fault,
    cell: Mutex<Option<Cell>>,
}

impl Running<'_> {
    /// One step, recorded; the outcome once the episode has ended.
    fn step(&mut self) -> Result<Option<Outcome>, recording::RecordingError> {
        self.outcome = self.episode.step();
        match self.outcome {
            None => self.recorder.iter_mut().try_for_each(|recorder| recorder.step(&self.episode))?,
            Some(outcome) => {
                if let Some(recorder) = self.recorder.take() {
                    recorder.finish(&self.episode, Ending::Over(outcome))?;
                }
            }
        }
        Ok(self.outcome)
    }
}

/// Makes the episode of a scenario and of custom partners.
pub fn cell(
    py: Python<'_>,
    prepared: Arc<PreparedScenario>,
    own: Own,
    fault: &Fault,
    state: Option<episode::EpisodeState>,
) -> PyResult<Cell> {
    let partners = own.partners(&prepared, fault);
    let cell = py.detach(|| guarded(|| Cell::begin(prepared, partners, state)));
    fault.take()?;
    cell?.map_err(|error| raise::<ScenarioError>(&error))
}

impl Episode {
    /// The episode of a scenario and custom partners, before its first step or in a state.
    fn of(
        py: Python<'_>,
        scenario: Py<Scenario>,
        own: Own,
        state: Option<episode::EpisodeState>,
    ) -> PyResult<Self> {
        let prepared = scenario.get().prepared(py)?;
        let pristine = own.copied(py)?;
        let fault = Fault::default();
        let cell = cell(py, prepared, own.clone(), &fault, state)?;
        Ok(Self { scenario, pristine, own, fault, cell: Mutex::new(Some(cell)) })
    }

    /// The episode of a snapshot.
    fn resumed(py: Python<'_>, snapshot: &Bound<'_, PyAny>, own: Own) -> PyResult<Self> {
        let Snapshot { scenario, state, .. } = snapshot_of(snapshot)?;
        let scenario = Py::new(py, Scenario::of(scenario))?;
        Self::of(py, scenario, own, Some(state)).map_err(|error| {
            match error.is_instance_of::<ScenarioError>(py) {
                true => SnapshotError::new_err(error.value(py).to_string()),
                false => error,
            }
        })
    }

    /// Runs `act` on the episode without Python's lock.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        act: impl for<'a, 'b> FnOnce(&'a Arc<PreparedScenario>, &'b mut Running<'a>) -> T + Send,
    ) -> PyResult<T> {
        let mut cell = match self.cell.try_lock() {
            Ok(cell) => cell,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                return Err(ClosedError::new_err(
                    "the episode is in a step: a policy, a human or another thread cannot use it before the step is over",
                ));
            }
        };
        let Some(cell) = cell.as_mut() else {
            return Err(ClosedError::new_err("the episode is closed; make another one"));
        };
        let done = py.detach(|| guarded(|| cell.with_dependent_mut(|owner, running| act(owner, running))));
        self.fault.take()?;
        done
    }

    /// Reads from the last step.
    fn read<T: Send>(&self, py: Python<'_>, read: impl FnOnce(&View) -> T + Send) -> PyResult<T> {
        let found = self.with(py, |prepared, running| {
            let begun = running.episode.summary().steps > 0;
            begun.then(|| read(&View::new(prepared, &running.episode)))
        })?;
        found.ok_or_else(|| Error::new_err("the episode has no tick before its first step; call step()"))
    }

    fn tick_record(&self, py: Python<'_>) -> PyResult<Record> {
        self.read(py, |view| TICK.into_iter().flat_map(|table| view.read(table)).collect())
    }

    fn advance(&self, py: Python<'_>, steps: usize) -> PyResult<Option<Outcome>> {
        let stepped = self.with(py, |_, running| {
            for _ in 0..steps {
                if running.step()?.is_some() || self.fault.is_there() {
                    break;
                }
            }
            Ok(running.outcome)
        })?;
        stepped.map_err(|error: recording::RecordingError| raise::<RecordingError>(&error))
    }

    /// Runs to the end, or `most` steps.
    fn run_steps(
        &self,
        py: Python<'_>,
        most: Option<u64>,
        mut each: impl FnMut() -> PyResult<()>,
        one_by_one: bool,
    ) -> PyResult<()> {
        let has_robot = self.scenario.get().inner().plant.robot_setup().is_some();
        let batch = if has_robot || one_by_one { 1 } else { STEPS_BETWEEN_SIGNALS };
        let mut left = most.unwrap_or(u64::MAX);
        while left > 0 {
            let steps = batch.min(usize::try_from(left).unwrap_or(usize::MAX));
            if self.advance(py, steps)?.is_some() {
                break;
            }
            left -= steps as u64;
            each()?;
            py.check_signals()?;
        }
        Ok(())
    }

    /// The recording of the episode so far, run again from its start.
    fn recorded(&self, py: Python<'_>) -> PyResult<Vec<u8>> {
        let (steps, outcome) =
            self.with(py, |_, running| (running.episode.summary().steps, running.outcome))?;
        let fault = Fault::default();
        let prepared = self.scenario.get().prepared(py)?;
        let mut again = cell(py, prepared, self.pristine.copied(py)?, &fault, None)?;
        let log = self.own.log(py, &fault);
        let recorded = py.detach(|| {
            guarded(|| {
                again.with_dependent_mut(|prepared, running| {
                    let mut recorder =
                        Recorder::new(Cursor::new(Vec::new()), "the episode", prepared, &running.episode)?
                            .logging(log);
                    for _ in 0..steps {
                        running.episode.step();
                        recorder.step(&running.episode)?;
                    }
                    let ending = outcome.map_or(Ending::Interrupted, |outcome| {
                        running.episode.step();
                        Ending::Over(outcome)
                    });
                    Ok::<_, recording::RecordingError>(
                        recorder.finish(&running.episode, ending)?.into_inner(),
                    )
                })
            })
        });
        fault.take()?;
        recorded?.map_err(|error| raise::<RecordingError>(&error))
    }

    fn check_not_recording(&self, py: Python<'_>) -> PyResult<()> {
        match self.with(py, |_, running| running.recorder.is_some())? {
            true => {
                Err(RecordingError::new_err("an episode that is being recorded cannot be copied or pickled"))
            }
            false => Ok(()),
        }
    }

    fn page(&self, py: Python<'_>, title: &str) -> PyResult<String> {
        let bytes = self.recorded(py)?;
        py.detach(|| page(Cursor::new(bytes), "the episode", title))
    }
}

/// The snapshot in an argument: bytes, or a file.
fn snapshot_of(given: &Bound<'_, PyAny>) -> PyResult<Snapshot> {
    let snapshot = match given.cast::<PyBytes>() {
        Ok(bytes) => Snapshot::parse("snapshot", bytes.as_bytes()),
        Err(_) => Snapshot::load(&given.extract::<PathBuf>().map_err(|_| {
            SnapshotError::new_err("a snapshot must be the bytes of Episode.snapshot() or a file")
        })?),
    };
    snapshot.map_err(|error| raise::<SnapshotError>(&error))
}

#[pymethods]
impl Episode {
    #[new]
    #[pyo3(signature = (scenario, *, policy = None, human = None))]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::scenario)] scenario: Py<Scenario>,
        policy: Option<&Bound<'_, PyAny>>,
        human: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Self::of(py, scenario, Own::of(policy, human)?, None)
    }

    /// The episode of a snapshot, its bytes or a file; it continues with the same bits. Raises
    /// SnapshotError.
    #[staticmethod]
    #[pyo3(signature = (snapshot, *, policy = None, human = None))]
    fn resume(
        py: Python<'_>,
        snapshot: &Bound<'_, PyAny>,
        policy: Option<&Bound<'_, PyAny>>,
        human: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Self::resumed(py, snapshot, Own::of(policy, human)?)
    }

    /// Takes one planning step; returns the outcome once the episode has ended, else None.
    fn step(&self, py: Python<'_>) -> PyResult<Option<&'static str>> {
        Ok(self.advance(py, 1)?.map(Outcome::name))
    }

    /// Runs to the end, or so many steps, without Python's lock; returns the summary. Ctrl-C stops it.
    #[pyo3(signature = (steps = None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::steps)] steps: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.run_steps(py, steps, || Ok(()), false)?;
        self.summary(py)
    }

    /// Runs on as ``run`` does; returns a row for every tick. Columns of options and joints are
    /// ``key[name]``.
    #[pyo3(signature = (steps = None))]
    fn ticks(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::steps)] steps: Option<u64>,
    ) -> PyResult<Table> {
        let mut records = Vec::new();
        let each = || {
            records.push(self.tick_record(py)?);
            Ok(())
        };
        self.run_steps(py, steps, each, true)?;
        Ok(Table::of_ticks(&records))
    }

    /// The quantities of the last step, as ``quantities("tick")`` has them; missing values are None.
    #[getter]
    fn tick<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        value::record(py, &self.tick_record(py)?)
    }

    /// The figures of the episode so far, as ``quantities("episode")`` has them; missing values are None.
    ///
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let record =
            self.with(py, |prepared, running| View::new(prepared, &running.episode).read(EPISODE))?;
        value::record(py, &record)
    }

    /// The belief over this human as of now, as ``/learned`` of a recording has it: means, variances,
    /// covariance and 95 % intervals of alpha, gamma and eta, information (nats), densities. None without
    /// ``belief_update="learn"``.
    #[getter]
    fn learned<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let record =
            self.with(py, |prepared, running| View::new(prepared, &running.episode).read(LEARNED))?;
        let found = record.into_iter().next().map(|(_, human)| human).unwrap_or_default();
        value::to_python(py, &found)
    }

    /// One quantity of the last step.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let Ok(key) = key.extract::<String>() else {
            let message = "it must be the name of a quantity, see cocarry.quantities(\"tick\")";
            return Err(no_such_key(py, format!("quantity = {}; {message}", value::repr(key))));
        };
        let Some(quantity) = TICK.into_iter().flatten().find(|quantity| quantity.key == key) else {
            let known: Vec<&str> = TICK.into_iter().flatten().map(|quantity| quantity.key).collect();
            let (listed, hint) = (known.join(", "), suggestion::hint(&key, known));
            let message = format!("unknown quantity `{key}`; expected one of: {listed}{hint}");
            return Err(no_such_key(py, message));
        };
        value::to_python(py, &self.read(py, quantity.get)?)
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match self.advance(py, 1)? {
            Some(_) => Err(PyStopIteration::new_err(())),
            None => self.tick(py),
        }
    }

    /// The scenario.
    #[getter]
    fn scenario(&self, py: Python<'_>) -> Py<Scenario> {
        self.scenario.clone_ref(py)
    }

    /// The custom policy; None with the scenario's.
    #[getter]
    fn policy(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.own.policy.as_ref().and_then(|held| held.get(py).ok())
    }

    /// The custom human; None with the scenario's.
    #[getter]
    fn human(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.own.human.as_ref().and_then(|held| held.get(py).ok())
    }

    /// Steps taken.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |_, running| running.episode.summary().steps)
    }

    /// How the episode ended; None while it runs.
    #[getter]
    fn outcome(&self, py: Python<'_>) -> PyResult<Option<&'static str>> {
        Ok(self.with(py, |_, running| running.outcome)?.map(Outcome::name))
    }

    /// Position of the team, (2,), m.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let position = self.with(py, |_, running| running.episode.position())?;
        Ok(PyArray1::from_slice(py, position.coords.as_slice()))
    }

    /// The state as the bytes of a snapshot file.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |prepared, running| prepared.snapshot(&running.episode).bytes())?;
        Ok(PyBytes::new(py, &bytes.map_err(|error| raise::<SnapshotError>(&error))?))
    }

    /// Records the steps into an MCAP file, from before the first step until the end or ``close``; returns
    /// itself.
    ///
    /// Raises RecordingError: the file exists, cannot be written or has another extension than ``.mcap``, or the
    /// episode has begun.
    #[pyo3(signature = (file, *, overwrite = false))]
    fn record(
        slf: Py<Self>,
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::file)] file: PathBuf,
        #[pyo3(from_py_with = arguments::overwrite)] overwrite: bool,
    ) -> PyResult<Py<Self>> {
        if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap")) {
            return Err(RecordingError::new_err(format!("{}: expected the extension .mcap", file.display())));
        }
        let log = slf.get().own.log(py, &slf.get().fault);
        let begun = slf.get().with(py, |prepared, running| {
            if running.episode.summary().steps > 0 || running.recorder.is_some() {
                return Ok(false);
            }
            let recorder = FileRecorder::create(&file, overwrite, prepared, &running.episode)?;
            running.recorder = Some(recorder.logging(log));
            Ok::<_, recording::RecordingError>(true)
        })?;
        match begun.map_err(|error| raise::<RecordingError>(&error))? {
            true => Ok(slf),
            false => Err(RecordingError::new_err(
                "a recording holds a whole episode: call record() once, before the first step",
            )),
        }
    }

    /// The recording of the episode so far (MCAP). Runs it again from its start, with copies of custom
    /// partners.
    fn recording<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.recorded(py)?))
    }

    /// The 3-D player of the episode so far, as one page. Runs the episode again, as ``recording`` does.
    ///
    #[pyo3(signature = (title = "episode"))]
    fn to_html(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::title)] title: &str,
    ) -> PyResult<String> {
        self.page(py, title)
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<Option<String>> {
        if self.steps(py)? == 0 {
            return Ok(None);
        }
        Ok(Some(framed(&self.page(py, "episode")?)))
    }

    /// Ends the episode and finishes its recording.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let Ok(mut cell) = self.cell.try_lock() else {
            return Err(ClosedError::new_err(
                "the episode is in a step, and cannot be closed before it is over",
            ));
        };
        let Some(mut cell) = cell.take() else { return Ok(()) };
        let done = py.detach(|| {
            cell.with_dependent_mut(|_, running| match running.recorder.take() {
                None => Ok(()),
                Some(recorder) => {
                    let ending = running.outcome.map_or(Ending::Interrupted, Ending::Over);
                    recorder.finish(&running.episode, ending)
                }
            })
        });
        done.map_err(|error| raise::<RecordingError>(&error))
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.__deepcopy__(py, None)
    }

    #[pyo3(signature = (_memo = None))]
    fn __deepcopy__(&self, py: Python<'_>, _memo: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        self.check_not_recording(py)?;
        let state = self.with(py, |_, running| running.episode.state())?;
        let copy = Self::of(py, self.scenario.clone_ref(py), self.own.copied(py)?, Some(state))?;
        Ok(Self { pristine: self.pristine.copied(py)?, ..copy })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, this) = (slf.py(), slf.get());
        this.check_not_recording(py)?;
        let first = |held: &Option<Held>| held.as_ref().and_then(|held| held.get(py).ok());
        let Own { policy, human } = &this.pristine;
        let parts = (this.snapshot(py)?, this.policy(py), this.human(py), first(policy), first(human));
        let rebuild = slf.get_type().getattr("_rebuild")?;
        Ok((rebuild, parts.into_pyobject(py)?.into_any()))
    }

    #[staticmethod]
    fn _rebuild(
        py: Python<'_>,
        snapshot: &Bound<'_, PyAny>,
        policy: Option<Py<PyAny>>,
        human: Option<Py<PyAny>>,
        first_policy: Option<Py<PyAny>>,
        first_human: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let own = |policy: Option<Py<PyAny>>, human: Option<Py<PyAny>>| Own {
            policy: policy.map(Held::new),
            human: human.map(Held::new),
        };
        let made = Self::resumed(py, snapshot, own(policy, human))?;
        Ok(Self { pristine: own(first_policy, first_human), ..made })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.own.held().chain(self.pristine.held()).try_for_each(|held| held.traverse(&visit))
    }

    fn __clear__(&self) {
        self.own.held().chain(self.pristine.held()).for_each(Held::clear);
    }

    fn __repr__(&self) -> String {
        let Ok(cell) = self.cell.try_lock() else { return "<cocarry.Episode, in a step>".to_owned() };
        match cell.as_ref() {
            None => "<cocarry.Episode, closed>".to_owned(),
            Some(cell) => {
                let running = cell.borrow_dependent();
                let outcome = running.outcome.map_or("running", Outcome::name);
                format!("<cocarry.Episode, {} steps, {outcome}>", running.episode.summary().steps)
            }
        }
    }
}

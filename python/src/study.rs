//! Sweeps: the episodes of a study on all threads.

use crate::arguments;
use crate::error::{StudyError, guarded, raise};
use crate::partners::{Fault, Held, Own};
use crate::table::Table;
use cocarry::episode::Episode;
use cocarry::scenario::PreparedScenario;
use cocarry_studies::columns::Columns;
use cocarry_studies::parallel::OnDone;
use cocarry_studies::study::{
    Custom, EpisodeMaker, Partner, Partners, Shard, Study, Sweep, SweepError, SweepOutputs, columns,
    complete_rows, read_rows, rows_with,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long the main thread waits for rows before it looks at signals.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

/// A policy or a human from Python: its name; of a custom one also what is known of its code, and the object.
type GivenPartner = (String, Option<String>, Option<Py<PyAny>>);

/// The custom policies and humans of a study, by their place in its lists.
#[derive(Default)]
struct Objects {
    policies: Vec<Option<Held>>,
    humans: Vec<Option<Held>>,
}

/// Splits policies and humans into what the study knows of them, and their objects.
fn split(policies: Vec<GivenPartner>, humans: Vec<GivenPartner>) -> PyResult<(Partners, Objects)> {
    // classes become objects once
    let made = |object: Option<Py<PyAny>>| {
        Python::attach(|py| Own::of(object.as_ref().map(|object| object.bind(py)), None))
            .map(|own| own.policy)
    };
    let part = |given: Vec<GivenPartner>| -> PyResult<(Vec<Partner>, Vec<Option<Held>>)> {
        let partner = |(name, code, object): GivenPartner| match code {
            Some(code) => Ok((Partner::Custom { name, code }, made(object)?)),
            None => Ok((Partner::BuiltIn(name), None)),
        };
        given.into_iter().map(partner).collect()
    };
    let ((policy_names, policies), (human_names, humans)) = (part(policies)?, part(humans)?);
    let partners = Partners::new(policy_names, human_names).map_err(|error| raise::<StudyError>(&error))?;
    Ok((partners, Objects { policies, humans }))
}

/// Makes the episodes of a study with the custom partners of Python.
struct Maker<'m> {
    objects: &'m Objects,
    is_custom: bool,
    fault: &'m Fault,
    stop: &'m AtomicBool,
}

impl Maker<'_> {
    /// Copies of the partners of an episode.
    fn copied(&self, custom: Custom) -> PyResult<Own> {
        Python::attach(|py| {
            let one = |list: &[Option<Held>], at: Option<usize>| list.get(at?)?.clone();
            let (policy, human) = (&self.objects.policies, &self.objects.humans);
            Own { policy: one(policy, custom.policy), human: one(human, custom.human) }.copied(py)
        })
    }
}

impl EpisodeMaker for Maker<'_> {
    fn begin<'s>(
        &self,
        prepared: &'s PreparedScenario,
        custom: Custom,
    ) -> Result<Episode<'s>, cocarry::Error> {
        if custom == Custom::default() {
            return prepared.episode();
        }
        let own = self.copied(custom).unwrap_or_else(|error| {
            self.fault.put(error);
            Own::default()
        });
        prepared.episode_of(own.partners(prepared, self.fault))
    }

    fn is_over(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || (self.is_custom && self.fault.is_there())
    }
}

/// Runs the episodes of a study's text; see cocarry.sweep.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds = None, shard = None, threads = None, policies = Vec::new(), humans = Vec::new(), out = None, ticks = None, overwrite = false, progress = None, table = true))]
#[allow(clippy::too_many_arguments, reason = "keywords")]
pub fn sweep(
    py: Python<'_>,
    text: &str,
    file: &str,
    folder: PathBuf,
    #[pyo3(from_py_with = arguments::seeds_of_study)] seeds: Option<NonZeroU64>,
    #[pyo3(from_py_with = arguments::shard)] shard: Option<(u64, u64)>,
    #[pyo3(from_py_with = arguments::threads_of_study)] threads: Option<usize>,
    policies: Vec<GivenPartner>,
    humans: Vec<GivenPartner>,
    out: Option<PathBuf>,
    ticks: Option<PathBuf>,
    overwrite: bool,
    progress: Option<&Bound<'_, PyAny>>,
    table: bool,
) -> PyResult<Option<Table>> {
    if ticks.is_some() && out.is_none() {
        return Err(StudyError::new_err(
            "ticks = a folder: needs out = a file, for the rows with which they resume",
        ));
    }
    let (partners, objects) = split(policies, humans)?;
    let is_custom = partners.are_custom();
    let study = py.detach(|| Study::parse_with(file, text, Path::new(&folder), seeds, partners));
    let refused = |error: SweepError| raise::<StudyError>(&error);
    let study = study.map_err(refused)?;
    let shard = match shard {
        Some((number, of)) if number < 1 || number > of => {
            return Err(StudyError::new_err(format!(
                "shard = ({number}, {of}); it must be (i, n), the i-th of n parts, with 1 <= i <= n"
            )));
        }
        shard => shard.map(|(number, of)| Shard { number, of }),
    };
    let threads = match threads {
        Some(0) => return Err(StudyError::new_err("threads = 0; it must be at least 1")),
        Some(threads) => threads,
        None => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let progress = progress.map(|progress| progress.clone().unbind());
    let (fault, stop) = (Fault::default(), AtomicBool::new(false));
    let maker = Maker { objects: &objects, is_custom, fault: &fault, stop: &stop };
    let watch = Watch { threads, progress: progress.as_ref(), stop: &stop, fault: &fault };
    match out {
        Some(rows) => {
            // as the program does; ticks may be missing where the rows are complete
            let is_new = overwrite || ticks.is_some();
            if !is_new && py.detach(|| complete_rows(&study, shard, &rows)).is_some() {
                return table.then(|| read(py, &rows)).transpose();
            }
            let to = SweepOutputs { rows: &rows, ticks: ticks.as_deref(), overwrite };
            py.detach(|| {
                let sweep = Sweep::open(&study, shard, to).map_err(refused)?;
                let counts = [sweep.kept(), sweep.episodes()];
                watch.run(counts, |on_done| sweep.run_with(&maker, on_done, &stop))
            })?;
            table.then(|| read(py, &rows)).transpose()
        }
        None => {
            let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
            let counts = [0, episodes.end - episodes.start];
            let work = |on_done: OnDone| rows_with(&study, shard, &maker, on_done, &stop);
            let lines = py.detach(|| watch.run(counts, work))?;
            table_of(&lines.concat()).map(Some)
        }
    }
}

/// The rows of these lines.
fn table_of(lines: &[u8]) -> PyResult<Table> {
    let mut columns = Columns::new(&columns());
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(lines);
    for row in reader.records() {
        columns.add(&row.map_err(|error| raise::<StudyError>(&error))?, []);
    }
    Table::of_rows(columns)
}

/// The check that an object can decide.
#[pyfunction]
pub fn check_partner(what: &str, given: &Bound<'_, PyAny>) -> PyResult<()> {
    let (policy, human) = if what == "human" { (None, Some(given)) } else { (Some(given), None) };
    Own::of(policy, human).map(drop)
}

/// The table of lines of results, as `study_rows` returns them.
#[pyfunction]
pub fn rows_table(lines: &[u8]) -> PyResult<Table> {
    table_of(lines)
}

/// The number of episodes of a study.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds, policies, humans))]
pub fn study_episodes(
    py: Python<'_>,
    text: &str,
    file: &str,
    folder: PathBuf,
    seeds: Option<NonZeroU64>,
    policies: Vec<GivenPartner>,
    humans: Vec<GivenPartner>,
) -> PyResult<u64> {
    let (partners, _) = split(policies, humans)?;
    let study = py.detach(|| Study::parse_with(file, text, &folder, seeds, partners));
    study.map(|study| study.episodes()).map_err(|error| raise::<StudyError>(&error))
}

/// The lines of results of the episodes from ``first`` to before ``end``, as ``cocarry sweep`` writes them.
///
/// Raises StudyError.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds, first, end, policies = Vec::new(), humans = Vec::new()))]
#[allow(clippy::too_many_arguments, reason = "keywords")]
pub fn study_rows<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    folder: PathBuf,
    seeds: Option<NonZeroU64>,
    first: u64,
    end: u64,
    policies: Vec<GivenPartner>,
    humans: Vec<GivenPartner>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (partners, objects) = split(policies, humans)?;
    let (fault, stop, is_custom) = (Fault::default(), AtomicBool::new(false), partners.are_custom());
    let maker = Maker { objects: &objects, is_custom, fault: &fault, stop: &stop };
    let rows = py.detach(|| {
        let study = Study::parse_with(file, text, &folder, seeds, partners);
        let study = study.map_err(|error| raise::<StudyError>(&error))?;
        let mut rows = Vec::new();
        for episode in first..end.min(study.episodes()) {
            rows.extend(guarded(|| study.row(episode, &maker))?);
            fault.take()?;
        }
        Ok::<_, PyErr>(rows)
    })?;
    Ok(PyBytes::new(py, &rows))
}

/// The results of a study whose episodes run elsewhere: a file that grows in the order of episodes. A file that
/// has all of them already is complete, unless ``overwrite``.
///
/// Raises StudyError, also if the file is that of another study, is no CSV file of results, or is written by another
/// process.
#[pyclass(module = "cocarry._cocarry")]
pub struct Rows {
    study: Arc<Study>,
    // for Sync, which the writer of ticks is not
    sweep: Mutex<Option<Sweep<Arc<Study>>>>,
    out: PathBuf,
    is_custom: bool,
}

impl Rows {
    fn sweep(&mut self) -> &mut Option<Sweep<Arc<Study>>> {
        self.sweep.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Rows {
    #[new]
    #[pyo3(signature = (text, *, file, folder, seeds, out, overwrite, policies = Vec::new(), humans = Vec::new()))]
    #[allow(clippy::too_many_arguments, reason = "keywords")]
    fn new(
        py: Python<'_>,
        text: &str,
        file: &str,
        folder: PathBuf,
        seeds: Option<NonZeroU64>,
        out: PathBuf,
        overwrite: bool,
        policies: Vec<GivenPartner>,
        humans: Vec<GivenPartner>,
    ) -> PyResult<Self> {
        let (partners, _) = split(policies, humans)?;
        let is_custom = partners.are_custom();
        py.detach(|| {
            let study = Arc::new(Study::parse_with(file, text, &folder, seeds, partners)?);
            let sweep = match !overwrite && complete_rows(&study, None, &out).is_some() {
                true => None,
                false => {
                    let outputs = SweepOutputs { rows: &out, ticks: None, overwrite };
                    Some(Sweep::open(Arc::clone(&study), None, outputs)?)
                }
            };
            Ok(Self { study, sweep: Mutex::new(sweep), out, is_custom })
        })
        .map_err(|error: SweepError| raise::<StudyError>(&error))
    }

    /// The number of episodes whose rows are there.
    #[getter]
    fn kept(&mut self) -> u64 {
        let all = self.study.episodes();
        self.sweep().as_ref().map_or(all, Sweep::kept)
    }

    /// The number of episodes.
    #[getter]
    fn episodes(&self) -> u64 {
        self.study.episodes()
    }

    /// The files that the study reads, if the study file is ``path``.
    fn files(&self, path: PathBuf) -> Vec<PathBuf> {
        self.study.files(&path).collect()
    }

    /// Appends the lines of the next episodes. Raises StudyError if one is not the next, or damaged.
    fn append(&mut self, py: Python<'_>, rows: &[u8]) -> PyResult<()> {
        let Some(sweep) = self.sweep() else {
            return Err(StudyError::new_err("the results are complete"));
        };
        py.detach(|| sweep.append(rows)).map_err(|error| raise::<StudyError>(&error))
    }

    /// Runs the episodes that are missing, gives the file its name, and returns the rows if ``table``.
    ///
    /// Raises StudyError.
    fn finish(&mut self, py: Python<'_>, table: bool) -> PyResult<Option<Table>> {
        if self.is_custom && self.kept() < self.episodes() {
            return Err(StudyError::new_err(
                "episodes of custom partners are missing; append their rows first",
            ));
        }
        if let Some(sweep) = self.sweep().take() {
            let finished = py.detach(|| sweep.run(&|| {}, &AtomicBool::new(false)));
            finished.map_err(|error| raise::<StudyError>(&error))?;
        }
        table.then(|| read(py, &self.out)).transpose()
    }
}

/// The rows of a file of results.
fn read(py: Python<'_>, file: &Path) -> PyResult<Table> {
    let mut columns = Columns::new(&columns());
    let read = py.detach(|| read_rows(file, |row| columns.add(row, [])));
    read.map_err(|error| raise::<StudyError>(&error))?;
    Table::of_rows(columns)
}

/// The stamp of this machine's arithmetic: a digest of a fixed list of results.
#[pyfunction]
pub fn arithmetic_stamp() -> &'static str {
    cocarry::arithmetic::stamp()
}

/// How a sweep is watched while it runs.
struct Watch<'w> {
    threads: usize,
    progress: Option<&'w Py<PyAny>>,
    stop: &'w AtomicBool,
    fault: &'w Fault,
}

impl Watch<'_> {
    /// Does the work on so many threads, and meanwhile looks at signals and tells the progress. What stopped
    /// the work is the error: a signal, an exception of `progress`, then one of a custom partner.
    fn run<T: Send>(
        &self,
        [kept, count]: [u64; 2],
        work: impl FnOnce(OnDone) -> Result<T, SweepError> + Send,
    ) -> PyResult<T> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build();
        let pool = pool.map_err(|error| raise::<StudyError>(&error))?;
        let done = AtomicU64::new(kept);
        let on_done = || {
            done.fetch_add(1, Ordering::Relaxed);
        };
        let (mut told, mut next) = (Ok(()), kept);
        let ended = std::thread::scope(|scope| {
            let (sender, ended) = mpsc::channel::<()>();
            let work = scope.spawn(|| {
                let _sender = sender;
                pool.install(|| guarded(|| work(&on_done)))
            });
            while ended.recv_timeout(BETWEEN_SIGNALS) == Err(RecvTimeoutError::Timeout) {
                if told.is_ok() {
                    let now = done.load(Ordering::Relaxed);
                    told = Python::attach(|py| {
                        py.check_signals()?;
                        self.tell(py, (now > next).then_some(now), count)
                    });
                    next = now;
                    self.stop.store(told.is_err(), Ordering::Relaxed);
                }
            }
            work.join().unwrap_or_else(|_| Err(StudyError::new_err("the sweep failed")))
        });
        told?;
        self.fault.take()?;
        let found = ended?.map_err(|error| raise::<StudyError>(&error))?;
        Python::attach(|py| self.tell(py, (next < count).then_some(count), count))?;
        Ok(found)
    }

    /// Tells how many episodes are done, if that is news.
    fn tell(&self, py: Python<'_>, done: Option<u64>, count: u64) -> PyResult<()> {
        match self.progress.zip(done) {
            Some((progress, done)) => progress.call1(py, (done, count)).map(drop),
            None => Ok(()),
        }
    }
}

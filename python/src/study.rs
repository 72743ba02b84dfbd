//! Sweeps: the episodes of a study on all threads.

use crate::error::{StudyError, guarded, raise};
use crate::partners::{Fault, Own};
use crate::table::Table;
use cocarry::episode::Episode;
use cocarry::scenario::PreparedScenario;
use cocarry_studies::columns::Columns;
use cocarry_studies::study::{Shard, Study, Sweep, SweepError, SweepOutputs, columns, read_rows};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long the main thread waits for rows before it looks at signals.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

/// What the threads share.
struct Work<'w> {
    study: &'w Study,
    own: &'w Own,
    next: AtomicU64,
    end: u64,
    is_stopped: AtomicBool,
    fault: Fault,
}

impl Work<'_> {
    /// Runs an episode to its end, or until the sweep is stopped.
    fn run<'s>(&self, prepared: &'s PreparedScenario) -> Result<Episode<'s>, cocarry::Error> {
        let own = match self.own.is_empty() {
            true => Own::default(),
            false => Python::attach(|py| self.own.copied(py)).unwrap_or_else(|error| {
                self.fault.put(error);
                Own::default()
            }),
        };
        let mut episode = prepared.episode_of(own.partners(prepared, &self.fault))?;
        while episode.step().is_none() && !self.is_over() {}
        Ok(episode)
    }

    fn is_over(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed) || (!self.own.is_empty() && self.fault.is_there())
    }

    /// Works on episodes until there are no more.
    fn work(&self, rows: &mpsc::Sender<(u64, Vec<u8>)>) {
        while !self.is_over() {
            let episode = self.next.fetch_add(1, Ordering::Relaxed);
            if episode >= self.end {
                break;
            }
            match guarded(|| self.study.row(episode, &|prepared| self.run(prepared))) {
                Ok(row) => {
                    if rows.send((episode, row)).is_err() {
                        break;
                    }
                }
                Err(error) => {
                    self.fault.put(error);
                    self.is_stopped.store(true, Ordering::Relaxed);
                }
            }
        }
    }
}

/// The name of a custom partner in results.
fn name(py: Python<'_>, object: &Py<PyAny>) -> String {
    let object = object.bind(py);
    let name = object.getattr("__name__").or_else(|_| object.get_type().getattr("__name__"));
    format!("own({})", name.map_or_else(|_| "?".to_owned(), |name| name.to_string()))
}

/// Runs the episodes of a study and returns a row for each, in the study's order.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds = None, shard = None, threads = None, policy = None, human = None, out = None, ticks = None, overwrite = false, progress = None, table = true))]
#[allow(clippy::too_many_arguments, reason = "keywords")]
pub fn sweep(
    py: Python<'_>,
    text: &str,
    file: &str,
    folder: PathBuf,
    seeds: Option<u64>,
    shard: Option<(u64, u64)>,
    threads: Option<usize>,
    policy: Option<&Bound<'_, PyAny>>,
    human: Option<&Bound<'_, PyAny>>,
    out: Option<PathBuf>,
    ticks: Option<PathBuf>,
    overwrite: bool,
    progress: Option<&Bound<'_, PyAny>>,
    table: bool,
) -> PyResult<Option<Table>> {
    let own = Own::of(policy, human)?;
    if out.is_some() && !own.is_empty() {
        return Err(StudyError::new_err(
            "out = a file: only for the partners of a study, which its digest covers; write the table of custom partners, as with polars.DataFrame(table).write_parquet",
        ));
    }
    if ticks.is_some() && out.is_none() {
        return Err(StudyError::new_err(
            "ticks = a folder: needs out = a file, for the rows with which they resume",
        ));
    }
    let study = py.detach(|| Study::parse(file, text, Path::new(&folder), seeds));
    let study = study.map_err(|error| raise::<StudyError>(&error))?;
    let shard = match shard {
        Some((number, of)) if number < 1 || number > of => {
            return Err(StudyError::new_err(format!(
                "shard = ({number}, {of}); it must be (i, n), the i-th of n parts, with 1 <= i <= n"
            )));
        }
        shard => shard.map(|(number, of)| Shard { number, of }),
    };
    let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
    let threads = match threads {
        Some(0) => return Err(StudyError::new_err("threads = 0; it must be at least 1")),
        Some(threads) => threads,
        None => std::thread::available_parallelism().map_or(1, usize::from),
    };
    let progress = progress.map(|progress| progress.clone().unbind());
    if let Some(rows) = out {
        let to = SweepOutputs { rows: &rows, ticks: ticks.as_deref(), overwrite };
        py.detach(|| into_file(&study, shard, to, threads, progress.as_ref()))?;
        return table.then(|| read(py, &rows)).transpose();
    }
    let count = episodes.end - episodes.start;
    let work = Work {
        study: &study,
        own: &own,
        next: AtomicU64::new(episodes.start),
        end: episodes.end,
        is_stopped: AtomicBool::new(false),
        fault: Fault::default(),
    };
    let lines = py.detach(|| run(&work, threads, count, progress.as_ref()));
    work.fault.take()?;
    let lines = lines?;
    let mut rows = Vec::with_capacity(lines.len());
    for line in lines {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_slice());
        let row = reader.records().next().transpose().map_err(|error| raise::<StudyError>(&error))?;
        rows.push(row.iter().flatten().map(str::to_owned).collect::<Vec<_>>());
    }
    let place = |key| columns().iter().position(|heading| heading.name == key);
    for (object, key) in [(&own.policy, "method"), (&own.human, "human_model")] {
        let Some(object) = object else { continue };
        let name = name(py, object);
        for row in &mut rows {
            // the checksum is that of the study's own row
            place("checksum").into_iter().for_each(|at| row[at].clear());
            place(key).into_iter().for_each(|at| row[at].clone_from(&name));
        }
    }
    let mut columns = Columns::new(&columns());
    rows.iter().for_each(|row| columns.add(row.iter().map(String::as_str), []));
    Table::of_rows(columns).map(Some)
}

/// The lines of results of the episodes from `first` to before `end`.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds, first, end))]
pub fn study_rows<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    folder: PathBuf,
    seeds: Option<u64>,
    first: u64,
    end: u64,
) -> PyResult<Bound<'py, PyBytes>> {
    let rows = py.detach(|| {
        let study = Study::parse(file, text, &folder, seeds).map_err(|error| raise::<StudyError>(&error))?;
        guarded(|| study.rows(first..end))
    })?;
    Ok(PyBytes::new(py, &rows))
}

/// The results of a study whose episodes run elsewhere.
#[pyclass(module = "cocarry._cocarry")]
pub struct Rows {
    study: Arc<Study>,
    // for Sync, which the writer of ticks is not
    sweep: Mutex<Option<Sweep<Arc<Study>>>>,
    out: PathBuf,
}

impl Rows {
    fn sweep(&mut self) -> &mut Option<Sweep<Arc<Study>>> {
        self.sweep.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Rows {
    #[new]
    #[pyo3(signature = (text, *, file, folder, seeds, out, overwrite))]
    fn new(
        py: Python<'_>,
        text: &str,
        file: &str,
        folder: PathBuf,
        seeds: Option<u64>,
        out: PathBuf,
        overwrite: bool,
    ) -> PyResult<Self> {
        py.detach(|| {
            let study = Arc::new(Study::parse(file, text, &folder, seeds)?);
            let outputs = SweepOutputs { rows: &out, ticks: None, overwrite };
            let sweep = Mutex::new(Some(Sweep::open(Arc::clone(&study), None, outputs)?));
            Ok(Self { study, sweep, out })
        })
        .map_err(|error: SweepError| raise::<StudyError>(&error))
    }

    /// The number of episodes whose rows are there.
    #[getter]
    fn kept(&mut self) -> u64 {
        let all = self.study.episodes();
        self.sweep().as_ref().map_or(all, Sweep::kept)
    }

    #[getter]
    fn episodes(&self) -> u64 {
        self.study.episodes()
    }

    /// The files that the study reads, besides its own, relative to the file `path`.
    fn files(&self, path: PathBuf) -> Vec<PathBuf> {
        self.study.files(&path).collect()
    }

    /// Appends the lines of the next episodes, each checked.
    fn append(&mut self, py: Python<'_>, rows: &[u8]) -> PyResult<()> {
        let Some(sweep) = self.sweep() else {
            return Err(StudyError::new_err("the results are complete"));
        };
        py.detach(|| sweep.append(rows)).map_err(|error| raise::<StudyError>(&error))
    }

    /// Gives the results their name, and returns them as a table if it is wanted.
    fn finish(&mut self, py: Python<'_>, table: bool) -> PyResult<Option<Table>> {
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

/// The stamp of this machine's arithmetic.
#[pyfunction]
pub fn arithmetic_stamp() -> &'static str {
    cocarry::arithmetic::stamp()
}

/// Runs the episodes of a study as `cocarry sweep` does, with its files.
fn into_file(
    study: &Study,
    shard: Option<Shard>,
    to: SweepOutputs<'_>,
    threads: usize,
    progress: Option<&Py<PyAny>>,
) -> PyResult<()> {
    let refused = |error: SweepError| raise::<StudyError>(&error);
    let sweep = Sweep::open(study, shard, to).map_err(refused)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| raise::<StudyError>(&error))?;
    let (kept, count) = (sweep.kept(), sweep.episodes());
    let (done, stop) = (AtomicU64::new(kept), AtomicBool::new(false));
    let on_done = || {
        done.fetch_add(1, Ordering::Relaxed);
    };
    std::thread::scope(|scope| {
        let work = scope.spawn(|| pool.install(|| guarded(|| sweep.run(&on_done, &stop))));
        let mut told = Ok(());
        let mut next = kept;
        while !work.is_finished() {
            std::thread::sleep(BETWEEN_SIGNALS);
            let now = done.load(Ordering::Relaxed);
            if told.is_ok() {
                told = Python::attach(|py| {
                    py.check_signals()?;
                    match progress.filter(|_| now > next) {
                        Some(progress) => progress.call1(py, (now, count)).map(drop),
                        None => Ok(()),
                    }
                });
                next = now;
                stop.store(told.is_err(), Ordering::Relaxed);
            }
        }
        let ended = work.join().unwrap_or_else(|_| Err(StudyError::new_err("the sweep failed")));
        // what stopped the sweep is the error to raise
        told?;
        ended?.map_err(refused)?;
        match progress.filter(|_| next < count) {
            Some(progress) => Python::attach(|py| progress.call1(py, (count, count)).map(drop)),
            None => Ok(()),
        }
    })
}

/// The lines of all episodes, in order.
fn run(work: &Work<'_>, threads: usize, count: u64, progress: Option<&Py<PyAny>>) -> PyResult<Vec<Vec<u8>>> {
    let begin = work.next.load(Ordering::Relaxed);
    let mut lines = vec![Vec::new(); usize::try_from(count).unwrap_or(0)];
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.min(lines.len()) {
            let sender = sender.clone();
            scope.spawn(move || work.work(&sender));
        }
        drop(sender);
        let (mut done, mut told) = (0, 0);
        let stopped = loop {
            match receiver.recv_timeout(BETWEEN_SIGNALS) {
                Ok((episode, line)) => {
                    lines[(episode - begin) as usize] = line;
                    done += 1;
                    // with many short episodes, signals and progress are not looked at after each
                    if done - told < 1 + count / 200 {
                        continue;
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break Ok(()),
            }
            told = done;
            let told = Python::attach(|py| {
                py.check_signals()?;
                progress.map_or(Ok(()), |progress| progress.call1(py, (done, count)).map(drop))
            });
            if let Err(error) = told {
                break Err(error);
            }
        };
        if stopped.is_err() {
            work.is_stopped.store(true, Ordering::Relaxed);
        } else if let Some(progress) = progress {
            Python::attach(|py| progress.call1(py, (done, count)))?;
        }
        stopped
    })?;
    Ok(lines)
}

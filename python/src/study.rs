//! Sweeps: the episodes of a study on all threads.

use crate::error::{StudyError, guarded, raise};
use crate::partners::{Fault, Own};
use crate::table::Table;
use cocarry::episode::Episode;
use cocarry::scenario::{PreparedScenario, ScenarioError};
use cocarry::study::{Shard, Study, columns};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
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
    fn run<'s>(&self, stage: &'s PreparedScenario) -> Result<Episode<'s>, ScenarioError> {
        let own = match self.own.is_empty() {
            true => Own::default(),
            false => Python::attach(|py| self.own.copied(py)).unwrap_or_else(|error| {
                self.fault.put(error);
                Own::default()
            }),
        };
        let mut episode = stage.episode_of(own.partners(stage, &self.fault))?;
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
            match guarded(|| self.study.row(episode, &|stage| self.run(stage))) {
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

/// The name of an own partner in results.
fn name(py: Python<'_>, object: &Py<PyAny>) -> String {
    let object = object.bind(py);
    let name = object.getattr("__name__").or_else(|_| object.get_type().getattr("__name__"));
    format!("own({})", name.map_or_else(|_| "?".to_owned(), |name| name.to_string()))
}

/// Runs the episodes of a study and returns a row for each, in the study's order.
#[pyfunction]
#[pyo3(signature = (text, *, file, folder, seeds = None, shard = None, threads = None, policy = None, human = None, progress = None))]
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
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Table> {
    let own = Own::of(policy, human)?;
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
    let count = episodes.end - episodes.start;
    let work = Work {
        study: &study,
        own: &own,
        next: AtomicU64::new(episodes.start),
        end: episodes.end,
        is_stopped: AtomicBool::new(false),
        fault: Fault::default(),
    };
    let progress = progress.map(|progress| progress.clone().unbind());
    let lines = py.detach(|| run(&work, threads, count, progress.as_ref()));
    work.fault.take()?;
    let lines = lines?;
    let mut rows = Vec::with_capacity(lines.len());
    for line in lines {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_slice());
        let row = reader.records().next().transpose().map_err(|error| raise::<StudyError>(&error))?;
        rows.push(row.iter().flatten().map(str::to_owned).collect::<Vec<_>>());
    }
    let place = |key| columns().iter().position(|(name, _)| *name == key);
    for (object, key) in [(&own.policy, "method"), (&own.human, "human_model")] {
        let Some(object) = object else { continue };
        let name = name(py, object);
        for row in &mut rows {
            // the checksum is that of the study's own row
            place("checksum").into_iter().for_each(|at| row[at].clear());
            place(key).into_iter().for_each(|at| row[at].clone_from(&name));
        }
    }
    Ok(Table::of_rows(&rows))
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

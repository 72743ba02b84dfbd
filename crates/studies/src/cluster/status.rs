//! How far the shards of a job are: what their files say, and what the scheduler knows.

use super::slurm::{self, Task};
use super::{ClusterError, Job, Progress};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// The state of a shard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShardState {
    /// Its results are complete.
    Done,
    /// Its task runs on a node.
    Running(String),
    /// Its task waits, for a reason.
    Waiting(String),
    /// Its task has ended without complete results, and why as far as it is known.
    Failed(String),
    /// It was not submitted.
    Missing,
}

/// The end of a log that is read for its last line, bytes.
const END_OF_LOG: u64 = 4096;

/// The states of all shards, in order, with their progress.
///
/// # Errors
/// [`ClusterError`], where the scheduler's commands are missing or fail, unless all shards are done.
pub fn states(job: &Job) -> Result<Vec<(ShardState, Progress)>, ClusterError> {
    let shards = 1..=job.description().shards;
    let is_submitted = !job.description().arrays.is_empty();
    // before the results are looked at, so that a task that ends in between is not called failed
    let progress =
        |shards: std::ops::RangeInclusive<u64>| shards.map(|n| job.progress(n)).collect::<Vec<_>>();
    let asks = is_submitted && progress(shards.clone()).iter().any(|progress| !progress.is_complete);
    let queue = if asks { slurm::queue(job)? } else { Default::default() };
    let ended = if asks { slurm::ended(job) } else { Default::default() };
    let state = |(number, progress): (u64, Progress)| {
        let state = match (progress.is_complete, queue.get(&number), slurm::last_array(job, number)) {
            (true, ..) => ShardState::Done,
            (_, Some(Task::Running(node)), _) => ShardState::Running(node.clone()),
            (_, Some(Task::Waiting(reason)), _) => ShardState::Waiting(reason.clone()),
            (_, _, None) => ShardState::Missing,
            (.., Some(array)) => {
                let log = job.logs().join(format!("{}_{}.log", array.id, number - array.offset));
                let account = ended.get(&number).and_then(|task| match task {
                    Task::Ended(why) => Some(why.clone()),
                    _ => None,
                });
                let why: Vec<String> = account.into_iter().chain(last_line(&log)).collect();
                let silent = "ended without a message; it may have been killed".to_owned();
                ShardState::Failed(if why.is_empty() { silent } else { why.join(": ") })
            }
        };
        (state, progress)
    };
    Ok(shards.clone().zip(progress(shards)).map(state).collect())
}

/// The last line of a log that is not empty.
fn last_line(log: &Path) -> Option<String> {
    let mut file = cocarry::located::open(log).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(END_OF_LOG))).ok()?;
    let mut bytes = Vec::new();
    file.take(END_OF_LOG).read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    text.lines().map(str::trim).rfind(|line| !line.is_empty()).map(str::to_owned)
}

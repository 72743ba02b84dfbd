//! Slurm: job arrays, and what the scheduler knows about their tasks.

use super::{Array, ClusterError, Job};
use cocarry::Error;
use cocarry::suggestion::shell_word;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Options of `sbatch` that a job sets itself.
const OWN: [&str; 6] = ["--array", "-a", "--wrap", "--parsable", "--output", "-o"];
/// The largest number of tasks of an array where the scheduler does not say; its default.
pub const MAX_TASKS: u64 = 1000;

/// The scheduler's report about a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Task {
    /// It waits, for a reason.
    Waiting(String),
    /// It runs on a node.
    Running(String),
    /// It has ended in this state, such as `TIMEOUT`.
    Ended(String),
}

/// The script of a task. Its first argument is the difference between a shard's number and the task's.
pub fn script(job: &Job, program: &Path, threads: u64) -> String {
    let name = job.results().file_stem().unwrap_or_default().to_string_lossy();
    let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    format!(
        "#!/bin/bash\n\
         # A task of a Slurm job array: one shard of {study}\n\
         #SBATCH --job-name=cocarry-{name}\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         exec {program} cluster shard {results} \"$((${{1:-0}} + SLURM_ARRAY_TASK_ID))\" \\\n    \
         --threads \"${{SLURM_CPUS_PER_TASK:-{threads}}}\"\n",
        study = job.description().study.display().to_string().replace(char::is_control, " "),
        program = shell_word(&program.display().to_string()),
        results = shell_word(&job.results().display().to_string()),
    )
}

/// The check that no option is one that the job sets.
///
/// # Errors
/// [`ClusterError`].
pub fn check_options(options: &[String]) -> Result<(), ClusterError> {
    let is_own = |option: &&String| OWN.contains(&option.split('=').next().unwrap_or_default());
    options.iter().find(is_own).map_or(Ok(()), |option| {
        let option = option.split('=').next().unwrap_or_default().to_owned();
        Err(ClusterError::set_by_cocarry(option))
    })
}

/// The arrays, without identifiers, that run these shards with at most `most` as the number of a task.
pub fn arrays(shards: &[u64], most: u64) -> Vec<Array> {
    let mut arrays: Vec<Array> = Vec::new();
    for &shard in shards {
        let offset = (shard - 1) / most * most;
        match arrays.last_mut() {
            Some(array) if array.offset == offset => match array.shards.last_mut() {
                Some([_, last]) if *last + 1 == shard => *last = shard,
                _ => array.shards.push([shard, shard]),
            },
            _ => arrays.push(Array { id: 0, offset, shards: vec![[shard, shard]] }),
        }
    }
    arrays
}

/// The words of the command that submits an array.
pub fn submission(job: &Job, array: &Array) -> Vec<String> {
    let range = |[first, last]: &[u64; 2]| match (first - array.offset, last - array.offset) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    };
    let tasks = array.shards.iter().map(range).collect::<Vec<_>>().join(",");
    let log = job.logs().join("%A_%a.log");
    let own = ["sbatch".to_owned(), "--parsable".to_owned(), format!("--array={tasks}")];
    let output = format!("--output={}", log.display());
    let script = [job.script().display().to_string(), array.offset.to_string()];
    own.into_iter().chain([output]).chain(job.description().sbatch.iter().cloned()).chain(script).collect()
}

/// Submits tasks for these shards, in as few arrays as the cluster allows. Each array is in the job's
/// description as soon as it is submitted. Returns the arrays.
///
/// # Errors
/// [`ClusterError`], where Slurm's commands are missing or refuse.
pub fn submit(job: &mut Job, shards: &[u64]) -> Result<Vec<Array>, ClusterError> {
    let mut submitted = Vec::new();
    for array in arrays(shards, most_tasks()?) {
        let said = ask("sbatch", &submission(job, &array)[1..])?;
        // the identifier, and the cluster's name after a semicolon
        let id = said.trim().split(';').next().and_then(|id| id.parse().ok());
        let id = id.ok_or_else(|| {
            ClusterError::scheduler(
                "sbatch --parsable".to_owned(),
                format!("expected the number of a job, found `{}`", said.trim()),
            )
        })?;
        let array = Array { id, ..array };
        job.add(array.clone())?;
        submitted.push(array);
    }
    Ok(submitted)
}

/// The check that Slurm answers on this machine.
///
/// # Errors
/// [`ClusterError`], where its commands are missing or fail.
pub fn check_available() -> Result<(), ClusterError> {
    most_tasks().map(drop)
}

/// The largest number that a task of an array may have on this cluster.
fn most_tasks() -> Result<u64, ClusterError> {
    let settings = said_by("scontrol", &["show", "config"])?.map_err(|said| no_cluster(&said))?;
    let line = settings.lines().find_map(|line| line.trim().strip_prefix("MaxArraySize"));
    let size = line.and_then(|rest| rest.trim_start_matches([' ', '=']).trim().parse::<u64>().ok());
    Ok(size.map_or(MAX_TASKS, |size| size.saturating_sub(1)).max(1))
}

/// The tasks of a job that wait or run, by shard.
///
/// # Errors
/// [`ClusterError`], where Slurm's commands are missing or fail.
pub fn queue(job: &Job) -> Result<BTreeMap<u64, Task>, ClusterError> {
    let said = ask("squeue", &["--noheader", "--array", "--me", "--format=%F|%K|%T|%r|%N"])?;
    Ok(said.lines().filter_map(|line| queued(job, line)).collect())
}

/// A line of the queue, if it is a task of the job.
fn queued(job: &Job, line: &str) -> Option<(u64, Task)> {
    let mut fields = line.split('|');
    let mut next = || fields.next();
    let (id, task, state, reason, node) = (next()?, next()?, next()?, next()?, next()?);
    let shard = shard(job, id, task)?;
    Some(match state {
        "RUNNING" | "COMPLETING" | "CONFIGURING" | "STAGE_OUT" => (shard, Task::Running(node.to_owned())),
        "PENDING" | "REQUEUED" | "SUSPENDED" | "REQUEUE_HOLD" | "REQUEUE_FED" | "PREEMPTED" | "STOPPED"
        | "RESIZING" | "SIGNALING" => {
            let waits = if state == "PENDING" { reason } else { state };
            (shard, Task::Waiting(waits.to_owned()))
        }
        // an ended task stays in the queue for a moment
        _ => return None,
    })
}

/// The tasks of a job that have ended, by shard, as far as the cluster keeps account of them.
pub fn ended(job: &Job) -> BTreeMap<u64, Task> {
    let ids: Vec<_> = job.description().arrays.iter().map(|array| array.id.to_string()).collect();
    if ids.is_empty() {
        return BTreeMap::new();
    }
    let ids = ids.join(",");
    let arguments =
        ["--noheader", "--allocations", "--parsable2", "--format=JobID,State,ExitCode,NodeList", "--jobs"];
    // not every cluster keeps account
    let said = ask("sacct", &[&arguments[..], &[&ids]].concat()).unwrap_or_default();
    let task = |line: &str| {
        let mut fields = line.split('|');
        let (id, task) = fields.next()?.split_once('_')?;
        let (state, exit, node) = (fields.next()?, fields.next()?, fields.next()?);
        let exit = exit.split(':').next().unwrap_or_default();
        let why = match state {
            "FAILED" => format!("exit code {exit} on {node}"),
            state => format!("{state} on {node}"),
        };
        Some((shard(job, id, task)?, Task::Ended(why)))
    };
    said.lines().filter_map(task).collect()
}

/// The shard of a task, if its array is the last one of this job that has the shard.
fn shard(job: &Job, id: &str, task: &str) -> Option<u64> {
    let (id, task): (u64, u64) = (id.parse().ok()?, task.parse().ok()?);
    let array = job.description().arrays.iter().find(|array| array.id == id)?;
    let shard = array.offset + task;
    (last_array(job, shard)?.id == id).then_some(shard)
}

/// The array in which a shard was submitted last.
pub(super) fn last_array(job: &Job, shard: u64) -> Option<&Array> {
    job.description().arrays.iter().rev().find(|array| array.has(shard))
}

/// The error that Slurm's commands are there, but no cluster; `said` is what `scontrol` printed.
fn no_cluster(said: &str) -> ClusterError {
    let why = said.lines().last().unwrap_or_default();
    let why = why.trim_start_matches("error:").trim_start_matches("fatal:").trim();
    ClusterError::Refused(Error::new(format!(
        "scontrol: no Slurm cluster answers ({why}); run this on a login node, where `scontrol ping` finds the controller that slurm.conf (or SLURM_CONF) names, or use --no-submit and submit the script yourself"
    )))
}

/// Runs a command of the scheduler. Returns what it printed.
fn ask(program: &'static str, arguments: &[impl AsRef<str>]) -> Result<String, ClusterError> {
    said_by(program, arguments)?.map_err(|said| ClusterError::scheduler(program.to_owned(), said))
}

/// Runs a command of the scheduler. Returns what it printed, or, if it failed, why.
fn said_by(
    program: &'static str,
    arguments: &[impl AsRef<str>],
) -> Result<Result<String, String>, ClusterError> {
    let output = Command::new(program).args(arguments.iter().map(AsRef::as_ref)).output();
    let output = output.map_err(|source| ClusterError::no_scheduler(program, source))?;
    if output.status.success() {
        return Ok(Ok(String::from_utf8_lossy(&output.stdout).into_owned()));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    // its name is before each line
    let line = |line: &str| line.trim().trim_start_matches(program).trim_start_matches(':').trim().to_owned();
    let lines: Vec<String> = said.lines().map(line).filter(|line| !line.is_empty()).collect();
    Ok(Err(if lines.is_empty() { output.status.to_string() } else { lines.join("\n") }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_has_no_task_beyond_the_largest_number() {
        let shards: Vec<u64> = (1..=7).filter(|n| *n != 5).collect();
        let array = |offset, shards: &[[u64; 2]]| Array { id: 0, offset, shards: shards.to_vec() };
        assert_eq!(arrays(&shards, 10), [array(0, &[[1, 4], [6, 7]])]);
        assert_eq!(
            arrays(&shards, 3),
            [array(0, &[[1, 3]]), array(3, &[[4, 4], [6, 6]]), array(6, &[[7, 7]])]
        );
        assert_eq!(arrays(&[], 3), []);
    }
}

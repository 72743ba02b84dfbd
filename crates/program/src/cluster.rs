//! `cocarry cluster`: runs a study as tasks of a cluster's scheduler, and gathers their results.

use super::interrupt::Interrupt;
use super::output::{
    Failure, Progress as Bar, counted, examples, input, print, print_json, print_message, table, table_text,
    warn,
};
use super::reproduce::Common;
use super::settings::built_in_methods;
use super::sweep::{self, print_summary};
use anyhow::Context;
use clap::{Args, Subcommand};
use cocarry::suggestion::shell_word;
use cocarry_studies::cluster::{
    self, Array, ClusterError, Description, Job, Progress, ShardState, slurm, states, with_methods,
};
use cocarry_studies::study::merge;
use serde_json::json;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Run a study on a cluster: submit its shards, follow them, and gather the results
///
/// The results are those of `cocarry sweep` on one machine, byte for byte. The commands share the folder
/// RESULTS.job next to the results, which must be on a file system that all nodes see.
#[derive(Debug, Subcommand)]
pub(super) enum Action {
    Slurm(SlurmArguments),
    Status(StatusArguments),
    Resubmit(ResubmitArguments),
    Gather(GatherArguments),
    Shard(ShardArguments),
}

/// Submit a study to Slurm as a job array, one task per shard
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry cluster slurm study.toml -o study.csv --shards 100", "a hundred tasks"),
    ("cocarry cluster slurm study.toml -o study.csv --sbatch \"--time=4:00:00 --partition=short\"", "with options of sbatch"),
    ("cocarry cluster slurm bench-1/full.toml -o full.csv --method mutual", "the benchmark with a method"),
    ("cocarry cluster slurm study.toml -o study.csv --no-submit", "only the files, to look at"),
]))]
pub(super) struct SlurmArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// File for the gathered results; FILE.job is the job's folder
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of shards, and so of tasks; at most one per episode
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    shards: u64,
    /// Threads of a task, which are the CPUs it asks for
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: u64,
    /// Method in place of the study's `methods`; may be repeated, to run all with the same humans
    #[arg(long, value_name = "WORD", value_parser = built_in_methods())]
    method: Vec<String>,
    /// Largest number of seeds of every run in the study [default: all]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    seeds: Option<u64>,
    /// Further options of sbatch, in one text; repeatable
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Write the job's folder and print the commands, but submit nothing
    #[arg(long)]
    no_submit: bool,
    /// Remove an earlier job for these results, with the results of its shards, and start again
    #[arg(long)]
    overwrite: bool,
}

/// Show which shards are done, run, wait or have failed, and why
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry cluster status study.csv", "the shards of its job")]))]
pub(super) struct StatusArguments {
    /// File given as --output
    results: PathBuf,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// Submit again the shards that have failed or were not submitted
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry cluster resubmit study.csv", "what `status` lists as failed or missing")]))]
pub(super) struct ResubmitArguments {
    /// File given as --output
    results: PathBuf,
    /// Print the commands, but submit nothing
    #[arg(long)]
    no_submit: bool,
}

/// Merge the results of all shards into one file; exit code 1 if shards are missing
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry cluster gather study.csv", "checked, and merged into study.csv"),
    ("cocarry cluster gather study.csv --audit 1", "and one percent of the episodes run again here"),
]))]
pub(super) struct GatherArguments {
    /// File given as --output
    results: PathBuf,
    /// Replace existing results
    #[arg(long)]
    overwrite: bool,
    /// Run this share (%) of the episodes of every shard again on this machine, at least one, and compare the
    /// rows; exit code 1 if one differs
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    audit: Option<f64>,
    /// Seed of the audit's sample
    #[arg(long, value_name = "SEED", default_value_t = 0, requires = "audit")]
    audit_seed: u64,
    #[command(flatten)]
    common: Common,
}

/// Run one shard of a job, or the rest of it: the command of a task
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry cluster shard study.csv 3", "the third shard, on this machine")]))]
pub(super) struct ShardArguments {
    /// File given as --output
    results: PathBuf,
    /// Number of the shard, from 1
    number: u64,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run_cluster(action: &Action) -> Result<ExitCode, Failure> {
    match action {
        Action::Slurm(arguments) => submit(arguments),
        Action::Status(arguments) => status(arguments),
        Action::Resubmit(arguments) => resubmit(arguments),
        Action::Gather(arguments) => gather(arguments),
        Action::Shard(arguments) => shard(arguments),
    }
}

fn submit(arguments: &SlurmArguments) -> Result<ExitCode, Failure> {
    let SlurmArguments {
        study: file, output: out, shards, threads, seeds, method, no_submit, overwrite, ..
    } = arguments;
    let options: Vec<String> =
        arguments.sbatch.iter().flat_map(|text| text.split_whitespace()).map(str::to_owned).collect();
    slurm::check_options(&options).map_err(failure)?;
    let seeds = seeds.and_then(NonZeroU64::new);
    let study = with_methods(file, seeds, method).map_err(|error| failure(error.into()))?;
    study.world_warnings().iter().for_each(warn);
    study.slow_drives().iter().for_each(warn);
    if *overwrite {
        refuse_queued(out)?;
    }
    if !*no_submit {
        // before the job's folder is created, and after what else may be wrong
        let outputs = cocarry_output::output_file::Outputs::new(*overwrite, [file.clone()]);
        outputs.check(out).map_err(|error| failure(error.into()))?;
        slurm::check_available().map_err(failure)?;
    }
    let program = std::env::current_exe().context("the path of this program").map_err(Failure::Output)?;
    let description = Description::of(&study, file, seeds, method.clone(), *shards, options);
    let script = |job: &Job| slurm::script(job, &program, *threads);
    let mut job = Job::create(out, description, script, *overwrite).map_err(failure)?;
    let shards: Vec<u64> = (1..=job.description().shards).collect();
    let sizes = format!(
        "{} of {}, {}\n",
        counted(study.episodes(), "episode"),
        counted(study.combinations(), "combination"),
        counted(shards.len(), "shard")
    );
    print(&format!("{}: {sizes}", job.folder().display()))?;
    send(&mut job, &shards, *no_submit)
}

/// Refuses to remove a job whose tasks are in the queue.
fn refuse_queued(out: &Path) -> Result<(), Failure> {
    let job = match Job::open(out) {
        Ok(job) if !job.description().arrays.is_empty() => job,
        _ => return Ok(()),
    };
    let tasks = slurm::queue(&job).map_err(failure)?.len();
    if tasks == 0 {
        return Ok(());
    }
    let ids: Vec<_> = job.description().arrays.iter().map(|array| array.id.to_string()).collect();
    Err(failure(ClusterError::in_queue(job.folder().to_owned(), tasks, ids.join(" "))))
}

/// Submits shards, or prints the commands.
fn send(job: &mut Job, shards: &[u64], no_submit: bool) -> Result<ExitCode, Failure> {
    let results = job.results().display().to_string();
    if no_submit {
        for array in slurm::arrays(shards, slurm::MAX_TASKS) {
            let words: Vec<String> =
                slurm::submission(job, &array).iter().map(|word| shell_word(word)).collect();
            print(&format!("{}\n", words.join(" ")))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let arrays = slurm::submit(job, shards).map_err(failure)?;
    let list = |array: &Array| format!("job {}: shards {}\n", array.id, ranges(&array.shards));
    print(&arrays.iter().map(list).collect::<String>())?;
    print(&format!("to follow it: cocarry cluster status {results}\n"))?;
    Ok(ExitCode::SUCCESS)
}

fn ranges(ranges: &[[u64; 2]]) -> String {
    let text = |[first, last]: &[u64; 2]| match first == last {
        true => first.to_string(),
        false => format!("{first} to {last}"),
    };
    ranges.iter().map(text).collect::<Vec<_>>().join(", ")
}

/// The name of a state, and remarks about it.
fn in_words(state: &ShardState) -> (&'static str, &str) {
    match state {
        ShardState::Done => ("done", ""),
        ShardState::Running(node) => ("running", node),
        ShardState::Waiting(reason) => ("waiting", reason),
        ShardState::Failed(why) => ("failed", why),
        ShardState::Missing => ("missing", "not submitted"),
    }
}

fn status(arguments: &StatusArguments) -> Result<ExitCode, Failure> {
    let job = Job::open(&arguments.results).map_err(failure)?;
    let states = states(&job).map_err(failure)?;
    let of = job.description().shards;
    if arguments.json {
        let shard = |(i, (state, progress)): (usize, &(ShardState, Progress))| {
            let (name, note) = in_words(state);
            json!({
                "shard": i + 1,
                "state": name,
                "note": note,
                "episodes_done": progress.done,
                "episodes": progress.of,
            })
        };
        let shards: Vec<_> = states.iter().enumerate().map(shard).collect();
        print_json(&json!({ "results": job.results(), "shards": shards }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let count = |name: &str| states.iter().filter(|(state, _)| in_words(state).0 == name).count();
    let counts = ["running", "waiting", "failed", "missing"].map(|name| (count(name), name));
    let counts = counts.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!(", {n} {name}"));
    let done: u64 = states.iter().map(|(_, progress)| progress.done).sum();
    let mut text = format!(
        "{}: {} of {} done{}; {done} of {}\n",
        job.results().display(),
        count("done"),
        counted(of, "shard"),
        counts.collect::<String>(),
        counted(job.description().episodes, "episode"),
    );
    let open: Vec<_> =
        states.iter().enumerate().filter(|(_, (state, _))| *state != ShardState::Done).collect();
    if !open.is_empty() {
        let mut rows = table(["shard", "state", "episodes", "of", "note"], 2);
        for (i, (state, progress)) in open {
            let (name, note) = in_words(state);
            let (done, of) = (progress.done.to_string(), progress.of.to_string());
            rows.add_row([
                format!("{}/{of_all}", i + 1, of_all = job.description().shards),
                name.to_owned(),
                done,
                of,
                note.to_owned(),
            ]);
        }
        text += &format!("\n{}", table_text(&rows));
    }
    let again = count("failed") + count("missing");
    let results = shell_word(&arguments.results.display().to_string());
    if again > 0 {
        text += &format!("to submit them again: cocarry cluster resubmit {results}\n");
    } else if count("done") as u64 == of {
        text += &format!("to merge them: cocarry cluster gather {results}\n");
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn resubmit(arguments: &ResubmitArguments) -> Result<ExitCode, Failure> {
    let mut job = Job::open(&arguments.results).map_err(failure)?;
    // a changed study would fail in every task
    job.study().map_err(failure)?;
    let states = states(&job).map_err(failure)?;
    let is_to_go = |state: &ShardState| matches!(state, ShardState::Failed(_) | ShardState::Missing);
    let shards: Vec<u64> =
        (1..).zip(&states).filter(|(_, (state, _))| is_to_go(state)).map(|(number, _)| number).collect();
    if shards.is_empty() {
        print("no shard has failed or is missing\n")?;
        return Ok(ExitCode::SUCCESS);
    }
    send(&mut job, &shards, arguments.no_submit)
}

fn gather(arguments: &GatherArguments) -> Result<ExitCode, Failure> {
    let job = Job::open(&arguments.results).map_err(failure)?;
    job.study().map_err(failure)?;
    let of = job.description().shards;
    let missing: Vec<u64> = (1..=of).filter(|&number| !job.progress(number).is_complete).collect();
    if !missing.is_empty() {
        // arrays list shards as ranges
        let listed = slurm::arrays(&missing, u64::MAX);
        let listed = listed.first().map_or(String::new(), |array| ranges(&array.shards));
        let results = shell_word(&arguments.results.display().to_string());
        print(&format!(
            "{} of {} are not complete: {listed}\nto see why: cocarry cluster status {results}\n",
            missing.len(),
            counted(of, "shard")
        ))?;
        return Ok(ExitCode::from(1));
    }
    let files: Vec<PathBuf> = (1..=of).map(|number| job.file_of(number)).collect();
    let episodes =
        merge(job.results(), &files, arguments.overwrite).map_err(|error| failure(error.into()))?;
    let title =
        format!("{}: {} of {}", job.results().display(), counted(episodes, "episode"), counted(of, "shard"));
    print_summary(job.results(), &title, arguments.common.json)?;
    match arguments.audit {
        Some(percent) => audit(&job, percent, arguments),
        None => Ok(ExitCode::SUCCESS),
    }
}

/// Runs a sample of the episodes again.
fn audit(job: &Job, percent: f64, arguments: &GatherArguments) -> Result<ExitCode, Failure> {
    let sample = cluster::sample(job, percent / 100.0, arguments.audit_seed).map_err(failure)?;
    let bar = Bar::new(sample.episodes(), "episodes run again");
    let found = arguments.common.on_threads(|| sample.compare(&|| bar.step()))?.map_err(failure)?;
    bar.finish();
    let size = sample.episodes();
    if found.is_empty() {
        print_message(&format!("audit: {} run again, all rows equal", counted(size, "episode")));
        return Ok(ExitCode::SUCCESS);
    }
    let of = job.description().shards;
    for difference in &found {
        let values = difference.row.values.iter().take(3);
        let values: Vec<_> =
            values.map(|[column, was, now]| format!("{column} is {was}, and {now} here")).collect();
        // names of nodes and values come from files
        print_message(&format!(
            "audit: episode {} of shard {}/{of}, from {}: {}",
            difference.row.episode,
            difference.shard,
            difference.node,
            values.join("; ")
        ));
    }
    print_message(&format!(
        "audit: {} of {} differ; run the shards of these nodes again",
        found.len(),
        counted(size, "episode")
    ));
    Ok(ExitCode::from(1))
}

fn shard(arguments: &ShardArguments) -> Result<ExitCode, Failure> {
    let job = Job::open(&arguments.results).map_err(failure)?;
    let (number, of) = (arguments.number, job.description().shards);
    let progress = job.progress(number);
    let node = node();
    let bar = Bar::new((progress.of - progress.done) as usize, "episodes");
    let interrupt = Interrupt::caught()?;
    let run = || job.run_shard(number, &node, &|| bar.step(), interrupt.flag());
    let done = arguments.common.on_threads(run)?;
    let before = done.map_err(failure)?;
    bar.finish();
    if arguments.common.json {
        print_json(
            &json!({ "shard": number, "shards": of, "episodes": before.of, "kept": before.done, "node": node }),
        )?;
        return Ok(ExitCode::SUCCESS);
    }
    let kept = match before {
        Progress { is_complete: true, .. } => ", complete before".to_owned(),
        Progress { done: 0, .. } => String::new(),
        Progress { done, .. } => format!(", {done} of them from an earlier run"),
    };
    print(&format!("shard {number}/{of} on {node}: {}{kept}\n", counted(before.of, "episode")))?;
    Ok(ExitCode::SUCCESS)
}

/// The name of this machine, as the scheduler or the system calls it.
fn node() -> String {
    let named = ["SLURMD_NODENAME", "HOSTNAME"].iter().find_map(|name| std::env::var(name).ok());
    let named = named.or_else(|| std::fs::read_to_string("/proc/sys/kernel/hostname").ok());
    let name = named.unwrap_or_default().split_whitespace().next().unwrap_or_default().to_owned();
    if name.is_empty() { "this machine".to_owned() } else { name }
}

fn failure(error: ClusterError) -> Failure {
    match error {
        ClusterError::Study(error) => sweep::failure(error),
        _ if error.is_about_writing() => Failure::Output(error.into()),
        _ => input(error),
    }
}

fn percent(text: &str) -> Result<f64, String> {
    let share: Option<f64> = text.trim_end_matches('%').trim().parse().ok();
    share
        .filter(|share| *share > 0.0 && *share <= 100.0)
        .ok_or_else(|| "must be a share in percent, above 0 and at most 100, such as 1".to_owned())
}

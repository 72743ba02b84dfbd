//! `cocarry sweep`: runs a study, merges the shards of a study, and prints summaries.

use super::custom::NamedPolicies;
use super::file_kind::{self, FileKind};
use super::interrupt::Interrupt;
use super::output::{
    Failure, Progress, counted, examples, input, note, print, print_json, table, table_text,
    table_with_notes, unwritten, warn,
};
use super::reproduce::Common;
use super::settings::methods;
use anyhow::Error;
use clap::Args;
use cocarry_output::output_file::Outputs;
use cocarry_studies::statistics::Estimate;
use cocarry_studies::study::{
    Comparing, Results, Shard, Study, Summary, SummaryGroup, Sweep, SweepError, SweepOutputs, complete_rows,
    merge,
};
use serde_json::json;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Run a study: every combination of worlds, methods, humans, plants and seeds, one row of results per
/// episode
///
/// The rows go to NAME.partial next to the results, which is renamed when it is complete. A sweep that was
/// stopped, by Ctrl-C or a power cut, resumes where it stopped when it is started again.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry sweep study.toml", "all episodes, into study.csv"),
    ("cocarry sweep study.toml --shard 3/16", "the third of sixteen parts, for a job array"),
    ("cocarry sweep --merge all.csv study.1-of-2.csv study.2-of-2.csv", "the parts as one file"),
    ("cocarry sweep --summary study.csv", "the tables again, without running episodes"),
]))]
pub(super) struct SweepArguments {
    /// Study file (TOML)
    #[arg(required_unless_present_any = ["merge", "summary"], conflicts_with_all = ["merge", "summary"])]
    study: Option<PathBuf>,
    /// Write the results into this file, CSV or (.parquet) Parquet [default: the study's name with .csv, or
    /// .I-of-N.csv for a shard, in the current directory]
    ///
    /// Parquet needs a program built with the feature `parquet`; the Python package includes it.
    #[arg(short, long, value_name = "FILE", conflicts_with_all = ["merge", "summary"])]
    output: Option<PathBuf>,
    /// Write every tick of every episode into this new folder, as Parquet files of 100 episodes each
    ///
    /// The columns are those of `cocarry run --ticks` with the episode, its seed and the inputs that vary.
    /// Needs the feature `parquet`, as --output.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["merge", "summary"])]
    ticks: Option<PathBuf>,
    /// Run only shard I of N, such as 3/16, for job arrays; --merge joins the shards
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with_all = ["merge", "summary"])]
    shard: Option<Shard>,
    /// Method or custom policy in place of the study's `methods`; may be repeated, to run all with the same
    /// humans
    #[arg(long, value_name = "WORD", value_parser = methods(), conflicts_with_all = ["merge", "summary"])]
    method: Vec<String>,
    /// Largest number of seeds of every run in the study [default: all]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000), conflicts_with_all = ["merge", "summary"])]
    seeds: Option<u64>,
    /// Replace existing results, and unfinished rows of another study
    #[arg(long, conflicts_with = "summary")]
    overwrite: bool,
    /// Merge the results of all shards into OUT: the same file, byte for byte, as without shards
    #[arg(long, num_args = 2.., value_names = ["OUT", "SHARD"], conflicts_with = "summary")]
    merge: Option<Vec<PathBuf>>,
    /// Print the tables of a file of results, without running episodes
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run_sweep(arguments: &SweepArguments) -> Result<ExitCode, Failure> {
    if let Some(file) = &arguments.summary {
        print_summary(file, &file.display().to_string(), arguments.common.json)?;
    } else if let Some([out, shards @ ..]) = arguments.merge.as_deref() {
        let episodes = merge(out, shards, arguments.overwrite).map_err(failure)?;
        let title = format!(
            "{}: {} of {}",
            out.display(),
            counted(episodes, "episode"),
            counted(shards.len(), "file")
        );
        print_summary(out, &title, arguments.common.json)?;
    } else if let Some(study) = &arguments.study {
        sweep(arguments, study)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn sweep(arguments: &SweepArguments, file: &Path) -> Result<(), Failure> {
    let file = &file_kind::within(file, FileKind::Study);
    let policies = NamedPolicies::new(&arguments.method);
    let study = Study::load_with(file, arguments.seeds.and_then(NonZeroU64::new), policies.partners()?);
    let study = study.map_err(|error| file_kind::refused(file, FileKind::Study, error.into()))?;
    study.world_warnings().iter().for_each(warn);
    study.human_warnings().iter().for_each(warn);
    study.slow_drives().iter().for_each(warn);
    study.robot_warnings().iter().for_each(warn);
    let out = arguments.output.clone().unwrap_or_else(|| results_of(file, arguments.shard));
    let inputs = std::iter::once(file.to_owned()).chain(study.files(file));
    Outputs::new(true, inputs).check(&out).map_err(unwritten)?;
    let is_new = arguments.overwrite || arguments.ticks.is_some();
    let complete = match is_new {
        true => None,
        false => complete_rows(&study, arguments.shard, &out),
    };
    let (kept, episodes) = match complete {
        Some(rows) => (rows, rows),
        None => run_episodes(arguments, &study, &policies, &out)?,
    };
    let mut title = format!(
        "{}: {} of {}",
        out.display(),
        counted(episodes, "episode"),
        counted(study.combinations(), "combination")
    );
    match kept {
        0 => {}
        kept if kept == episodes => title += &format!(", all {kept} of them from the earlier run"),
        kept => title += &format!(", {kept} of them from the earlier run"),
    }
    match (arguments.shard, episodes) {
        (Some(Shard { number, of }), 0) => {
            // the study has fewer episodes than shards
            note(&format_args!("shard {number}/{of} has no episode"));
            Ok(())
        }
        _ => print_summary(&out, &title, arguments.common.json),
    }
}

/// Runs the episodes that have no rows yet. Returns the number of those that had, and of all.
fn run_episodes(
    arguments: &SweepArguments,
    study: &Study,
    policies: &NamedPolicies,
    out: &Path,
) -> Result<(u64, u64), Failure> {
    let to = SweepOutputs { rows: out, ticks: arguments.ticks.as_deref(), overwrite: arguments.overwrite };
    // before the file is there: from then on a signal finds someone who says what is in it
    let interrupt = Interrupt::caught()?;
    let sweep = Sweep::open(study, arguments.shard, to).map_err(failure)?;
    let (kept, episodes) = (sweep.kept(), sweep.episodes());
    let bar = Progress::new((episodes - kept) as usize, "episodes");
    let done = arguments.common.on_threads(|| sweep.run_with(policies, &|| bar.step(), interrupt.flag()))?;
    bar.finish();
    policies.failure().map_or(Ok(()), |error| Err(input(error)))?;
    done.map_err(failure)?;
    Ok((kept, episodes))
}

/// The default file of results of a study.
fn results_of(study: &Path, shard: Option<Shard>) -> PathBuf {
    let mut name = study.file_stem().unwrap_or(study.as_os_str()).to_owned();
    if let Some(Shard { number, of }) = shard {
        name.push(format!(".{number}-of-{of}"));
    }
    name.push(".csv");
    PathBuf::from(name)
}

pub(super) fn failure(error: SweepError) -> Failure {
    match error {
        SweepError::Stopped { .. } => Failure::Interrupted(error.into()),
        _ if error.is_about_writing() => Failure::Output(error.into()),
        _ => input(error),
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parsed
        .filter(|(number, of)| (1..=*of).contains(number) && *of <= 1_000_000)
        .map(|(number, of)| Shard { number, of })
        .ok_or_else(|| "must be I/N, the I-th of N parts, with 1 <= I <= N <= 1000000".to_owned())
}

/// Prints the tables of a file of results.
pub(super) fn print_summary(file: &Path, title: &str, as_json: bool) -> Result<(), Failure> {
    let summary = Summary::load(&[Results::File(file)], &Comparing::default()).map_err(failure)?;
    summary.notes.iter().for_each(note);
    if as_json {
        let value = serde_json::to_value(&summary).map_err(|e| Failure::Output(Error::from(e)))?;
        return print_json(&json!({ "file": file.display().to_string(), "summary": value }));
    }
    let mut text = format!("{title}\n\n");
    text += &groups(&summary);
    text += &comparisons(&summary);
    print(&text)
}

/// The columns of the tables: world, method and varied inputs.
fn headings(summary: &Summary) -> Vec<String> {
    let always = ["world", "method"].into_iter().filter(|key| !summary.varied.iter().any(|v| v == key));
    always.chain(summary.named()).map(str::to_owned).collect()
}

/// The columns of what the episodes were to the human.
const HUMAN_OUTCOMES: [(&str, &str); 5] = [
    ("accumulated_subjective_cost", "J^"),
    ("final_stubbornness", "phi"),
    ("final_discomfort", "g"),
    ("share_off_preference", "off (%)"),
    ("preferred_option_switches", "switches"),
];

/// Two tables of the groups: costs, and means for the human.
fn groups(summary: &Summary) -> String {
    let keys = headings(summary);
    let outcome = |group: &SummaryGroup, key: &str| group.outcomes.get(key).cloned().flatten();
    let names = |group: &SummaryGroup| -> Vec<String> {
        keys.iter().map(|key| group.inputs.get(key).cloned().unwrap_or_default()).collect()
    };
    let has_control = summary.groups.iter().any(|g| outcome(g, "accumulated_control_cost").is_some());
    let titles = |more: &[&str]| {
        keys.iter().cloned().chain(more.iter().map(|title| (*title).to_owned())).collect::<Vec<_>>()
    };
    let controlled: &[&str] = if has_control { &["C", "std", "95 %"] } else { &[] };
    let mut costs =
        table(titles(&[&["n", "arrived", "J (m)", "std", "95 %"], controlled].concat()), keys.len());
    let mut human = table(titles(&HUMAN_OUTCOMES.map(|(_, title)| title)), keys.len());
    for group in &summary.groups {
        let mut cells = names(group);
        cells.extend([group.n.to_string(), group.arrived.to_string()]);
        cells.extend(estimate(outcome(group, "accumulated_objective_cost_m").as_ref()));
        if has_control {
            cells.extend(estimate(outcome(group, "accumulated_control_cost").as_ref()));
        }
        costs.add_row(cells);
        let mean = |(key, _): (&str, &str)| {
            let factor = if key == "share_off_preference" { 100.0 } else { 1.0 };
            outcome(group, key).map_or("-".to_owned(), |found| format!("{:.2}", factor * found.mean))
        };
        human.add_row(names(group).into_iter().chain(HUMAN_OUTCOMES.map(mean)));
    }
    format!(
        "{}Of the episodes that arrived. J: accumulated objective cost; C: control cost; std: standard deviation; 95 %: interval of the mean over humans, none where all humans make the same choices.\n\nMeans for the human\n{}J^: accumulated subjective cost; phi, g: stubbornness and discomfort in the last step; off: share of the steps on an option that the human does not prefer; switches: changes of the preferred option.\n",
        table_text(&costs),
        table_text(&human)
    )
}

/// Mean, deviation and interval.
fn estimate(estimate: Option<&Estimate>) -> [String; 3] {
    let dash = || "-".to_owned();
    match estimate {
        None => [dash(), dash(), dash()],
        Some(Estimate { mean, std, interval, .. }) => [
            format!("{mean:.2}"),
            std.map_or_else(dash, |std| format!("{std:.2}")),
            interval.map_or_else(dash, |[lower, upper]| format!("{lower:.2} to {upper:.2}")),
        ],
    }
}

fn comparisons(summary: &Summary) -> String {
    let table = summary.comparison_table(false);
    if table.rows.is_empty() { String::new() } else { format!("\n{}", table_with_notes(&table)) }
}

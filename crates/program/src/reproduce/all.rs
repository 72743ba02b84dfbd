//! `cocarry reproduce all -o FOLDER`: a report with every claim, table and picture of the paper next to
//! ours.

use super::super::output::{Failure, Progress, examples, input, print, print_json};
use super::super::report_folder::{PAGE, prepare, write};
use super::super::robot::load_robot;
use super::common::Common;
use clap::Args;
use clap::builder::PossibleValuesParser;
use cocarry_studies::report::{PARTS, Part, Plan, Report, Section};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce all -o report", "the page is report/report.html"),
    ("cocarry reproduce all -o draft --short", "a little of everything, in a minute"),
    ("cocarry reproduce all -o some --parts h1,h2", ""),
]))]
pub(in super::super) struct AllArguments {
    #[command(flatten)]
    common: Common,
    /// Write the report into this folder: report.html, report.md, a CSV file for each table, tables.csv with
    /// their checksums, figures/*.svg
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Only these parts, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = PossibleValuesParser::new(PARTS.iter().map(|part| part.id)))]
    parts: Vec<String>,
    /// Few episodes in every part: a first look in a short time
    #[arg(long)]
    short: bool,
    /// Random humans in each of the 16 cells of Table III [default: 100]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    episodes: Option<u64>,
    /// Random humans in each cell of Table III with bodies [default: 6]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    episodes_with_bodies: Option<u64>,
    /// Humans in each of 5 worlds with each of 4 methods, with bodies; and two fifths of them where they lead
    /// or change their mind [default: 100]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: Option<u64>,
    /// Humans in each of the 16 cells of Table II with bodies [default: 20]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    humans: Option<u64>,
    /// Random worlds in the search for locked cycles [default: 10000]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    worlds: Option<u64>,
    /// Random worlds in the search for locked cycles with a robot [default: 5000]
    #[arg(long, value_name = "WORLDS", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    worlds_with_robot: Option<u64>,
    /// Random worlds with bodies [default: 200]
    #[arg(long, value_name = "WORLDS", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    worlds_with_bodies: Option<u64>,
    /// Walks with bodies through each of 9 openings from each of 3 angles [default: 30]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    walks: Option<u64>,
    /// Walks with bodies through each of 16 slots with each of 5 turns [default: 2]
    #[arg(long, value_name = "WALKS", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    slot_walks: Option<u64>,
    /// Random indoor worlds in the study of starts [default: 200]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    rooms: Option<u64>,
    /// People of each of 6 kinds in each of 6 groups of worlds, about whom the robot learns [default: 200]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    people: Option<u64>,
    /// Simulated studies in each of 45 cells of the coverage of the fits; and two fifths of them for each of
    /// 3 values of c_r [default: 500]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    fits: Option<u64>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Replace an existing report in the folder; other files stay
    #[arg(long)]
    overwrite: bool,
}

pub(super) fn reproduce_all(arguments: &AllArguments) -> Result<(), Failure> {
    let folder = &arguments.output;
    prepare(folder, arguments.overwrite)?;
    let robot = load_robot(None)?;
    let mut plan = if arguments.short { Plan::short(&robot) } else { Plan::new(&robot) };
    let is_asked =
        |part: &&Part| arguments.parts.is_empty() || arguments.parts.iter().any(|id| id == part.id);
    let parts: Vec<&Part> = PARTS.iter().filter(is_asked).collect();
    let given = |to: &mut usize, count: Option<u64>| *to = count.map_or(*to, |n| n as usize);
    given(&mut plan.episodes, arguments.episodes);
    given(&mut plan.episodes_with_bodies, arguments.episodes_with_bodies);
    given(&mut plan.seeds, arguments.seeds);
    given(&mut plan.humans, arguments.humans);
    given(&mut plan.worlds, arguments.worlds);
    given(&mut plan.worlds_with_robot, arguments.worlds_with_robot);
    given(&mut plan.worlds_with_bodies, arguments.worlds_with_bodies);
    given(&mut plan.walks, arguments.walks);
    given(&mut plan.slot_walks, arguments.slot_walks);
    given(&mut plan.rooms, arguments.rooms);
    given(&mut plan.people, arguments.people);
    given(&mut plan.fits, arguments.fits);
    plan.seed = arguments.seed;

    let begun = Instant::now();
    let (sections, threads) =
        arguments.common.on_threads(|| (sections(&plan, &parts), rayon::current_num_threads()))?;
    let report = Report::new(&plan, &parts, sections.map_err(input)?);
    let made = format!(
        "Made in {:.0} s on {threads} {}.",
        begun.elapsed().as_secs_f64(),
        if threads == 1 { "thread" } else { "threads" },
    );
    let texts =
        [("report.md", report.markdown.clone()), ("tables.csv", report.index()), (PAGE, report.page(&made))];
    let files = write(folder, report.figures(), report.tables(), texts)?;
    if arguments.common.json {
        return print_json(&report_json(&report, (&plan, &parts), folder, &files));
    }
    let mut text = String::new();
    for section in &report.sections {
        let finding = &section.finding;
        text += &format!("{}: {}\n  {}\n", finding.claim, finding.verdict, finding.figures);
    }
    print(&format!(
        "{text}\n{}: {} files; open {}\n",
        folder.display(),
        files.len(),
        folder.join(PAGE).display()
    ))
}

/// Every part's section, in order.
fn sections(plan: &Plan, parts: &[&Part]) -> Result<Vec<Section>, cocarry::Error> {
    parts
        .iter()
        .map(|part| {
            let bar = Progress::new((part.episodes)(plan) + (part.studies)(plan), part.name);
            let section = (part.run)(plan, &|| bar.step());
            bar.finish();
            section
        })
        .collect()
}

/// The findings and the files written, as JSON.
fn report_json(report: &Report, (plan, parts): (&Plan, &[&Part]), folder: &Path, files: &[String]) -> Value {
    let claims = report.sections.iter().map(|section| {
        let finding = &section.finding;
        json!({ "claim": finding.claim, "verdict": finding.verdict, "figures": finding.figures })
    });
    let tables: Map<String, Value> = report.tables().map(|t| (t.name.clone(), t.json())).collect();
    json!({
        "report": folder.display().to_string(),
        "files": files,
        "episodes": parts.iter().map(|part| (part.episodes)(plan)).sum::<usize>(),
        "seed": plan.seed,
        "claims": claims.collect::<Vec<_>>(),
        "tables": tables,
    })
}

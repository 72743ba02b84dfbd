//! `cocarry reproduce`: the paper's claims and tables, the paper's figures beside ours.

mod all;
mod contacts;
mod cycles;
mod h2_physical;
mod h3;

use super::output::{Failure, Progress, input, print, print_json, table_with_notes, write_file};
use super::robot::sway;
use crate::episode::{Outcome, Settings};
use crate::paper::h2::{self, ExampleRun};
use crate::paper::{self, h1};
use crate::report::{example_picture, example_table, table_1, table_2};
use anyhow::{Context, anyhow};
use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Reproduce a table or a claim of the paper, its figures beside ours
#[derive(Debug, Subcommand)]
pub(super) enum Claim {
    /// Table I: how humans choose between the options of four environments
    H1(H1),
    /// Table II: objective cost with and without the mode transition, and the Environment 4 example
    H2(H2),
    /// Table III: control cost with and without pose optimisation, when the human leads and changes their mind
    H3(h3::Arguments),
    /// How dangerous an opening of the paper's risk S = d_r / w is: how often a team with bodies touches its sides
    Contacts(contacts::Arguments),
    /// "No locked cycles" (Sec. IV-B): random worlds and humans, each episode run to its end
    Cycles(cycles::Arguments),
    /// All of it as a report with tables and pictures: H1, H2, H3, locked cycles, and Table II with bodies
    All(all::Arguments),
}

#[derive(Args, Debug)]
pub(super) struct H1 {
    #[command(flatten)]
    common: Common,
}

#[derive(Args, Debug)]
pub(super) struct H2 {
    #[command(flatten)]
    common: Common,
    /// Seed of the twenty random humans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// What walks: `point`, as in the paper, or `rapier`: the same humans once more with bodies, beside the point
    #[arg(long, value_enum, default_value_t = TeamPlant::Point)]
    plant: TeamPlant,
    /// Humans in each cell, with --plant rapier [default: 20]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    humans: Option<u64>,
    /// How far the human's hand sways to either side with the gait, in metres, with --plant rapier [default: 0.01]
    #[arg(long, value_name = "M", value_parser = sway, allow_negative_numbers = true)]
    sway: Option<f64>,
    /// Draw the Environment 4 example (trajectories, stubbornness) into this file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["humans", "sway"])]
    svg: Option<PathBuf>,
}

/// What walks, for claims about the planning level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TeamPlant {
    /// The team is a point that walks its path exactly
    Point,
    /// Robot, object, human and obstacles as bodies
    Rapier,
}

/// What the controller acts on, for tables that need a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TablePlant {
    /// The robot moves exactly as its inputs say
    Kinematic,
    /// Robot, object, human and obstacles as bodies
    Rapier,
}

impl TablePlant {
    fn name(self) -> &'static str {
        match self {
            Self::Kinematic => "kinematic",
            Self::Rapier => "rapier",
        }
    }
}

/// What commands that run many episodes take.
#[derive(Args, Debug)]
pub(super) struct Common {
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Threads to use [default: all cores]; the figures do not depend on it
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
}

impl Common {
    /// Runs the work on as many threads as asked for.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        let threads = self.threads.map_or(0, |n| n as usize);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(pool.context("threads").map_err(Failure::Output)?.install(work))
    }
}

pub(super) fn run(claim: &Claim) -> Result<ExitCode, Failure> {
    match claim {
        Claim::H1(arguments) => run_h1(arguments),
        Claim::H2(arguments) => run_h2(arguments),
        Claim::H3(arguments) => h3::run(arguments),
        Claim::Contacts(arguments) => contacts::run(arguments),
        Claim::Cycles(arguments) => cycles::run(arguments),
        Claim::All(arguments) => all::run(arguments),
    }?;
    Ok(ExitCode::SUCCESS)
}

fn run_h1(arguments: &H1) -> Result<(), Failure> {
    let settings = Settings::default();
    let rows = h1::table(&settings.predictor).map_err(input)?;
    let (mean, worst) = h1::differences(&rows);
    if arguments.common.json {
        return print_json(&json!({
            "table": "I",
            "rows": rows,
            "mean_absolute_difference": mean,
            "largest_absolute_difference": worst,
        }));
    }
    print(&table_with_notes(&table_1(&rows)))
}

fn run_h2(arguments: &H2) -> Result<(), Failure> {
    if arguments.plant == TeamPlant::Rapier {
        return h2_physical::run(arguments);
    }
    if arguments.humans.is_some() || arguments.sway.is_some() {
        return Err(input(anyhow!("--humans and --sway are for --plant rapier")));
    }
    let settings = Settings::default();
    let bar = Progress::new(h2::EPISODES, "Table II");
    let rows = arguments
        .common
        .on_threads(|| h2::table(&settings, arguments.seed, &|| bar.step()))?
        .map_err(input)?;
    bar.finish();
    let (world, runs) = h2::example(paper::EXAMPLE_ENVIRONMENT, &settings).map_err(input)?;
    if let Some(path) = &arguments.svg {
        let svg = example_picture(&world, &runs, settings.period)
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(path, &svg)?;
    }
    if arguments.common.json {
        return print_json(&json!({
            "table": "II",
            "grid": h2::GRID,
            "samples": h2::SAMPLES,
            "seed": arguments.seed,
            "rows": rows,
            "example": runs.iter().map(example_json).collect::<Vec<_>>(),
        }));
    }
    print(&format!("{}\n{}", table_with_notes(&table_2(&rows)), table_with_notes(&example_table(&runs))))
}

fn example_json(run: &ExampleRun) -> Value {
    json!({
        "eta": run.eta,
        "paper_transition_step": run.paper.and_then(|(step, _)| step),
        "transition_step": run.summary.transition.map(|t| t.step),
        "paper_ends_on": run.paper.map(|(_, option)| option),
        "ends_on": run.ended_on,
        "accumulated_objective_cost_m": run.summary.accumulated_cost,
        "steps": run.summary.steps,
        "arrived": run.summary.outcome == Outcome::Arrived,
    })
}

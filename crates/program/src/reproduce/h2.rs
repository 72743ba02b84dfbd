//! `cocarry reproduce h2`: Table II and the Environment 4 example, with the team as a point or with bodies.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, svg_file, table_with_notes, write_file,
};
use super::super::robot::{SwayArguments, sway_of};
use super::super::settings::plants;
use super::common::Common;
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::scenario::PlantKind;
use cocarry_studies::paper;
use cocarry_studies::paper::h2::{self, ExampleRun, WithBodies};
use cocarry_studies::report::{example_picture, example_table, table_2, table_2_with_bodies};
use serde_json::{Value, json};
use std::path::PathBuf;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce h2 --svg example.svg", "Table II, and the Environment 4 example"),
    ("cocarry reproduce h2 --humans 20", "on the physical plant, with 20 random humans"),
]))]
pub(in super::super) struct H2Arguments {
    #[command(flatten)]
    common: Common,
    /// Seed of the twenty random humans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Team: `point`, as in the paper, or `rapier`, the same humans with bodies in addition to the point
    #[arg(long, default_value = "point", value_parser = plants(&[PlantKind::Point, PlantKind::Rapier]))]
    plant: PlantKind,
    /// Humans per cell, with --plant rapier [default: 20]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    humans: Option<u64>,
    #[command(flatten)]
    sway: SwayArguments,
    /// Draw the Environment 4 example (trajectories, stubbornness) into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file, conflicts_with_all = ["humans", "sway"])]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn reproduce_h2(arguments: &H2Arguments) -> Result<(), Failure> {
    if arguments.plant == PlantKind::Rapier {
        return run_with_bodies(arguments);
    }
    if arguments.humans.is_some() || arguments.sway.sway.is_some() {
        return Err(input(anyhow!("--humans and --sway need --plant rapier")));
    }
    let outputs = arguments.overwrite.outputs([], &arguments.svg)?;
    let settings = EpisodeSettings::default();
    let rows = arguments
        .common
        .with_progress(h2::EPISODES, "Table II", |on_done| h2::table(&settings, arguments.seed, on_done))?
        .map_err(input)?;
    let (world, runs) = h2::example(paper::EXAMPLE_ENVIRONMENT, &settings).map_err(input)?;
    if let Some(path) = &arguments.svg {
        let svg = example_picture(&world, &runs, settings.planning_step)
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
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

fn run_with_bodies(arguments: &H2Arguments) -> Result<(), Failure> {
    if arguments.svg.is_some() {
        return Err(input(anyhow::anyhow!("--svg needs --plant point: it draws the Environment 4 example")));
    }
    let plant = arguments.sway.plant()?;
    let humans = arguments.humans.map_or(h2::SAMPLES, |n| n as usize);
    let study =
        WithBodies { plant: &plant, settings: &EpisodeSettings::default(), humans, seed: arguments.seed };
    let rows = arguments
        .common
        .with_progress(h2::units(humans), "Table II with bodies", |on_done| study.table(on_done))?
        .map_err(input)?;
    let sway = sway_of(&plant);
    if arguments.common.json {
        return print_json(&json!({
            "table": "II",
            "plant": "rapier",
            "humans": humans,
            "seed": arguments.seed,
            "sway_m": sway,
            "rows": rows,
        }));
    }
    print(&table_with_notes(&table_2_with_bodies(&rows, humans, sway)))
}

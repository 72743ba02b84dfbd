//! `cocarry reproduce guide`: how much of the base's inputs eqs. (7) and (8) can decide with bodies.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, svg_file, table_with_notes, write_file,
};
use super::super::robot::load_robot;
use super::common::Common;
use anyhow::Context;
use clap::Args;
use cocarry::episode::Settings;
use cocarry_studies::paper::h3::guide::{Guide, Study};
use cocarry_studies::report::{guide_picture, guide_tables};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Humans in each cell, and worlds, where none are given.
const EPISODES: u64 = 3;
const WORLDS: u64 = 100;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce guide --few --episodes 1 --worlds 10", "a first look"),
]))]
pub(in super::super) struct GuideArguments {
    #[command(flatten)]
    common: Common,
    /// Random humans in each of the 16 cells of Table III
    #[arg(long, default_value_t = EPISODES, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    episodes: u64,
    /// Random walled worlds
    #[arg(long, default_value_t = WORLDS, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    worlds: u64,
    /// Compare few guides only
    #[arg(long)]
    few: bool,
    /// Seed of the humans and of the first world
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Draw arrivals and ratios into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn reproduce_guide(arguments: &GuideArguments) -> Result<(), Failure> {
    let outputs = arguments.overwrite.outputs([] as [&Path; 0], &arguments.svg)?;
    let study = Study {
        robot: &load_robot(None)?,
        settings: &Settings::default(),
        guides: if arguments.few { Guide::FEW } else { Guide::ALL },
        episodes: arguments.episodes as usize,
        worlds: arguments.worlds as usize,
        seed: arguments.seed,
    };
    let rows = arguments
        .common
        .with_progress(study.units(), "guides", |on_done| study.table(on_done))?
        .map_err(input)?;
    if let Some(path) = &arguments.svg {
        let svg =
            guide_picture(&rows).with_context(|| path.display().to_string()).map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.common.json {
        return print_json(&json!({
            "claim": "guide",
            "episodes": study.episodes,
            "worlds": study.worlds,
            "seed": study.seed,
            "rows": rows,
        }));
    }
    print(&guide_tables(&rows).map(|table| table_with_notes(&table)).join("\n"))
}

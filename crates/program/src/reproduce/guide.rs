//! `cocarry reproduce guide`: how much of the base's inputs eqs. (7) and (8) can decide with bodies.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, svg_file, table_with_notes, write_file,
};
use super::super::robot::load_robot;
use super::common::Common;
use anyhow::Context;
use clap::Args;
use cocarry::episode::Settings;
use cocarry_studies::paper::h3::EPISODES_WITH_BODIES;
use cocarry_studies::paper::h3::guide;
use cocarry_studies::report::{guide_picture, guide_table};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce guide --episodes 2", "few episodes: a first look in a short time"),
]))]
pub(in super::super) struct GuideArguments {
    #[command(flatten)]
    common: Common,
    /// Random humans in each of the 16 cells of Table III
    #[arg(long, default_value_t = EPISODES_WITH_BODIES as u64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    episodes: u64,
    /// Seed of the humans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Draw arrivals and ratios into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run(arguments: &GuideArguments) -> Result<(), Failure> {
    let outputs = arguments.overwrite.outputs([] as [&Path; 0], &arguments.svg)?;
    let (robot, settings, episodes) = (load_robot(None)?, Settings::default(), arguments.episodes as usize);
    let rows = arguments
        .common
        .with_progress(guide::episodes(episodes), "guides", |on_done| {
            guide::table(&robot, &settings, episodes, arguments.seed, on_done)
        })?
        .map_err(input)?;
    if let Some(path) = &arguments.svg {
        let svg =
            guide_picture(&rows).with_context(|| path.display().to_string()).map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.common.json {
        return print_json(&json!({
            "claim": "guide",
            "episodes": episodes,
            "seed": arguments.seed,
            "rows": rows,
        }));
    }
    print(&table_with_notes(&guide_table(&rows)))
}

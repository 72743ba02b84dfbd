//! `cocarry reproduce guide`: how much of the base's inputs eqs. (7) and (8) can decide with bodies.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, svg_file, table_with_notes, write_file,
};
use super::super::robot::load_robot;
use super::common::Common;
use anyhow::Context;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry_studies::paper::h3::guide::{Guide, GuideStudy};
use cocarry_studies::report::{guide_picture, guide_tables};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Humans in each cell, and worlds, where none are given.
const EPISODES: u64 = 3;
const WORLDS: u64 = 100;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce guide --prices 10000,100 --episodes 1 --worlds 10", "a first look"),
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
    /// Compare these prices only, separated by commas [default: eight from 10000 to 0, three widths without a
    /// price, and the kinematic plant]
    #[arg(long, value_delimiter = ',', value_name = "PRICES", value_parser = price)]
    prices: Vec<f64>,
    /// Seed of the humans and of the first world
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Draw arrivals and ratios into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// A price of the setting `guide_price`.
fn price(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(price) if (0.0..=1e6).contains(&price) => Ok(price),
        _ => Err("expected a number from 0 to 1000000".to_owned()),
    }
}

pub(super) fn reproduce_guide(arguments: &GuideArguments) -> Result<(), Failure> {
    let outputs = arguments.overwrite.outputs([] as [&Path; 0], &arguments.svg)?;
    let prices: Vec<Guide> = arguments.prices.iter().map(|price| Guide::Price { price: *price }).collect();
    let study = GuideStudy {
        robot: &load_robot(None)?,
        settings: &EpisodeSettings::default(),
        guides: if prices.is_empty() { Guide::ALL } else { &prices },
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

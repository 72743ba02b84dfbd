//! `cocarry reproduce slots`: whether a team with bodies comes through slots in thick walls.

use super::super::output::{Failure, examples, input, print, print_json, table_with_notes};
use super::super::robot::{SwayArguments, sway_of};
use super::common::Common;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry_studies::paper::slots::{DEPTHS, OFFSETS_M, SlotStudy, WALKS, WIDTHS};
use cocarry_studies::report::slot_table;
use serde_json::json;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce slots", "160 walks, in about ten seconds"),
]))]
pub(in super::super) struct SlotsArguments {
    #[command(flatten)]
    common: Common,
    /// Walks through each slot for each of five pairs of places of A and B, each with its own gait
    #[arg(long, default_value_t = WALKS as u64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    walks: u64,
    /// Seed of the first gait; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    sway: SwayArguments,
}

pub(super) fn reproduce_slots(arguments: &SlotsArguments) -> Result<(), Failure> {
    let plant = arguments.sway.plant()?;
    let settings = EpisodeSettings::default();
    let study = SlotStudy {
        plant: &plant,
        settings: &settings,
        turns: &OFFSETS_M,
        walks: arguments.walks as usize,
        seed: arguments.seed,
    };
    let rows = arguments
        .common
        .with_progress(study.units(), "walks", |on_done| study.table(on_done))?
        .map_err(input)?;
    let sway = sway_of(&plant);
    if arguments.common.json {
        return print_json(&json!({
            "claim": "slots",
            "walks": study.walks,
            "seed": study.seed,
            "sway_m": sway,
            "widths_m": WIDTHS,
            "depths_m": DEPTHS,
            "lateral_offsets_m": OFFSETS_M,
            "rows": rows,
        }));
    }
    let table = slot_table(&rows).with_note(format!("The human's hand sways by {sway} m."));
    print(&table_with_notes(&table))
}

//! `cocarry reproduce contacts`: how often a team with bodies touches the sides of an opening, against the
//! paper's risk S.

use super::super::output::{Failure, examples, input, print, print_json, table_with_notes};
use super::super::robot::{SwayArguments, sway_of};
use super::common::Common;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry_studies::paper::contacts::{ANGLES, ContactStudy, WALKS};
use cocarry_studies::report::contact_table;
use serde_json::json;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce contacts --walks 20", ""),
]))]
pub(in super::super) struct ContactsArguments {
    #[command(flatten)]
    common: Common,
    /// Walks through each opening from each of three angles, each with its own gait
    #[arg(long, default_value_t = WALKS as u64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    walks: u64,
    /// Seed of the first gait; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    sway: SwayArguments,
}

pub(super) fn reproduce_contacts(arguments: &ContactsArguments) -> Result<(), Failure> {
    let plant = arguments.sway.plant()?;
    let settings = EpisodeSettings::default();
    let study = ContactStudy {
        plant: &plant,
        settings: &settings,
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
            "claim": "contacts",
            "walks": study.walks,
            "seed": study.seed,
            "sway_m": sway,
            "angles_deg": ANGLES,
            "rows": rows,
        }));
    }
    let table = contact_table(&rows).with_note(format!("The human's hand sways by {sway} m."));
    print(&table_with_notes(&table))
}

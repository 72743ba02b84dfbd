//! `cocarry reproduce contacts`: how often a team with bodies touches the sides of an opening, against the
//! paper's risk S.

use super::super::output::{Failure, Progress, examples, input, print, print_json, table, table_text};
use super::super::robot::{SwayArguments, sway_of};
use super::common::Common;
use crate::episode::Settings;
use crate::paper::contacts::{ANGLES, ContactRow, Study, WALKS};
use clap::Args;
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

pub(super) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    let plant = arguments.sway.plant()?;
    let settings = Settings::default();
    let study =
        Study { plant: &plant, settings: &settings, walks: arguments.walks as usize, seed: arguments.seed };
    let bar = Progress::new(study.units(), "walks");
    let rows = arguments.common.on_threads(|| study.table(&|| bar.step()))?.map_err(input)?;
    bar.finish();
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
    print(&text(&rows, sway))
}

fn text(rows: &[ContactRow], sway: f64) -> String {
    let angles = ANGLES.map(|angle| format!("at {angle} deg"));
    let headings = ["risk S", "width (m)", "walks", "contact", "robot", "object", "human"].map(str::to_owned);
    let mut shown = table(headings.into_iter().chain(angles).chain(["clear (cm)".to_owned()]), 0);
    for row in rows {
        let touched: usize = row.touched.iter().sum();
        let share = |n: usize, of: usize| format!("{:.0} %", 100.0 * n as f64 / of as f64);
        let mut cells = vec![
            format!("{:.2}", row.risk),
            format!("{:.3}", row.width),
            row.walks.to_string(),
            share(touched, row.walks),
        ];
        cells.extend(row.touched.map(|n| n.to_string()));
        cells.extend(row.touched_by_angle.map(|n| share(n, row.walks / ANGLES.len())));
        cells.push(if row.free > 0 { format!("{:.1}", 100.0 * row.clearance) } else { "-".to_owned() });
        shown.add_row(cells);
    }
    let other: usize = rows.iter().map(|r| r.other).sum();
    let mut text = format!(
        "Contacts with the sides of one opening, walked through by a team with bodies whose human sways by {sway} m\n{}\
         contact: share of walks in which a body touched a side, and how often each body did first; at ... deg: start at that angle to the opening's axis;\n\
         clear: smallest clearance from a side in the walks without contact, mean.\n",
        table_text(&shown),
    );
    if other > 0 {
        text += &format!("{other} walks ended otherwise: stuck, or out of time.\n");
    }
    text
}

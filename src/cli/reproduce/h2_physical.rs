//! `cocarry reproduce h2 --plant rapier`: Table II's episodes with bodies beside those without.

use super::super::output::{Failure, Progress, input, print, print_json, table_with_notes};
use super::super::robot::{load_robot, physics};
use super::H2;
use crate::episode::Settings;
use crate::paper::h2;
use crate::paper::h2_physical::Study;
use crate::report::table_2_with_bodies;
use serde_json::json;

pub(super) fn run(arguments: &H2) -> Result<(), Failure> {
    if arguments.svg.is_some() {
        return Err(input(anyhow::anyhow!("--svg draws the example of --plant point")));
    }
    let robot = load_robot(None)?;
    let settings = Settings::default();
    let study = Study {
        robot: &robot,
        physics: physics(arguments.sway),
        episode: &settings,
        humans: arguments.humans.map_or(h2::SAMPLES, |n| n as usize),
        seed: arguments.seed,
    };
    let bar = Progress::new(study.units(), "Table II with bodies");
    let rows = arguments.common.on_threads(|| study.table(&|| bar.step()))?.map_err(input)?;
    bar.finish();
    if arguments.common.json {
        return print_json(&json!({
            "table": "II",
            "plant": "rapier",
            "humans": study.humans,
            "seed": study.seed,
            "sway_m": study.physics.human.sway_lateral,
            "rows": rows,
        }));
    }
    let sway = study.physics.human.sway_lateral;
    print(&table_with_notes(&table_2_with_bodies(&rows, study.humans, sway)))
}

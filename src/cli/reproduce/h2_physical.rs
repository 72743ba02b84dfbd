//! `cocarry reproduce h2 --plant rapier`: Table II's episodes with bodies beside those without.

use super::super::output::{Failure, Progress, input, print, print_json, table, table_text};
use super::super::robot::{load_robot, physics};
use super::H2;
use crate::episode::Settings;
use crate::experiments::h2;
use crate::experiments::h2_physical::{Row, Study};
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
    print(&text(&rows, &study))
}

fn text(rows: &[Row], study: &Study) -> String {
    let headings = [
        "environment",
        "method",
        "arrived",
        "point (m)",
        "bodies (m)",
        "ratio",
        "farthest",
        "same option",
        "transition",
        "error (mm)",
        "force (N)",
        "grip (cm)",
    ];
    let mut shown = table(headings, 2);
    for row in rows {
        shown.add_row([
            row.environment.to_string(),
            row.eta.map_or("without model".to_owned(), |eta| format!("mutual, eta {eta}")),
            format!("{} of {}", row.arrived, row.humans),
            format!("{:.1}", row.point_mean),
            format!("{:.1}", row.physical_mean),
            format!("{:.3}", row.mean_ratio),
            format!("{:.3}", row.farthest_ratio),
            row.same_option.to_string(),
            format!("±{}", row.transition_difference),
            format!("{:.1}", 1e3 * row.position_error_rms),
            format!("{:.1}", row.hand_force_rms[0]),
            format!("{:.1}", 100.0 * row.stretch),
        ]);
    }
    let lost: Vec<&str> = rows.iter().flat_map(|r| r.lost.iter().copied()).collect();
    let mut text = format!(
        "Table II with bodies: {} humans a cell, whose hands sway by {} m\n{}\
         Means are over those who arrive with bodies, without any contact. point: accumulated objective cost of a team without bodies; ratio: with over without,\n\
         human by human, mean and farthest from 1; same option: ended on it; transition: largest difference in steps; error: of the grasp, rms;\n\
         force: of the human on the object, rms; grip: how far a grip yielded at most.\n",
        study.humans,
        study.physics.human.sway_lateral,
        table_text(&shown),
    );
    if !lost.is_empty() {
        text += &format!("Not arrived: {} ({}).\n", lost.len(), lost.join(", "));
    }
    text
}

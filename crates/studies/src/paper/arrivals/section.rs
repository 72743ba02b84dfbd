//! How a team with bodies carries in all built-in worlds: arrivals, errors, grips and forces.

use crate::paper::arrivals::{ArrivalRow, ArrivalStudy};
use crate::paper::part::{Block, Finding, Part, Plan, Section, grouped, holds, none};
use crate::parallel::OnDone;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// The study of arrivals.
pub(crate) const PART: Part = Part {
    id: "arrivals",
    name: "arrivals",
    episodes: |plan| with_study(plan, |study| study.units()),
    studies: none,
    run: arrivals_section,
};

fn with_study<T>(plan: &Plan, work: impl FnOnce(&ArrivalStudy) -> T) -> T {
    let plant = &Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    work(&ArrivalStudy { plant, settings: &plan.settings, seeds: plan.seeds, seed: plan.seed })
}

fn arrivals_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let rows = with_study(plan, |study| study.table(on_done))?;
    let text = "Robot, object and human with bodies, in the four environments and the workshop. A contact with an obstacle ends an episode.";
    Ok(Section {
        title: "Bodies: arrivals, errors and forces".to_owned(),
        finding: finding(&rows),
        blocks: vec![Block::Text(text.to_owned()), Block::Table(table(&rows))],
    })
}

fn table(rows: &[ArrivalRow]) -> Table {
    let scaled = |values: [f64; 2], scale: f64, decimals: usize| Cell {
        shown: format!("{:.decimals$} to {:.decimals$}", scale * values[0], scale * values[1]),
        values: values.map(Into::into).to_vec(),
    };
    Columns::of(rows)
        .text("world", "world", |r| r.world.clone())
        .text("method", "method", |r| r.method.to_string())
        .column("eta", false, &["eta"], |r| Cell {
            shown: r.eta.map_or("-".to_owned(), |eta| eta.to_string()),
            values: vec![r.eta.into()],
        })
        .text("changes", "changes", |r| if r.has_changes { "once or twice" } else { "none" })
        .column("arrived", false, &["arrived", "episodes"], |r| Cell {
            shown: format!("{} of {}", r.arrived, r.episodes),
            values: vec![r.arrived.into(), r.episodes.into()],
        })
        .column("error (mm)", false, &["error_rms_mean_m", "error_rms_largest_m"], |r| Cell {
            shown: format!("{:.1} ({:.1})", 1e3 * r.error_rms[0], 1e3 * r.error_rms[1]),
            values: r.error_rms.map(Into::into).to_vec(),
        })
        .column("grip (cm)", false, &["largest_grip_deflection_m"], |r| Cell {
            shown: format!("{:.2}", 100.0 * r.deflection),
            values: vec![r.deflection.into()],
        })
        .column("hand (N)", false, &["hand_force_rms_least_N", "hand_force_rms_largest_N"], |r| {
            scaled(r.hand_force, 1.0, 1)
        })
        .number("peak (N)", "peak_force_N", 1, |r| r.peak_force)
        .column("above 10 Hz (N)", false, &["force_noise_least_N", "force_noise_largest_N"], |r| {
            scaled(r.force_noise, 1.0, 2)
        })
        .number("effort", "largest_effort_share", 2, |r| r.effort_share)
        .table("arrivals", "A team with bodies in all built-in worlds")
        .with_note("error: of the grasp, rms over an episode, mean (and largest) of the episodes; grip: largest deflection; hand: the human's force on the object, rms over an episode;")
        .with_note("peak: largest force in a grip; above 10 Hz: a grip's force above that, rms over an episode; effort: the most that a motor of the arm exerted, as a share of its limit.")
}

fn finding(rows: &[ArrivalRow]) -> Finding {
    let sum = |of: fn(&ArrivalRow) -> usize| rows.iter().map(of).sum::<usize>();
    let (arrived, episodes) = (sum(|r| r.arrived), sum(|r| r.episodes));
    let deflection = rows.iter().map(|r| r.deflection).fold(0.0, f64::max);
    let error = rows.iter().map(|r| r.error_rms[1]).fold(0.0, f64::max);
    Finding {
        claim: "A team with bodies arrives without touching anything (not in the paper)",
        verdict: holds(arrived, episodes, "episodes"),
        figures: format!(
            "{} of {} episodes in five worlds; grips yield by {:.2} cm at most; the error of the grasp is at most {:.1} mm (rms)",
            grouped(arrived),
            grouped(episodes),
            100.0 * deflection,
            1e3 * error
        ),
    }
}

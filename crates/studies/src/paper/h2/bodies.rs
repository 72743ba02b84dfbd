//! H2 with bodies: Table II's humans on the physical plant, compared with the point team.

use super::section::{DIFFERENCE_AXIS, method};
use crate::paper::ENVIRONMENTS;
use crate::paper::h2::{self, BodiesRow, WithBodies};
use crate::paper::pairs::{SIGNIFICANCE_LEVEL, compared, explained, is_significant};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, holds, none};
use crate::parallel::OnDone;
use crate::statistics::Estimate;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_output::drawing::{DifferencePanel, DifferenceRow, Sheet, differences};

/// Table II with bodies.
pub(crate) const PART: Part = Part {
    id: "h2-bodies",
    name: "Table II with bodies",
    episodes: |plan| 2 * h2::units(plan.humans),
    studies: none,
    run: table_2_with_bodies_section,
};

/// Table II's episodes with bodies, compared with those without.
pub fn table_2_with_bodies(rows: &[BodiesRow], humans: usize, sway: f64) -> Table {
    let columns = Columns::of(rows)
        .numbered("environment", "environment", |r| r.environment)
        .text("method", "method", |r| method(r.eta))
        .data("eta", |r| r.eta)
        .column("arrived", false, &["arrived", "humans"], |r| Cell {
            shown: format!("{} of {}", r.arrived, r.humans),
            values: vec![r.arrived.into(), r.humans.into()],
        })
        .number("point (m)", "point_mean_m", 1, |r| r.point_mean)
        .number("bodies (m)", "physical_mean_m", 1, |r| r.physical_mean);
    let against = ["against_without", "_m"];
    let table = compared(columns, "against no model (m)", against, |r| r.against_without)
        .number("ratio", "mean_ratio", 3, |r| r.mean_ratio)
        .number("farthest", "farthest_ratio", 3, |r| r.farthest_ratio)
        .count("within 5 %", "within_5_percent", |r| r.alike as u64)
        .count("same option", "same_option", |r| r.same_option as u64)
        .column("transition", false, &["transition_difference_steps"], |r| Cell {
            shown: format!("±{}", r.transition_difference),
            values: vec![r.transition_difference.into()],
        })
        .column("error (mm)", false, &["position_error_rms_m"], |r| Cell {
            shown: format!("{:.1}", 1e3 * r.position_error_rms),
            values: vec![r.position_error_rms.into()],
        })
        .column("force (N)", false, &["hand_force_rms_mean_N", "hand_force_rms_largest_N"], |r| Cell {
            shown: format!("{:.1}", r.hand_force_rms[0]),
            values: r.hand_force_rms.map(Into::into).to_vec(),
        })
        .column("grip (cm)", false, &["largest_grip_deflection_m"], |r| Cell {
            shown: format!("{:.1}", 100.0 * r.deflection),
            values: vec![r.deflection.into()],
        })
        .table(
            "table-2-bodies",
            format!("Table II with bodies: {humans} humans per cell, whose hands sway by {sway} m"),
        )
        .with_note("Means are over the humans who arrive with bodies and without any contact. point: accumulated objective cost of a team without bodies; ratio: cost with bodies over cost without,")
        .with_note("for each human, mean and value farthest from 1; within 5 %: number of such ratios; same option: humans who end on the same option; transition: largest difference in steps; error: of the grasp, rms;")
        .with_note("against no model: cost with bodies minus cost without the model, for the humans who arrive both times;")
        .with_note("force: of the human on the object, rms; grip: largest deflection of a grip.");
    let tested = rows.iter().filter_map(|r| r.against_without?.p_value).count();
    let table = explained(table, tested, "of this table");
    let lost: Vec<&str> = rows.iter().flat_map(|r| r.lost.iter().copied()).collect();
    match lost.len() {
        0 => table,
        n => table.with_note(format!("Not arrived: {n} ({}).", lost.join(", "))),
    }
}

fn table_2_with_bodies_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let study = WithBodies { plant: &plant, settings: &plan.settings, humans: plan.humans, seed: plan.seed };
    // a human's episode as a point and the one with bodies finish together
    let both = || (0..2).for_each(|_| on_done());
    let rows = study.table(&both)?;
    let text = "The paper's team is a point. Here robot, object, human and obstacles have bodies, forces and contacts.";
    let mut blocks = vec![
        Block::Text(text.to_owned()),
        Block::Table(table_2_with_bodies(
            &rows,
            study.humans,
            plant.physics().map_or(0.0, |physics| physics.human.sway_lateral),
        )),
    ];
    let panels = panels(&rows);
    if !panels.is_empty() {
        blocks.push(Block::Figure(Figure {
            name: "table-2-bodies".to_owned(),
            caption: "Table II with bodies: cost minus that of the same human without the model, of the humans who arrive both times.".to_owned(),
            is_half: false,
            svg: differences(&panels, DIFFERENCE_AXIS, Sheet::default())?,
        }));
    }
    Ok(Section { title: "H2 with bodies".to_owned(), finding: finding(&rows), blocks })
}

/// The differences, one panel for each environment.
fn panels(rows: &[BodiesRow]) -> Vec<DifferencePanel> {
    let row = |r: &BodiesRow| {
        let Estimate { mean, interval, .. } = r.against_without?.difference;
        Some(DifferenceRow { label: method(r.eta), mean, interval, ..DifferenceRow::default() })
    };
    let panel = |number: u32| DifferencePanel {
        title: format!("Environment {number}"),
        rows: rows.iter().filter(|r| r.environment == number).filter_map(row).collect(),
    };
    ENVIRONMENTS
        .iter()
        .map(|environment| panel(environment.number))
        .filter(|panel| !panel.rows.is_empty())
        .collect()
}

fn finding(rows: &[BodiesRow]) -> Finding {
    let mut without = f64::NAN;
    let (mut cells, mut cheaper) = (0, 0);
    for row in rows {
        match row.eta {
            None => without = row.physical_mean,
            Some(_) => {
                cells += 1;
                cheaper += usize::from(row.physical_mean < without);
            }
        }
    }
    let against = || rows.iter().filter_map(|r| r.against_without);
    let shown = against().filter(|p| p.difference.mean < 0.0 && is_significant(p)).count();
    let sum = |of: fn(&BodiesRow) -> usize| rows.iter().map(of).sum::<usize>();
    let ratio = rows.iter().map(|r| r.mean_ratio).sum::<f64>() / rows.len() as f64;
    Finding {
        claim: "H2, where the team has bodies (not in the paper)",
        verdict: holds(cheaper, cells, "cells"),
        figures: format!(
            "mean cost lower than without the model in {cheaper} of {cells} cells, significantly (p < {SIGNIFICANCE_LEVEL}, Holm) in {shown}; {} of {} humans arrive without touching anything, {} on the option of the point team; cost {ratio:.3} times the point team's on average over the cells",
            sum(|r| r.arrived),
            sum(|r| r.humans),
            sum(|r| r.same_option),
        ),
    }
}

//! Slots in thick walls: the part of the report.

use super::{DEPTHS, OFFSETS_M, SlotRow, SlotStudy, WIDTHS};
use crate::paper::part::{Block, Finding, Part, Plan, Section, holds, none};
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// The study of slots.
pub(crate) const PART: Part = Part {
    id: "slots",
    name: "slots",
    episodes: |plan| WIDTHS.len() * DEPTHS.len() * plan.slot_turns * plan.slot_walks,
    studies: none,
    run: slots_section,
};

fn slots_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let turns = &OFFSETS_M[..plan.slot_turns];
    let study =
        SlotStudy { plant: &plant, settings: &plan.settings, turns, walks: plan.slot_walks, seed: plan.seed };
    let rows = study.table(on_done)?;
    let text = format!(
        "A team with bodies, led by the robot, goes through slots in walls {} to {} m thick, straight or with a turn before or after.",
        DEPTHS[0],
        DEPTHS[DEPTHS.len() - 1]
    );
    Ok(Section {
        title: "Slots in thick walls".to_owned(),
        finding: finding(&rows),
        blocks: vec![Block::Text(text), Block::Table(slot_table(&rows))],
    })
}

/// The table of slots, for people and for programs.
pub fn slot_table(rows: &[SlotRow]) -> Table {
    Columns::of(rows)
        .number("width (m)", "width_m", 2, |r| r.width)
        .count("walks", "walks", |r| r.walks as u64)
        .count("arrived", "arrived", |r| r.arrived as u64)
        .count("robot", "touched_by_robot", |r| r.touched[0] as u64)
        .count("object", "touched_by_object", |r| r.touched[1] as u64)
        .count("human", "touched_by_human", |r| r.touched[2] as u64)
        .count("lost", "lost_object", |r| r.lost as u64)
        .count("other", "ended_otherwise", |r| r.other as u64)
        .table("slots", "Slots in thick walls, of a team with bodies")
        .with_note("robot, object, human: walks in which that body touched a side first; lost: the object was lost; other: stuck, or out of time.")
}

fn finding(rows: &[SlotRow]) -> Finding {
    let sum = |of: fn(&SlotRow) -> usize| rows.iter().map(of).sum::<usize>();
    let (walks, arrived) = (sum(|r| r.walks), sum(|r| r.arrived));
    Finding {
        claim: "A team with bodies comes through slots in thick walls (not in the paper)",
        verdict: holds(arrived, walks, "walks"),
        figures: format!(
            "{arrived} of {walks} arrive without contact; {} touch a side, {} lose the object",
            sum(|r| r.touched.iter().sum()),
            sum(|r| r.lost)
        ),
    }
}

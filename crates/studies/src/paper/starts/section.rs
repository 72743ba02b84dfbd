//! Starts in random rooms: the part of the report.

use super::{CLEAR_M, StartStudy, Starts};
use crate::paper::part::{Block, Finding, Part, Plan, Section, holds, none};
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// The study of starts.
pub(crate) const PART: Part = Part {
    id: "starts",
    name: "random indoor worlds",
    episodes: |plan| plan.rooms,
    studies: none,
    run: starts_section,
};

fn starts_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let study = StartStudy { plant: &plant, settings: &plan.settings, worlds: plan.rooms, seed: plan.seed };
    let starts = study.run(on_done)?;
    let text = format!(
        "Random buildings with {CLEAR_M} m clear all round A and B, in which a point reaches B. A team with bodies needs room to stand, to set out, and beyond B."
    );
    Ok(Section {
        title: "Starts in random rooms".to_owned(),
        finding: finding(&starts),
        blocks: vec![Block::Text(text), Block::Table(start_table(&starts))],
    })
}

/// The table of starts, for people and for programs.
pub fn start_table(starts: &Starts) -> Table {
    let other = |s: &Starts| (s.lost.len() - s.touched.iter().sum::<usize>()) as u64;
    Columns::of(std::slice::from_ref(starts))
        .count("worlds", "worlds", |s| s.worlds as u64)
        .count("started", "started", |s| s.started as u64)
        .count("arrived", "arrived", |s| s.arrived as u64)
        .count("robot", "touched_by_robot", |s| s.touched[0] as u64)
        .count("object", "touched_by_object", |s| s.touched[1] as u64)
        .count("human", "touched_by_human", |s| s.touched[2] as u64)
        .count("other", "ended_otherwise", other)
        .table("starts", "Starts in random rooms, of a team with bodies")
        .with_note("started: the team has room at A and B; robot, object, human: that body touched an obstacle first; other: the object was lost, or the team was stuck or out of time.")
}

fn finding(starts: &Starts) -> Finding {
    let Starts { worlds, started, arrived, touched, .. } = starts;
    Finding {
        claim: "A team with bodies starts where A and B are clear all round (not in the paper)",
        verdict: holds(*started, *worlds, "rooms"),
        figures: format!(
            "{started} of {worlds} start, {arrived} arrive; an obstacle is touched in {}",
            touched.iter().sum::<usize>()
        ),
    }
}

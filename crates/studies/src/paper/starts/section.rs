//! Starts of teams with bodies in random indoor worlds.

use crate::paper::part::{Block, Finding, Part, Plan, ReportError, Section, grouped, holds};
use crate::paper::starts::{CLEAR_M, Starts, Study};
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// The study of starts.
pub(crate) const PART: Part =
    Part { id: "starts", name: "random indoor worlds", episodes: |plan| plan.indoor_worlds, run };

fn run(plan: &Plan, on_done: OnDone) -> Result<Section, ReportError> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let study =
        Study { plant: &plant, settings: &plan.settings, worlds: plan.indoor_worlds, seed: plan.seed };
    let starts = study.run(on_done)?;
    let text = format!(
        "Random buildings with rooms, doors and furniture, in which a point reaches B and A and B have {CLEAR_M} m all round. A team with bodies starts where robot, object and \
         human have room at A and at the end of every option."
    );
    Ok(Section {
        title: "Starts in random rooms".to_owned(),
        finding: finding(&starts),
        blocks: vec![Block::Text(text), Block::Table(table(&starts))],
    })
}

fn ended_otherwise(starts: &Starts) -> u64 {
    (starts.lost.len() - starts.touched.iter().sum::<usize>()) as u64
}

fn table(starts: &Starts) -> Table {
    Columns::of(std::slice::from_ref(starts))
        .count("worlds", "worlds", |s| s.worlds as u64)
        .count("started", "started", |s| s.started as u64)
        .count("arrived", "arrived", |s| s.arrived as u64)
        .count("robot", "touched_by_robot", |s| s.touched[0] as u64)
        .count("object", "touched_by_object", |s| s.touched[1] as u64)
        .count("human", "touched_by_human", |s| s.touched[2] as u64)
        .count("other", "ended_otherwise", ended_otherwise)
        .table("starts", "Starts of a team with bodies in random indoor worlds")
        .with_note("robot, object, human: episodes in which that body touched an obstacle; other: the object was lost, or the team was stuck or out of time.")
}

fn finding(starts: &Starts) -> Finding {
    Finding {
        claim: "A team with bodies starts where A and B are in the open (not in the paper)",
        verdict: holds(starts.started, starts.worlds, "worlds"),
        figures: format!(
            "{} of {} random indoor worlds start, {} of these arrive",
            grouped(starts.started),
            grouped(starts.worlds),
            grouped(starts.arrived)
        ),
    }
}

//! "No locked cycles" (Sec. IV-B): the search for a counterexample.

use crate::paper::cycles::{Cause, Findings, SOON_STEPS, Search};
use crate::paper::part::{Block, Finding, Part, Plan, Section, grouped, holds, none};
use crate::paper::placed::Placed;
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// The search.
pub(crate) const PART: Part = Part {
    id: "cycles",
    name: "random worlds",
    episodes: |plan| plan.worlds,
    studies: none,
    run: cycles_section,
};

/// The search with a robot that follows the team.
pub(crate) const WITH_ROBOT: Part = Part {
    id: "cycles-kinematic",
    name: "random worlds with a robot",
    episodes: |plan| plan.worlds_with_robot,
    studies: none,
    run: run_with_robot,
};

/// The same worlds' kind with bodies.
pub(crate) const WITH_BODIES: Part = Part {
    id: "cycles-bodies",
    name: "random worlds with bodies",
    episodes: |plan| plan.worlds_with_bodies,
    studies: none,
    run: run_with_bodies,
};

fn run_with_bodies(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let (settings, worlds, seed) = (&plan.settings, plan.worlds_with_bodies, plan.seed);
    let search = Search { plant: &plant, settings, worlds, seed, placed: Placed::AsDrawn };
    let findings = search.run(on_done)?;
    let text = "Random worlds with room for the bodies, human and \u{3b7} as before, on the physical plant. A contact with an obstacle ends an episode.";
    Ok(Section {
        title: "Random worlds with bodies".to_owned(),
        finding: finding_with_bodies(&findings),
        blocks: vec![Block::Text(text.to_owned()), Block::Table(table_with_bodies(&findings))],
    })
}

/// Episodes that ended neither at B nor with a contact.
fn ended_otherwise(findings: &Findings) -> u64 {
    (findings.lost.len() - findings.touched.iter().sum::<usize>()) as u64
}

fn table_with_bodies(findings: &Findings) -> Table {
    Columns::of(std::slice::from_ref(findings))
        .count("worlds", "worlds", |f| f.episodes as u64)
        .count("two options or more", "with_choice", |f| f.with_choice as u64)
        .count("arrived", "arrived", |f| f.arrived as u64)
        .count("robot", "touched_by_robot", |f| f.touched[0] as u64)
        .count("object", "touched_by_object", |f| f.touched[1] as u64)
        .count("human", "touched_by_human", |f| f.touched[2] as u64)
        .count("other", "ended_otherwise", ended_otherwise)
        .number("longest / cheapest option", "longest_detour", 2, |f| f.longest_detour)
        .table("worlds-with-bodies", "Random worlds with bodies")
        .with_note("robot, object, human: episodes in which that body touched an obstacle; other: the object was lost, or the team was stuck or out of time;")
        .with_note("longest / cheapest option: as above, of the episodes that arrived.")
}

fn finding_with_bodies(findings: &Findings) -> Finding {
    let [robot, object, human] = findings.touched;
    Finding {
        claim: "A team with bodies arrives in random worlds (not in the paper)",
        verdict: holds(findings.arrived, findings.episodes, "worlds"),
        figures: format!(
            "{} of {} arrive; an obstacle is touched by the robot in {robot}, the object in {object}, the human in {human}; {} end otherwise",
            findings.arrived,
            findings.episodes,
            ended_otherwise(findings)
        ),
    }
}

fn cycles_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let (settings, worlds, seed) = (&plan.settings, plan.worlds, plan.seed);
    let search = Search { plant: &Plant::Point, settings, worlds, seed, placed: Placed::AsDrawn };
    let findings = search.run(on_done)?;
    let text = "The paper claims, without proof, that eq. (6) never makes the team alternate between options forever. Every episode has a random world, human and \u{3b7} \
                (1 to 30). It runs until the team arrives or ten times the time of the longest option has passed. A counterexample is an episode that does not \
                arrive.";
    Ok(Section {
        title: "No locked cycles".to_owned(),
        finding: finding(&findings),
        blocks: vec![
            Block::Text(text.to_owned()),
            Block::Table(table(&findings, "cycles", "The search for locked cycles")),
        ],
    })
}

fn run_with_robot(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(plan.robot));
    let (settings, worlds, seed) = (&plan.settings, plan.worlds_with_robot, plan.seed);
    let findings = Search { plant: &plant, settings, worlds, seed, placed: Placed::AsDrawn }.run(on_done)?;
    let text = format!(
        "The first of these worlds and humans again, with a robot on the kinematic plant that carries by eqs. (7) and (8). The human walks on whatever the robot does; the \
         robot may begin inside a wall behind A, and loses the object in {} episodes, which go on.",
        findings.lost_object
    );
    let claim = "Eq. (6) causes no locked cycles of a team with a robot";
    Ok(Section {
        title: "No locked cycles, with a robot".to_owned(),
        finding: Finding { claim, ..finding(&findings) },
        blocks: vec![
            Block::Text(text),
            Block::Table(table(&findings, "cycles-kinematic", "The search for locked cycles with a robot")),
        ],
    })
}

fn table(findings: &Findings, name: &str, title: &str) -> Table {
    let of =
        |cause: Cause| move |f: &Findings| f.dropped_soon.iter().filter(|d| d.cause == cause).count() as u64;
    Columns::of(std::slice::from_ref(findings))
        .count("worlds", "worlds", |f| f.episodes as u64)
        .count("two options or more", "with_choice", |f| f.with_choice as u64)
        .count("option changed in", "with_changes", |f| f.with_changes as u64)
        .count("most changes", "most_changes", |f| u64::from(f.most_changes))
        .number("longest / cheapest option", "longest_detour", 2, |f| f.longest_detour)
        .count("dropped soon", "dropped_soon", |f| f.dropped_soon.len() as u64)
        .count("object lost", "lost_object", |f| f.lost_object as u64)
        .count("counterexamples", "counterexamples", |f| f.lost.len() as u64)
        .count("phi", "dropped_by_stubbornness", of(Cause::Stubbornness))
        .count("gap", "dropped_by_opening", of(Cause::Opening))
        .count("D", "dropped_by_length", of(Cause::Length))
        .count("D^alpha", "dropped_by_perception", of(Cause::Perception))
        .table(name, title)
        .with_note("longest / cheapest option: the most steps that an episode took, over those of its cheapest option at the start;")
        .with_note(format!("dropped soon: episodes in which the same leader took up an option and dropped it again within {SOON_STEPS} steps, of these"))
        .with_note("phi: eq. (6) with phi of the step in which it was taken up keeps it; gap: a gap was crossed or left behind, which changes S;")
        .with_note("D: a length did not fall as the team walked; D^alpha: none of these, perceived lengths fall otherwise than lengths.")
}

fn finding(findings: &Findings) -> Finding {
    Finding {
        claim: "Eq. (6) causes no locked cycles",
        verdict: match holds(findings.arrived, findings.episodes, "worlds") {
            verdict if verdict == "holds" => "no counterexample".to_owned(),
            verdict => verdict,
        },
        figures: format!(
            "{} random worlds, {} with two options or more; the executed option changed in {}, at most {} times; the longest episode took {:.1} times \
             the steps of its cheapest option",
            grouped(findings.episodes),
            grouped(findings.with_choice),
            grouped(findings.with_changes),
            findings.most_changes,
            findings.longest_detour,
        ),
    }
}

//! `cocarry reproduce cycles`: random worlds and humans, by a team that is a point, or by one with bodies.

use super::super::output::{Failure, Progress, input, print, print_json, write_file};
use super::super::robot::{load_robot, physics, sway};
use super::{Common, TeamPlant};
use crate::episode::Settings;
use crate::paper::{cycles, cycles_physical};
use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(in super::super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// How many random worlds [default: 10000; with --plant rapier 200]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    worlds: Option<u64>,
    /// Seed of the first world; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// What walks: `point`, as in the paper, or `rapier`: a team with bodies, in fields with room for it
    #[arg(long, value_enum, default_value_t = TeamPlant::Point)]
    plant: TeamPlant,
    /// How far the human's hand sways to either side with the gait, in metres, with --plant rapier [default: 0.01]
    #[arg(long, value_name = "M", value_parser = sway, allow_negative_numbers = true)]
    sway: Option<f64>,
    /// Write the worlds of episodes that did not arrive into this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.keep {
        // before the work, which would be lost
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be made", folder.display()))
            .map_err(Failure::Output)?;
    }
    match arguments.plant {
        TeamPlant::Point if arguments.sway.is_some() => Err(input(anyhow!("--sway is for --plant rapier"))),
        TeamPlant::Point => run_point(arguments),
        TeamPlant::Rapier => run_bodies(arguments),
    }
}

fn run_point(arguments: &Arguments) -> Result<(), Failure> {
    let settings = Settings::default();
    let worlds = arguments.worlds.map_or(cycles::WORLDS, |n| n as usize);
    let bar = Progress::new(worlds, "random worlds");
    let findings =
        arguments.common.on_threads(|| cycles::search(worlds, arguments.seed, &settings, &|| bar.step()))?;
    bar.finish();
    if let Some(folder) = &arguments.keep {
        for found in &findings.counterexamples {
            let arguments = format!("--alpha {} --gamma {} --eta {}", found.alpha, found.gamma, found.eta);
            keep(folder, found.index, &arguments, &found.world)?;
        }
    }
    if arguments.common.json {
        return print_json(&json!(findings));
    }
    print(&point_text(&findings))
}

fn run_bodies(arguments: &Arguments) -> Result<(), Failure> {
    let robot = load_robot(None)?;
    let settings = Settings::default();
    let study = cycles_physical::Study {
        robot: &robot,
        physics: physics(arguments.sway),
        episode: &settings,
        worlds: arguments.worlds.map_or(cycles_physical::WORLDS, |n| n as usize),
        seed: arguments.seed,
    };
    let bar = Progress::new(study.worlds, "random worlds");
    let findings = arguments.common.on_threads(|| study.search(&|| bar.step()))?.map_err(input)?;
    bar.finish();
    let sway = study.physics.human.sway_lateral;
    if let Some(folder) = &arguments.keep {
        for lost in &findings.lost {
            let arguments = format!(
                "--alpha {} --gamma {} --eta {} --seed {} --sway {sway}",
                lost.alpha, lost.gamma, lost.eta, lost.index
            );
            keep(folder, lost.index, &arguments, &lost.world)?;
        }
    }
    if arguments.common.json {
        return print_json(
            &json!({ "plant": "rapier", "seed": study.seed, "sway_m": sway, "findings": findings }),
        );
    }
    print(&bodies_text(&findings, sway))
}

/// Writes a world with the command that runs its episode again.
fn keep(folder: &Path, index: u64, arguments: &str, world: &str) -> Result<(), Failure> {
    let head = format!("# cocarry run FILE {arguments}\n\n");
    write_file(&folder.join(format!("cycle-{index}.toml")), &(head + world))
}

fn point_text(findings: &cycles::Findings) -> String {
    let mut text = format!(
        "No locked cycles (Sec. IV-B): {} random worlds, {} with two options or more; the executed option changed in {}, at most {} times.\n\
         The longest episode took {:.1} times the steps of its cheapest option.\n",
        findings.episodes,
        findings.with_choice,
        findings.with_changes,
        findings.most_changes,
        findings.longest_detour,
    );
    match findings.counterexamples.as_slice() {
        [] => text += "Every episode ended at the target: no counterexample.\n",
        found => {
            let _ = writeln!(text, "{} did not arrive (see --keep):", found.len());
            for c in found {
                let _ = writeln!(
                    text,
                    "  world {}: alpha {:.4}, gamma {:.4}, eta {:.2}",
                    c.index, c.alpha, c.gamma, c.eta
                );
            }
        }
    }
    text
}

fn bodies_text(findings: &cycles_physical::Findings, sway: f64) -> String {
    let [robot, object, human] = findings.touched;
    let mut text = format!(
        "Random worlds with bodies, sway {sway} m: {} worlds, {} with two options or more; the executed option changed in {}, at most {} times.\n\
         {} arrived without touching anything, the longest after {:.1} times the steps of the cheapest option. An obstacle was touched by the robot in {robot}, \
         the object in {object}, the human in {human}; {} ended otherwise.\n",
        findings.episodes,
        findings.with_choice,
        findings.with_changes,
        findings.most_changes,
        findings.arrived,
        findings.longest_detour,
        findings.lost.len() - robot - object - human,
    );
    if !findings.lost.is_empty() {
        text += "Did not arrive (see --keep):\n";
    }
    for lost in &findings.lost {
        let what = match (&lost.contact, lost.from_target) {
            (Some(contact), Some(distance)) => {
                let [own, obstacle] = &contact.between;
                format!(
                    "the {}'s {} touched {}, {distance:.2} m from the target",
                    own.kind.name(),
                    own.name,
                    obstacle.name
                )
            }
            _ => lost.outcome.to_owned(),
        };
        let _ = writeln!(
            text,
            "  world {}: alpha {:.4}, gamma {:.4}, eta {:.2}: {what}",
            lost.index, lost.alpha, lost.gamma, lost.eta
        );
    }
    text
}

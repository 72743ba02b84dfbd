//! `cocarry reproduce cycles`: random worlds and humans, with the team as a point or with bodies.

use super::super::output::{Failure, OverwriteArguments, examples, input, print, print_json, write_file};
use super::super::robot::{SwayArguments, sway_of};
use super::super::settings::plants;
use super::common::Common;
use anyhow::{Context, anyhow};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use cocarry::episode::Settings;
use cocarry::scenario::{Plant, PlantKind};
use cocarry_output::output_file::{OutputError, Outputs};
use cocarry_studies::paper::cycles::{Findings, Search, WORLDS, WORLDS_WITH_BODIES};
use cocarry_studies::paper::placed::Placed;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce cycles --worlds 100", ""),
]))]
pub(in super::super) struct CyclesArguments {
    #[command(flatten)]
    common: Common,
    /// Number of random worlds [default: 10000; 200 with --plant rapier]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    worlds: Option<u64>,
    /// Seed of the first world; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Team: `point`, as in the paper, or `rapier`, with bodies, in worlds with room for them
    #[arg(long, default_value = "point", value_parser = plants(&[PlantKind::Point, PlantKind::Rapier]))]
    plant: PlantKind,
    /// Where the worlds lie: turned by 77.3 degrees, mirrored, or moved by kilometres, they are the same worlds
    #[arg(long, default_value = "as-drawn", value_parser = placements())]
    placed: Placed,
    #[command(flatten)]
    sway: SwayArguments,
    /// Write the worlds of episodes that did not arrive into this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// A parser of where worlds lie.
fn placements() -> impl TypedValueParser<Value = Placed> {
    let names = PossibleValuesParser::new(Placed::ALL.map(|(name, _)| name));
    let named =
        |name: &String| Placed::ALL.iter().find(|(known, _)| known == name).map(|(_, placed)| *placed);
    names.try_map(move |name| named(&name).ok_or("unknown place"))
}

pub(super) fn reproduce_cycles(arguments: &CyclesArguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.keep {
        // before the work, which would otherwise be lost
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be created", folder.display()))
            .map_err(Failure::Output)?;
        let kept = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut kept = kept.filter(|entry| entry.file_name().to_string_lossy().starts_with("cycle-"));
        if let Some(entry) = kept.next().filter(|_| !arguments.overwrite.overwrite) {
            return Err(input(OutputError::Exists { file: entry.path() }));
        }
    }
    let is_point = arguments.plant == PlantKind::Point;
    if is_point && arguments.sway.sway.is_some() {
        return Err(input(anyhow!("--sway needs --plant rapier")));
    }
    let plant = if is_point { Plant::Point } else { arguments.sway.plant()? };
    let default = if is_point { WORLDS } else { WORLDS_WITH_BODIES };
    let search = Search {
        plant: &plant,
        settings: &Settings::default(),
        worlds: arguments.worlds.map_or(default, |n| n as usize),
        seed: arguments.seed,
        placed: arguments.placed,
    };
    let findings = arguments
        .common
        .with_progress(search.worlds, "random worlds", |on_done| search.run(on_done))?
        .map_err(input)?;
    let sway = sway_of(&plant);
    if let Some(folder) = &arguments.keep {
        let outputs = Outputs::new(arguments.overwrite.overwrite, []);
        for lost in &findings.lost {
            let (plant, of_hand) =
                (plant.name(), if is_point { String::new() } else { format!(" --sway {sway}") });
            let how = format!(
                "--plant {plant} --alpha {} --gamma {} --eta {} --seed {}{of_hand}",
                lost.alpha, lost.gamma, lost.eta, lost.index
            );
            keep(&outputs, folder, lost.index, &how, &lost.world)?;
        }
    }
    if arguments.common.json {
        return print_json(&json!({
            "plant": plant.name(),
            "seed": search.seed,
            "placed": search.placed,
            "sway_m": plant.physics().map(|_| sway),
            "findings": findings,
        }));
    }
    print(&text(&findings, plant.physics().map(|_| sway)))
}

/// Writes a world with the command that runs its episode again.
fn keep(outputs: &Outputs, folder: &Path, index: u64, arguments: &str, world: &str) -> Result<(), Failure> {
    let head = format!("# cocarry run FILE {arguments}\n\n");
    write_file(outputs, &folder.join(format!("cycle-{index}.toml")), &(head + world))
}

/// The text of the findings. `sway`: the sway of the hand, m, if the team has bodies.
fn text(findings: &Findings, sway: Option<f64>) -> String {
    let Findings { episodes, with_choice, with_changes, most_changes, arrived, longest_detour, .. } =
        findings;
    let [robot, object, human] = findings.touched;
    let dropped = findings.dropped_soon.len();
    let what = match sway {
        None => "No locked cycles (Sec. IV-B):".to_owned(),
        Some(sway) => format!("Random worlds with bodies, sway {sway} m:"),
    };
    let mut text = format!(
        "{what} {episodes} random worlds, {with_choice} with two options or more; the executed option changed in {with_changes}, at most {most_changes} times;\n\
         in {dropped} the same leader took up an option and dropped it again within 5 steps.\n\
         {arrived} arrived, the longest after {longest_detour:.1} times the steps of its cheapest option.\n"
    );
    if sway.is_some() {
        let other = findings.lost.len() - robot - object - human;
        let _ = writeln!(
            text,
            "An obstacle was touched by the robot in {robot}, the object in {object}, the human in {human}; {other} ended otherwise."
        );
    }
    text += if findings.lost.is_empty() { "No counterexample.\n" } else { "Did not arrive (see --keep):\n" };
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

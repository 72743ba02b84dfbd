//! `cocarry reproduce cycles`: random worlds and humans, with the team as a point, with a robot or with bodies.

use super::super::output::{Failure, OverwriteArguments, examples, input, print, print_json, write_file};
use super::super::robot::{SwayArguments, load_robot, sway_of};
use super::super::settings::plants;
use super::common::Common;
use anyhow::{Context, anyhow};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_output::output_file::{OutputError, Outputs};
use cocarry_studies::paper::cycles::{
    Cause, Findings, Search, WORLDS, WORLDS_WITH_BODIES, WORLDS_WITH_ROBOT,
};
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
    /// Number of random worlds [default: 10000; 5000 with --plant kinematic, 200 with --plant rapier]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    worlds: Option<u64>,
    /// Seed of the first world; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Team: `point`, as in the paper; `kinematic`, with a robot that follows it, in the same worlds; or
    /// `rapier`, with bodies, in worlds with room for them
    #[arg(long, default_value = "point", value_parser = plants(&PlantKind::ALL))]
    plant: PlantKind,
    /// Where the worlds lie: turned by 77.3 degrees, mirrored, or moved by kilometres, they are the same
    /// worlds
    #[arg(long, default_value = "as-drawn", value_parser = placements())]
    placed: Placed,
    #[command(flatten)]
    sway: SwayArguments,
    /// Write the worlds of episodes that did not arrive, and of those in which an option was dropped soon,
    /// into this folder
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
            return Err(input(OutputError::exists(&entry.path())));
        }
    }
    let has_bodies = arguments.plant == PlantKind::Rapier;
    if !has_bodies && arguments.sway.sway.is_some() {
        return Err(input(anyhow!("--sway needs --plant rapier")));
    }
    let (plant, default) = match arguments.plant {
        PlantKind::Point => (Plant::Point, WORLDS),
        PlantKind::Kinematic => {
            (Plant::new(PlantKind::Kinematic, RobotSetup::new(&load_robot(None)?)), WORLDS_WITH_ROBOT)
        }
        PlantKind::Rapier => (arguments.sway.plant()?, WORLDS_WITH_BODIES),
    };
    let search = Search {
        plant: &plant,
        settings: &EpisodeSettings::default(),
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
        let how = |[alpha, gamma, eta]: [f64; 3], seed: u64| {
            let (plant, of_hand) =
                (plant.name(), if has_bodies { format!(" --sway {sway}") } else { String::new() });
            format!("--plant {plant} --alpha {alpha} --gamma {gamma} --eta {eta} --seed {seed}{of_hand}")
        };
        for lost in &findings.lost {
            let how = how([lost.alpha, lost.gamma, lost.eta], lost.index);
            keep(&outputs, folder, &format!("cycle-{}", lost.index), &how, &lost.world)?;
        }
        for dropped in &findings.dropped_soon {
            let how = how([dropped.human.alpha, dropped.human.gamma, dropped.eta], dropped.seed);
            keep(&outputs, folder, &format!("dropped-{}", dropped.seed), &how, &dropped.world)?;
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
    print(&text(&findings, arguments.plant, sway))
}

/// Writes a world with the command that runs its episode again.
fn keep(outputs: &Outputs, folder: &Path, name: &str, arguments: &str, world: &str) -> Result<(), Failure> {
    let head = format!("# cocarry run FILE {arguments}\n\n");
    write_file(outputs, &folder.join(format!("{name}.toml")), &(head + world))
}

/// The text of the findings. `sway`: the sway of the hand, m, for a team with bodies.
fn text(findings: &Findings, plant: PlantKind, sway: f64) -> String {
    let Findings { episodes, with_choice, with_changes, most_changes, arrived, longest_detour, .. } =
        findings;
    let [robot, object, human] = findings.touched;
    let dropped = findings.dropped_soon.len();
    let of = |cause: Cause| findings.dropped_soon.iter().filter(|d| d.cause == cause).count();
    let [stubbornness, opening, length, perception] = Cause::ALL.map(of);
    let what = match plant {
        PlantKind::Point => "No locked cycles (Sec. IV-B):".to_owned(),
        PlantKind::Kinematic => "No locked cycles (Sec. IV-B), with a robot:".to_owned(),
        PlantKind::Rapier => format!("Random worlds with bodies, sway {sway} m:"),
    };
    let mut text = format!(
        "{what} {episodes} random worlds, {with_choice} with two options or more; the executed option changed in {with_changes}, at most {most_changes} times;\n\
         in {dropped} the same leader took up an option and dropped it again within 5 steps (phi grew: {stubbornness}, a gap was crossed: {opening}, \
         a D did not fall as was walked: {length}, perceived lengths: {perception}).\n\
         {arrived} arrived, the longest after {longest_detour:.1} times the steps of its cheapest option.\n"
    );
    if plant == PlantKind::Rapier {
        let other = findings.lost.len() - robot - object - human;
        let _ = writeln!(
            text,
            "An obstacle was touched by the robot in {robot}, the object in {object}, the human in {human}; {other} ended otherwise."
        );
    }
    if plant == PlantKind::Kinematic {
        let _ = writeln!(
            text,
            "The robot lost the object in {}: the human walks on whatever it does, and it may begin inside a wall behind A.",
            findings.lost_object
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

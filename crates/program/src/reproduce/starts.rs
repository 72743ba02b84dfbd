//! `cocarry reproduce starts`: how often a team with bodies has room to start in random indoor worlds.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, table_with_notes, write_file,
};
use super::super::robot::{SwayArguments, sway_of};
use super::common::Common;
use anyhow::Context;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry_output::output_file::Outputs;
use cocarry_studies::paper::starts::{CLEAR_M, StartStudy, Starts, WORLDS};
use cocarry_studies::report::start_table;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce starts --worlds 10", ""),
]))]
pub(in super::super) struct StartsArguments {
    #[command(flatten)]
    common: Common,
    /// Number of random indoor worlds
    #[arg(long, default_value_t = WORLDS as u64, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    worlds: u64,
    /// Seed of the first world; the others follow it
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    sway: SwayArguments,
    /// Write the worlds in which the team is refused or does not arrive into this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn reproduce_starts(arguments: &StartsArguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.keep {
        // before the work, which would otherwise be lost
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be created", folder.display()))
            .map_err(Failure::Output)?;
    }
    let plant = arguments.sway.plant()?;
    let settings = EpisodeSettings::default();
    let study = StartStudy {
        plant: &plant,
        settings: &settings,
        worlds: arguments.worlds as usize,
        seed: arguments.seed,
    };
    let starts = arguments
        .common
        .with_progress(study.worlds, "random indoor worlds", |on_done| study.run(on_done))?
        .map_err(input)?;
    let sway = sway_of(&plant);
    if let Some(folder) = &arguments.keep {
        let outputs = Outputs::new(arguments.overwrite.overwrite, []);
        for refused in &starts.refused {
            let text = format!("# refused: {}\n\n{}", refused.reason, refused.world);
            write_file(&outputs, &folder.join(format!("refused-{}.toml", refused.seed)), &text)?;
        }
        for lost in &starts.lost {
            let text = format!(
                "# cocarry run FILE --alpha {} --gamma {} --eta {} --seed {} --sway {sway}\n\n{}",
                lost.alpha, lost.gamma, lost.eta, lost.seed, lost.world
            );
            write_file(&outputs, &folder.join(format!("lost-{}.toml", lost.seed)), &text)?;
        }
    }
    if arguments.common.json {
        return print_json(
            &json!({ "seed": study.seed, "clear_m": CLEAR_M, "sway_m": sway, "starts": starts }),
        );
    }
    print(&text(&starts, sway))
}

fn text(starts: &Starts, sway: f64) -> String {
    let note = format!(
        "Random indoor worlds in which a point reaches B, {CLEAR_M} m clear round A and B; the human's hand sways by {sway} m."
    );
    let mut text = table_with_notes(&start_table(starts).with_note(note));
    for refused in &starts.refused {
        let _ = writeln!(text, "  world {}: {}", refused.seed, refused.reason);
    }
    for lost in &starts.lost {
        let what = match &lost.contact {
            Some([own, obstacle]) => format!("{own} touches {obstacle}"),
            None => lost.outcome.to_owned(),
        };
        let _ = writeln!(
            text,
            "  world {}: alpha {:.4}, gamma {:.4}, eta {:.2}: {what} after {:.1} s",
            lost.seed, lost.alpha, lost.gamma, lost.eta, lost.time
        );
    }
    text
}

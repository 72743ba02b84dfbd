//! `cocarry reproduce h3`: Table III next to the paper's, and further measurements.

use super::super::output::{
    Failure, OverwriteArguments, examples, input, print, print_json, svg_file, table_with_notes, warn,
    write_file,
};
use super::super::robot::load_robot;
use super::super::settings::plants;
use super::common::Common;
use anyhow::Context;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry::team;
use cocarry_studies::paper::h3::{EPISODES, Human, PoseMethod, PoseRow, PoseStudy, units};
use cocarry_studies::report::{Compared, ratio_picture, table_3, table_3_ratios};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce h3 --episodes 5", "few episodes: a first look in a short time"),
]))]
pub(in super::super) struct H3Arguments {
    #[command(flatten)]
    common: Common,
    /// Plant: `kinematic`, as in the paper, or `rapier`, with bodies
    #[arg(long, default_value = "kinematic", value_parser = plants(&[PlantKind::Kinematic, PlantKind::Rapier]))]
    plant: PlantKind,
    /// Random humans in each of the 16 cells [default: 100; 20 with --plant rapier, where an episode takes
    /// fifty times as long]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    episodes: Option<u64>,
    /// Seed of the humans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Robot file (TOML), or a URDF with a robot file of the same name next to it [default: the built-in
    /// robot]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Write the humans of all cells into this CSV file: perception at the start, preference changes, and the
    /// seed and stream of the generator that drew them
    #[arg(long, value_name = "FILE")]
    humans: Option<PathBuf>,
    /// Draw all cost ratios into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn reproduce_h3(arguments: &H3Arguments) -> Result<(), Failure> {
    let files = arguments.humans.iter().chain(&arguments.svg);
    let robot = load_robot(arguments.robot.as_deref())?;
    let inputs = [&robot.texts.file, &robot.texts.urdf_file].map(Path::new);
    let outputs = arguments.overwrite.outputs(inputs, files)?;
    let settings = EpisodeSettings::default();
    let has_bodies = arguments.plant == PlantKind::Rapier;
    for posture in &robot.postures {
        team::slow_drive(&robot, &posture.joints, settings.speed, has_bodies).iter().for_each(warn);
    }
    let default = if arguments.plant == PlantKind::Rapier { EPISODES / 5 } else { EPISODES };
    let episodes = arguments.episodes.map_or(default, |n| n as usize);
    let plant = Plant::new(arguments.plant, RobotSetup::new(&robot));
    let starts: Vec<&str> = robot.postures.iter().map(|p| p.name.as_str()).collect();
    let methods = PoseMethod::on(plant.kind());
    let (starts, seed) = (&starts[..], arguments.seed);
    let study = PoseStudy { plant: &plant, starts, methods, episodes, seed, settings: &settings };
    if let Some(path) = &arguments.humans {
        let humans = study.humans().map_err(input)?;
        write_file(&outputs, path, humans_as_csv(&humans, study.seed).map_err(Failure::Output)?)?;
    }
    let rows = arguments
        .common
        .with_progress(units(methods, starts.len(), episodes), "Table III", |on_done| study.table(on_done))?
        .map_err(input)?;
    let of = |start| Compared { rows: &rows, start, methods };
    if let Some(path) = &arguments.svg {
        let svg = ratio_picture(&rows, starts)
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.common.json {
        let (table, other): (Vec<&PoseRow>, Vec<&PoseRow>) = rows.iter().partition(|r| r.start == starts[0]);
        return print_json(&json!({
            "table": "III",
            "robot": robot.name,
            "plant": arguments.plant.name(),
            "episodes": episodes,
            "seed": arguments.seed,
            "start": starts[0],
            "mean_ratio": of(starts[0]).mean_ratio(PoseMethod::WithPo),
            "rows": table,
            "rows_of_other_starts": other,
        }));
    }
    let tables =
        [table_3(of(starts[0]))].into_iter().chain(starts.iter().map(|start| table_3_ratios(of(start))));
    print(&tables.map(|table| table_with_notes(&table)).collect::<Vec<_>>().join("\n"))
}

/// The humans as CSV, one row each. Preference changes have the form of `cocarry run --change`, separated by
/// spaces.
fn humans_as_csv(humans: &[Human], seed: u64) -> Result<Vec<u8>, anyhow::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "environment",
        "setting",
        "episode",
        "seed",
        "stream",
        "gait_seed",
        "alpha",
        "gamma",
        "preference_changes",
    ])?;
    for Human { environment, setting, episode, stream, gait_seed, first, changes } in humans {
        let changes = changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let numbers = [*episode as u64, seed, *stream, *gait_seed].map(|number| number.to_string());
        let [episode, seed, stream, gait_seed] = numbers;
        writer.write_record([
            environment.to_string(),
            (*setting).to_owned(),
            episode,
            seed,
            stream,
            gait_seed,
            first.alpha.to_string(),
            first.gamma.to_string(),
            changes,
        ])?;
    }
    writer.into_inner().context("CSV")
}

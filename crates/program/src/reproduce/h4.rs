//! `cocarry reproduce h4`: whether it pays that the robot learns who it carries with.

use super::super::output::{
    Failure, OverwriteArguments, csv_file, examples, input, print, print_json, table_with_notes, write_file,
};
use super::super::robot::load_robot;
use super::common::Common;
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_studies::paper::h4::{FORGETFUL, HUMANS, LearningStudy, RATIONALITY, TASKS, WORLDS};
use cocarry_studies::report::{learning_tables, people_table};
use serde_json::json;
use std::path::PathBuf;

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce h4 --humans 5 --worlds 5", "few humans: a first look in a short time"),
]))]
pub(in super::super) struct H4Arguments {
    #[command(flatten)]
    common: Common,
    /// Humans of each of six kinds in each built-in world and in the random worlds
    #[arg(long, default_value_t = HUMANS as u64, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    humans: u64,
    /// Number of random worlds, which their humans take in turn
    #[arg(long, default_value_t = WORLDS as u64, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    worlds: u64,
    /// Tasks in a row with the same person
    #[arg(long, default_value_t = TASKS as u64, value_parser = clap::value_parser!(u64).range(1..=100))]
    tasks: u64,
    /// Seed of humans and random worlds
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write a row for every person, task and robot into this CSV file
    #[arg(long, value_name = "FILE", value_parser = csv_file)]
    rows: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn reproduce_h4(arguments: &H4Arguments) -> Result<(), Failure> {
    let outputs = arguments.overwrite.outputs([], &arguments.rows)?;
    let settings = EpisodeSettings::default();
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(&load_robot(None)?));
    let study = LearningStudy {
        settings: &settings,
        plant: &plant,
        humans: arguments.humans as usize,
        worlds: arguments.worlds as usize,
        tasks: arguments.tasks as usize,
        seed: arguments.seed,
    };
    let findings = arguments
        .common
        .with_progress(study.units(), "people", |on_done| study.run(on_done))?
        .map_err(input)?;
    if let Some(path) = &arguments.rows {
        write_file(&outputs, path, people_table(&findings.people).csv())?;
    }
    if arguments.common.json {
        let [lapse_rate, change_rate] = FORGETFUL;
        return print_json(&json!({
            "claim": "h4",
            "humans": study.humans,
            "worlds": study.worlds,
            "tasks": study.tasks,
            "seed": study.seed,
            "boltzmann_rationality": RATIONALITY,
            "forgetful": { "lapse_rate": lapse_rate, "change_rate": change_rate },
            "by_world": findings.by_world,
            "by_human": findings.by_human,
            "control": findings.control,
        }));
    }
    print(&learning_tables(&findings).map(|table| table_with_notes(&table)).join("\n"))
}

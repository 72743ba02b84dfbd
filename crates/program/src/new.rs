//! `cocarry new`: files to start from.

use super::catalog::ROBOT_URDF;
use super::export::write_all;
use super::output::{Failure, OverwriteArguments, examples, print};
use anyhow::Context;
use clap::Args;
use cocarry::suggestion::shell_word;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a commented world, robot, study and answers into a folder, to start from
///
/// The files run as they are. Their comments say what every line means; the program prints the commands to
/// try.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry new kitchen", "kitchen/world.toml, robot.toml, robot.urdf, study.toml and answers.csv"),
]))]
pub(super) struct NewArguments {
    /// Folder; it is created if it does not exist
    folder: PathBuf,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// The files' names and texts.
const FILES: [(&str, &str); 5] = [
    ("world.toml", include_str!("../../../assets/new/world.toml")),
    ("robot.toml", include_str!("../../../assets/new/robot.toml")),
    ("robot.urdf", ROBOT_URDF),
    ("study.toml", include_str!("../../../assets/new/study.toml")),
    ("answers.csv", include_str!("../../../assets/new/answers.csv")),
];

pub(super) fn run_new(arguments: &NewArguments) -> Result<ExitCode, Failure> {
    let NewArguments { folder, overwrite } = arguments;
    let files = FILES.map(|(name, text)| (folder.join(name), text));
    // before the folder is made, which has no files then
    if folder.exists() {
        overwrite.outputs([], files.iter().map(|(file, _)| file))?;
    }
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: cannot be created", folder.display()))
        .map_err(Failure::Output)?;
    write_all(*overwrite, &files)?;
    let file = |name: &str| shell_word(&folder.join(name).display().to_string());
    let [world, robot, study, answers] = ["world.toml", "robot.toml", "study.toml", "answers.csv"].map(file);
    print(&format!(
        "\nTry:\n  \
        cocarry world {world}\n  \
        cocarry run {world} --robot {robot} --render {}\n  \
        cocarry sweep {study} -o {}\n  \
        cocarry fit risk-weight {answers}\n",
        file("episode.html"),
        file("results.csv"),
    ))?;
    Ok(ExitCode::SUCCESS)
}

//! `cocarry export`: writes built-in files.

use super::catalog;
use super::output::{Failure, OverwriteArguments, examples, print, write_file};
use super::settings::named;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a built-in world, robot or study into a file of your own, to read or to change
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry export environment-4", "the world of the paper's example, as environment-4.toml"),
    ("cocarry export carrier --folder robots", "the built-in robot: robots/carrier.toml and robots/carrier.urdf"),
]))]
pub(super) struct ExportArguments {
    /// What to write. A world or study goes to NAME.toml, the robot to NAME.toml and NAME.urdf
    #[arg(value_parser = named(catalog::all().into_iter().map(|item| (item.name, item.about))))]
    name: String,
    /// Folder to write into, which must exist [default: the current directory]
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run(arguments: &ExportArguments) -> Result<ExitCode, Failure> {
    let folder = arguments.folder.clone().unwrap_or_default();
    let item = catalog::all().into_iter().find(|item| item.name == arguments.name);
    let files = item.map(|item| item.files).unwrap_or_default();
    let files: Vec<_> = files.into_iter().map(|(name, text)| (folder.join(name), text)).collect();
    write_all(arguments.overwrite, &files)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes files and prints their names. If one of them may not be written, none is.
pub(super) fn write_all(overwrite: OverwriteArguments, files: &[(PathBuf, &str)]) -> Result<(), Failure> {
    let outputs = overwrite.outputs([], files.iter().map(|(file, _)| file))?;
    for (file, text) in files {
        write_file(&outputs, file, text)?;
        print(&format!("wrote {}\n", file.display()))?;
    }
    Ok(())
}

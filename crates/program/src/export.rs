//! `cocarry export`: writes built-in files.

use super::catalog;
use super::output::{Failure, OverwriteArguments, examples, input, print, print_for_programs, unwritten};
use super::settings::named;
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry_output::output_file::OutputFile;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write a built-in world, robot or study into a file, to read or to change
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry export environment-4", "the world of the paper's example, as environment-4.toml"),
    ("cocarry export carrier -o robots", "the built-in robot: robots/carrier.toml and robots/carrier.urdf"),
    ("cocarry export environment-4 -", "the same on standard output"),
    ("cocarry export porter", "a robot with meshes: porter.toml, porter.urdf and the folder porter"),
]))]
pub(super) struct ExportArguments {
    /// What to write. A world or study goes to NAME.toml; a robot to NAME.toml, NAME.urdf and its meshes
    /// to the folder NAME
    #[arg(value_parser = named(catalog::all().into_iter().map(|item| (item.name, item.about))))]
    name: String,
    /// `-` prints the file on standard output, of a robot its robot file
    #[arg(value_name = "-", value_parser = ["-"], hide_possible_values = true, conflicts_with = "output")]
    stdout: Option<String>,
    /// Folder to write into, which must exist [default: the current directory]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_export(arguments: &ExportArguments) -> Result<ExitCode, Failure> {
    let folder = arguments.output.clone().unwrap_or_default();
    let item = catalog::all().into_iter().find(|item| item.name == arguments.name);
    let files = item.expect("the command line takes names of the catalog only").files;
    if arguments.stdout.is_some() {
        let (_, text) = files.first().expect("every item of the catalog has a file");
        print_for_programs(&String::from_utf8_lossy(text))?;
        return Ok(ExitCode::SUCCESS);
    }
    let files: Vec<_> = files.into_iter().map(|(name, bytes)| (folder.join(name), bytes)).collect();
    // before the folder of meshes is made, which has no files then
    let has_folder = |file: &&PathBuf| file.parent().is_none_or(|parent| parent == folder || parent.is_dir());
    arguments.overwrite.outputs([], files.iter().map(|(file, _)| file).filter(has_folder))?;
    let parents = files.iter().filter_map(|(file, _)| file.parent());
    let made = match parents.filter(|parent| **parent != *folder).find(|parent| !parent.is_dir()) {
        Some(meshes) => Some(made(meshes)?),
        None => None,
    };
    let written = write_all(arguments.overwrite, &files);
    if let (Err(_), Some(made)) = (&written, made) {
        // stays if there is anything in it
        let _ = std::fs::remove_dir(made);
    }
    written?;
    Ok(ExitCode::SUCCESS)
}

/// A new folder for meshes.
fn made(folder: &Path) -> Result<&Path, Failure> {
    if folder.symlink_metadata().is_ok() {
        return Err(input(anyhow!(
            "{}: exists and is not a folder; choose another --output",
            folder.display()
        )));
    }
    let made =
        std::fs::create_dir(folder).with_context(|| format!("{}: cannot be created", folder.display()));
    made.map(|()| folder).map_err(Failure::Output)
}

/// Writes files and prints their names. All are complete before the first gets its name; if one of them may
/// not be written, none is.
pub(super) fn write_all(
    overwrite: OverwriteArguments,
    files: &[(PathBuf, impl AsRef<[u8]>)],
) -> Result<(), Failure> {
    let outputs = overwrite.outputs([], files.iter().map(|(file, _)| file))?;
    let begun: Result<Vec<OutputFile>, _> =
        files.iter().map(|(file, contents)| outputs.begin(file, contents)).collect();
    for (output, (file, _)) in begun.map_err(unwritten)?.into_iter().zip(files) {
        output.finish().map_err(unwritten)?;
        print(&format!("wrote {}\n", file.display()))?;
    }
    Ok(())
}

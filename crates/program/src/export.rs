//! `cocarry export`: writes built-in files.

use super::catalog;
use super::mjcf::export_mjcf;
use super::output::{
    Failure, OverwriteArguments, csv_file, examples, input, print, print_for_programs, unwritten, xml_file,
};
use super::scenario::TeamArguments;
use super::settings::named;
use anyhow::{Context, anyhow};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, Args, Command};
use cocarry_output::output_file::OutputFile;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write a built-in world, robot or study into a file, or a scenario for MuJoCo
#[derive(Args, Debug)]
#[command(mut_args = of_mjcf, after_help = examples(&[
    ("cocarry export environment-4", "the world of the paper's example, as environment-4.toml"),
    ("cocarry export carrier -o robots", "the built-in robot: robots/carrier.toml and robots/carrier.urdf"),
    ("cocarry export environment-4 -", "the same on standard output"),
    ("cocarry export porter", "a robot with meshes: porter.toml, porter.urdf and the folder porter"),
    ("cocarry export environment-2 --mjcf scene.xml", "robot, object, human and obstacles for MuJoCo"),
    ("cocarry export environment-2 --mjcf scene.xml --motors motors.csv", "and the controls of an episode"),
]))]
pub(super) struct ExportArguments {
    /// What to write. A world or study goes to NAME.toml; a robot to NAME.toml, NAME.urdf and its meshes
    /// to the folder NAME. With --mjcf, a built-in world or a world file
    #[arg(value_parser = Names)]
    name: String,
    /// `-` prints the file on standard output, of a robot its robot file
    #[arg(value_name = "-", value_parser = ["-"], hide_possible_values = true, conflicts_with = "output")]
    stdout: Option<String>,
    /// Folder to write into, which must exist [default: the current directory]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
    /// Write robot, object, grips, hand, torso and obstacles of a scenario in this world as MuJoCo's MJCF.
    /// Takes the scenario's options of `cocarry run`, such as --seed, --robot, --posture and
    /// --gripper-stiffness
    #[arg(long, value_name = "FILE", value_parser = xml_file, conflicts_with_all = ["stdout", "output"], help_heading = MUJOCO)]
    pub mjcf: Option<PathBuf>,
    /// Run the episode, and write for every physics step its time, the controls of the file's actuators, the
    /// poses of hand, torso and object, and the forces of both grips
    #[arg(long, value_name = "FILE", value_parser = csv_file, help_heading = MUJOCO)]
    pub motors: Option<PathBuf>,
    #[command(flatten)]
    pub team: TeamArguments,
}

impl ExportArguments {
    /// The world of `--mjcf`.
    pub fn world(&self) -> &Path {
        Path::new(&self.name)
    }

    /// Whether files that exist may be replaced.
    pub fn overwrite(&self) -> OverwriteArguments {
        self.overwrite
    }
}

/// The heading of the options about MuJoCo.
const MUJOCO: &str = "MuJoCo";
/// The arguments that do not need `--mjcf`.
const WITHOUT_MJCF: [&str; 5] = ["name", "stdout", "output", "overwrite", "mjcf"];

/// The options of a scenario that the help shows; the others are those of `cocarry run`.
const SHOWN: [&str; 4] = ["motors", "seed", "robot", "posture"];

/// An argument that needs `--mjcf`, unless it is one of the others.
fn of_mjcf(argument: Arg) -> Arg {
    let name = argument.get_id().as_str();
    if WITHOUT_MJCF.contains(&name) {
        return argument;
    }
    let is_shown = SHOWN.contains(&name);
    let argument = argument.requires("mjcf");
    if is_shown { argument } else { argument.hide(true) }
}

/// A parser of names of the catalog and of files.
#[derive(Clone)]
struct Names;

impl Names {
    fn of_catalog() -> PossibleValuesParser {
        named(catalog::all().into_iter().map(|item| (item.name, item.about)))
    }
}

impl TypedValueParser for Names {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        let file = Path::new(value);
        match value.to_str() {
            Some(name) if file.extension().is_some() || file.exists() => Ok(name.to_owned()),
            _ => Self::of_catalog().parse_ref(command, argument, value),
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = Self::of_catalog().possible_values()?.collect::<Vec<_>>();
        Some(Box::new(values.into_iter()))
    }
}

pub(super) fn run_export(arguments: &ExportArguments) -> Result<ExitCode, Failure> {
    if let Some(file) = &arguments.mjcf {
        return export_mjcf(arguments, file);
    }
    let folder = arguments.output.clone().unwrap_or_default();
    let item = catalog::all().into_iter().find(|item| item.name == arguments.name);
    let Some(files) = item.map(|item| item.files) else {
        return Err(input(anyhow!(
            "{}: not the name of a built-in world, robot or study, which `cocarry export` writes; a world file needs --mjcf FILE.xml",
            arguments.name
        )));
    };
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
    write_silently(overwrite, files)?;
    files.iter().try_for_each(|(file, _)| print(&format!("wrote {}\n", file.display())))
}

/// The same without a word.
pub(super) fn write_silently(
    overwrite: OverwriteArguments,
    files: &[(PathBuf, impl AsRef<[u8]>)],
) -> Result<(), Failure> {
    let outputs = overwrite.outputs([], files.iter().map(|(file, _)| file))?;
    let begun: Result<Vec<OutputFile>, _> =
        files.iter().map(|(file, contents)| outputs.begin(file, contents)).collect();
    begun.map_err(unwritten)?.into_iter().try_for_each(|output| output.finish().map_err(unwritten))
}

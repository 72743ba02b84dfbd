//! `cocarry cite`: the bibliography of what an episode used.

mod reference;
mod works;

use super::catalog_robots::ROBOTS;
use super::output::{
    Failure, OverwriteArguments, examples, input, note, print, print_for_programs, write_file,
};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use cocarry::scenario::Scenario;
use cocarry_recording::recording::{Entry, METADATA, Reader, VERSION, scenario};
use reference::Reference;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use works::{Origin, WORKS};

/// Print the bibliography entries of what an episode used: the paper, this program, the physics, the solver and
/// the models of choice; without a recording, of paper and program
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry cite", "the paper and this program, as BibTeX"),
    ("cocarry cite run.mcap -o run.bib", "all that this episode used"),
    ("cocarry cite run.mcap --format text", "the same to read"),
]))]
pub(super) struct CiteArguments {
    /// Recording (MCAP) of the episode
    #[arg(value_name = "RUN")]
    run: Option<PathBuf>,
    /// Format of the entries
    #[arg(long, value_enum, default_value_t = Format::Bibtex)]
    format: Format,
    /// Write the entries into this file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For LaTeX: the entries' keys and fields, with the reason for each as a comment
    Bibtex,
    /// CSL-JSON, for Zotero, pandoc and other programs
    Csl,
    /// One paragraph for each, to read
    Text,
}

impl Format {
    fn text(self, references: &[Reference]) -> String {
        match self {
            Self::Bibtex => references.iter().map(Reference::bibtex).collect::<Vec<_>>().join("\n"),
            Self::Csl => {
                let entries: serde_json::Value = references.iter().map(Reference::csl).collect();
                format!("{entries:#}\n")
            }
            Self::Text => references.iter().map(Reference::text).collect(),
        }
    }
}

pub(super) fn run_cite(arguments: &CiteArguments) -> Result<ExitCode, Failure> {
    let CiteArguments { run, format, output, overwrite } = arguments;
    let outputs = overwrite.outputs(run.as_deref(), output)?;
    let (scenario, origin) = match run {
        Some(file) => {
            let scenario = scenario(&mut Reader::open(file).map_err(input)?).map_err(input)?;
            (Some(scenario), Origin::of_recording(recorded_version(file)?))
        }
        None => (None, Origin::of_program()),
    };
    let used = WORKS.iter().filter(|work| scenario.as_ref().map_or(work.is_general, work.is_used));
    let references: Vec<Reference> = used.map(|work| (work.reference)(&origin)).collect();
    origin.notes().iter().for_each(note);
    scenario.as_ref().and_then(unknown_robot).iter().for_each(note);
    let text = format.text(&references);
    match (output, format) {
        (Some(file), _) => {
            write_file(&outputs, file, &text)?;
            print(&format!("wrote {}\n", file.display()))?;
        }
        (None, Format::Text) => print(&text)?,
        (None, Format::Bibtex | Format::Csl) => print_for_programs(&text)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The version of the program that wrote a recording; `None` if the recording does not name it.
fn recorded_version(file: &Path) -> Result<Option<String>, Failure> {
    let mut reader = Reader::open(file).map_err(input)?;
    let version = loop {
        match reader.next().map_err(input)? {
            Some(Entry::Metadata { name, mut entries }) if name == METADATA => break entries.remove(VERSION),
            Some(Entry::Message(_)) | None => break None,
            Some(_) => {}
        }
    };
    let is_version = |text: &String| {
        let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+');
        text.len() <= 100 && text.starts_with(|c: char| c.is_ascii_digit()) && text.chars().all(is_part)
    };
    match version.as_ref().filter(|version| !is_version(version)) {
        Some(version) => Err(input(anyhow!(
            "{}: {VERSION} in its metadata is `{version}`; expected a version such as {}",
            file.display(),
            env!("CARGO_PKG_VERSION")
        ))),
        None => Ok(version),
    }
}

/// A note about a robot of others, whose source a recording does not name.
fn unknown_robot(scenario: &Scenario) -> Option<String> {
    let robot = scenario.plant.robot_setup()?.robot.texts();
    let is_ours = ROBOTS.iter().flat_map(|ours| ours.files).any(|(_, bytes)| *bytes == robot.urdf.as_bytes());
    (!is_ours).then(|| {
        format!(
            "{} is not a built-in robot, and a recording does not name its source: cite whoever published {}",
            robot.file, robot.urdf_file
        )
    })
}

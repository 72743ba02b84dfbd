//! `cocarry recover`: saves the intact messages of a damaged recording as a valid one.

use super::output::{Failure, OverwriteArguments, counted, examples, input, print};
use super::record::output;
use clap::Args;
use cocarry_recording::recording::{Reader, RecoverError, recover};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Save the intact messages of an incomplete or damaged recording
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry recover run.mcap.partial -o run.mcap", "what a run that crashed has recorded"),
]))]
pub(super) struct RecoverArguments {
    /// Recording (MCAP), usually named NAME.mcap.partial
    file: PathBuf,
    /// Write the recovered recording into this file
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// The largest number of faults that are listed.
const LISTED_FAULTS: usize = 10;

pub(super) fn run_recover(arguments: &RecoverArguments) -> Result<ExitCode, Failure> {
    let OverwriteArguments { overwrite } = arguments.overwrite;
    arguments.overwrite.outputs([arguments.file.as_path()], [&arguments.output])?;
    let mut reader = Reader::open(&arguments.file).map_err(input)?;
    let saved = recover(&mut reader, &arguments.output, overwrite).map_err(|error| match error {
        RecoverError::Read(error) => input(error),
        RecoverError::Write(error) => output(error),
    })?;
    let mut text = format!(
        "{}: {} saved, up to {:.1} s\n",
        arguments.output.display(),
        counted(saved.messages, "message"),
        saved.until as f64 / 1e9
    );
    if saved.lost.is_empty() {
        text += "nothing is lost: the recording is complete\n";
    }
    for fault in saved.lost.iter().take(LISTED_FAULTS) {
        let _ = writeln!(text, "lost: {fault}");
    }
    if saved.lost.len() > LISTED_FAULTS {
        let _ = writeln!(text, "lost: {} more", saved.lost.len() - LISTED_FAULTS);
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

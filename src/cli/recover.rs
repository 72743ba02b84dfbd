//! `cocarry recover`: makes a valid recording of what is whole in a damaged one.

use super::output::{Failure, OverwriteArguments, input, print};
use super::record::output;
use crate::recording::{Reader, RecoverError, recover};
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Save what is whole in a recording that was cut or damaged
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// The recording, mostly called .mcap.partial
    file: PathBuf,
    /// Where to save it
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Faults that are told one by one.
const TOLD: usize = 10;

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let OverwriteArguments { overwrite } = arguments.overwrite;
    arguments.overwrite.outputs([arguments.file.as_path()], [&arguments.output])?;
    let mut reader = Reader::open(&arguments.file).map_err(input)?;
    let saved = recover(&mut reader, &arguments.output, overwrite).map_err(|error| match error {
        RecoverError::Read(error) => input(error),
        RecoverError::Write(error) => output(error),
    })?;
    let mut text = format!(
        "{}: {} messages saved, up to {:.1} s\n",
        arguments.output.display(),
        saved.messages,
        saved.until as f64 / 1e9
    );
    if saved.lost.is_empty() {
        text += "nothing is lost: the recording is whole\n";
    }
    for fault in saved.lost.iter().take(TOLD) {
        let _ = writeln!(text, "lost: {fault}");
    }
    if saved.lost.len() > TOLD {
        let _ = writeln!(text, "lost: {} more", saved.lost.len() - TOLD);
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

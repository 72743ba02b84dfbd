//! `cocarry replay`: a recording in; whether the same run gives the same messages again out.

use super::output::{Failure, input, print};
use crate::recording::{Reader, Verdict, replay, scenario};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run a recording again from what is inside it, and compare every message
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// The recording
    file: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let open = || Reader::open(&arguments.file).map_err(input);
    let period = scenario(&mut open()?).map_err(input)?.settings.period;
    let replayed = replay(open()?, open()?).map_err(input)?;
    let file = arguments.file.display();
    let so_far = format!("{} messages, up to {:.1} s", replayed.same, replayed.until as f64 / 1e9);
    match &replayed.verdict {
        Verdict::Identical => print(&format!("{file}: identical: {so_far}\n"))?,
        Verdict::IdenticalUntilCut => {
            print(&format!("{file}: identical as far as it goes: {so_far}; it was cut there\n"))?;
        }
        Verdict::Different(difference) => {
            let seconds = difference.time as f64 / 1e9;
            print(&format!(
                "{file}: differs at {seconds:.1} s (tick {:.0}), on {}, in {}\n  recorded: {}\n  run again: {}\n\
                 identical before that: {so_far}\n",
                (seconds / period).floor(),
                difference.topic,
                difference.field,
                difference.recorded,
                difference.expected
            ))?;
            return Ok(ExitCode::from(1));
        }
    }
    Ok(ExitCode::SUCCESS)
}

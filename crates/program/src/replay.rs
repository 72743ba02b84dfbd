//! `cocarry replay`: runs a recording's scenario again and compares the messages.

use super::output::{Failure, counted, examples, input, print_verdict};
use clap::Args;
use cocarry::arithmetic;
use cocarry_recording::recording::{Reader, Verdict, replay};
use std::path::PathBuf;
use std::process::ExitCode;

/// Run the scenario of a recording again, and compare every message
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry replay run.mcap", "runs the episode again, and compares every message"),
]))]
pub(super) struct ReplayArguments {
    /// Recording (MCAP)
    file: PathBuf,
}

pub(super) fn run_replay(arguments: &ReplayArguments) -> Result<ExitCode, Failure> {
    let open = || Reader::open(&arguments.file).map_err(input);
    let replayed = replay(open()?, open()?).map_err(input)?;
    let file = arguments.file.display();
    let ours = arithmetic::stamp();
    let other = match replayed.arithmetic.as_deref() {
        Some(theirs) if theirs == ours => String::new(),
        Some(theirs) => format!(
            "recorded with arithmetic {theirs}, run again with {ours}: the last bits of their results differ\n"
        ),
        None => "the recording does not name its arithmetic: an older version wrote it\n".to_owned(),
    };
    let so_far = format!("{}, up to {:.1} s", counted(replayed.same, "message"), replayed.until as f64 / 1e9);
    match &replayed.verdict {
        Verdict::Identical => print_verdict(&format!("{file}: identical: {so_far}\n{other}"), true)?,
        Verdict::IdenticalUntilCut => print_verdict(
            &format!("{file}: identical until its end: {so_far}; the recording is incomplete\n{other}"),
            true,
        )?,
        Verdict::Different(difference) => {
            let at = replayed.step.map_or("before the first tick".to_owned(), |k| format!("in tick {k}"));
            let text = format!(
                "{file}: differs {at}, at {:.1} s, on {}, in {}\n  recorded: {}\n  run again: {}\nidentical before that: {so_far}\n{other}",
                difference.time as f64 / 1e9,
                difference.topic,
                difference.field,
                difference.recorded,
                difference.expected
            );
            print_verdict(&text, false)?;
            return Ok(ExitCode::from(1));
        }
    }
    Ok(ExitCode::SUCCESS)
}

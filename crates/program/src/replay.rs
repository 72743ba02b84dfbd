//! `cocarry replay`: runs the scenario of a recording, or of a log from the page, again, and compares.

use super::output::{
    Failure, OverwriteArguments, counted, examples, has_extension, input, mcap_file, print_json,
    print_verdict,
};
use super::replay_log::run_log;
use anyhow::anyhow;
use clap::Args;
use cocarry::arithmetic;
use cocarry_recording::recording::{Reader, Verdict, replay};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run the scenario of a recording again, and compare every message; or that of a log from the page of `cocarry
/// demo`, and compare the digests of its state
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry replay run.mcap", "runs the episode again, and compares every message"),
    ("cocarry replay carry.json --record carry.mcap", "an episode that you steered in the page, as a recording"),
]))]
pub(super) struct ReplayArguments {
    /// Recording (MCAP), or log of an episode from the page (JSON)
    pub file: PathBuf,
    /// Record the episode of a log into this MCAP file
    #[arg(long, value_name = "FILE", value_parser = mcap_file)]
    pub record: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub overwrite: OverwriteArguments,
}

pub(super) fn run_replay(arguments: &ReplayArguments) -> Result<ExitCode, Failure> {
    if has_extension(&arguments.file, "json") {
        return run_log(arguments);
    }
    if arguments.record.is_some() {
        let file = arguments.file.display();
        return Err(input(anyhow!("--record: {file} is a recording already; --record is for logs (.json)")));
    }
    let open = || Reader::open(&arguments.file).map_err(input);
    let replayed = replay(open()?, open()?).map_err(input)?;
    let file = arguments.file.display();
    let ours = arithmetic::stamp();
    if arguments.json {
        let (verdict, difference) = match &replayed.verdict {
            Verdict::Identical => ("identical", None),
            Verdict::IdenticalUntilCut => ("identical-until-cut", None),
            Verdict::Different(difference) => ("different", Some(difference)),
        };
        print_json(&json!({
            "file": file.to_string(),
            "verdict": verdict,
            "same_messages": replayed.same,
            "until_s": replayed.until as f64 / 1e9,
            "arithmetic": { "recorded": replayed.arithmetic, "here": ours },
            "difference": difference.map(|difference| json!({
                "step": replayed.step,
                "time_s": difference.time as f64 / 1e9,
                "topic": difference.topic,
                "field": difference.field,
                "recorded": difference.recorded,
                "run_again": difference.expected,
            })),
        }))?;
        return Ok(if difference.is_some() { ExitCode::from(1) } else { ExitCode::SUCCESS });
    }
    let other = match replayed.arithmetic.as_deref() {
        Some(theirs) if theirs == ours => String::new(),
        Some(theirs) => format!(
            "recorded with arithmetic {theirs}, run again with {ours}: the last bits of their results may differ\n"
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

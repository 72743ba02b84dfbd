//! `cocarry replay LOG.json`: runs the episode of a log from the page again, and compares the digests of its
//! state.

use super::output::{Failure, counted, input, print_json, print_verdict};
use super::record::output;
use super::replay::ReplayArguments;
use anyhow::Context;
use cocarry::arithmetic;
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, Outcome};
use cocarry::geometry::Point;
use cocarry::options::{Crossing, OptionSet};
use cocarry::scenario::{EpisodeLog, PreparedScenario};
use cocarry::{bounds, located};
use cocarry_recording::recording::{Ending, FileRecorder};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

pub(super) fn run_log(arguments: &ReplayArguments) -> Result<ExitCode, Failure> {
    let name = arguments.file.display().to_string();
    arguments.overwrite.outputs([arguments.file.as_path()], &arguments.record)?;
    let log = load(&arguments.file).map_err(Failure::Input)?;
    let record = arguments.record.as_deref().map(|file| (file, arguments.overwrite.overwrite));
    let Replayed { same, difference, steps, seconds, .. } = replayed(&log, &name, record)?;
    let ours = arithmetic::stamp();
    if arguments.json {
        print_json(&json!({
            "file": name,
            "verdict": if difference.is_none() { "identical" } else { "different" },
            "same_digests": same,
            "until_s": seconds,
            "arithmetic": { "recorded": log.arithmetic, "here": ours },
            "difference": difference.as_ref().map(|difference| json!({ "step": steps, "digest": difference })),
        }))?;
        return Ok(if difference.is_some() { ExitCode::from(1) } else { ExitCode::SUCCESS });
    }
    let other = match &*log.arithmetic {
        theirs if theirs.is_empty() || theirs == ours => String::new(),
        theirs => format!(
            "logged with arithmetic {theirs}, run again with {ours}: the last bits of their results may differ\n"
        ),
    };
    let so_far = format!("{}, up to {seconds:.1} s", counted(same, "digest"));
    match difference {
        None => print_verdict(&format!("{name}: identical: {so_far}\n{other}"), true)?,
        Some(difference) => {
            let text = format!(
                "{name}: differs after {}: {difference}\nidentical before that: {so_far}\n{other}",
                counted(steps, "step")
            );
            print_verdict(&text, false)?;
            return Ok(ExitCode::from(1));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// A log that was run again.
#[cfg_attr(
    not(feature = "people"),
    allow(dead_code, reason = "tables of studies with people have all of it")
)]
pub(super) struct Replayed {
    /// The number of digests that are equal.
    pub same: u64,
    /// The first difference.
    pub difference: Option<String>,
    /// The number of steps until then, or to the end, and their time, s.
    pub steps: u64,
    pub seconds: f64,
    pub outcome: Option<Outcome>,
    /// The time at which the human first led, and the time during which the human led, s.
    pub human_led_from: Option<f64>,
    pub human_led: f64,
    /// How often the lead changed.
    pub transitions: u64,
    /// Length of the path walked, m.
    pub walked: f64,
    /// Mean force of the human's hand, and the largest in either grip, N; `None` without physics.
    pub forces: Option<[f64; 2]>,
    /// The option that was executed at the end.
    pub option: String,
    /// The options through whose openings the team went.
    pub ways: Vec<String>,
}

/// Runs the episode of a log, called `name` in errors, until it ends or differs; `record` is the recording to
/// write, and whether it may replace a file.
pub(super) fn replayed(
    log: &EpisodeLog,
    name: &str,
    record: Option<(&Path, bool)>,
) -> Result<Replayed, Failure> {
    let prepared = log.checked(name).and_then(|scenario| scenario.prepare()).map_err(input)?;
    let partners = log.decisions.clone().partners(&prepared);
    let mut episode = prepared.episode_of(partners).map_err(input)?;
    let recorder = record.map(|(file, overwrite)| {
        let recorder = FileRecorder::create(file, overwrite, &prepared, &episode).map_err(output)?;
        Ok::<_, Failure>(recorder.logging(log.decisions.begun()))
    });
    let mut recorder = recorder.transpose()?;
    let mut difference = None;
    let mut digests = log.digests.iter().peekable();
    let mut same = 0_u64;
    let (mut human_led_from, mut human_led_steps, mut transitions) = (None, 0_u64, 0);
    let mut lead = None;
    let mut crossed = Vec::new();
    let mut position = episode.position();
    while episode.summary().steps < log.steps && difference.is_none() && episode.step().is_none() {
        if let Some(recorder) = &mut recorder {
            recorder.step(&episode).map_err(output)?;
        }
        if episode.tick().mode == Mode::HumanLed {
            human_led_from.get_or_insert(episode.tick().time);
            human_led_steps += 1;
        }
        let mode = episode.tick().mode;
        transitions += u64::from(lead.replace(mode).is_some_and(|before| before != mode));
        go_through(prepared.options(), &mut crossed, position, episode.position());
        position = episode.position();
        let steps = episode.summary().steps;
        while let Some((_, logged)) = digests.next_if(|(at, _)| *at <= steps) {
            let digest = format!("{:016x}", episode.state().digest());
            match *logged == digest {
                true => same += 1,
                false => difference = Some(format!("logged {logged}, run again {digest}")),
            }
        }
    }
    let outcome = episode.ended();
    if let Some(recorder) = recorder {
        recorder.finish(&episode, outcome.map_or(Ending::Interrupted, Ending::Over)).map_err(output)?;
    }
    let difference = difference.or_else(|| ends_otherwise(log, &episode, outcome));
    let option = prepared.options().options()[episode.tick().executed].name.clone();
    let (steps, seconds) = (episode.summary().steps, seconds(&prepared, &episode));
    let ways = ways(prepared.options(), &crossed, outcome == Some(Outcome::Arrived));
    let human_led = human_led_steps as f64 * prepared.scenario().settings.planning_step;
    let (walked, felt) = (episode.summary().walked, episode.summary().interaction.as_ref());
    let forces = felt.map(|felt| [felt.mean_force(), felt.peak_force]);
    Ok(Replayed {
        same,
        difference,
        steps,
        seconds,
        outcome,
        human_led_from,
        human_led,
        transitions,
        walked,
        forces,
        option,
        ways,
    })
}

/// Adds the openings that a step goes through; one that is gone through back again is not counted.
fn go_through(options: &OptionSet, crossed: &mut Vec<Crossing>, from: Point, to: Point) {
    for crossing in options.crossings(from, to) {
        match crossed.last() == Some(&crossing.back()) {
            true => drop(crossed.pop()),
            false => crossed.push(crossing),
        }
    }
}

/// The options with these openings in this order: all of theirs after an arrival, else their first ones. None
/// of a team that has not left the first room.
fn ways(options: &OptionSet, crossed: &[Crossing], has_arrived: bool) -> Vec<String> {
    let fits = |theirs: &[Crossing]| match has_arrived {
        true => theirs == crossed,
        false => !crossed.is_empty() && theirs.starts_with(crossed),
    };
    options.options().iter().filter(|o| fits(&o.crossings)).map(|o| o.name.clone()).collect()
}

/// How the end is another one than the log's, if it is.
fn ends_otherwise(log: &EpisodeLog, episode: &Episode, outcome: Option<Outcome>) -> Option<String> {
    let (steps, outcome) = (episode.summary().steps, outcome.map(Outcome::name));
    let words = |outcome: Option<&str>| outcome.unwrap_or("not over").to_owned();
    let logged = log.outcome.as_deref();
    (steps != log.steps || logged != outcome).then(|| {
        format!("logged {} steps, {}; run again {steps} steps, {}", log.steps, words(logged), words(outcome))
    })
}

fn seconds(prepared: &PreparedScenario, episode: &Episode) -> f64 {
    episode.summary().steps as f64 * prepared.scenario().settings.planning_step
}

fn load(file: &Path) -> anyhow::Result<EpisodeLog> {
    let name = || file.display().to_string();
    let bytes = located::read_bytes(&bounds::DECISIONS, file).with_context(name)?;
    serde_json::from_slice(&bytes).context("not a log of an episode").with_context(name)
}

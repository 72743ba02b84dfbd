//! `cocarry run`: runs one episode and reports, tabulates, draws or records it.

use super::custom;
use super::episode_report::EpisodeReport;
use super::interrupt::Interrupt;
use super::live::LiveArguments;
use super::output::{
    Failure, OverwriteArguments, Progress, examples, input, print, print_json, print_message, print_text,
    svg_file, warn, with_spinner, write_file,
};
use super::record::RecordArguments;
use super::scenario::{ScenarioArguments, inputs_of};
use super::snapshots::{Saves, SnapshotArguments};
use super::tick_log;
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry::episode::{EpisodeState, Outcome, Summary};
use cocarry::preference::Perception;
use cocarry::quantities::View;
use cocarry::scenario::{Decisions, Scenario, Snapshot};
use cocarry_output::drawing;
use cocarry_output::output_file::Outputs;
use cocarry_recording::recording::Ending;
use cocarry_recording::rendering::Width;
use cocarry_studies::paper::EXAMPLE_HUMAN;
use std::path::PathBuf;
use std::process::ExitCode;

/// The heading of options about output.
const OUTPUT: &str = "Output";

/// Run one episode: a human and a robot carry an object from A to B
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry run environment-2 --alpha 0.9 --gamma 0.6 --seed 3", "a certain human, in another world"),
    ("cocarry run --change 40:0.6,0.9", "a human who changes their mind at step 40"),
    ("cocarry run --method human-led --eta 5", "another method, a sensitive human"),
    ("cocarry run --belief-alpha uniform(0.6,0.8)", "a robot that is more certain about humans"),
    ("cocarry run --plant kinematic --robot my-robot.toml", "your robot, without dynamics"),
    ("cocarry run --plant kinematic --pose whole-body --pose-weight 2", "pose optimisation of base and arm"),
    ("cocarry run --sway 0.02", "a hand that sways more with the gait"),
    ("cocarry run --speed 0.3 --max-steps 500", "a slower walk, and a limit"),
    ("cocarry run --record run.mcap --ticks run.csv --svg run.svg", "recording, table and picture"),
    ("cocarry run --save-at 60 half.snapshot", "a snapshot; --resume half.snapshot continues"),
]))]
pub(super) struct RunArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    #[command(flatten, next_help_heading = "Snapshots")]
    snapshots: SnapshotArguments,
    /// Print one JSON object instead of text
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Write every tick into this file: .csv, or .jsonl for JSON lines. With --resume, ticks start at the
    /// resumed step
    #[arg(long, value_name = "FILE", value_parser = tick_log::file, help_heading = OUTPUT)]
    ticks: Option<tick_log::File>,
    /// Draw trajectory and stubbornness into this SVG file. With --resume, the picture starts at the resumed
    /// step
    #[arg(long, value_name = "FILE", value_parser = svg_file, help_heading = OUTPUT)]
    svg: Option<PathBuf>,
    /// Width of that picture, in inches or pixels: 3.5in, 1200px. Type is at least 7 pt from 3.5 inches on
    /// [default: 720px]
    #[arg(long, value_name = "WIDTH", requires = "svg", value_parser = clap::value_parser!(Width), help_heading = OUTPUT)]
    width: Option<Width>,
    #[command(flatten, next_help_heading = OUTPUT)]
    recording: RecordArguments,
    #[command(flatten, next_help_heading = OUTPUT)]
    overwrite: OverwriteArguments,
    #[command(flatten, next_help_heading = "Live viewing")]
    live: LiveArguments,
}

impl RunArguments {
    /// The rule for the output files, which must not be inputs of the episode.
    fn outputs(&self, scenario: &Scenario, saves: &Saves) -> Result<Outputs, Failure> {
        let given = [self.snapshots.resume.as_ref(), self.scenario.belief_samples()];
        let inputs = inputs_of(scenario).chain(given.into_iter().flatten().map(PathBuf::as_path));
        let ticks = self.ticks.iter().map(|file| &file.path);
        let files = ticks.chain(&self.svg).chain(self.recording.files()).chain(saves.files());
        self.overwrite.outputs(inputs, files)
    }
}

/// The episode that runs without a command.
pub(super) fn example() -> Result<ExitCode, Failure> {
    use clap::Parser;
    #[derive(Parser)]
    struct Defaults {
        #[command(flatten)]
        arguments: RunArguments,
    }
    let Perception { alpha, gamma } = EXAMPLE_HUMAN;
    let line = format!("run environment-4 --alpha {alpha} --gamma {gamma}");
    print(&format!("$ cocarry {line}  (see cocarry --help)\n\n"))?;
    let code = run_episode(&Defaults::parse_from(line.split(' ')).arguments)?;
    print(&format!(
        "\nTo watch this episode in a browser, write it into a page and open that:\n  \
        cocarry {line} --render episode.html\nIn a clone of the project, begin with `cargo run --release --` instead of `cocarry`.\n"
    ))?;
    Ok(code)
}

pub(super) fn run_episode(arguments: &RunArguments) -> Result<ExitCode, Failure> {
    arguments.snapshots.guard(|| carry_out(arguments))
}

fn carry_out(arguments: &RunArguments) -> Result<ExitCode, Failure> {
    let (scenario, state) = match arguments.snapshots.load()? {
        None => (arguments.scenario.scenario()?, None),
        Some(Snapshot { scenario, state, .. }) => (scenario, Some(state)),
    };
    let resumed = state.as_ref().map(EpisodeState::steps);
    let refused = |error| arguments.snapshots.refused(error);
    let prepared = with_spinner("preparing the world", || scenario.prepare()).map_err(refused)?;
    prepared.warnings().iter().for_each(warn);
    let policy = arguments.scenario.custom_policy();
    let begun = match state {
        None => custom::begin(policy, &prepared),
        Some(state) => prepared.resume(state).map(|episode| (episode, Decisions::default())),
    };
    let (mut episode, decisions) = begun.map_err(refused)?;
    let mut saves = arguments.snapshots.saves(resumed)?;
    if let Some((name, file)) = policy.zip(saves.files().next()) {
        return Err(input(anyhow!(
            "--save-at {}: a snapshot does not have the code of the policy `{name}`; Episode.snapshot of the Python package has its state",
            file.display()
        )));
    }
    let outputs = arguments.outputs(prepared.scenario(), &saves)?;
    let mut ticks = Vec::new();
    let mut log = arguments.ticks.as_ref().map(tick_log::File::begin);
    let bar = Progress::new(episode.expected_steps() as usize, "episode");
    saves.write(&outputs, &prepared, &episode)?;
    let interrupt = Interrupt::caught()?;
    let mut viewers = arguments.live.begin(&prepared, &episode, &interrupt)?;
    let overwrite = arguments.overwrite.overwrite;
    let mut recording = arguments.recording.begin(&prepared, &episode, &decisions, overwrite)?;
    viewers.iter_mut().for_each(|viewers| viewers.await_first());
    while !interrupt.is_set() && episode.step().is_none() {
        custom::check()?;
        recording.step(&episode)?;
        if let Some(viewers) = &mut viewers {
            viewers.step(&episode);
        }
        if let Some(log) = &mut log {
            log.step(&View::new(&prepared, &episode))?;
        }
        ticks.push(episode.tick().clone());
        saves.write(&outputs, &prepared, &episode)?;
        bar.step();
    }
    bar.finish();
    custom::check()?;
    let Summary { steps, outcome, .. } = *episode.summary();
    let is_interrupted = interrupt.is_set();
    let ending = if is_interrupted { Ending::Interrupted } else { Ending::Over(outcome) };
    let recorded = recording.finish(&episode, ending, arguments.scenario.robot(), &outputs)?;
    if let Some(viewers) = &mut viewers {
        viewers.end(&episode, ending);
    }
    let report = EpisodeReport { prepared: &prepared, episode: &episode, policy, resumed, ticks };
    log.map_or(Ok(()), |log| log.finish(&outputs))?;
    if let Some(path) = &arguments.svg {
        let svg = drawing::adaptation(
            prepared.world(),
            &[report.track()],
            prepared.scenario().settings.planning_step,
            Width::sheet_or_default(arguments.width),
        )
        .with_context(|| path.display().to_string())
        .map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if is_interrupted {
        let ticks = arguments.ticks.iter().map(|file| &file.path);
        let files: Vec<_> =
            recorded.iter().chain(ticks).chain(&arguments.svg).map(|f| f.display().to_string()).collect();
        let place =
            if files.is_empty() { String::new() } else { format!(", which are in {}", files.join(", ")) };
        print_message(&format!("interrupted after {steps} steps{place}"));
        viewers.into_iter().for_each(|viewers| viewers.stop());
        return Ok(ExitCode::from(130));
    }
    if arguments.json {
        print_json(&report.as_json())?;
    } else {
        print_text(&report.as_text())?;
        if let Some(file) = arguments.recording.rendered() {
            print(&format!("wrote {}\n", file.display()))?;
        }
    }
    viewers.into_iter().for_each(|viewers| viewers.stop());
    saves.finish(steps)?;
    Ok(match outcome {
        Outcome::Arrived => ExitCode::SUCCESS,
        _ => ExitCode::from(3),
    })
}

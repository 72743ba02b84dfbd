//! `cocarry stimuli`: what the participants of a study are shown of worlds, and of a robot that leads in them.

use super::export::write_all;
use super::model::load_world;
use super::output::{Failure, OverwriteArguments, Progress, examples, input, warn};
use super::record;
use super::robot::RobotArguments;
use super::settings::SettingArguments;
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::policy::Method;
use cocarry::preference::Belief;
use cocarry::scenario::{GivenPerception, Plant, PreparedScenario, SETTINGS, Scenario, Setting};
use cocarry_output::drawing::{Letters, Shown, Stimulus};
use cocarry_recording::recording::{Ending, Playback, Reader, Recorder};
use cocarry_recording::rendering;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write what participants of a study see: a map of every world, without lengths, widths, risks and
/// probabilities; and for each of its options the episode in which the robot leads on it
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry stimuli environment-1 environment-2 -o pictures", "maps, as SVG and PNG, in the folder pictures"),
    ("cocarry stimuli environment-4 --show options -o pictures", "with the options' paths and names"),
    ("cocarry stimuli environment-4 --episodes -o pictures", "and each option as GIF and as a 3-D page, in real time"),
    ("cocarry stimuli my-world.toml --width 1200 -o pictures", "your world, 1200 px wide"),
]))]
pub(super) struct StimuliArguments {
    /// World files (TOML), or built-in worlds: see `cocarry worlds`
    #[arg(required = true)]
    worlds: Vec<PathBuf>,
    /// Folder to write into, which must exist: WORLD.svg and WORLD.png of each world, and stimuli.csv, a table
    /// of all files
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// What maps show besides obstacles, A and B
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    show: Vec<Names>,
    /// Width of the pictures, px
    #[arg(long, value_name = "PX", default_value_t = 800, value_parser = clap::value_parser!(u32).range(300..=4000))]
    width: u32,
    /// Also write WORLD-option-N.gif and .html for every option: the robot leads on it from A to B, in real
    /// time, seen from above and in three dimensions
    #[arg(long)]
    episodes: bool,
    #[command(flatten)]
    overwrite: OverwriteArguments,
    #[command(flatten, next_help_heading = "Robot and plant of the episodes")]
    robot: RobotArguments,
    #[command(flatten)]
    settings: SettingArguments,
}

/// What maps can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Names {
    /// The names of the openings
    Openings,
    /// The options: their paths, all drawn alike, with their names
    Options,
}

/// A row of the table of all files.
#[derive(Default, serde::Serialize)]
struct StimulusRow<'a> {
    file: &'a str,
    world: &'a str,
    option: &'a str,
    number: Option<usize>,
    openings: String,
    length_m: Option<f64>,
    risk: Option<f64>,
    steps: Option<u64>,
    planning_step_s: Option<f64>,
}

/// The files so far, and their table.
struct Stimuli<'a> {
    arguments: &'a StimuliArguments,
    plant: Plant,
    files: Vec<(PathBuf, Vec<u8>)>,
    table: csv::Writer<Vec<u8>>,
}

/// A world, and its name in the names of files.
struct Shot<'a> {
    name: String,
    world: &'a Path,
    prepared: PreparedScenario,
}

/// The kinds of files of an option.
const EPISODE_KINDS: [&str; 2] = ["gif", "html"];
const TABLE: &str = "stimuli.csv";

/// What the command sets itself, for one option after the other.
const PRESCRIBED: [&str; 2] = ["method", "lead_option"];

pub(super) fn run_stimuli(arguments: &StimuliArguments) -> Result<ExitCode, Failure> {
    let given = |setting: &&Setting| arguments.settings.given(setting).is_some();
    if let Some(setting) = SETTINGS.iter().filter(|s| PRESCRIBED.contains(&s.key)).find(given) {
        return Err(input(anyhow!(
            "--{}: the robot leads on each option in turn; leave it out",
            setting.flag
        )));
    }
    let plant = arguments.robot.plant(&arguments.settings)?;
    let table = csv::Writer::from_writer(Vec::new());
    let mut stimuli = Stimuli { arguments, plant, files: Vec::new(), table };
    let shots = arguments.worlds.iter().map(|world| stimuli.shot(world)).collect::<Result<Vec<_>, _>>()?;
    if let Some(i) = (1..shots.len()).find(|i| shots[..*i].iter().any(|shot| shot.name == shots[*i].name)) {
        let (file, name) = (shots[i].world.display(), &shots[i].name);
        return Err(input(anyhow!(
            "{file}: another world is called `{name}`, and its files would have the same names"
        )));
    }
    if !arguments.output.is_dir() {
        let folder = arguments.output.display();
        return Err(input(anyhow!("{folder}: no such folder; make it, or choose another --output")));
    }
    // before the episodes, which take a while
    let table = arguments.output.join(TABLE);
    let files: Vec<PathBuf> =
        shots.iter().flat_map(|shot| stimuli.names(shot)).chain([table.clone()]).collect();
    arguments.overwrite.outputs(arguments.worlds.iter().map(PathBuf::as_path), &files)?;
    let bar = Progress::new(files.len(), "files");
    for shot in &shots {
        stimuli.add_maps(shot)?;
        stimuli.add_episodes(shot, &bar)?;
    }
    bar.finish();
    let rows = stimuli.table.into_inner().expect("a table in memory is always written");
    stimuli.files.push((table, rows));
    write_all(arguments.overwrite, &stimuli.files)?;
    Ok(ExitCode::SUCCESS)
}

impl Stimuli<'_> {
    fn shot<'w>(&self, world: &'w Path) -> Result<Shot<'w>, Failure> {
        let prepared = self.scenario(world, None)?.prepare().map_err(input)?;
        prepared.warnings().iter().for_each(warn);
        let name = world.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Shot { name, world, prepared })
    }

    /// The names of the files of a world.
    fn names(&self, shot: &Shot) -> Vec<PathBuf> {
        let count = if self.arguments.episodes { shot.prepared.options().options().len() } else { 0 };
        let maps = ["svg", "png"].map(|kind| format!("{}.{kind}", shot.name));
        let episode = |number| EPISODE_KINDS.map(|kind| episode_file(&shot.name, number, kind));
        let names = maps.into_iter().chain((1..=count).flat_map(episode));
        names.map(|name| self.arguments.output.join(name)).collect()
    }

    fn shown(&self) -> Shown {
        let shows = |what| self.arguments.show.contains(&what);
        Shown { openings: shows(Names::Openings), options: shows(Names::Options) }
    }

    fn stimulus<'p>(&self, prepared: &'p PreparedScenario, letters: Letters) -> Stimulus<'p> {
        let width = f64::from(self.arguments.width);
        Stimulus::new(prepared.world(), prepared.options(), self.shown(), width, letters)
    }

    /// The pictures of a world without a team.
    fn add_maps(&mut self, shot: &Shot) -> Result<(), Failure> {
        let svg = self.stimulus(&shot.prepared, Letters::Text).map();
        let outlined = self.stimulus(&shot.prepared, Letters::Outlines);
        let png = rendering::stimulus_png(&outlined, self.arguments.width).map_err(input)?;
        for (kind, bytes) in [("svg", svg.into_bytes()), ("png", png)] {
            let file = format!("{}.{kind}", shot.name);
            self.add(StimulusRow { file: &file, world: &shot.name, ..StimulusRow::default() }, bytes);
        }
        Ok(())
    }

    /// The episodes of a robot that leads on each option, if they are asked for.
    fn add_episodes(&mut self, shot: &Shot, bar: &Progress) -> Result<(), Failure> {
        let Shot { name, world, prepared } = shot;
        let set = prepared.options();
        let asked = if self.arguments.episodes { set.options() } else { &[] };
        let outlined = self.stimulus(prepared, Letters::Outlines);
        for (o, option) in asked.iter().enumerate() {
            let led = prepared.prepare(self.scenario(world, Some(o as u64 + 1))?).map_err(input)?;
            let (playback, steps) = played(&led, &option.name)?;
            let gif = rendering::stimulus_gif(&playback, &outlined, self.arguments.width).map_err(input)?;
            let page = rendering::stimulus_page(&playback, name, self.shown()).map_err(input)?;
            let crossed = option.crossings.iter().map(|c| prepared.world().openings[c.opening].name.as_str());
            let openings = crossed.collect::<Vec<_>>().join(" ");
            let remaining = set.remaining(&set.begin(), o);
            for (kind, bytes) in EPISODE_KINDS.into_iter().zip([gif, page.into_bytes()]) {
                let row = StimulusRow {
                    file: &episode_file(name, o + 1, kind),
                    world: name,
                    option: &option.name,
                    number: Some(o + 1),
                    openings: openings.clone(),
                    length_m: Some(remaining.length),
                    risk: Some(remaining.risk),
                    steps: Some(steps),
                    planning_step_s: Some(led.scenario().settings.planning_step),
                };
                self.add(row, bytes);
                bar.step();
            }
        }
        Ok(())
    }

    fn add(&mut self, row: StimulusRow, bytes: Vec<u8>) {
        self.table.serialize(&row).expect("a table in memory is always written");
        self.files.push((self.arguments.output.join(row.file), bytes));
    }

    /// The scenario of a robot that leads on an option, by its number.
    fn scenario(&self, world: &Path, option: Option<u64>) -> Result<Scenario, Failure> {
        let settings =
            EpisodeSettings { method: Method::ROBOT_LED, lead_option: option, ..EpisodeSettings::default() };
        let (world, plant) = (load_world(world)?, self.plant.clone());
        let given = GivenPerception::default();
        let mut scenario = Scenario::of_seed(0, world.into(), plant, settings, &Belief::default(), given);
        self.arguments.settings.apply(&mut scenario);
        (scenario.settings.method, scenario.settings.lead_option) = (Method::ROBOT_LED, option);
        Ok(scenario)
    }
}

/// The file of an option, by its number.
fn episode_file(world: &str, number: usize, kind: &str) -> String {
    format!("{world}-option-{number}.{kind}")
}

/// The episode as it is drawn, and its number of steps.
fn played(prepared: &PreparedScenario, option: &str) -> Result<(Playback, u64), Failure> {
    const NAME: &str = "the recording of this stimulus";
    let mut episode = prepared.episode().map_err(input)?;
    let mut recorder =
        Recorder::new(Cursor::new(Vec::new()), NAME, prepared, &episode).map_err(record::output)?;
    while episode.step().is_none() {
        recorder.step(&episode).map_err(record::output)?;
    }
    let (outcome, steps) = (episode.summary().outcome, episode.summary().steps);
    if outcome != Outcome::Arrived {
        let world = prepared.scenario().world.file();
        return Err(input(anyhow!(
            "{world}: option `{option}`: a robot that leads on it does not arrive ({}); leave --episodes out, or change the world",
            outcome.name()
        )));
    }
    let recording = recorder.finish(&episode, Ending::Over(outcome)).map_err(record::output)?.into_inner();
    let mut reader = Reader::new(Cursor::new(recording), NAME).map_err(input)?;
    Ok((Playback::read(&mut reader).map_err(input)?, steps))
}

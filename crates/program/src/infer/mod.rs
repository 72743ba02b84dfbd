//! `cocarry infer`: alpha, gamma and eta of participants, from their answers and switches.

mod text;

use super::fit::worlds::{inputs, load, note_similar};
use super::model::ModelArguments;
use super::output::{
    Failure, OverwriteArguments, csv_file, examples, has_extension, input, print, print_json,
    table_with_notes, write_file,
};
use super::reproduce::Common;
use super::settings::number;
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry::coordination;
use cocarry::episode::{self, HumanObserver};
use cocarry::learning;
use cocarry::options::OptionSet;
use cocarry::scenario::{BELIEF_LAPSE, INITIAL_STUBBORNNESS, PLANNING_STEP, Plant, Scenario};
use cocarry_recording::recording::{Reader, rerun, scenario};
use cocarry_studies::fit::{
    AnswerFile, Answers, EvidenceKind, InferenceModel, InferenceSettings, PERCEPTION_UNITS, Situation,
    Switch, SwitchFile, Switches, Walk, compare_perceptions, infer, infer_means, participants_files,
};
use cocarry_studies::report::people_columns;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Infer alpha, gamma and eta of participants, and of their population
///
/// Files are those of `cocarry fit`, answers (CSV with the columns participant, world, option and percent)
/// and switches (CSV with the columns participant, world, option or method, and step), and recordings of
/// walks (MCAP). Give one file of answers, one of switches, any number of recordings, or several of these.
/// Use the same participant name in all files; for a recording it is the file name without its extension.
///
/// An answer is taken as one choice, distributed as the participant says; a lapse occurs with the given rate
/// and is uninformative. Every participant's posterior of alpha and gamma is exact, with the belief as prior;
/// a posterior of eta too, with a log-normal prior. With two participants or more, alpha and gamma also have a
/// population: independent truncated normals on the belief's ranges, whose means and spreads are inferred.
/// With two worlds or more, each is held out in turn, and its answers are predicted from the others;
/// --perceptions does so by other perceptions of risk, too.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry infer answers.csv", "alpha and gamma of every participant, and of all"),
    ("cocarry infer answers.csv switches.csv --csv people.csv", "eta too, with a row for every participant"),
    ("cocarry infer anna.mcap ben.mcap", "from recorded walks"),
    ("cocarry infer answers.csv --arviz people.zarr.zip", "draws from the posterior, for ArviZ"),
    ("cocarry infer answers.csv --perceptions", "do the answers follow another perception of risk?"),
    ("cocarry infer docs/data/table-1-humans.csv --means-of 20 --normalise", "a population from mean answers"),
]))]
pub(super) struct InferArguments {
    /// Answers (CSV), switches (CSV), recordings (MCAP), or a folder with answers.csv, switches.csv or both
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    model: ModelArguments,
    /// Probability that an answer or a switch says nothing about its participant
    #[arg(long, value_name = "RATE", value_parser = number(&BELIEF_LAPSE), allow_negative_numbers = true, default_value_t = learning::LearningSettings::default().lapse_rate)]
    lapse_rate: f64,
    /// Median of eta a priori
    #[arg(long, conflicts_with = "means_of", value_name = "ETA", value_parser = of_eta, allow_negative_numbers = true, default_value_t = learning::TolerancePrior::default().median)]
    eta_median: f64,
    /// Standard deviation of the logarithm of eta a priori
    #[arg(long, conflicts_with = "means_of", value_name = "STD", value_parser = of_eta, allow_negative_numbers = true, default_value_t = learning::TolerancePrior::default().log_std)]
    eta_log_std: f64,
    /// Stubbornness phi(0) at the start, between 0 and 1
    #[arg(long, value_name = "PHI", default_value_t = coordination::StubbornnessSettings::default().initial_stubbornness, value_parser = number(&INITIAL_STUBBORNNESS), allow_negative_numbers = true)]
    initial_stubbornness: f64,
    /// Planning step in which steps and eta count, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = episode::EpisodeSettings::default().planning_step, value_parser = number(&PLANNING_STEP), allow_negative_numbers = true)]
    planning_step: f64,
    /// Take each participant in the answers as the mean of this many people, and infer only their population
    #[arg(long, value_name = "PEOPLE", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    means_of: Option<u64>,
    /// Infer every participant alone, without a population
    #[arg(long, conflicts_with = "means_of")]
    no_population: bool,
    /// Compare the paper's perception of risk with cumulative prospect theory, conditional value at risk and
    /// expected risk, by the answers in worlds held out
    #[arg(long, conflicts_with = "means_of")]
    perceptions: bool,
    /// Scale the percentages of every answer to sum to 100 [default: only sums from 99 to 101 are scaled, for
    /// rounding; others are refused]
    #[arg(long)]
    normalise: bool,
    /// Draws of each of four chains
    #[arg(long, conflicts_with = "means_of", value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(100..=100_000))]
    draws: u64,
    /// Seed of the draws
    #[arg(long, conflicts_with = "means_of", default_value_t = 0)]
    seed: u64,
    /// Write a row for every participant into this CSV file
    #[arg(long, value_name = "FILE", value_parser = csv_file, conflicts_with = "means_of")]
    csv: Option<PathBuf>,
    /// Write draws from posterior and prior for ArviZ into this file, which must end in .zarr.zip
    #[arg(long, value_name = "FILE", value_parser = zarr_file, conflicts_with = "means_of")]
    arviz: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// The files, read and matched with their worlds.
struct Read {
    walks: Vec<Walk>,
    answers: Option<Answers>,
    switches: Option<(String, Vec<Switch>)>,
    inputs: Vec<PathBuf>,
}

pub(super) fn run_infer(arguments: &InferArguments) -> Result<ExitCode, Failure> {
    let read = read(arguments)?;
    let files = arguments.csv.iter().chain(&arguments.arviz);
    let outputs = arguments.overwrite.outputs(read.inputs.iter().map(PathBuf::as_path), files)?;
    let model = InferenceModel {
        belief: arguments.model.predictor()?.belief().clone(),
        risk_weight: arguments.model.risk_weight,
    };
    let settings = InferenceSettings {
        lapse_rate: arguments.lapse_rate,
        tolerance: learning::TolerancePrior { median: arguments.eta_median, log_std: arguments.eta_log_std },
        has_population: !arguments.no_population,
        draws: arguments.draws as usize,
        keeps_draws: arguments.arviz.is_some(),
        seed: arguments.seed,
    };
    if let Some(people) = arguments.means_of {
        let (Some(answers), None, []) = (&read.answers, &read.switches, read.walks.as_slice()) else {
            return Err(input(anyhow!("--means-of {people}: it needs a file of answers, and nothing else")));
        };
        let units = answers.situations.iter().map(|s| s.options.len()).sum();
        let means = arguments
            .common
            .with_progress(units, "options", |done| infer_means(answers, people, &model, &settings, done))?
            .map_err(input)?;
        if arguments.common.json {
            return json_of_means(&means, people, &settings).map(|()| ExitCode::SUCCESS);
        }
        print(&text::of_means(&means, answers, people))?;
        return Ok(ExitCode::SUCCESS);
    }
    let answered = read.answers.as_ref().map_or(0, |answers| answers.participants.len());
    let switches = read.switches.as_ref().map(|(file, switches)| Switches { file, switches });
    let inference = arguments
        .common
        .with_progress(3 * answered, "participants", |done| {
            infer(read.answers.as_ref(), switches, &read.walks, &model, &settings, done)
        })?
        .map_err(input)?;
    let perceptions = match (&read.answers, arguments.perceptions) {
        (_, false) => None,
        (Some(answers), true) if answers.situations.len() > 1 => Some(
            arguments
                .common
                .with_progress(PERCEPTION_UNITS, "perceptions", |done| {
                    compare_perceptions(answers, &model, &settings, done)
                })?
                .map_err(input)?,
        ),
        _ => return Err(input(anyhow!("--perceptions: it needs a file of answers in two worlds or more"))),
    };
    if let Some(path) = &arguments.csv {
        write_file(&outputs, path, people_columns(&inference.people).table("people", "Participants").csv())?;
    }
    if let Some(path) = &arguments.arviz {
        let store = inference.store(read.answers.as_ref(), switches, &settings);
        let bytes = store.zipped().with_context(|| path.display().to_string()).map_err(Failure::Output)?;
        write_file(&outputs, path, bytes)?;
    }
    if arguments.common.json {
        print_json(&json!({
            "people": inference.people,
            "population": inference.population.as_ref().map(text::population_json),
            "eta_population": inference.tolerances.as_ref().map(|fit| json!({
                "overall": fit.overall,
                "median_interval": fit.median_interval,
                "no_interval": fit.no_interval,
            })),
            "unexplained_lines": inference.tolerances.as_ref().map(|fit| &fit.unexplained_lines),
            "held_out": inference.held_out,
            "checks": inference.checks,
            "perceptions": perceptions,
            "lapse_rate": settings.lapse_rate,
            "planning_step_s": arguments.planning_step,
            "draws": settings.draws * cocarry_studies::fit::CHAINS,
            "seed": settings.seed,
        }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut shown = String::new();
    let compared = perceptions.as_deref().map(|rows| text::of_perceptions(rows, model.risk_weight));
    for table in text::tables(&inference, &settings).into_iter().chain(compared) {
        if !shown.is_empty() {
            shown.push('\n');
        }
        shown += &table_with_notes(&table);
    }
    shown += &text::notes(read.answers.as_ref(), &inference);
    if inference.people.iter().any(|person| person.episodes > 0) {
        shown += &format!("eta counts in planning steps of {} s.\n", arguments.planning_step);
    }
    print(&shown)?;
    Ok(ExitCode::SUCCESS)
}

fn json_of_means(
    means: &cocarry_studies::fit::Means,
    people: u64,
    settings: &InferenceSettings,
) -> Result<(), Failure> {
    print_json(&json!({
        "people": people,
        "population": text::population_json(&means.population),
        "rows": means.rows,
        "lapse_rate": settings.lapse_rate,
    }))
}

fn read(arguments: &InferArguments) -> Result<Read, Failure> {
    let mut read = Read { walks: Vec::new(), answers: None, switches: None, inputs: Vec::new() };
    let files = arguments.files.iter().map(|file| participants_files(file).map_err(input));
    for file in files.collect::<Result<Vec<_>, _>>()?.iter().flatten() {
        if has_extension(file, "mcap") {
            read.walks.push(walk(arguments, file)?);
            read.inputs.push(file.clone());
            continue;
        }
        let kind = EvidenceKind::of(file).map_err(input)?;
        let is_second = match kind {
            EvidenceKind::Answers => read.answers.is_some(),
            EvidenceKind::Switches => read.switches.is_some(),
        };
        if is_second {
            let what = if kind == EvidenceKind::Answers { "answers" } else { "switches" };
            return Err(input(anyhow!("{}: a second file of {what}; give one of each kind", file.display())));
        }
        match kind {
            EvidenceKind::Answers => answers(arguments, file, &mut read)?,
            EvidenceKind::Switches => switches(arguments, file, &mut read)?,
        }
    }
    let answers = read.answers.iter().flat_map(|answers| &answers.participants);
    let switches = read.switches.iter().flat_map(|(_, switches)| switches.iter().map(|s| &s.participant));
    let walks = read.walks.iter().map(|walk| &walk.participant);
    note_similar(answers.chain(switches).chain(walks).map(String::as_str));
    Ok(read)
}

fn answers(arguments: &InferArguments, path: &Path, read: &mut Read) -> Result<(), Failure> {
    let file = AnswerFile::read(path).map_err(input)?;
    let risk_weight = arguments.model.risk_weight;
    let worlds = load(path, file.worlds(), |world| OptionSet::new(&world, risk_weight))?;
    read.inputs.extend(inputs(path, &worlds, &arguments.model.belief));
    let situations = worlds.iter().map(|(world, set)| Situation::new(world.clone(), set)).collect();
    read.answers = Some(file.matched(situations, arguments.normalise).map_err(input)?);
    Ok(())
}

fn switches(arguments: &InferArguments, path: &Path, read: &mut Read) -> Result<(), Failure> {
    let phi = arguments.initial_stubbornness;
    if phi >= 1.0 {
        return Err(input(anyhow!(
            "--initial-stubbornness {phi}: it must be less than 1; with 1, every eta switches at the first discomfort"
        )));
    }
    let file = SwitchFile::read(path).map_err(input)?;
    let settings = episode::EpisodeSettings {
        predictor: arguments.model.predictor()?,
        coordination: coordination::StubbornnessSettings { initial_stubbornness: phi, ..Default::default() },
        predict_while_human_leads: false,
        planning_step: arguments.planning_step,
        ..episode::EpisodeSettings::default()
    };
    let prepared = load(path, file.worlds(), |world| {
        Scenario { settings: settings.clone(), ..Scenario::new(world.into(), Plant::Point) }.prepare()
    })?;
    read.inputs.extend(inputs(path, &prepared, &arguments.model.belief));
    read.switches = Some((path.display().to_string(), file.matched(&prepared).map_err(input)?));
    Ok(())
}

/// The robot's observations of the human in a recording, whose name is the participant's.
fn walk(arguments: &InferArguments, path: &Path) -> Result<Walk, Failure> {
    let file = path.display().to_string();
    let scenario = scenario(&mut Reader::open(path).map_err(input)?).map_err(input)?;
    let (recorded, ours) = (scenario.settings.predictor.risk_weight(), arguments.model.risk_weight);
    if recorded != ours {
        return Err(input(anyhow!(
            "{file}: recorded with risk_weight_m = {recorded}, not {ours}; give --risk-weight {recorded}"
        )));
    }
    let (recorded, ours) = (scenario.settings.planning_step, arguments.planning_step);
    if recorded != ours {
        return Err(input(anyhow!(
            "{file}: recorded with a planning step of {recorded} s, not {ours} s, and eta counts in it; give --planning-step {recorded}"
        )));
    }
    if scenario.settings.learning.is_some() {
        return Err(input(anyhow!(
            "{file}: recorded with --belief learn: it does not hold the P_o of the prior, by which discomfort grows"
        )));
    }
    let phi = scenario.settings.coordination.initial_stubbornness;
    let mut observer = HumanObserver::new(learning::LearningSettings::default(), phi)
        .context(file.clone())
        .map_err(Failure::Input)?;
    rerun(&mut Reader::open(path).map_err(input)?, |episode| observer.observe(episode)).map_err(input)?;
    let participant = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Walk { file, participant, sightings: observer.sightings().to_vec(), etas: observer.etas() })
}

/// A parser of a number of the prior of eta; both have one range.
fn of_eta(text: &str) -> Result<f64, String> {
    let number = text.parse().map_err(|_| "must be a number".to_owned())?;
    let tolerance = learning::TolerancePrior { median: number, log_std: number };
    let settings = learning::LearningSettings { tolerance, ..Default::default() };
    settings.check().map_err(|error| format!("must be {}", error.expected))?;
    Ok(number)
}

/// A parser of the name of a Zarr store in a ZIP file.
fn zarr_file(name: &str) -> Result<PathBuf, String> {
    match name.ends_with(".zarr.zip") {
        true => Ok(PathBuf::from(name)),
        false => Err("expected the extension .zarr.zip".to_owned()),
    }
}

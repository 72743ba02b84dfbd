//! `cocarry fit eta`: estimates eta from the steps at which participants asked to switch.

use super::worlds::{inputs, load, note_similar};
use crate::model::ModelArguments;
use crate::output::{
    Failure, OverwriteArguments, counted, examples, input, print, print_json, svg_file, table, table_text,
    write_file,
};
use crate::settings::number;
use anyhow::{Context, anyhow};
use clap::Args;
use cocarry::coordination;
use cocarry::episode::EpisodeSettings;
use cocarry::math;
use cocarry::scenario::{INITIAL_STUBBORNNESS, PLANNING_STEP, Plant, Scenario};
use cocarry_studies::fit::{Eta, EtaFit, EvidenceKind, SwitchFile, fit_eta};
use cocarry_studies::report::{no_interval, tolerances_picture};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// Fit the tolerance eta of participants to the steps at which they asked to stop following the robot
///
/// Switches are CSV with the columns participant, world, option and step: one row for every option that a
/// participant watched the robot walk, and the planning step (0.2 s and 0.1 m by default) at which the
/// participant asked to switch, empty if never. Instead of an option, a column `method` may have the value
/// `mutual`: the robot chose its option as in `cocarry run`. A column `trial` distinguishes repetitions.
/// `world` is a world file, relative to the file of switches, or a built-in world.
///
/// g(k) is the same for everyone. A switch at step k therefore implies
/// g(k - 1) / ln(1 / phi(0)) <= eta < g(k) / ln(1 / phi(0)). Without a switch, eta is at least the last of
/// these bounds (censored). A participant's eta lies in the intersection of these intervals. If the intervals
/// of any participant contradict each other, eta is modelled as log-normally distributed between episodes,
/// for everyone. Intervals of medians are 95 % intervals. If the switches do not determine an interval, the
/// output says why.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry fit eta switches.csv --svg eta.svg", ""),
]))]
pub(crate) struct EtaArguments {
    /// Switches (CSV), or a folder with switches.csv
    switches: PathBuf,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    model: ModelArguments,
    /// Stubbornness phi(0) at the start, between 0 and 1
    #[arg(long, value_name = "PHI", default_value_t = coordination::StubbornnessSettings::default().initial_stubbornness, value_parser = number(&INITIAL_STUBBORNNESS), allow_negative_numbers = true)]
    initial_stubbornness: f64,
    /// Planning step in which steps and eta count, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = EpisodeSettings::default().planning_step, value_parser = number(&PLANNING_STEP), allow_negative_numbers = true)]
    planning_step: f64,
    /// Draw every participant's episodes and eta into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_fit_eta(arguments: &EtaArguments) -> Result<(), Failure> {
    let phi = arguments.initial_stubbornness;
    if phi >= 1.0 {
        return Err(input(anyhow!(
            "--initial-stubbornness {phi}: it must be less than 1; with 1, every eta switches at the first discomfort"
        )));
    }
    let path = EvidenceKind::Switches.within(&arguments.switches).map_err(input)?;
    let file = SwitchFile::read(&path).map_err(input)?;
    note_similar(file.participants().iter().map(|(name, _)| name.as_str()));
    let settings = EpisodeSettings {
        predictor: arguments.model.predictor()?,
        coordination: coordination::StubbornnessSettings { initial_stubbornness: phi, ..Default::default() },
        predict_while_human_leads: false,
        planning_step: arguments.planning_step,
        ..EpisodeSettings::default()
    };
    let prepared = load(&path, file.worlds(), |world| {
        Scenario { settings: settings.clone(), ..Scenario::new(world.into(), Plant::Point) }.prepare()
    })?;
    let inputs = inputs(&path, &prepared, &arguments.model.belief);
    let outputs = arguments.overwrite.outputs(inputs.iter().map(PathBuf::as_path), &arguments.svg)?;
    let switches = file.matched(&prepared).map_err(input)?;
    let fit = fit_eta(&switches);
    if let Some(path) = &arguments.svg {
        let svg =
            tolerances_picture(&fit).with_context(|| path.display().to_string()).map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.json {
        return print_json(&json!({
            "participants": fit.participants,
            "overall": fit.overall,
            "median_interval": fit.median_interval,
            "no_interval": fit.no_interval,
            "is_cautious": fit.is_cautious,
            "is_scattered": fit.is_scattered,
            "unexplained_lines": fit.unexplained_lines,
            "initial_stubbornness": phi,
            "planning_step_s": arguments.planning_step,
            "episodes": switches.iter().map(|s| json!({
                "line": s.line,
                "participant": s.participant,
                "world": s.world,
                "executed": s.executed.name(),
                "step": s.step,
                "eta": s.etas,
            })).collect::<Vec<_>>(),
        }));
    }
    print(&text(&fit, arguments.planning_step))
}

fn text(fit: &EtaFit, planning_step: f64) -> String {
    let mut text = format!(
        "eta: tolerance of {}, from the steps at which they asked to switch\n",
        counted(fit.participants.len(), "participant")
    );
    let headings = ["participant", "eta", "interval", "evidence", "episodes", "switches"];
    let mut shown = table(headings, 1);
    for eta in &fit.participants {
        shown.add_row([
            eta.participant.clone(),
            eta.eta.map_or("-".to_owned(), |eta| format!("{eta:.2}")),
            eta.interval.map_or("-".to_owned(), interval),
            evidence(eta),
            eta.episodes.to_string(),
            eta.switches.to_string(),
        ]);
    }
    text += &table_text(&shown);
    if let Some(overall) = &fit.overall {
        let factor = math::exp(overall.log_std);
        let (low, high) = (overall.median / factor, overall.median * factor);
        let _ = writeln!(
            text,
            "All: median {:.2} ({}), spread: a factor of {factor:.2} (two thirds of people from {low:.2} to {high:.2}).",
            overall.median,
            fit.median_interval
                .map_or("no interval".to_owned(), |ends| format!("95 % interval {}", interval(ends)))
        );
    }
    if fit.is_cautious {
        text += "So few participants switched that the interval is cautious: in simulated studies, such intervals contain the median in up to 100 %, not in 95 %.\n";
    }
    if let Some(reason) = no_interval(fit) {
        let _ = writeln!(text, "All: {reason}.");
    }
    for eta in &fit.participants {
        if let Some(reason) = &eta.no_interval {
            let _ = writeln!(text, "{}: not determined: episodes: {reason}.", eta.participant);
        }
    }
    if !fit.unexplained_lines.is_empty() {
        let lines: Vec<String> = fit.unexplained_lines.iter().map(u64::to_string).collect();
        let _ = writeln!(
            text,
            "Left out: no eta explains a switch before any discomfort; line {}.",
            lines.join(", ")
        );
    }
    text += "bounded: all episodes agree, and eta lies in the interval. censored: never switched.";
    text += match fit.is_scattered {
        true => {
            " scattered: episodes of a participant contradict each other, and eta varies between episodes: a median, with its 95 % interval.\n"
        }
        false => " No participant's episodes contradict each other: eta is the same in every episode.\n",
    };
    text + "All: the log-normal distribution of everyone's eta. "
        + &format!("eta counts in planning steps of {planning_step} s.\n")
}

fn interval([low, high]: [f64; 2]) -> String {
    match high.is_finite() {
        true => format!("{low:.2} to {high:.2}"),
        false => format!("at least {low:.2}"),
    }
}

fn evidence(eta: &Eta) -> String {
    match eta.log_scatter {
        Some(scatter) => format!("{}, factor {:.2}", eta.evidence.name(), math::exp(scatter)),
        None => eta.evidence.name().to_owned(),
    }
}

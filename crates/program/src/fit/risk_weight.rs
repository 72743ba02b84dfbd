//! `cocarry fit risk-weight`: estimates c_r from participants' percentages, by least squares and by
//! likelihood.

use super::worlds::{inputs, load, note_similar};
use crate::model::BeliefArguments;
use crate::output::{
    Failure, OverwriteArguments, counted, examples, input, print, print_json, svg_file, table, table_text,
    write_file,
};
use crate::reproduce::Common;
use anyhow::Context;
use clap::Args;
use cocarry::options::OptionSet;
use cocarry::preference::RISK_WEIGHT;
use cocarry_studies::fit::{
    AnswerFile, Answers, CELL_ERROR, Estimate, EvidenceKind, LEAST_SQUARES_CAUTION, RiskWeightFit,
    RiskWeightSettings, Situation, fit_risk_weight,
};
use cocarry_studies::report::answers_picture;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// Fit the risk weight c_r to the percentages with which participants would choose each option
///
/// Answers are CSV with the columns participant, world, option and percent: one row for every option of every
/// world that a participant was asked about, including 0 percent. `world` is a world file, relative to the
/// file of answers, or a built-in world; `option` is the name of an option there. Other columns, and lines
/// that begin with #, are ignored.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry fit risk-weight answers.csv --svg answers.svg", ""),
]))]
pub(crate) struct RiskWeightArguments {
    /// Answers (CSV), or a folder with answers.csv
    answers: PathBuf,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    belief: BeliefArguments,
    /// Hold the answers of this world out of the fit, and report how well the fit predicts them; may be given
    /// several times
    #[arg(long, value_name = "WORLD")]
    validate: Vec<String>,
    /// Scale the percentages of every answer to sum to 100 [default: only sums from 99 to 101 are scaled, for
    /// rounding; others are refused]
    #[arg(long)]
    normalise: bool,
    /// Number of resamples of the participants for the 95 % bootstrap interval
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(40..=1_000_000))]
    resamples: u64,
    /// Seed of the resamples
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Draw answers and fit into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_fit_risk_weight(arguments: &RiskWeightArguments) -> Result<(), Failure> {
    let path = EvidenceKind::Answers.within(&arguments.answers).map_err(input)?;
    let file = AnswerFile::read(&path).map_err(input)?;
    note_similar(file.participants().iter().map(|(name, _)| name.as_str()));
    let worlds = load(&path, file.worlds(), |world| OptionSet::new(&world, RISK_WEIGHT))?;
    let inputs = inputs(&path, &worlds, &arguments.belief);
    let outputs = arguments.overwrite.outputs(inputs.iter().map(PathBuf::as_path), &arguments.svg)?;
    let situations = worlds.iter().map(|(world, set)| Situation::new(world.clone(), set)).collect();
    let answers = file.matched(situations, arguments.normalise).map_err(input)?;
    let predictor = arguments.belief.predictor(RISK_WEIGHT)?;
    let settings = RiskWeightSettings {
        resamples: arguments.resamples as usize,
        seed: arguments.seed,
        held_out: arguments.validate.clone(),
        ..RiskWeightSettings::default()
    };
    let fit = arguments
        .common
        .with_progress(settings.resamples, "resamples", |on_done| {
            fit_risk_weight(&answers, &predictor, &settings, on_done)
        })?
        .map_err(input)?;
    if let Some(path) = &arguments.svg {
        let svg =
            answers_picture(&fit).with_context(|| path.display().to_string()).map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.common.json {
        return print_json(&json!({
            "participants": answers.participants.len(),
            "recommended": fit.is_determined().then_some("likelihood"),
            "likelihood": fit.likelihood,
            "least_squares": fit.least_squares,
            "least_squares_caution": LEAST_SQUARES_CAUTION,
            "caution": fit.caution(),
            "nearly_as_good_m": fit.nearly_as_good,
            "tried_m": settings.range,
            "resamples": settings.resamples,
            "seed": settings.seed,
            "held_out": settings.held_out,
            "scaled": answers.scaled.iter().map(|(participant, world, percent)| json!({
                "participant": participant, "world": world, "sum_percent": percent,
            })).collect::<Vec<_>>(),
            "rows": fit.rows,
        }));
    }
    print(&text(&answers, &settings, &fit))
}

fn text(answers: &Answers, settings: &RiskWeightSettings, fit: &RiskWeightFit) -> String {
    let mut text = format!(
        "c_r: weight of risk against distance, from the answers of {}\n",
        counted(answers.participants.len(), "participant")
    );
    let headings =
        ["by", "c_r (m)", "95 % interval (m)", "lapse (%)", "rms error, fitted (pp)", "held out (pp)"];
    let mut shown = table(headings, 1);
    let estimates = [("likelihood", &fit.likelihood), ("least squares", &fit.least_squares)];
    for (name, estimate) in estimates {
        let interval = estimate.interval.map(|[low, high]| format!("{low:.2} to {high:.2}"));
        shown.add_row([
            match estimate.lapse {
                Some(_) if fit.is_determined() => format!("{name} (recommended)"),
                Some(_) => format!("{name} (undetermined)"),
                None => name.to_owned(),
            },
            format!("{:.3}", estimate.risk_weight),
            interval.unwrap_or_else(|| "-".to_owned()),
            estimate.lapse.map_or("-".to_owned(), |lapse| format!("{:.1}", 100.0 * lapse)),
            format!("{:.2}", estimate.fitted.rms),
            estimate.held_out.map_or("-".to_owned(), |e| format!("{:.2}", e.rms)),
        ]);
    }
    text += &table_text(&shown);
    let _ = writeln!(text, "{}", fit.caution());
    let [low, high] = fit.nearly_as_good.map(|end| format!("{end:.2}"));
    // none of the other values tried is as good
    if low != high {
        let _ = writeln!(
            text,
            "From {low} to {high} m, the rms error is at most {CELL_ERROR} percentage points above the smallest."
        );
    }
    if answers.participants.len() == 1 {
        text += "No interval: the bootstrap needs two participants or more.\n";
    } else {
        let _ = writeln!(
            text,
            "Intervals: {} resamples of the participants, seed {}.",
            settings.resamples, settings.seed
        );
    }
    let has_one = |(_, estimate): &(&str, &Estimate)| {
        answers.participants.len() > 1 && estimate.interval.is_none() && estimate.undetermined.is_none()
    };
    for (name, _) in estimates.into_iter().filter(has_one) {
        let _ = writeln!(text, "By {name}, all resamples have the same c_r: no interval.");
    }
    for (name, estimate) in estimates {
        text += &notes(name, estimate, settings);
    }
    for (participant, world, sum) in &answers.scaled {
        let _ =
            writeln!(text, "The answer of `{participant}` in {world} summed to {sum} %: scaled to 100 %.");
    }
    let headings = [
        "world",
        "option",
        "answered (%)",
        "likelihood (%)",
        "difference",
        "least squares (%)",
        "difference",
    ];
    let mut shown = table(headings, 2);
    for row in &fit.rows {
        shown.add_row([
            format!("{}{}", row.world, if row.is_held_out { " (held out)" } else { "" }),
            row.option.clone(),
            format!("{:.1}", row.mean_percent),
            format!("{:.1}", row.likelihood_percent),
            format!("{:+.1}", row.likelihood_percent - row.mean_percent),
            format!("{:.1}", row.least_squares_percent),
            format!("{:+.1}", row.least_squares_percent - row.mean_percent),
        ]);
    }
    text + "\n" + &table_text(&shown)
}

fn notes(name: &str, estimate: &Estimate, settings: &RiskWeightSettings) -> String {
    let mut text = String::new();
    if estimate.is_at_end {
        let [low, high] = settings.range;
        let _ = writeln!(
            text,
            "By {name}, c_r lies at an end of the searched range ({low} to {high} m): the answers do not bound it."
        );
    }
    if !estimate.other_optima.is_empty() {
        let others: Vec<String> = estimate.other_optima.iter().map(|c| format!("{c:.2}")).collect();
        let _ = writeln!(text, "By {name}, there are other local optima at {} m.", others.join(", "));
    }
    let errors = estimate.held_out.map(|e| ("held out", e));
    for (what, e) in [("fitted", estimate.fitted)].into_iter().chain(errors) {
        let _ = writeln!(
            text,
            "By {name}, in the worlds {what}: mean |difference| {:.2}, largest {:.2} percentage points.",
            e.mean_absolute, e.largest
        );
    }
    text
}

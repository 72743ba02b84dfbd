//! `cocarry calibrate`: checks that what the robot learns about a human is as certain as it should be.

use super::output::{Failure, Progress, examples, input, print, print_json, table, table_text};
use super::settings::number;
use clap::Args;
use cocarry::learning;
use cocarry::options::OptionSet;
use cocarry::scenario::BELIEF_LAPSE;
use cocarry::world::{BUILT_IN_WORLDS, World};
use cocarry_studies::fit::{Calibration, Check, checks};
use serde_json::json;
use std::process::ExitCode;

/// Check the calibration of what the robot learns about a human
///
/// Humans are drawn from the prior and observed in the built-in worlds, with lapses and changes of mind. The
/// posterior probability up to the true alpha, gamma and eta must be uniform over all humans (simulation-based
/// calibration, Talts et al. 2018). Exits with 1 if a Kolmogorov-Smirnov test rejects uniformity at 0.001.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry calibrate --replications 1000", ""),
    ("cocarry calibrate --lapse-rate 0.3 --assumed-lapse-rate 0.02", "a belief that is too certain: it fails"),
]))]
pub(super) struct CalibrateArguments {
    /// Number of humans
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(100..=10_000_000))]
    replications: u64,
    /// Sightings of each human under their lead
    #[arg(long, alias = "looks", value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=1000))]
    sightings: u32,
    /// Tasks with each human under the robot's lead
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=100))]
    tasks: u32,
    /// Seed
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    seed: u64,
    /// Probability that a sighting of a human says nothing about them
    #[arg(long, value_name = "RATE", value_parser = number(&BELIEF_LAPSE), allow_negative_numbers = true, default_value_t = learning::LearningSettings::default().lapse_rate)]
    lapse_rate: f64,
    /// The lapse rate that the robot assumes [default: the true one]
    #[arg(long, value_name = "RATE", value_parser = number(&BELIEF_LAPSE), allow_negative_numbers = true)]
    assumed_lapse_rate: Option<f64>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

pub(super) fn run_calibrate(arguments: &CalibrateArguments) -> Result<ExitCode, Failure> {
    let truth = learning::LearningSettings { lapse_rate: arguments.lapse_rate, ..Default::default() };
    let lapse_rate = arguments.assumed_lapse_rate.unwrap_or(arguments.lapse_rate);
    let calibration = Calibration {
        truth,
        assumed: learning::LearningSettings { lapse_rate, ..truth },
        replications: arguments.replications,
        sightings: arguments.sightings,
        tasks: arguments.tasks,
        seed: arguments.seed,
        ..Calibration::default()
    };
    let risk_weight = calibration.settings.predictor.risk_weight();
    let mut sets = Vec::new();
    for built_in in BUILT_IN_WORLDS {
        let world = World::parse(built_in.name, built_in.text).map_err(input)?;
        sets.push(OptionSet::new(&world, risk_weight).map_err(input)?);
    }
    let bar = Progress::new(arguments.replications as usize, "humans");
    let replications = calibration.run(&sets, &|| bar.step()).map_err(input)?;
    bar.finish();
    let checks = checks(&replications);
    if arguments.json {
        print_json(&json!({ "replications": arguments.replications, "checks": checks }))?;
    } else {
        print(&text(&checks, arguments.replications))?;
    }
    Ok(ExitCode::from(u8::from(!checks.iter().all(|check| check.is_calibrated))))
}

fn text(checks: &[Check], replications: u64) -> String {
    let headings =
        ["quantity", "distance", "band", "in 50 %", "in 80 %", "in 95 %", "recovery", "calibrated"];
    let mut shown = table(headings, 1);
    for check in checks {
        let [half, most, nearly_all] = check.coverage.map(|share| format!("{:.1} %", 100.0 * share));
        shown.add_row([
            check.name.to_owned(),
            format!("{:.4}", check.distance),
            format!("{:.4}", check.band),
            half,
            most,
            nearly_all,
            check.recovery.map_or("-".to_owned(), |recovery| format!("{recovery:.3}")),
            if check.is_calibrated { "yes" } else { "no" }.to_owned(),
        ]);
    }
    format!("Calibration over {replications} humans\n{}", table_text(&shown))
}

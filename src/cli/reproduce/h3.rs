//! `cocarry reproduce h3`: Table III beside the paper's, and what the paper does not measure.

use super::super::output::{Failure, Progress, input, print, print_json, table, table_text, write_file};
use super::super::robot::load_robot;
use super::{Common, TablePlant};
use crate::control;
use crate::drawing::{self, RatioPanel, RatioRow};
use crate::episode::Settings;
use crate::experiments::h3::{EPISODES, PoseMethod, Row, Study};
use crate::experiments::paper::{ENVIRONMENTS, SETTINGS};
use crate::simulation::PhysicsSettings;
use anyhow::Context;
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(in super::super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// What the controller acts on: `kinematic`, as in the paper, or `rapier`, where the team has bodies
    #[arg(long, value_enum, default_value_t = TablePlant::Kinematic)]
    plant: TablePlant,
    /// Random humans in each of the 16 cells [default: 100; 20 with --plant rapier, where an episode takes fifty times as long]
    #[arg(long, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    episodes: Option<u64>,
    /// Seed of the humans
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Robot file (TOML), or a URDF with a robot file of the same name beside it [default: the built-in carrier]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Draw all cost ratios into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let robot = load_robot(arguments.robot.as_deref())?;
    let settings = Settings::default();
    let physics = (arguments.plant == TablePlant::Rapier).then(PhysicsSettings::default);
    let default = if physics.is_some() { EPISODES / 5 } else { EPISODES };
    let episodes = arguments.episodes.map_or(default, |n| n as usize);
    let study = Study {
        robot: &robot,
        episodes,
        seed: arguments.seed,
        episode: &settings,
        control: control::Settings::default(),
        physics,
    };
    let bar = Progress::new(study.units(), "Table III");
    let rows = arguments.common.on_threads(|| study.table(&|| bar.step()))?.map_err(input)?;
    bar.finish();
    let starts: Vec<&str> = robot.postures.iter().map(|p| p.name.as_str()).collect();
    if let Some(path) = &arguments.svg {
        let svg = drawing::cost_ratios(&panels(&rows, &starts))
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(path, &svg)?;
    }
    if arguments.common.json {
        let (table, other): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|r| r.start == starts[0]);
        return print_json(&json!({
            "table": "III",
            "robot": robot.name,
            "plant": arguments.plant.name(),
            "episodes": episodes,
            "seed": arguments.seed,
            "start": starts[0],
            "mean_ratio": mean_ratio(&rows, starts[0], PoseMethod::WithPo),
            "rows": table,
            "rows_of_other_starts": other,
        }));
    }
    let mut text = side_by_side(&rows, starts[0]);
    for start in &starts {
        text += &ratios(&rows, start, study.methods());
    }
    print(&(text + &notes(&rows, study.methods())))
}

fn of<'a>(rows: &'a [Row], start: &'a str, method: PoseMethod) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |r| r.start == start && r.method == method)
}

fn mean_ratio(rows: &[Row], start: &str, method: PoseMethod) -> f64 {
    let ratios: Vec<f64> = of(rows, start, method).map(|r| r.ratio).collect();
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

fn saving(with: f64, without: f64) -> String {
    format!("{:.1} %", 100.0 * (1.0 - with / without))
}

/// The paper's table and ours.
fn side_by_side(rows: &[Row], start: &str) -> String {
    let headings = [
        "environment",
        "setting",
        "paper: without PO",
        "with PO",
        "saving",
        "ours: without PO",
        "with PO",
        "saving",
        "p (paired)",
        "cheaper in",
    ];
    let mut shown = table(headings, 0);
    let pairs = of(rows, start, PoseMethod::WithoutPo).zip(of(rows, start, PoseMethod::WithPo));
    let mut paper_ratios = Vec::new();
    for (without, with) in pairs {
        let paper = [without.paper_mean.unwrap_or(f64::NAN), with.paper_mean.unwrap_or(f64::NAN)];
        paper_ratios.push(paper[1] / paper[0]);
        shown.add_row([
            with.environment.to_string(),
            with.setting.to_owned(),
            format!("{:.1}", paper[0]),
            format!("{:.1}", paper[1]),
            saving(paper[1], paper[0]),
            format!("{:.1} ± {:.1}", without.ours_mean, without.ours_std),
            format!("{:.1} ± {:.1}", with.ours_mean, with.ours_std),
            saving(with.ours_mean, without.ours_mean),
            with.p_value.map_or("-".to_owned(), |p| format!("{p:.0e}")),
            format!("{} of {}", with.wins, with.episodes),
        ]);
    }
    format!(
        "Table III: control cost C with and without pose optimisation (PO); episodes start `{start}`\n{}\
         mean ratio with / without: paper {:.3}, ours {:.3}. C depends on robot, worlds and speed, which the paper does not give: compare the savings.\n",
        table_text(&shown),
        paper_ratios.iter().sum::<f64>() / paper_ratios.len() as f64,
        mean_ratio(rows, start, PoseMethod::WithPo),
    )
}

/// Every method's cost over its baseline's.
fn ratios(rows: &[Row], start: &str, methods: &[PoseMethod]) -> String {
    let compared = || COMPARED.into_iter().filter(|(method, _)| methods.contains(method));
    let mut shown = table(["environment", "setting"], 0);
    let headings = ["environment", "setting"].into_iter().chain(compared().map(|(_, label)| label));
    shown.set_header(headings);
    for environment in &ENVIRONMENTS {
        for setting in &SETTINGS {
            let cell = |(method, _)| {
                let row = of(rows, start, method)
                    .find(|r| r.environment == environment.number && r.setting == setting.name);
                row.map_or("-".to_owned(), |r| {
                    let doubtful = r.p_value.is_none_or(|p| p >= 0.01);
                    format!("{:.3}{}", r.ratio, if doubtful { "?" } else { "" })
                })
            };
            let named = [environment.number.to_string(), setting.name.to_owned()];
            shown.add_row(named.into_iter().chain(compared().map(cell)).collect::<Vec<_>>());
        }
    }
    let means = compared().map(|(method, _)| format!("{:.3}", mean_ratio(rows, start, method)));
    shown.add_row(["mean".to_owned(), String::new()].into_iter().chain(means).collect::<Vec<_>>());
    for column in shown.column_iter_mut() {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    format!("\nC relative to no pose optimisation; episodes start `{start}`\n{}", table_text(&shown))
}

/// What is compared with its baseline, and what tables and pictures call it.
const COMPARED: [(PoseMethod, &str); 6] = [
    (PoseMethod::WithPo, "with PO"),
    (PoseMethod::WithPoWholeBody, "whole-body"),
    (PoseMethod::Manipulability, "manipulability"),
    (PoseMethod::UniformWeights, "uniform weights"),
    (PoseMethod::TrackedOption, "tracked option"),
    (PoseMethod::WithPoObstacles, "with PO, obstacles"),
];

fn notes(rows: &[Row], methods: &[PoseMethod]) -> String {
    let mut text = "?: p >= 0.01. manipulability: the most manipulable candidate. uniform weights: eq. (8) without P_o.\n\
         tracked option: eq. (8) for that option alone.\n"
        .to_owned();
    text += match methods.contains(&PoseMethod::WithPoObstacles) {
        true => {
            "whole-body: candidates move base and arm. obstacles: the base is kept out of them, compared with no PO under the same limits.\n"
        }
        false => {
            "With bodies: obstacles are kept off, and the base follows the way; pairs of which either did not arrive do not count.\n"
        }
    };
    let lost: usize = rows.iter().map(|r| r.not_arrived).sum();
    let unsolved: u64 = rows.iter().map(|r| r.fallback_steps).sum();
    if lost > 0 {
        let _ = writeln!(text, "{lost} episodes did not arrive.");
    }
    if unsolved > 0 {
        let _ = writeln!(text, "{unsolved} steps had no solution of eq. (7).");
    }
    text
}

fn panels(rows: &[Row], starts: &[&str]) -> Vec<RatioPanel> {
    let paper = RatioRow {
        label: "paper, with PO".to_owned(),
        ratios: ENVIRONMENTS
            .iter()
            .flat_map(|e| {
                let pairs = e.control_cost_with.iter().zip(e.control_cost_without);
                pairs.map(move |(with, without)| (e.number, with / without))
            })
            .collect(),
    };
    starts
        .iter()
        .enumerate()
        .map(|(i, start)| {
            let ours = COMPARED.iter().map(|(method, label)| RatioRow {
                label: (*label).to_owned(),
                ratios: of(rows, start, *method).map(|r| (r.environment, r.ratio)).collect(),
            });
            let ours = ours.filter(|row| !row.ratios.is_empty());
            let papers = (i == 0).then(|| paper.clone());
            RatioPanel {
                title: format!("({}) episodes that start {start}", char::from(b'a' + (i % 26) as u8)),
                rows: ours.chain(papers).collect(),
            }
        })
        .collect()
}

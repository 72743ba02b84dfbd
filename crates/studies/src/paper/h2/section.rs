//! H2: Table II, the Environment 4 example, and the same human in the other environments.

use crate::paper::h2::{self, CostRow, ExampleRun};
use crate::paper::pairs::{SIGNIFICANCE_LEVEL, compared, difference, explained, is_significant, rounded};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, holds, none};
use crate::paper::{ENVIRONMENTS, EXAMPLE_HUMAN, Environment};
use crate::parallel::OnDone;
use crate::statistics::{Estimate, Paired};
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::policy::Method;
use cocarry::world::World;
use cocarry_output::drawing::{
    Curve, CurvePanel, DifferencePanel, DifferenceRow, Sheet, Track, adaptation, curves, differences,
};

/// Table II.
pub(crate) const PART: Part =
    Part { id: "h2", name: "Table II", episodes: |_| h2::EPISODES, studies: none, run: table_2_section };

/// Table II: accumulated objective costs.
pub fn table_2(rows: &[CostRow]) -> Table {
    let baselines = with_baseline(rows);
    let columns = Columns::of(&baselines)
        .numbered("environment", "environment", |(r, _)| r.environment)
        .text("method", "method", |(r, _)| method(r.eta))
        .data("eta", |(r, _)| r.eta)
        .number("paper (m)", "paper_mean_m", 1, |(r, _)| r.paper_mean)
        .number("ours (m)", "ours_mean_m", 1, |(r, _)| r.ours_mean)
        .derived("ours / paper", |(r, _)| format!("{:+.1} %", 100.0 * (r.ours_mean / r.paper_mean - 1.0)))
        .derived("reduction", |(r, without)| format!("{:.1} %", 100.0 * (1.0 - r.ours_mean / without)))
        .spread("20 humans (m)", ["sample_mean_m", "sample_std_m"], 0, |(r, _)| {
            [r.sample_mean, r.sample_std]
        });
    let against = ["sample_against_without", "_m"];
    let table = compared(columns, "their difference (m)", against, |(r, _)| r.sample_against_without)
        .column("transition", false, &["transition_step"], |(r, _)| Cell {
            shown: r.transition_step.map_or("-".to_owned(), |step| format!("step {step}")),
            values: vec![r.transition_step.into()],
        })
        .data("not_arrived", |(r, _)| r.not_arrived)
        .table("table-2", "Table II: accumulated objective cost of an episode")
        .with_note(format!(
            "ours: expectation over a {n} x {n} midpoint grid of (alpha, gamma); 20 humans: mean ± std of {} seeded humans, as in the paper.",
            h2::SAMPLES,
            n = h2::GRID,
        ))
        .with_note("Reduction: ours compared with `without model`. Their difference: the cost of the same 20 humans minus their cost without the model.");
    let tested = rows.iter().filter_map(|r| r.sample_against_without?.p_value).count();
    let table = explained(table, tested, "of this table");
    match rows.iter().map(|r| r.not_arrived).sum::<usize>() {
        0 => table,
        lost => table.with_note(format!("{lost} episodes did not arrive.")),
    }
}

/// The name of a method in the rows of Table II and of others.
pub(crate) fn method(eta: Option<f64>) -> String {
    eta.map_or("without model".to_owned(), |eta| format!("mutual, eta {eta}"))
}

/// Every row with the mean of its environment's row without the model, which comes first.
fn with_baseline(rows: &[CostRow]) -> Vec<(&CostRow, f64)> {
    let mut without = f64::NAN;
    rows.iter()
        .map(|row| {
            if row.method == Method::WITHOUT_MODEL {
                without = row.ours_mean;
            }
            (row, without)
        })
        .collect()
}

/// The four runs of the Environment 4 example.
pub fn example_table(runs: &[ExampleRun]) -> Table {
    Columns::of(runs)
        .text("eta", "eta", |r| r.eta.map_or("without model".to_owned(), |eta| eta.to_string()))
        .count("paper: transition", "paper_transition_step", |r| r.paper.and_then(|(step, _)| step))
        .count("ours: transition", "transition_step", |r| r.summary.transition.map(|t| t.step))
        .column("paper: ends on", false, &["paper_ends_on"], |r| Cell {
            shown: r.paper.map_or("-".to_owned(), |(_, option)| format!("option {option}")),
            values: vec![r.paper.map(|(_, option)| option).into()],
        })
        .column("ours: ends on", false, &["ends_on"], |r| Cell {
            shown: format!("option {}", r.ended_on),
            values: vec![r.ended_on.clone().into()],
        })
        .number("cost (m)", "accumulated_objective_cost_m", 1, |r| r.summary.accumulated_cost)
        .count("steps", "steps", |r| r.summary.steps)
        .table(
            "example-environment-4",
            format!(
                "Environment 4 example: a human (alpha {}, gamma {}) who starts out preferring option 4",
                EXAMPLE_HUMAN.alpha, EXAMPLE_HUMAN.gamma
            ),
        )
}

/// Trajectories and phi(k) of an example.
///
/// # Errors
/// If the period is not a positive time.
pub fn example_picture(world: &World, runs: &[ExampleRun], period: f64) -> Result<String, Error> {
    let tracks = runs.iter().map(|run| Track::new(label(run), &run.ticks, Some(world.target)));
    adaptation(world, &tracks.collect::<Vec<_>>(), period, Sheet::default())
}

fn label(run: &ExampleRun) -> String {
    run.eta.map_or("without model".to_owned(), |eta| format!("\u{3b7} = {eta}"))
}

fn table_2_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let settings = &plan.settings;
    let rows = h2::table(settings, plan.seed, on_done)?;
    let mut blocks = vec![
        Block::Text(
            "The robot leads until the human's stubbornness \u{3c6}(k), eq. (5), exceeds 1, and follows from then on. While it leads, it takes the option of eq. (6). \
             Without the model, the human leads from start to end on the option preferred at the start."
                .to_owned(),
        ),
        Block::Table(table_2(&rows)),
        Block::Figure(Figure {
            name: "table-2".to_owned(),
            caption: format!(
                "Table II: accumulated objective cost minus that of the same human without the model, {} humans per cell; left of 0, adapting pays. \
                 No interval where all humans make the same choices.",
                h2::SAMPLES
            ),
            is_half: false,
            svg: differences(&panels(&rows), DIFFERENCE_AXIS, Sheet::default())?,
        }),
    ];
    // the paper's example first, then the same human elsewhere
    for environment in ENVIRONMENTS.iter().rev() {
        let (world, runs) = h2::example(environment, settings)?;
        let number = environment.number;
        let is_papers = runs.iter().any(|run| run.paper.is_some());
        if is_papers {
            blocks.push(Block::Table(example_table(&runs)));
            blocks.push(Block::Figure(Figure {
                name: "discomfort".to_owned(),
                caption: format!(
                    "Environment {number} example: accumulated discomfort g(k) and stubbornness \u{3c6}(k), eq. (5), up to the transition."
                ),
                is_half: false,
                svg: curves(&growth(&runs))?,
            }));
        }
        let whose = if is_papers { "example" } else { "with the human of the example" };
        blocks.push(Block::Figure(Figure {
            name: format!("example-environment-{number}"),
            caption: format!(
                "Environment {number} {whose}: trajectories, a cross where the human takes the lead; \u{3c6}(k)."
            ),
            is_half: !is_papers,
            svg: example_picture(&world, &runs, settings.planning_step)?,
        }));
    }
    let title = "H2: adapting to each other".to_owned();
    Ok(Section { title, finding: finding(&rows), blocks })
}

/// The title of the axis of differences.
pub(crate) const DIFFERENCE_AXIS: &str = "cost minus cost without the model (m)";

/// The differences of Table II, one panel for each environment.
fn panels(rows: &[CostRow]) -> Vec<DifferencePanel> {
    let pairs = with_baseline(rows);
    let panel = |environment: &Environment| {
        let of = pairs.iter().filter(|(row, _)| row.environment == environment.number);
        let row = |(row, without): &(&CostRow, f64)| {
            let Estimate { mean, interval, .. } = row.sample_against_without?.difference;
            Some(DifferenceRow {
                label: method(row.eta),
                mean,
                interval,
                expected: Some(row.ours_mean - without),
                paper: Some(row.paper_mean - environment.objective_cost[0]),
            })
        };
        DifferencePanel {
            title: format!("Environment {}", environment.number),
            rows: of.filter_map(row).collect(),
        }
    };
    ENVIRONMENTS.iter().map(panel).collect()
}

/// g(k) and phi(k) of the robot-led runs, up to their transitions.
fn growth(runs: &[ExampleRun]) -> Vec<CurvePanel> {
    let led = || runs.iter().filter(|run| run.eta.is_some());
    let curve = |run: &ExampleRun, of: fn(&cocarry::episode::Tick) -> f64| {
        let last = run.summary.transition.map_or(u64::MAX, |t| t.step);
        let ticks = run.ticks.iter().filter(|t| t.step <= last);
        Curve { label: label(run), points: ticks.map(|t| [t.step as f64, of(t)]).collect() }
    };
    let panel = |title: &str, letter: &str, mark: Option<f64>, of: fn(&cocarry::episode::Tick) -> f64| {
        let curves: Vec<Curve> = led().map(|run| curve(run, of)).collect();
        let end =
            |axis: usize| curves.iter().flat_map(|c| &c.points).map(|p| p[axis]).fold(1.0, f64::max) * 1.06;
        let ranges = [[0.0, end(0)], [0.0, end(1)]];
        let axes = ["step k".to_owned(), letter.to_owned()];
        CurvePanel { title: title.to_owned(), axes, ranges, mark, curves }
    };
    vec![
        panel("discomfort", "g(k)", None, |tick| tick.discomfort),
        panel("stubbornness", "\u{3c6}(k)", Some(1.0), |tick| tick.stubbornness),
    ]
}

fn finding(rows: &[CostRow]) -> Finding {
    let pairs: Vec<(&CostRow, f64)> =
        with_baseline(rows).into_iter().filter(|(row, _)| row.eta.is_some()).collect();
    let reductions: Vec<f64> =
        pairs.iter().map(|(row, without)| 100.0 * (1.0 - row.ours_mean / without)).collect();
    let cheaper = reductions.iter().filter(|r| **r > 0.0).count();
    let most = reductions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = reductions.iter().copied().fold(f64::INFINITY, f64::min);
    let off = rows.iter().map(|r| 100.0 * (r.ours_mean / r.paper_mean - 1.0).abs());
    let lost: usize = rows.iter().map(|r| r.not_arrived).sum();
    let (sample, shown) = sampled(&pairs);
    Finding {
        claim: "H2: with a mode transition by stubbornness, the team's objective cost is lower than with a human who always leads",
        verdict: format!(
            "{} in expectation; {} humans show it in {shown} of {} cells",
            holds(cheaper, pairs.len(), "cells"),
            h2::SAMPLES,
            pairs.len()
        ),
        figures: format!(
            "expectation over all humans (no sample, no test): lower in {cheaper} of {} cells, by {least:.1} to {most:.1} % (mean {:.1} %); {sample}; means within {:.1} % of the paper's (calibrated to them); {}",
            pairs.len(),
            reductions.iter().sum::<f64>() / reductions.len() as f64,
            off.fold(0.0, f64::max),
            if lost == 0 {
                "every episode arrived".to_owned()
            } else {
                format!("{lost} episodes did not arrive")
            },
        ),
    }
}

/// The result of the paper's own protocol, a sample of random humans, for the cells with the model; and the
/// number of cells in which it shows a lower cost.
fn sampled(pairs: &[(&CostRow, f64)]) -> (String, usize) {
    let all: Vec<_> = pairs.iter().filter_map(|(row, _)| Some((row, row.sample_against_without?))).collect();
    let is_lower = |paired: &Paired| paired.difference.mean < 0.0;
    let lower = all.iter().filter(|(_, paired)| is_lower(paired)).count();
    let shown = all.iter().filter(|(_, paired)| is_lower(paired) && is_significant(paired)).count();
    let mut text = format!(
        "the paper's protocol, {} random humans: lower in {lower} of {} cells, significantly (p < {SIGNIFICANCE_LEVEL}, Holm) in {shown}",
        h2::SAMPLES,
        all.len()
    );
    for (row, paired) in all.iter().filter(|(_, paired)| !is_lower(paired)) {
        text += &format!(
            ", not lower in Environment {}, {}: {} m, p {}",
            row.environment,
            method(row.eta),
            difference(paired, 0),
            rounded(paired.p_holm)
        );
    }
    (text, shown)
}

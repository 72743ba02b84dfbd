//! Figures of the page of results, and of the README.

use super::Figure;
use super::tables::{FigureRow, Tables, counted, grouped, largest, least, line, mean};
use crate::support::repository;
use cocarry::episode::{EpisodeSettings, prospects};
use cocarry::options::OptionSet;
use cocarry::preference::ChoiceDistribution;
use cocarry::scenario::WorldText;
use cocarry::world::World;
use cocarry_studies::paper::ENVIRONMENTS;
use cocarry_studies::paper::h2::{GRID, expected_costs};

/// The postures at the start of Table III, and the table of their ratios.
const UP: &str = "table-3-ratios-elbow-up";
const OUT: &str = "table-3-ratios-elbow-out";
const OMNI: &str = "table-3-omni-ratios-elbow-up";

pub const FIGURES: &[Figure] = &[
    ("table-1.mean-difference", |t| format!("{:.1}", mean(&table_1(t)))),
    ("table-1.largest-difference", |t| format!("{:.1}", largest(&table_1(t)))),
    ("table-2.difference-of-1-3-4", |t| {
        let all = ["1", "3", "4"].map(|environment| largest(&table_2(t, environment)));
        format!("{:.1} %", largest(&all))
    }),
    ("table-2.difference-of-2", |t| format!("{:.1} %", largest(&table_2(t, "2")))),
    ("table-2.largest-difference", |t| {
        let all = ["1", "2", "3", "4"].map(|environment| largest(&table_2(t, environment)));
        format!("{:.1} %", largest(&all))
    }),
    ("table-2.spread", |t| {
        let of = |environment| t.column("table-2", &[("environment", environment)], "sample_std_m");
        let all = [of("1"), of("4")].concat();
        format!("{:.0} to {:.0} m", least(&all), largest(&all))
    }),
    ("environment-2.cells", environment_2),
    ("environment-2.rise", |t| {
        let paper = ENVIRONMENTS[1].objective_cost;
        let falls = |costs: &[f64]| costs.windows(2).all(|pair| pair[1] <= pair[0]);
        assert!(falls(&paper) && falls(&t.column("table-2", &[("environment", "2")], "ours_mean_m")));
        let [without, five, ten, _] =
            expected_costs(anew(), &EpisodeSettings::default(), GRID).expect("a world");
        assert!(five > without && ten > without, "H2 holds in {ANEW}: it may replace the built-in geometry");
        format!("{:.1} m with eta 5 and {:.1} m with eta 10.5", five - without, ten - without)
    }),
    ("risk-weight.least-squares", |t| format!("{:.2} m", risk_weight(t, "least squares", "risk_weight_m"))),
    ("risk-weight.likelihood", |t| format!("{:.2} m", risk_weight(t, "likelihood", "risk_weight_m"))),
    ("risk-weight.lapse", |t| format!("{:.0} %", 100.0 * risk_weight(t, "likelihood", "lapse"))),
    ("risk-weight.held-out-least-squares", |t| {
        format!("{:.1}", risk_weight(t, "least squares", "held_out_rms_points"))
    }),
    ("risk-weight.held-out-likelihood", |t| {
        format!("{:.1}", risk_weight(t, "likelihood", "held_out_rms_points"))
    }),
    ("table-3.costs-by-default", |t| choice_costs(t, "none", "default")),
    ("table-3.costs-at-shorter-periods", |t| choice_costs(t, "control period (s)", "0.1")),
    ("table-3.costs-at-shorter-steps", |t| choice_costs(t, "planning step (s)", "0.1")),
    ("table-3.costs-at-any-yaw-rate", |t| choice_costs(t, "yaw rate (rad/s)", "not limited")),
    ("cycles.worlds", |t| grouped(t.row("cycles", &[]).number("worlds"))),
    ("cycles.with-choice", |t| grouped(t.row("cycles", &[]).number("with_choice"))),
    ("cycles.changed", |t| grouped(t.row("cycles", &[]).number("with_changes"))),
    ("cycles.most", |t| grouped(t.row("cycles", &[]).number("most_changes"))),
    ("cycles.dropped-soon", |t| grouped(t.row("cycles", &[]).number("dropped_soon"))),
    ("cycles.dropped-phi", |t| grouped(t.row("cycles", &[]).number("dropped_by_stubbornness"))),
    ("cycles.dropped-gap", |t| grouped(t.row("cycles", &[]).number("dropped_by_opening"))),
    ("cycles.dropped-length", |t| grouped(t.row("cycles", &[]).number("dropped_by_length"))),
    ("cycles.dropped-perceived", |t| grouped(t.row("cycles", &[]).number("dropped_by_perception"))),
    ("kinematic.worlds", |t| grouped(t.row("cycles-kinematic", &[]).number("worlds"))),
    ("kinematic.counterexamples", |t| counted(t.row("cycles-kinematic", &[]).number("counterexamples"))),
    ("kinematic.lost", |t| grouped(t.row("cycles-kinematic", &[]).number("lost_object"))),
    ("cycles.detour", |t| format!("{:.1}", t.row("cycles", &[]).number("longest_detour"))),
    ("cycles.counterexamples", |t| match t.row("cycles", &[]).number("counterexamples") {
        0.0 => "no counterexample".to_owned(),
        1.0 => "one counterexample".to_owned(),
        n => format!("{} counterexamples", grouped(n)),
    }),
    ("table-3.rows", table_3),
    ("table-3.cells", |t| {
        let ratios = t.column("table-3-elbow-up", &[], "ratio");
        format!("{} of {}", ratios.iter().filter(|ratio| **ratio < 1.0).count(), ratios.len())
    }),
    ("table-3.pairs", |t| {
        let sum = |column| t.column("table-3-elbow-up", &[], column).iter().sum::<f64>();
        format!("{} of {}", grouped(sum("wins")), grouped(sum("episodes")))
    }),
    ("table-3.ratio", |t| ratio(t, UP, "with_po")),
    ("table-3.paper-ratio", |t| {
        let ratios = t.rows("table-3-elbow-up", &[]);
        let ratios: Vec<f64> =
            ratios.iter().map(|row| row.number("paper_with_po") / row.number("paper_without_po")).collect();
        format!("{:.3}", mean(&ratios))
    }),
    ("table-3.ratio-from-elbow-out", |t| ratio(t, OUT, "with_po")),
    ("table-3.cells-from-elbow-out", |t| {
        let ratios = cells(t, OUT, "with_po");
        format!("{} of {}", ratios.iter().filter(|ratio| **ratio < 1.0).count(), ratios.len())
    }),
    ("table-3.uniform", |t| ratio(t, UP, "uniform_weights")),
    ("table-3.tracked", |t| ratio(t, UP, "tracked_option")),
    ("table-3.manipulability", |t| ratio(t, UP, "manipulability")),
    ("table-3.manipulability-from-elbow-out", |t| ratio(t, OUT, "manipulability")),
    ("table-3.whole-body", |t| ratio(t, UP, "whole_body")),
    ("table-3.whole-body-from-elbow-out", |t| ratio(t, OUT, "whole_body")),
    ("table-3.obstacles", |t| ratio(t, UP, "with_po_obstacles")),
    ("table-3.lost-with-po", |t| lost(t, "with-po")),
    ("table-3.lost-without-po", |t| lost(t, "without-po")),
    ("table-3.choices", choices),
    ("table-3.omni-rows", omnidirectional),
    ("table-3.ratio-omni", |t| ratio(t, OMNI, "with_po")),
    ("table-3.ratio-omni-from-elbow-out", |t| ratio(t, "table-3-omni-ratios-elbow-out", "with_po")),
    ("table-3.uniform-omni", |t| ratio(t, OMNI, "uniform_weights")),
    ("table-3.omni-cheaper-without-po", |t| below(t, "without_po_mean", "without_po_mean")),
    ("table-3.omni-cheaper-than-with-po", |t| below(t, "without_po_mean", "with_po_mean")),
    ("table-3.omni-wins-in-4", |t| {
        let wins = t.column("table-3-omni-elbow-up", &[("environment", "4")], "wins");
        let of = largest(&t.column("table-3-omni-elbow-up", &[("environment", "4")], "episodes"));
        format!("{:.0} to {:.0} of {of:.0}", least(&wins), largest(&wins))
    }),
    ("table-3.overlaps-with-po", |t| overlaps(t, "with-po")),
    ("table-3.overlaps-without-po", |t| overlaps(t, "without-po")),
    ("table-3.overlaps-avoided", |t| overlaps(t, "with-po-obstacles")),
];

/// The geometry of Environment 2 that was searched for anew.
const ANEW: &str = "docs/data/environment-2-anew.toml";

fn anew() -> WorldText {
    WorldText { file: ANEW.to_owned(), text: std::fs::read_to_string(repository(ANEW)).unwrap() }
}

/// Tables I and II of the geometry that was searched for anew, worked out here, next to the kept ones of the
/// built-in geometry.
fn environment_2(t: &Tables) -> String {
    let settings = EpisodeSettings::default();
    let costs = |world: WorldText| expected_costs(world, &settings, GRID).expect("a world");
    let choices = |world: &World| -> Vec<f64> {
        let set = OptionSet::new(world, settings.predictor.risk_weight()).expect("options");
        let mut choice = ChoiceDistribution::default();
        settings.predictor.clone().predict(&prospects(&set, &set.begin()), &mut choice);
        choice.probabilities().iter().map(|p| 100.0 * p).collect()
    };
    let paper = &ENVIRONMENTS[1];
    let (file, anew) = (ANEW, anew());
    let built_in = |table: &str, column: &str| t.column(table, &[("environment", "2")], column);
    let rows = [
        choices(&World::parse(file, &anew.text).unwrap()),
        built_in("table-1", "ours_percent"),
        costs(anew).to_vec(),
        built_in("table-2", "ours_mean_m"),
    ];
    let mut text = line(["", "paper", "anew", "built in"]) + &line([":--", "--:", "--:", "--:"]);
    for (o, percent) in paper.model_percent.iter().enumerate() {
        text += &line([
            format!("Table I, option {}", o + 1),
            format!("{percent:.1} %"),
            format!("{:.1} %", rows[0][o]),
            format!("{:.1} %", rows[1][o]),
        ]);
        assert!((rows[0][o] - percent).abs() < 1.2, "{file}: Table I, option {}", o + 1);
    }
    for (o, column) in ["without model", "eta 5", "eta 10.5", "eta 15"].into_iter().enumerate() {
        let paper = paper.objective_cost[o];
        let cell = |ours: f64| format!("{ours:.1} m ({:+.1} %)", 100.0 * (ours / paper - 1.0));
        text += &line([
            format!("Table II, {column}"),
            format!("{paper:.1} m"),
            cell(rows[2][o]),
            cell(rows[3][o]),
        ]);
        assert!((rows[2][o] / paper - 1.0).abs() < 0.05, "{file}: Table II, {column}");
    }
    text
}

fn risk_weight(t: &Tables, by: &str, column: &str) -> f64 {
    t.row("risk-weight", &[("by", by)]).number(column)
}

/// Differences of the model cells of Table I to the paper's, percentage points.
fn table_1(t: &Tables) -> Vec<f64> {
    let rows = t.rows("table-1", &[]);
    rows.iter().map(|row| (row.number("ours_percent") - row.number("paper_percent")).abs()).collect()
}

/// Differences of the cells of Table II to the paper's in an environment, in percent.
fn table_2(t: &Tables, environment: &str) -> Vec<f64> {
    let rows = t.rows("table-2", &[("environment", environment)]);
    let of = |column: &'static str| rows.iter().map(move |row| row.number(column));
    of("ours_mean_m")
        .zip(of("paper_mean_m"))
        .map(|(ours, paper)| 100.0 * (ours / paper - 1.0).abs())
        .collect()
}

pub fn cells(t: &Tables, table: &str, method: &str) -> Vec<f64> {
    t.rows(table, &[])
        .iter()
        .filter(|row| !row.text("setting").is_empty())
        .map(|row| row.number(method))
        .collect()
}

/// The mean ratio of a method's costs to its baseline's.
pub fn ratio(t: &Tables, table: &str, method: &str) -> String {
    format!("{:.3}", mean(&cells(t, table, method)))
}

/// The share of episodes in which the base overlaps an obstacle.
fn overlaps(t: &Tables, method: &str) -> String {
    let with = [("start", "elbow-up"), ("method", method)];
    let sum = |column| t.column("table-3-all", &with, column).iter().sum::<f64>();
    format!("{:.0} %", 100.0 * sum("overlapping_episodes") / sum("episodes"))
}

/// Table III: without and with pose optimisation, and what it saves, ours and the paper's.
fn table_3(t: &Tables) -> String {
    let mut text = line(["environment", "", "S1", "S2", "S3", "S4"]) + &line(["---"; 6]);
    for environment in ["1", "2", "3", "4"] {
        let rows = t.rows("table-3-elbow-up", &[("environment", environment)]);
        for method in ["without", "with"] {
            let cells = rows.iter().map(|row| {
                let number = |column: String| row.number(&column);
                let [mean, std] = ["mean", "std"].map(|part| number(format!("{method}_po_{part}")));
                format!("{mean:.0} ± {std:.0} ({:.0})", number(format!("paper_{method}_po")))
            });
            let first = if method == "without" { environment } else { "" };
            let titles = [first.to_owned(), format!("{method} PO, ours (paper)")];
            text += &line(titles.into_iter().chain(cells));
        }
        let cells = rows.iter().map(|row| {
            let saving = |with: &str, without: &str| 100.0 * (1.0 - row.number(with) / row.number(without));
            let ours = saving("with_po_mean", "without_po_mean");
            format!("{ours:.0} % ({:.0} %)", saving("paper_with_po", "paper_without_po"))
        });
        text += &line([String::new(), "saving, ours (paper)".to_owned()].into_iter().chain(cells));
    }
    text
}

/// The share of episodes in which the grasp was off by more than 10 cm.
fn lost(t: &Tables, method: &str) -> String {
    let with = [("start", "elbow-up"), ("method", method)];
    let sum = |column| t.column("table-3-all", &with, column).iter().sum::<f64>();
    format!("{:.0} %", 100.0 * sum("lost_object") / sum("episodes"))
}

/// Cells in which the omnidirectional base costs less than the one on two wheels.
fn below(t: &Tables, omnidirectional: &str, two_wheels: &str) -> String {
    let of = |table: &str, column: &str| t.column(table, &[], column);
    let pairs: Vec<(f64, f64)> = of("table-3-omni-elbow-up", omnidirectional)
        .into_iter()
        .zip(of("table-3-elbow-up", two_wheels))
        .collect();
    format!("{} of {}", pairs.iter().filter(|(omni, two)| omni < two).count(), pairs.len())
}

/// Savings by pose optimisation on two wheels and on the omnidirectional base.
fn omnidirectional(t: &Tables) -> String {
    let mut text = line(["environment", "S1", "S2", "S3", "S4"]) + &line(["---"; 5]);
    for environment in ["1", "2", "3", "4"] {
        let savings = ["table-3-elbow-up", "table-3-omni-elbow-up"]
            .map(|table| t.column(table, &[("environment", environment)], "ratio"));
        let saving = |ratio: f64| format!("{:.0} %", 100.0 * (1.0 - ratio));
        let cells = savings[0].iter().zip(&savings[1]);
        let cells = cells.map(|(two, omni)| format!("{} / {}", saving(*two), saving(*omni)));
        text += &line([environment.to_owned()].into_iter().chain(cells));
    }
    text
}

/// Mean C without and with pose optimisation where a choice is made otherwise.
fn choice_costs(t: &Tables, choice: &str, value: &str) -> String {
    let row = t.row("table-3-choices", &[("choice", choice), ("value", value)]);
    format!("{:.0} and {:.0}", row.number("cost_without_po"), row.number("cost_with_po"))
}

/// The mean ratio and that of the worst cell for every value of every choice.
fn choices(t: &Tables) -> String {
    let cell =
        |row: &FigureRow| format!("{:.3} ({:.3})", row.number("mean_ratio"), row.number("worst_ratio"));
    let of = |choice: &str| t.rows("table-3-choices", &[("choice", choice)]);
    let mut text = line(["choice", "default", "others"]) + &line(["---"; 3]);
    text += &line(["all", &cell(of("none")[0]), ""]);
    for (choice, title, default) in [
        ("yaw rate (rad/s)", "yaw rate of the reference, rad/s", "0.8"),
        ("concentration", "concentration of the walking direction's likelihood", "20"),
        ("walking speed (m/s)", "walking speed, m/s", "0.5"),
        ("kappa", "kappa (given by the paper)", "1"),
        ("control period (s)", "control period, s", "0.2"),
        ("planning step (s)", "planning step, s", "0.2"),
    ] {
        let others = of(choice).into_iter().map(|row| format!("{}: {}", row.text("value"), cell(row)));
        text += &line([title, default, &others.collect::<Vec<_>>().join("; ")]);
    }
    text
}

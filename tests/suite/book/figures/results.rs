//! Figures of the page of results, and of the README.

use super::Figure;
use super::tables::{Tables, counted, grouped, largest, least, line, mean};

/// The postures at the start of Table III, and the table of their ratios.
const UP: &str = "table-3-ratios-elbow-up";
const OUT: &str = "table-3-ratios-elbow-out";

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
    ("cycles.worlds", |t| grouped(t.row("cycles", &[]).number("worlds"))),
    ("cycles.with-choice", |t| grouped(t.row("cycles", &[]).number("with_choice"))),
    ("cycles.changed", |t| grouped(t.row("cycles", &[]).number("with_changes"))),
    ("cycles.most", |t| grouped(t.row("cycles", &[]).number("most_changes"))),
    ("cycles.detour", |t| format!("{:.1}", t.row("cycles", &[]).number("longest_detour"))),
    ("cycles.counterexamples", |t| match t.row("cycles", &[]).number("counterexamples") {
        0.0 => "no counterexample".to_owned(),
        1.0 => "one counterexample".to_owned(),
        n => format!("{} counterexamples", grouped(n)),
    }),
    ("bodies.worlds", |t| grouped(t.row("worlds-with-bodies", &[]).number("worlds"))),
    ("bodies.with-choice", |t| grouped(t.row("worlds-with-bodies", &[]).number("with_choice"))),
    ("bodies.arrived", |t| grouped(t.row("worlds-with-bodies", &[]).number("arrived"))),
    ("bodies.touched", |t| {
        let row = t.row("worlds-with-bodies", &[]);
        let by = ["touched_by_robot", "touched_by_object", "touched_by_human"];
        counted(by.iter().map(|column| row.number(column)).sum())
    }),
    ("bodies.ended-otherwise", |t| counted(t.row("worlds-with-bodies", &[]).number("ended_otherwise"))),
    ("bodies.detour", |t| format!("{:.1}", t.row("worlds-with-bodies", &[]).number("longest_detour"))),
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
    ("table-3.overlaps-with-po", |t| overlaps(t, "with-po")),
    ("table-3.overlaps-without-po", |t| overlaps(t, "without-po")),
    ("table-3.overlaps-avoided", |t| overlaps(t, "with-po-obstacles")),
    ("bodies-table-2.arrived", |t| {
        let sum = |column| t.column("table-2-bodies", &[], column).iter().sum::<f64>();
        format!("{:.0} of {:.0}", sum("arrived"), sum("humans"))
    }),
    ("bodies-table-2.same-option", |t| {
        format!("{:.0}", t.column("table-2-bodies", &[], "same_option").iter().sum::<f64>())
    }),
    ("bodies-table-2.within-5-percent", |t| {
        format!("{:.0}", t.column("table-2-bodies", &[], "within_5_percent").iter().sum::<f64>())
    }),
    ("bodies-table-2.grip-cm", |t| {
        format!("{:.1} cm", 100.0 * largest(&t.column("table-2-bodies", &[], "largest_grip_deflection_m")))
    }),
    ("bodies-table-2.dearer", |t| {
        let ratios = t.column("table-2-bodies", &[], "mean_ratio");
        format!("{:.1} to {:.1} %", 100.0 * (least(&ratios) - 1.0), 100.0 * (largest(&ratios) - 1.0))
    }),
    ("bodies-table-2.transition-steps", |t| {
        let steps: Vec<f64> = transitions(t).iter().map(|steps| steps.abs()).collect();
        format!("{:.0}", largest(&steps))
    }),
    ("bodies-table-2.same-transition", |t| {
        let steps = transitions(t);
        format!("{} of {}", steps.iter().filter(|steps| **steps == 0.0).count(), steps.len())
    }),
    ("bodies-table-2.dearest", |t| {
        let ratios = t.column("table-2-bodies", &[], "farthest_ratio");
        format!("{:.0} %", 100.0 * (largest(&ratios) - 1.0))
    }),
    ("contacts.walks", |t| grouped(t.column("contacts", &[], "walks").iter().sum())),
    ("contacts.walks-per-opening", |t| grouped(largest(&t.column("contacts", &[], "walks")))),
    ("contacts.touched", |t| {
        let by = ["touched_by_robot", "touched_by_object", "touched_by_human"];
        counted(by.iter().flat_map(|column| t.column("contacts", &[], column)).sum())
    }),
    ("contacts.rows", |t| {
        let cell = |value: f64| format!("{:.1}", 100.0 * value);
        let rows = t.rows("contacts", &[]);
        let of = |title: &str, cells: Vec<String>| line([title.to_owned()].into_iter().chain(cells));
        let risks = rows.iter().map(|row| row.text("risk").to_owned()).collect();
        let free = |risk: f64, width: f64| cell(0.5 * width * (1.0 - risk));
        of("S", risks)
            + &line(vec!["---"; rows.len() + 1])
            + &of(
                "half of the free width, (w - d_r) / 2, cm",
                rows.iter().map(|row| free(row.number("risk"), row.number("width_m"))).collect(),
            )
            + &of(
                "smallest clearance of the team, mean, cm",
                rows.iter().map(|row| cell(row.number("clearance_m"))).collect(),
            )
    }),
];

/// Differences of the model cells of Table I to the paper's, percentage points.
fn table_1(t: &Tables) -> Vec<f64> {
    let rows = t.rows("table-1", &[]);
    rows.iter().map(|row| (row.number("ours_percent") - row.number("paper_percent")).abs()).collect()
}

/// Differences of the cells of Table II to the paper's in an environment, in percent.
fn table_2(t: &Tables, environment: &str) -> Vec<f64> {
    let rows = t.rows("table-2", &[("environment", environment)]);
    let of = |column: &'static str| rows.iter().map(move |row| row.number(column));
    of("ours_mean_m").zip(of("paper_mean_m")).map(|(ours, paper)| 100.0 * (ours / paper - 1.0).abs()).collect()
}

fn cells(t: &Tables, table: &str, method: &str) -> Vec<f64> {
    t.rows(table, &[]).iter().filter(|row| row.text("setting") != "").map(|row| row.number(method)).collect()
}

/// The mean ratio of a method's costs to its baseline's.
fn ratio(t: &Tables, table: &str, method: &str) -> String {
    format!("{:.3}", mean(&cells(t, table, method)))
}

/// The share of episodes in which the base overlaps an obstacle.
fn overlaps(t: &Tables, method: &str) -> String {
    let with = [("start", "elbow-up"), ("method", method)];
    let sum = |column| t.column("table-3-all", &with, column).iter().sum::<f64>();
    format!("{:.0} %", 100.0 * sum("overlapping_episodes") / sum("episodes"))
}

fn transitions(t: &Tables) -> Vec<f64> {
    t.rows("table-2-bodies", &[]).iter().filter_map(|row| row.maybe("transition_difference_steps")).collect()
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

//! The table of `benches/results.json`, which `cargo bench` keeps.

#[path = "../../../../benches/rows/file.rs"]
mod file;

use super::Figure;
use crate::support::repository;
use file::{Comparison, Results, Row};

pub const FIGURES: &[Figure] = &[("benches.table", |_| table(&Results::read(&repository(""))))];

fn table(results: &Results) -> String {
    let mut text =
        "| bench | what | measured | against | commit |\n| --- | --- | --- | --- | --- |\n".to_owned();
    let (mut bench, mut origins) = ("", Vec::new());
    for row in &results.rows {
        let Row { name, unit, value, against, measured, .. } = row;
        let new = if row.bench == bench { String::new() } else { format!("`{}`", row.bench) };
        bench = &row.bench;
        let comparison = |other: &Comparison| {
            let (what, ratio) = other.described(unit);
            format!("{what}: {ratio}")
        };
        let against: Vec<String> = against.iter().map(comparison).collect();
        let cells = [&new, name, &value.with_unit(unit), &against.join("; "), &measured.commit];
        text += &format!("| {} |\n", cells.map(String::as_str).join(" | "));
        if !origins.contains(measured) {
            origins.push(measured.clone());
        }
    }
    let origins: Vec<String> = origins.iter().map(ToString::to_string).collect();
    text + &format!("\nCommits, with version, date and cores: {}.\n", origins.join("; "))
}

#[test]
fn every_bench_of_the_kept_results_is_there() {
    let results = Results::read(&repository(""));
    assert!(!results.rows.is_empty());
    for Row { bench, .. } in results.rows {
        let file = if bench.contains('.') { bench } else { format!("{bench}.rs") };
        assert!(repository(&format!("benches/{file}")).is_file(), "{file}");
    }
}

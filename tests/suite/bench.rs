//! The benchmark: its files, who counts, and the score worked out again from the rows.

use crate::support::{repository, stderr, stdout};
use cocarry_studies::study::Study;
use cocarry_studies::study::bench::{Best, FILES, Set};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("a program")
}

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

fn refused(folder: &Path, arguments: &[&str], said: &[&str]) {
    let output = run(folder, arguments);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert!(said.iter().all(|part| error.contains(part)), "{arguments:?}: {error}");
}

/// A folder with the benchmark in it.
fn written() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let told = good(folder.path(), &["bench", "b"]);
    assert!(
        told.contains("wrote cocarry bench 1 into b") && told.contains("cocarry sweep b/small.toml"),
        "{told}"
    );
    folder
}

/// Every file of `assets/bench-1` ships, except the best known results, and what made them and the worlds.
#[test]
fn all_files_of_the_benchmark_are_written() {
    fn names(folder: &Path, within: &str, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry")) {
            let name = format!("{within}{}", entry.file_name().to_str().expect("a name"));
            match entry.path().is_dir() {
                true => names(&entry.path(), &format!("{name}/"), found),
                false => found.push(name),
            }
        }
    }
    let (mut there, mut shipped) = (Vec::new(), FILES.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    names(&repository("assets/bench-1"), "", &mut there);
    there.retain(|name| !["make.py", "best.py", "best.csv"].contains(&name.as_str()));
    there.sort();
    shipped.sort_unstable();
    assert_eq!(there, shipped);
    let folder = written();
    // again: nothing is written; a changed file is not replaced without a word
    assert!(good(folder.path(), &["bench", "b"]).contains("has the files of"));
    std::fs::write(folder.path().join("b/worlds/walls-1.toml"), "name = \"mine\"").expect("a file");
    refused(folder.path(), &["bench", "b"], &["exists already"]);
}

/// The benchmark does not change: a number that moves here is a change of worlds, humans or robots, or of the
/// program's version, for which the best known results must be measured anew.
#[test]
fn the_studies_are_those_of_the_best_known_results() {
    let folder = written();
    for (set, digest) in Set::ALL.into_iter().zip(["063d11e8f46a6510", "36c1040f624e28ea"]) {
        let file = folder.path().join("b").join(set.file());
        let study = Study::load(&file, None).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(study.episodes(), set.episodes(), "{set:?}");
        let best: Vec<Best> = Best::all().filter(|best| best.set == set).collect();
        let worlds = if set == Set::Small { 6 } else { 30 };
        assert_eq!(best.len(), worlds, "{set:?}");
        assert!(best.iter().all(|best| best.result > 0.0), "{set:?}");
        assert_eq!(study.digest(), digest, "{set:?}");
    }
}

fn cells(file: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(file).expect("results");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn closed_form_scores_are_those_of_the_rows_and_only_whole_unchanged_sets_count() {
    let folder = written();
    let here = folder.path();
    for (method, out) in [("robot-led", "r.csv"), ("mutual", "m.csv")] {
        good(here, &["sweep", "b/small.toml", "--method", method, "-o", out]);
    }
    let text = |name: &str| std::fs::read_to_string(here.join(name)).expect("results");
    let write = |name: &str, text: &str| std::fs::write(here.join(name), text).expect("a file");
    let (first, second) = (text("r.csv"), text("m.csv"));
    write("two.csv", &format!("{first}{}", second.split_once('\n').expect("a header").1));
    let card: Value = serde_json::from_str(&good(here, &["bench", "b", "two.csv", "--json"])).expect("JSON");
    let rows = cells(&here.join("two.csv"));
    assert_eq!(rows.len(), 120);
    let entries = card["entries"].as_array().expect("entries");
    assert_eq!(entries.len(), 2);
    for entry in entries {
        let policy = entry["policy"].as_str().expect("a policy");
        let own: Vec<_> = rows.iter().filter(|row| row["method"] == policy).collect();
        let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().expect("a number");
        let succeeds = |row: &BTreeMap<String, String>| {
            row["outcome"] == "arrived" && number(row, "overruled_time_s") == 0.0
        };
        let succeeded = own.iter().filter(|row| succeeds(row)).count() as f64;
        assert_eq!(entry["success_percent"], 100.0 * succeeded / 60.0);
        let mut shares = BTreeMap::<&str, f64>::new();
        for row in own.iter().filter(|row| succeeds(row)) {
            let best = Best::all()
                .find(|best| best.set == Set::Small && best.world == row["world"])
                .expect("a best");
            *shares.entry(&row["world"]).or_default() +=
                1.0 / number(row, "accumulated_objective_cost_m") / best.result / 10.0;
        }
        let score = 100.0 * shares.values().sum::<f64>() / 6.0;
        let found = entry["score"].as_f64().expect("a score");
        assert!((found - score).abs() < 1e-9, "{policy}: {found}, not {score}");
        assert!(policy != "robot-led" || succeeded < 60.0, "a robot that never gives way overrules somebody");
    }
    // a file of each policy is the same
    let apart: Value =
        serde_json::from_str(&good(here, &["bench", "b", "r.csv", "m.csv", "--json"])).expect("JSON");
    assert_eq!(apart, card);
    let worlds = good(here, &["bench", "b", "m.csv", "--worlds"]);
    assert!(worlds.contains("worlds/posts-1.toml") && worlds.contains("best known"), "{worlds}");

    let lines: Vec<&str> = second.lines().collect();
    write("part.csv", &format!("{}\n", lines[..40].join("\n")));
    refused(here, &["bench", "b", "part.csv"], &["part.csv", "39 of 60 episodes", "Number 39"]);
    write("changed.csv", &second.replacen(",arrived,", ",dropped,", 1));
    refused(here, &["bench", "b", "changed.csv"], &["changed.csv: line 2"]);
    good(here, &["sweep", "b/small.toml", "--seeds", "1", "-o", "one.csv"]);
    refused(here, &["bench", "b", "one.csv"], &["one.csv: line 2", "none of cocarry bench 1"]);
    // another world than the benchmark's
    let world = here.join("b/worlds/walls-2.toml");
    let changed = std::fs::read_to_string(&world)
        .expect("a world")
        .replace("robot_width_m = 0.5", "robot_width_m = 0.4");
    std::fs::write(&world, changed).expect("a world");
    refused(here, &["bench", "elsewhere", "m.csv"], &["elsewhere/full.toml: missing"]);
    refused(
        here,
        &["bench", "b", "m.csv"],
        &["walls-2.toml", "not as it is in cocarry bench 1", "`cocarry bench FOLDER`"],
    );
}

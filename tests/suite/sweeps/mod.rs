//! Sweeps: the rows are those of `cocarry run`, the file is the same to the byte however the sweep was run,
//! and what is wrong in a study is named.

mod cluster;
mod compare;
mod interrupted;
#[cfg(feature = "parquet")]
mod parquet;
mod preference_changes;
mod studies;
mod summary;

use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::quantities::EPISODE;
use cocarry_studies::statistics::mean_and_std;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A study on the planning level, with most kinds of values.
const STUDY: &str = r#"name = "A study"

worlds = ["environment-1", "environment-4"]
plants = "point"
methods = ["mutual", "without-model"]
eta = [5, 10.5]
humans = ["all", "same"]
seeds = 6

[[human]]
name = "all"
alpha = "uniform(0.55,0.95)"
gamma = "uniform(0.5,1.1)"

[[human]]
name = "same"
alpha = 0.747
gamma = 0.765

[[belief]]
name = "sharp"
alpha = "normal(0.75,0.05,0.55,0.95)"
gamma = "uniform(0.5,1.1)"
"#;

/// A folder with a study in it.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new(study: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("study.toml"), study).expect("a study");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        command.arg("sweep").args(arguments).current_dir(self.folder.path());
        command
    }

    fn sweep(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    fn good(&self, arguments: &[&str]) -> Output {
        let output = self.sweep(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
        output
    }

    /// Runs what must be refused, and sees the message about it.
    fn refused(&self, arguments: &[&str], code: i32, said: &[&str]) {
        let output = self.sweep(arguments);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?} printed something");
        assert!(error.starts_with("error: ") && !error.contains("panicked"), "{error}");
        for part in said {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn rows(&self, name: &str) -> Vec<Row> {
        rows(&self.path(name))
    }
}

/// A row by its columns.
type Row = std::collections::BTreeMap<String, String>;

fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).expect("a file of results");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn every_combination_is_run_with_every_seed_the_humans_the_same_for_all_methods() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml"]);
    let rows = bench.rows("study.csv");
    assert_eq!(rows.len(), 2 * 2 * 2 * 2 * 6);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((row["episode"].parse(), row["episodes"].as_str()), (Ok(i), "96"));
        assert_eq!(row["outcome"], "arrived");
        assert!(
            row["accumulated_control_cost"].is_empty() && row["robot"].is_empty(),
            "the point has no robot"
        );
        if row["humans"] == "same" {
            assert_eq!((row["alpha"].as_str(), row["gamma"].as_str()), ("0.747", "0.765"));
        }
        for other in rows.iter().filter(|r| r["seed"] == row["seed"] && r["humans"] == row["humans"]) {
            assert_eq!((&row["alpha"], &row["gamma"]), (&other["alpha"], &other["gamma"]));
        }
    }
    let drawn = |row: &&Row| row["humans"] == "all";
    let mut alphas: Vec<_> = rows.iter().filter(drawn).map(|row| row["alpha"].clone()).collect();
    alphas.sort();
    alphas.dedup();
    assert_eq!(alphas.len(), 6, "another seed is another human");
}

/// Compares a row with what `run --json` says of the same episode.
fn agrees(row: &Row, told: &Value, pairs: &[(&str, impl AsRef<str>)]) {
    for (column, pointer) in pairs {
        let (cell, value) = (&row[*column], told.pointer(pointer.as_ref()).unwrap_or(&Value::Null));
        let agrees = match value {
            Value::Null => cell.is_empty(),
            Value::Number(number) => cell.parse::<f64>().ok() == number.as_f64(),
            Value::String(text) => cell == text,
            _ => false,
        };
        assert!(agrees, "{column}: {cell} and {value}");
    }
}

#[test]
fn a_row_is_what_run_says_of_the_same_episode() {
    let inputs = [
        ("seed", "/seed"),
        ("alpha", "/human/alpha"),
        ("gamma", "/human/gamma"),
        ("method", "/method"),
        ("eta", "/eta"),
    ];
    let of_robot = ["posture", "avoid", "pose"].map(|key| (key, format!("/robot/{key}")));
    let results = EPISODE.iter().map(|quantity| (quantity.key, format!("/{}", quantity.key)));
    let pairs = inputs
        .map(|(column, pointer)| (column, pointer.to_owned()))
        .into_iter()
        .chain(of_robot)
        .chain(results);
    let pairs: Vec<(&str, String)> = pairs.collect();
    // the last one ends in a contact
    for (study, arguments) in [
        ("plants = \"point\"\nmethods = \"mutual\"", &["--plant", "point"][..]),
        (
            "methods = \"human-led\"\npose = \"whole-body\"\npostures = \"elbow-out\"\navoid = \"nothing\"",
            &[
                "--plant",
                "kinematic",
                "--method",
                "human-led",
                "--pose",
                "whole-body",
                "--posture",
                "elbow-out",
                "--no-obstacles",
            ],
        ),
        ("plants = \"rapier\"\nsway_m = 0.02", &["--plant", "rapier", "--sway", "0.02"]),
        (
            "plants = \"rapier\"\nmethods = \"robot-led\"\navoid = \"nothing\"\nspeed_m_per_s = 0.7",
            &["--plant", "rapier", "--method", "robot-led", "--no-obstacles", "--speed", "0.7"],
        ),
    ] {
        let world = if study.contains("robot-led") { "environment-2" } else { "environment-4" };
        let bench =
            Bench::new(&format!("worlds = \"{world}\"\nseeds = {{ first = 3, last = 3 }}\n{study}\n"));
        bench.good(&["study.toml"]);
        let output = cocarry(&[&["run", world, "--json", "--seed", "3"], arguments].concat());
        let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        agrees(&bench.rows("study.csv")[0], &told, &pairs);
        if study.contains("robot-led") {
            assert!(told["collision_of"].is_string(), "choose an episode with a contact");
        }
    }
}

#[test]
fn the_number_of_threads_and_of_shards_makes_no_difference() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--threads", "1", "--output", "one.csv"]);
    bench.good(&["study.toml", "--threads", "3", "--output", "three.csv"]);
    assert!(bench.read("one.csv") == bench.read("three.csv"));
    for number in 1..=5 {
        bench.good(&["study.toml", "--shard", &format!("{number}/5")]);
    }
    let shard = |n| format!("study.{n}-of-5.csv");
    let [a, b, c, d, e] = [3, 1, 5, 2, 4].map(shard);
    bench.good(&["--merge", "merged.csv", &a, &b, &c, &d, &e]);
    assert!(bench.read("one.csv") == bench.read("merged.csv"));
    bench.refused(&["--merge", "merged.csv", &a, &b], 2, &["merged.csv: exists already", "--overwrite"]);
    bench.refused(&["--merge", "new.csv", &a, &b, &c, &e], 2, &["episodes 19 to 37 of 96", "shard 2/5"]);
    bench.refused(&["--merge", "new.csv", &a, &b, &b], 2, &["study.1-of-5.csv: duplicate episode 0"]);
    bench.good(&["study.toml", "--seeds", "5", "--shard", "2/5", "--output", "foreign.csv"]);
    bench.refused(
        &["--merge", "new.csv", &a, &b, &c, "foreign.csv", &e],
        2,
        &["foreign.csv: study ", "80", "96"],
    );
    bench.refused(&["--merge", "new.csv", &a, "study.toml"], 2, &["study.toml: not the results of a sweep"]);
    assert!(!bench.path("new.csv").exists() && !bench.path("new.csv.partial").exists());
    std::fs::write(bench.path("new.csv.partial"), "a sweep under way").expect("a file");
    bench.refused(&["--merge", "new.csv", &a, &b, &c, &d, &e], 2, &["new.csv.partial: exists already"]);
    assert_eq!(bench.read("new.csv.partial"), b"a sweep under way");
}

/// The same command again finds its results complete: no episode runs, and the tables are printed.
#[test]
fn a_finished_sweep_is_a_success() {
    let bench = Bench::new(STUDY);
    let first = stdout(&bench.good(&["study.toml"]));
    let rows = bench.read("study.csv");
    let again = stdout(&bench.good(&["study.toml"]));
    let title = "study.csv: 96 episodes of 16 combinations";
    assert!(first.starts_with(&format!("{title}\n")), "{first}");
    assert!(again.starts_with(&format!("{title}, all 96 of them from the earlier run\n")), "{again}");
    assert!(bench.read("study.csv") == rows && !bench.path("study.csv.partial").exists());
    // results of another study, or a row less, are not
    bench.refused(&["study.toml", "--seeds", "2"], 2, &["study.csv: exists already"]);
    std::fs::write(bench.path("study.csv"), &rows[..rows.len() - 9]).expect("a file");
    bench.refused(&["study.toml"], 2, &["study.csv: exists already"]);
}

#[test]
fn more_shards_than_episodes_are_merged_too() {
    let bench = Bench::new("worlds = \"environment-1\"\nplants = \"point\"\nseeds = 2\n");
    bench.good(&["study.toml", "--output", "all.csv"]);
    let mut merge = vec!["--merge".to_owned(), "merged.csv".to_owned()];
    for number in 1..=4 {
        bench.good(&["study.toml", "--shard", &format!("{number}/4")]);
        merge.push(format!("study.{number}-of-4.csv"));
    }
    bench.good(&merge.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(bench.read("all.csv") == bench.read("merged.csv"));
}

#[test]
fn rows_that_are_there_are_kept_and_a_row_that_was_cut_is_run_again() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--output", "undisturbed.csv"]);
    let whole = bench.read("undisturbed.csv");
    let lines = whole.split_inclusive(|byte| *byte == b'\n');
    let ten: usize = lines.take(11).map(<[u8]>::len).sum();
    for (cut, kept) in [(0, 0), (5, 0), (ten, 10), (ten + 40, 10), (ten + 1, 10), (whole.len(), 96)] {
        std::fs::write(bench.path("study.csv.partial"), &whole[..cut]).expect("a partial file");
        let told = stdout(&bench.good(&["study.toml", "--overwrite"]));
        let says = format!("{kept} of them from the earlier run");
        assert_eq!(told.contains(&says), kept > 0, "cut at {cut}: {told}");
        assert!(bench.read("study.csv") == whole, "cut at {cut}");
    }
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_program_without_parquet_says_so_before_the_work() {
    let bench = Bench::new(STUDY);
    let said = |name| [name, "without the feature `parquet`", "--features parquet"];
    bench.refused(&["study.toml", "--output", "a.parquet"], 2, &said("a.parquet: "));
    bench.refused(&["study.toml", "--ticks", "ticks"], 2, &said("ticks: "));
    bench.refused(&["--merge", "a.parquet", "b.csv", "c.csv"], 2, &said("a.parquet: "));
    std::fs::write(bench.path("b.parquet"), b"PAR1PAR1").expect("a file");
    bench.refused(&["--summary", "b.parquet"], 2, &said("b.parquet: "));
    assert!(!bench.path("a.parquet.partial").exists() && !bench.path("ticks.partial").exists());
}

#[test]
fn results_of_another_study_are_not_gone_on_with() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml"]);
    let first = bench.read("study.csv");
    std::fs::rename(bench.path("study.csv"), bench.path("study.csv.partial")).expect("renamed");
    let other = STUDY.replace("eta = [5, 10.5]", "eta = [5, 10]");
    std::fs::write(bench.path("study.toml"), &other).expect("a study");
    bench.refused(&["study.toml"], 2, &["study.csv.partial: line 2 is of study", "--overwrite"]);
    bench.good(&["study.toml", "--overwrite"]);
    assert_ne!(bench.read("study.csv"), first);
    // comments and names make no other study
    std::fs::write(bench.path("study.toml"), STUDY.replace("A study", "Another name")).expect("a study");
    bench.good(&["study.toml", "--overwrite"]);
    assert!(bench.read("study.csv") == first);
    std::fs::write(bench.path("study.csv.partial"), "my diary\n").expect("a file");
    std::fs::remove_file(bench.path("study.csv")).expect("removed");
    bench.refused(&["study.toml"], 2, &["not the results of a sweep", "my diary"]);
    std::fs::write(bench.path("study.csv.partial"), "no end of line").expect("a file");
    bench.refused(&["study.toml"], 2, &["not the results of a sweep", "no end of line"]);
}

#[test]
fn rows_out_of_order_are_summarised_and_not_continued() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml"]);
    let text = String::from_utf8(bench.read("study.csv")).expect("UTF-8");
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    lines.swap(3, 4);
    std::fs::write(bench.path("swapped.csv"), lines.concat()).expect("a file");
    // a summary reads tables that other programs sorted
    let summary = |name: &str| stdout(&bench.good(&["--summary", name])).replace(name, "");
    assert_eq!(summary("swapped.csv"), summary("study.csv"));
    std::fs::rename(bench.path("swapped.csv"), bench.path("study.csv.partial")).expect("renamed");
    std::fs::remove_file(bench.path("study.csv")).expect("removed");
    bench.refused(&["study.toml"], 2, &["study.csv.partial: line 4 is episode 3"]);
}

/// Every value of a kept row is that which the sweep wrote: on resuming, and in a merge.
#[test]
fn changed_values_in_kept_rows_are_refused() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--shard", "1/2", "--output", "1.csv"]);
    bench.good(&["study.toml", "--shard", "2/2", "--output", "2.csv"]);
    let (rows, text) = (bench.rows("1.csv"), String::from_utf8(bench.read("1.csv")).expect("UTF-8"));
    let fields = |line: &str| -> Vec<String> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
        reader.records().next().expect("a line").expect("CSV").iter().map(str::to_owned).collect()
    };
    let header = fields(text.lines().next().expect("a header"));
    for column in ["checksum", "world", "seed", "alpha", "outcome", "accumulated_objective_cost_m", "steps"] {
        let at = header.iter().position(|name| *name == column).unwrap_or_else(|| panic!("{column}"));
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut fields = fields(&lines[7]);
        assert_eq!(fields[at], rows[6][column]);
        let last = fields[at].pop().expect("a value");
        fields[at].push(if last == '1' { '2' } else { '1' });
        let mut line = csv::Writer::from_writer(Vec::new());
        line.write_record(&fields).expect("memory");
        lines[7] =
            String::from_utf8(line.into_inner().expect("memory")).expect("UTF-8").trim_end().to_owned();
        let changed = lines.join("\n") + "\n";
        std::fs::write(bench.path("changed.csv"), &changed).expect("a file");
        std::fs::write(bench.path("half.csv.partial"), &changed).expect("a file");
        let words = ["line 8 is a row with changed values", "as its sweep wrote it"];
        bench.refused(&["--merge", "all.csv", "changed.csv", "2.csv"], 2, &words);
        assert!(!bench.path("all.csv").exists() && !bench.path("all.csv.partial").exists());
        bench.refused(&["study.toml", "--shard", "1/2", "--output", "half.csv"], 2, &words);
        assert!(bench.read("half.csv.partial") == changed.as_bytes(), "what is there stays");
    }
    bench.good(&["study.toml", "--shard", "1/2", "--output", "half.csv", "--overwrite"]);
    assert!(bench.read("half.csv") == text.as_bytes());
}

#[test]
fn runs_override_the_study_and_may_have_seeds_of_their_own() {
    let bench = Bench::new(
        r#"worlds = "environment-1"
plants = "point"
eta = [5, 15]
seeds = 4

[[run]]
methods = "mutual"

[[run]]
methods = "without-model"
eta = 5
seeds = { first = 2, last = 5 }
"#,
    );
    let told = stdout(&bench.good(&["study.toml"]));
    let rows = bench.rows("study.csv");
    let cells: Vec<String> =
        rows.iter().map(|row| format!("{} {} {}", row["seed"], row["method"], row["eta"])).collect();
    assert_eq!(cells.len(), 2 * 4 + 4);
    assert_eq!(cells[..5], ["0 mutual 5", "0 mutual 15", "1 mutual 5", "1 mutual 15", "2 mutual 5"]);
    assert_eq!(cells[5..8], ["2 mutual 15", "2 without-model 5", "3 mutual 5"]);
    assert_eq!(cells[10..], ["4 without-model 5", "5 without-model 5"]);
    // two seeds in common
    assert!(told.lines().any(|l| l.contains("mutual - without-model") && l.contains("  2  ")), "{told}");
}

/// Worlds and robots lie next to the study, wherever it is run from, and the rows do not depend on that.
#[test]
fn files_are_relative_to_the_study() {
    let study = "worlds = \"mine.toml\"\nrobots = [\"built-in\", \"six.toml\"]\nseeds = 1\nmax_steps = 3\n";
    let bench = Bench::new(study);
    std::fs::copy(repository("worlds/environment-1.toml"), bench.path("mine.toml")).expect("a copy");
    for name in ["six.toml", "six.urdf"] {
        std::fs::copy(repository("tests/fixtures/robots").join(name), bench.path(name)).expect("a copy");
    }
    bench.good(&["study.toml"]);
    let (study, out) = (bench.path("study.toml"), bench.path("other.csv"));
    let arguments = [study.to_str().expect("UTF-8"), "--output", out.to_str().expect("UTF-8")];
    let output = cocarry(&[&["sweep"], &arguments[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(bench.read("study.csv") == bench.read("other.csv"));
    let robots: Vec<_> = bench.rows("study.csv").iter().map(|row| row["robot"].clone()).collect();
    assert_eq!(robots, ["built-in", "six.toml"]);
    std::fs::write(bench.path("mine.toml"), "name = 3").expect("a world");
    bench.refused(&["study.toml"], 2, &["study.toml:1: worlds", "mine.toml: not a valid world file"]);
}

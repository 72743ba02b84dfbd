//! `cocarry infer`: what participants' files say, and what is wrong with them.

use crate::support::{cocarry, json, repository, stderr, stdout};
use std::path::{Path, PathBuf};

const ANSWERS: &str = "docs/data/simulated-answers.csv";
const SWITCHES: &str = "docs/data/simulated-switches.csv";
const TABLE_1: &str = "docs/data/table-1-humans.csv";

fn refused(arguments: &[&str], said: &[&str]) {
    let output = cocarry(arguments);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    for part in said {
        assert!(error.contains(part), "{part:?} is missing from: {error}");
    }
}

fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a temporary file");
    path.to_str().expect("UTF-8").to_owned()
}

fn file(folder: &Path, name: &str) -> (PathBuf, String) {
    let path = folder.join(name);
    (path.clone(), path.to_str().expect("UTF-8").to_owned())
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: &str, seed: &str| {
        let (store, name) = file(folder.path(), &format!("{threads}-{seed}.zarr.zip"));
        let (rows, csv) = file(folder.path(), &format!("{threads}-{seed}.csv"));
        let arguments = [
            "infer",
            ANSWERS,
            SWITCHES,
            "--draws",
            "100",
            "--threads",
            threads,
            "--seed",
            seed,
            "--arviz",
            &name,
            "--csv",
            &csv,
        ];
        let output = cocarry(&arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        (stdout(&output), std::fs::read(store).unwrap(), std::fs::read(rows).unwrap())
    };
    let one = run("1", "0");
    assert!(one == run("2", "0"));
    assert!(one.1 != run("2", "1").1);
}

#[test]
fn the_people_of_simulated_files_are_found_again() {
    let found = json(&["infer", ANSWERS, SWITCHES, "--json"]);
    let truth = std::fs::read_to_string(repository(ANSWERS)).unwrap();
    let mut inside = 0;
    let mut all = 0;
    for person in found["people"].as_array().unwrap() {
        let name = person["participant"].as_str().unwrap();
        let line = truth.lines().find(|line| line.starts_with(&format!("# {name}:"))).expect("the truth");
        for part in line.split(": ").nth(1).unwrap().split(", ") {
            let (parameter, value) = part.split_once(" = ").unwrap();
            let value: f64 = value.parse().unwrap();
            let interval = &person[parameter]["interval"];
            let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
            all += 1;
            inside += usize::from(low <= value && value <= high);
        }
    }
    // 30 intervals of 95 %
    assert!(all == 30 && inside >= 26, "{inside} of {all}");
    assert_eq!(found["held_out"].as_array().unwrap().len(), 5);
    assert_eq!(found["checks"].as_array().unwrap().len(), 16);
    let all = &found["held_out"][4];
    let score = |by: &str| all[by]["log_score"].as_f64().unwrap();
    assert!(all["world"].is_null() && score("posterior") > score("prior"), "{all}");
}

#[test]
fn answers_and_switches_alone_and_people_alone() {
    let found = json(&["infer", SWITCHES, "--json", "--draws", "100"]);
    assert!(found["population"].is_null() && found["held_out"].as_array().unwrap().is_empty());
    assert!(found["people"][0]["eta"]["mean"].is_f64());
    let found = json(&["infer", ANSWERS, "--json", "--draws", "100", "--no-population"]);
    assert!(found["population"].is_null() && found["people"][0]["within_population"].is_null());
    assert!(found["people"][0]["eta"].is_null() && found["people"][0]["alpha"]["mean"].is_f64());
    let folder = tempfile::tempdir().unwrap();
    let samples = written(folder.path(), "s.csv", "alpha,gamma\n0.6,0.7\n0.9,1.0\n0.7,0.9\n");
    let found = json(&["infer", ANSWERS, "--json", "--draws", "100", "--belief-samples", &samples]);
    assert!(found["population"].is_null());
}

#[test]
fn four_mean_answers_say_little_of_a_population() {
    let found = json(&["infer", TABLE_1, "--means-of", "20", "--normalise", "--json"]);
    let quantities = found["population"]["quantities"].as_array().unwrap();
    for quantity in quantities {
        let [posterior, prior] = ["posterior", "prior"].map(|which| quantity[which]["std"].as_f64().unwrap());
        assert!(posterior < 1.3 * prior, "{quantity}");
    }
    let sum: f64 = found["rows"].as_array().unwrap()[..4]
        .iter()
        .map(|row| row["posterior_percent"].as_f64().unwrap())
        .sum();
    assert!((sum - 100.0).abs() < 0.1, "{sum}");
}

#[test]
fn what_is_wrong_with_files_and_flags_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| written(folder.path(), name, text);
    refused(&["infer"], &["required"]);
    refused(&["infer", "no-such.csv"], &["no-such.csv: cannot be read"]);
    refused(&["infer", &at("empty.csv", "")], &["empty.csv: no rows"]);
    refused(&["infer", &at("e2.csv", "participant,world,option,percent\n")], &["e2.csv: no rows"]);
    let other = at("other.csv", "person,place\na,b\n");
    refused(&["infer", &other], &["other.csv", "neither answers nor switches", "person, place"]);
    refused(&["infer", ANSWERS, ANSWERS], &["a second file of answers"]);
    refused(&["infer", TABLE_1], &["sums to 95", "--normalise"]);
    let rows = |world: &str, first: &str, second: &str| {
        format!(
            "participant,world,option,percent\na,{world},1,{first}\na,{world},2,{second}\na,{world},3,0\na,{world},4,0\n"
        )
    };
    refused(&["infer", &at("w.csv", &rows("nowhere", "100", "0"))], &["w.csv:2", "nowhere", "no such world"]);
    // nobody prefers this way
    let never = at("never.csv", &rows("environment-1", "100", "0"));
    let said = ["never.csv", "participant `a`", "environment-1", "--lapse-rate above 0"];
    refused(&["infer", &never, "--lapse-rate", "0"], &said);
    refused(
        &["infer", &never, "--lapse-rate", "0", "--means-of", "9"],
        &["never.csv", "--lapse-rate above 0"],
    );
    assert!(cocarry(&["infer", &never]).status.success());
    let split = at("split.csv", &rows("environment-1", "50", "50"));
    refused(&["infer", &split, "--lapse-rate", "0"], &["split.csv", "100 percent"]);
    let text = "participant,world,option,step,trial\na,environment-4,1,20,1\na,environment-4,1,70,2\n";
    let twice = at("twice.csv", text);
    refused(&["infer", &twice, "--lapse-rate", "0"], &["twice.csv", "participant `a`", "no eta agrees"]);
    assert!(cocarry(&["infer", &twice]).status.success());
    let many: String = (0..257).map(|trial| format!("a,environment-4,1,20,{trial}\n")).collect();
    let many = at("many.csv", &format!("participant,world,option,step,trial\n{many}"));
    refused(&["infer", &many], &["many.csv", "participant `a`", "257 episodes", "at most 256"]);
    refused(&["infer", &twice, "--means-of", "20"], &["--means-of 20", "answers"]);
    refused(
        &["infer", TABLE_1, SWITCHES, "--normalise", "--means-of", "20"],
        &["--means-of 20", "nothing else"],
    );
    refused(&["infer", TABLE_1, "--means-of", "20", "--draws", "200"], &["--means-of", "--draws"]);
    refused(&["infer", ANSWERS, "--lapse-rate", "0.7"], &["--lapse-rate", "from 0 to 0.5"]);
    refused(&["infer", ANSWERS, "--eta-median", "0"], &["--eta-median", "greater than 0"]);
    refused(&["infer", ANSWERS, "--draws", "10"], &["--draws", "100"]);
    refused(&["infer", SWITCHES, "--initial-stubbornness", "1"], &["--initial-stubbornness 1"]);
    refused(&["infer", ANSWERS, "--csv", "rows.txt"], &["--csv", "expected the extension .csv"]);
    refused(&["infer", ANSWERS, "--arviz", "draws.nc"], &["--arviz", "expected the extension .zarr.zip"]);
}

#[test]
fn outputs_are_refused_before_the_work_and_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let name = written(folder.path(), "there.csv", "kept");
    refused(&["infer", ANSWERS, "--csv", &name], &["there.csv: exists already", "--overwrite"]);
    assert_eq!(std::fs::read_to_string(&name).unwrap(), "kept");
    let answers = std::fs::read_to_string(repository(ANSWERS)).unwrap();
    let own = written(folder.path(), "own.csv", &answers);
    refused(&["infer", &own, "--csv", &own, "--overwrite"], &["own.csv: is an input"]);
    // nothing is left where the answers are wrong
    let (store, name) = file(folder.path(), "draws.zarr.zip");
    refused(&["infer", "no-such.csv", "--arviz", &name], &["no-such.csv"]);
    assert!(!store.exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// A recorded walk says what the robot of `--belief learn` learns in the same episode.
#[test]
fn recorded_walks_are_seen_as_the_learning_robot_sees_them() {
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str, more: &[&str]| {
        let (_, path) = file(folder.path(), name);
        let fixed = ["run", "environment-4", "--plant", "point", "--record", &path];
        assert!(cocarry(&[&fixed[..], more].concat()).status.success());
        path
    };
    let anna = record("anna.mcap", &["--method", "human-led", "--alpha", "0.6", "--gamma", "0.9"]);
    let ben = record("ben.mcap", &["--eta", "5"]);
    let found = json(&["infer", &anna, &ben, "--json", "--draws", "100"]);
    let people = found["people"].as_array().unwrap();
    assert_eq!(people.len(), 2);
    assert!(people[0]["participant"] == "anna" && people[0]["sightings"].as_u64().unwrap() > 5, "{found}");
    assert!(people[0]["eta"].is_null() && people[0]["information"].as_f64().unwrap() > 0.3, "{found}");
    let inside = |figure: &serde_json::Value, truth: f64| {
        let [low, high] = [0, 1].map(|end| figure["interval"][end].as_f64().unwrap());
        assert!(low <= truth && truth <= high, "{truth}: {figure}");
    };
    inside(&people[0]["alpha"], 0.6);
    inside(&people[0]["gamma"], 0.9);
    inside(&people[1]["eta"], 5.0);
    assert!(found["population"].is_object());
    // the switch at this step, from a file
    let switch =
        written(folder.path(), "ben.csv", "participant,world,method,step\nben,environment-4,mutual,22\n");
    let listed = json(&["infer", &switch, "--json", "--draws", "100"]);
    let [one, other] = [&people[1], &listed["people"][0]].map(|p| p["eta"]["mean"].as_f64().unwrap());
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
    let other = record("other.mcap", &["--risk-weight", "5"]);
    refused(&["infer", &other], &["other.mcap", "risk_weight_m = 5", "--risk-weight 5"]);
    assert!(cocarry(&["infer", &other, "--risk-weight", "5", "--draws", "100"]).status.success());
    let learns = record("learns.mcap", &["--belief", "learn"]);
    refused(&["infer", &learns], &["learns.mcap", "--belief learn"]);
    let broken = written(folder.path(), "broken.mcap", "no recording");
    refused(&["infer", &broken], &["broken.mcap"]);
}

#[test]
fn perceptions_of_risk_are_compared_on_held_out_worlds() {
    let told = stdout(&cocarry(&["infer", ANSWERS, "--perceptions", "--draws", "100"]));
    let rows = told.split("The same by other perceptions of risk").nth(1).expect("a table");
    assert!(rows.contains("cumulative-prospect") && rows.contains("its own c_r"), "{rows}");
    let table = rows.lines().filter(|line| line.contains(" %") || line.contains('═'));
    assert!(table.into_iter().all(|line| line.chars().count() <= 80), "{rows}");
    let found = json(&["infer", ANSWERS, "--perceptions", "--draws", "100", "--json"]);
    let rows = found["perceptions"].as_array().unwrap();
    // these people are the paper's
    assert_eq!(rows[0]["perception"], "stevens-prelec");
    assert_eq!(rows.len(), 4);
    // the first row's score with the given c_r is the one of the exact posterior
    let all = found["held_out"].as_array().unwrap().iter().find(|row| row["world"].is_null()).unwrap();
    let [ours, exact] =
        [&rows[0]["posterior"], &all["posterior"]].map(|row| row["log_score"].as_f64().unwrap());
    assert!((ours - exact).abs() < 1e-3, "{ours} {exact}");
    assert!(json(&["infer", ANSWERS, "--json"])["perceptions"].is_null());
    refused(
        &["infer", SWITCHES, "--perceptions"],
        &["--perceptions", "a file of answers in two worlds or more"],
    );
    refused(&["infer", TABLE_1, "--means-of", "20", "--perceptions"], &["cannot be used with"]);
    refused(
        &["infer", ANSWERS, "--perceptions", "--risk-weight", "0"],
        &["risk weight c_r = 0 m", "greater than 0"],
    );
}

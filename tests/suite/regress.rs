//! The regression gate: what was recorded stands, what moves is told, and what is wrong is named.

use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::quantities::EPISODE;
use std::path::Path;

const OWN: &str = "tests/fixtures/regress/costs.toml";

const SMALL: &str = r#"# kept

[[run]]
name = "a"                    # this too
world = "environment-4"
plant = "point"
seed = 1

# before the second
[[run]]
eta = 5
plant = "point"
world = "environment-1"
seed = 2
"#;

fn at(folder: &Path, text: &str) -> String {
    let path = folder.join("costs.toml");
    std::fs::write(&path, text).expect("a temporary file");
    path.to_str().expect("UTF-8").to_owned()
}

fn refused(text: &str, said: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), text);
    for action in ["record", "check"] {
        let output = cocarry(&["regress", action, &file]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{action}: {error}");
        assert!(output.stdout.is_empty() && error.starts_with("error: "), "{error}");
        for part in [&["costs.toml"], said].concat() {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text, "a file that was refused was written");
}

#[test]
fn the_projects_own_figures_have_not_moved() {
    let output = cocarry(&["regress", "check", OWN]);
    assert_eq!(output.status.code(), Some(0), "{}{}", stdout(&output), stderr(&output));
    assert!(stdout(&output).contains("nothing moved"));
}

#[test]
fn recording_again_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let once = std::fs::read_to_string(&file).unwrap();
    assert!(cocarry(&["regress", "record", &file, "--threads", "1"]).status.success());
    assert_eq!(std::fs::read_to_string(&file).unwrap(), once);
}

/// A check tells servers of continuous integration what moved, in their own forms.
#[test]
fn a_check_reports_to_servers() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), &SMALL.replace("name = \"a\"", "name = \"a <b>, 50 %\""));
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let xml = folder.path().join("costs.xml");
    let arguments = ["regress", "check", &file, "--junit", xml.to_str().unwrap(), "--github"];
    let output = cocarry(&arguments);
    assert!(output.status.success() && stderr(&output).is_empty(), "{}", stderr(&output));
    let report = std::fs::read_to_string(&xml).unwrap();
    assert!(
        report.contains("tests=\"2\" failures=\"0\"") && report.contains("name=\"a &lt;b&gt;, 50 %\""),
        "{report}"
    );
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replacen("outcome = \"arrived\"", "outcome = \"stuck\"", 1)).unwrap();
    assert_eq!(cocarry(&arguments).status.code(), Some(2), "the report exists already");
    let output = cocarry(&[&arguments[..], &["--overwrite", "--json"]].concat());
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(serde_json::from_slice::<serde_json::Value>(&output.stdout).is_ok());
    let annotation = said.lines().next().expect("an annotation");
    assert!(
        annotation.starts_with("::error file=") && annotation.contains(",line=4,title=a <b>%2C 50 %25::"),
        "{said}"
    );
    assert!(
        annotation.ends_with("outcome: recorded stuck, now arrived") && said.lines().count() == 1,
        "{said}"
    );
    let report = std::fs::read_to_string(&xml).unwrap();
    assert!(
        report.contains("failures=\"1\"")
            && report.contains("<failure message=\"1 figure moved\">outcome: recorded stuck"),
        "{report}"
    );
}

#[test]
fn recording_keeps_entries_order_and_comments() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let text = std::fs::read_to_string(&file).unwrap();
    let mut rest = text.as_str();
    for line in SMALL.lines() {
        let (_, after) = rest.split_once(line).unwrap_or_else(|| panic!("{line:?} is lost in:\n{text}"));
        rest = after;
    }
    assert_eq!(text.matches("[run.recorded]").count(), 2);
    assert!(text.contains("outcome = \"arrived\"") && text.contains("transition_step = "), "{text}");
    assert!(cocarry(&["regress", "check", &file]).status.success());
}

#[test]
fn a_figure_that_moved_is_told_and_ends_with_1() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    // another human does what was not recorded
    let file = at(folder.path(), &recorded.replace("seed = 2", "seed = 2\nmethod = \"without-model\""));
    let output = cocarry(&["regress", "check", &file]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = stdout(&output);
    for part in ["accumulated_objective_cost_m", "eta 5", "recorded", "now"] {
        assert!(text.contains(part), "{part:?} is missing from:\n{text}");
    }
    assert!(!text.contains(" a "), "a run that did not move is told:\n{text}");
    let output = cocarry(&["regress", "check", &file, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!told["moved"].as_array().unwrap().is_empty());
}

#[test]
fn tolerances_decide_what_moved() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    let line = recorded.lines().find(|l| l.starts_with("walked_m")).unwrap();
    let walked: f64 = line.split(" = ").nth(1).unwrap().parse().unwrap();
    let spoiled = recorded.replacen(line, &format!("walked_m = {}", walked * 1.001), 1);
    let moved = |head: &str| {
        let file = at(folder.path(), &spoiled.replacen("format = 3\n", &format!("format = 3\n{head}\n"), 1));
        let output = cocarry(&["regress", "check", &file, "--json"]);
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let moved = told["moved"].as_array().unwrap().clone();
        assert_eq!(output.status.code(), Some(i32::from(!moved.is_empty())));
        moved
    };
    let found = moved("");
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((&found[0]["run"], &found[0]["figure"]), (&"a".into(), &"walked_m".into()));
    assert!(moved("[tolerance]\nrelative = 0.002").is_empty());
    assert!(moved("[tolerance.walked_m]\nrelative = 0.002").is_empty());
    assert!(moved("[tolerance.walked_m]\nabsolute = 0.1").is_empty());
    assert_eq!(moved("[tolerance]\nrelative = 0.002\n[tolerance.walked_m]\nrelative = 1e-9").len(), 1);
    assert_eq!(moved("[tolerance.steps]\nrelative = 0.002").len(), 1);
}

#[test]
fn a_figure_that_is_gone_or_new_has_moved() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    let spoiled = recorded.replacen("outcome = \"arrived\"\n", "accumulated_control_cost = 3.0\n", 1);
    let output = cocarry(&["regress", "check", &at(folder.path(), &spoiled)]);
    assert_eq!(output.status.code(), Some(1));
    let text = stdout(&output);
    assert!(
        text.contains("accumulated_control_cost") && text.contains("outcome") && text.contains("2 moved"),
        "{text}"
    );
}

/// Two ways around a pillar, of which the one above the line from start to target is listed as the only
/// option.
const PILLAR: &str = r#"
name = "Pillar"
robot_width_m = 0.5
start_m = [0.0, 0.0]
target_m = [8.0, 0.0]

[[obstacle]]
name = "pillar"
shape = "cylinder"
center_m = [4.0, 0.0]
radius_m = 0.6
height_m = 2.0

[[obstacle]]
name = "wall"
shape = "box"
center_m = [4.0, 3.0]
size_m = [0.2, 3.0]
height_m = 2.0

[[opening]]
name = "door"
between = ["pillar", "wall"]

[[option]]
name = "only"
openings = ["door"]
"#;

#[test]
fn the_same_way_on_the_other_side_has_moved() {
    let folder = tempfile::tempdir().unwrap();
    let world = folder.path().join("pillar.toml");
    std::fs::write(&world, PILLAR).unwrap();
    let text = "[[run]]\nworld = \"pillar.toml\"\nplant = \"point\"\nseed = 1\n";
    let file = at(folder.path(), text);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    assert!(recorded.contains("openings = \"door (4.00, 1.05)\""), "{recorded}");
    let mirrored = PILLAR.replace("center_m = [4.0, 3.0]", "center_m = [4.0, -3.0]");
    assert_ne!(mirrored, PILLAR);
    std::fs::write(&world, mirrored).unwrap();
    let output = cocarry(&["regress", "check", &file, "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let moved: Vec<&str> =
        told["moved"].as_array().unwrap().iter().map(|m| m["figure"].as_str().unwrap()).collect();
    assert_eq!(moved, ["openings", "mean_offset_m"], "nothing else tells the sides apart");
    assert_eq!(told["moved"][0]["now"], "door (4.00, -1.05)");
}

#[test]
fn figures_of_an_earlier_format_are_to_be_recorded_anew() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    let is_new =
        |line: &&str| ["format", "openings", "mean_offset_m"].iter().any(|key| line.starts_with(key));
    let old: Vec<&str> = recorded.lines().filter(|line| !is_new(line)).collect();
    // the names of then
    let old = old.join("\n").replace("option_change_count", "option_changes");
    assert!(old.contains("option_changes"));
    let file = at(folder.path(), &(old + "\n"));
    let output = cocarry(&["regress", "check", &file]);
    assert_eq!(output.status.code(), Some(2));
    let error = stderr(&output);
    assert!(error.contains("format 1") && error.contains("openings"), "{error}");
    assert!(error.contains("regress record"), "{error}");
    assert!(cocarry(&["regress", "record", &file]).status.success());
    assert!(cocarry(&["regress", "check", &file]).status.success());
    refused(&format!("format = 4\n{SMALL}"), &[":1:", "format = 4", "from 1 to 3"]);
}

#[test]
fn a_run_without_figures_asks_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = at(folder.path(), SMALL);
    let output = cocarry(&["regress", "check", &file]);
    assert_eq!(output.status.code(), Some(2));
    let error = stderr(&output);
    assert!(error.contains(":3: run `a` has no figures yet") && error.contains("regress record"), "{error}");
}

#[test]
fn keys_are_those_of_run() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[[run]]\nworld = \"environment-1\"\nplant = \"kinematic\"\nmethod = \"human-led\"\nseed = 4\nno-obstacles = true\npose_criterion = \"uniform\"\nprepare-while-leading = false\nbelief-alpha = \"uniform(0.6,0.9)\"\nmax_steps = 40\n";
    let file = at(folder.path(), text);
    assert!(cocarry(&["regress", "record", &file]).status.success());
    let recorded = std::fs::read_to_string(&file).unwrap();
    let same = "run environment-1 --plant kinematic --method human-led --seed 4 --no-obstacles --pose-criterion uniform --belief-alpha uniform(0.6,0.9) --max-steps 40 --json";
    let output = cocarry(&same.split(' ').collect::<Vec<_>>());
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cost = told["accumulated_control_cost"].as_f64().unwrap();
    assert!(recorded.contains(&format!("accumulated_control_cost = {cost}")), "{cost}:\n{recorded}");
    for quantity in EPISODE {
        let is_recorded = recorded.contains(&format!("\n{} = ", quantity.key));
        assert_eq!(is_recorded, !told[quantity.key].is_null(), "{}:\n{recorded}", quantity.key);
    }
    assert!(recorded.contains("outcome = \"out-of-time\""));
}

#[test]
fn humans_who_change_their_mind_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let head = "[[run]]\nworld = \"environment-4\"\nplant = \"point\"\nmethod = \"human-led\"\nseed = 4\n";
    for (key, arguments) in [
        ("change = [\"10:0.95,1.1\", \"40:0.6,0.6\"]", "--change 10:0.95,1.1 --change 40:0.6,0.6"),
        ("change = \"10:0.95,1.1\"", "--change 10:0.95,1.1"),
        ("preference_changes = 3", "--preference-changes 3"),
        ("preference_changes = \"once-or-twice\"", "--preference-changes once-or-twice"),
    ] {
        let file = at(folder.path(), &format!("{head}{key}\n"));
        assert!(cocarry(&["regress", "record", &file]).status.success(), "{key}");
        let recorded = std::fs::read_to_string(&file).unwrap();
        let same = format!("run environment-4 --plant point --method human-led --seed 4 --json {arguments}");
        let told = json(&same.split(' ').collect::<Vec<_>>());
        let walked = told["walked_m"].as_f64().unwrap();
        assert!(recorded.contains(&format!("walked_m = {walked}")), "{walked}:\n{recorded}");
    }
}

#[test]
fn wrong_files_are_named_by_line() {
    let spoil = |from: &str, to: &str| {
        assert_eq!(SMALL.matches(from).count(), 1, "{from:?}");
        SMALL.replace(from, to)
    };
    refused("", &["no runs", "[[run]]"]);
    refused("[run]\nworld = 1\n", &["no runs"]);
    refused("[[run]\n", &["line 1"]);
    refused(&spoil("# kept", "runs = 3"), &[":1:", "unknown key `runs`", "format, tolerance, run"]);
    refused(&spoil("seed = 1", "sed = 1"), &[":7:", "unknown key `sed`", "seed", "eta", "world"]);
    refused(&spoil("seed = 1", "json = true"), &[":7:", "unknown key `json`"]);
    refused(&spoil("eta = 5", "eta = 0"), &[":11:", "eta", "greater than 0"]);
    refused(&spoil("eta = 5", "eta = [5]"), &[":11:", "eta = [5]", "a number"]);
    refused(&spoil("eta = 5", "no_obstacles = []"), &[":11:", "no_obstacles = []", "true or false"]);
    refused(&spoil("eta = 5", "change = [\"3\"]"), &[":11:", "--change", "STEP:ALPHA,GAMMA"]);
    refused(&spoil("eta = 5", "change = [true]"), &[":11:", "change = [true]", "a number, a word in quotes"]);
    refused(&spoil("eta = 5", "preference_changes = 9"), &[":11:", "--preference-changes", "from 0 to 8"]);
    refused(&spoil("eta = 5", "eta = true"), &[":11:", "eta = true"]);
    refused(&spoil("eta = 5", "no_obstacles = 1"), &[":11:", "no_obstacles = 1", "true or false"]);
    refused(&spoil("eta = 5", "method = \"democratic\""), &[":11:", "democratic", "mutual"]);
    refused(&spoil("eta = 5", "sway = 0.1"), &[":10:", "--sway", "--plant point"]);
    refused(&spoil("environment-1", "environment-9"), &[":10:", "environment-9", "no such world"]);
    refused(&spoil("seed = 2", "seed = 2\nname = \"a\""), &[":10:", "duplicate run `a`"]);
    refused(&spoil("# kept", "[tolerance]\nrelative = -1"), &[":2:", "relative = -1", "at least 0"]);
    refused(&spoil("# kept", "[tolerance.cost]\nrelative = 1"), &[":1:", "unknown key `cost`", "walked_m"]);
    refused(&spoil("# kept", "[tolerance.steps]\nrel = 1"), &[":2:", "unknown key `rel`", "absolute"]);
    let recorded = format!("format = 3\n{}", spoil("seed = 2", "[run.recorded]\ncost = 1"));
    refused(&recorded, &[":16:", "unknown key `cost`"]);
    let output = cocarry(&["regress", "check", "no-such.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no-such.toml: cannot be read"));
}

#[test]
fn files_lie_beside_the_file_that_names_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(repository("worlds/free-form.toml"), folder.path().join("mine.toml")).unwrap();
    let text = "[[run]]\nworld = \"mine.toml\"\nplant = \"point\"\nalpha = 0.7\ngamma = 0.8\n";
    let told = json(&["regress", "record", &at(folder.path(), text), "--json"]);
    assert_eq!(told["runs"], 1);
}

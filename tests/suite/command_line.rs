//! What the program prints and writes, as its users rely on it.

use crate::support::{cocarry, json, stderr, stdout};

#[test]
fn without_arguments_a_good_default_runs() {
    let output = cocarry(&[]);
    assert_eq!(output.status.code(), Some(0));
    let text = stdout(&output);
    for part in ["Environment 4", "takes the lead", "arrived at B on option 3", "accumulated objective cost"]
    {
        assert!(text.contains(part), "{part:?} is missing from:\n{text}");
    }
    // it ends by saying how to see it, with a command that works
    let (_, watch) = text.split_once("To watch this episode").expect("where to look");
    let command = watch.lines().find_map(|line| line.trim().strip_prefix("cocarry ")).expect("a command");
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("episode.html");
    let arguments: Vec<&str> = command.split(' ').collect();
    let [arguments @ .., "episode.html"] = &arguments[..] else { panic!("{command}") };
    let output = cocarry(&[arguments, &[page.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    assert!(stdout(&output).ends_with(&format!("wrote {}\n", page.display())));
    assert!(page.exists());
}

#[test]
fn json_of_a_world_has_the_agreed_keys() {
    let world = json(&["world", "environment-4", "--json"]);
    let options = world["options"].as_array().unwrap();
    assert_eq!(options.len(), 4);
    let mut sum = 0.0;
    for option in options {
        assert!(option["name"].is_string() && option["openings"].is_array());
        let number = |key: &str| option[key].as_f64().unwrap_or_else(|| panic!("{key}"));
        assert!((number("objective_cost_m") - number("length_m") - 10.0 * number("risk")).abs() < 1e-9);
        sum += number("probability");
    }
    assert!((sum - 1.0).abs() < 1e-12);
    assert_eq!(world["openings"].as_array().unwrap().len(), 4);
}

#[test]
fn json_of_the_tables_has_flat_rows_with_the_agreed_keys() {
    let keys = |claim: &str| {
        let table = json(&["reproduce", claim, "--json"]);
        let rows = table["rows"].as_array().unwrap().clone();
        assert_eq!(rows.len(), 16);
        rows[0].as_object().unwrap().keys().cloned().collect::<Vec<_>>()
    };
    let h1 = keys("h1");
    for key in ["environment", "option", "human_percent", "paper_percent", "ours_percent"] {
        assert!(h1.iter().any(|k| k == key), "{key}");
    }
    let h2 = keys("h2");
    for key in ["environment", "method", "eta", "paper_mean", "ours_mean", "sample_mean", "sample_std"] {
        assert!(h2.iter().any(|k| k == key), "{key}");
    }
}

#[test]
fn every_tick_is_written_as_csv_and_as_json_lines() {
    let folder = tempfile::tempdir().unwrap();
    let [csv_file, jsonl_file, svg_file] =
        ["t.csv", "t.jsonl", "t.svg"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    let summary = json(&["run", "--json", "--seed", "1", "--ticks", &csv_file, "--svg", &svg_file]);
    json(&["run", "--json", "--seed", "1", "--ticks", &jsonl_file]);
    let steps = summary["steps"].as_u64().unwrap() as usize;
    let mut reader = csv::Reader::from_path(&csv_file).unwrap();
    let headers = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let text = std::fs::read_to_string(&jsonl_file).unwrap();
    let lines: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!((rows.len(), lines.len()), (steps, steps));
    let column = |name: &str| headers.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"));
    for (row, line) in rows.iter().zip(&lines) {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!(number("x_m"), line["x_m"].as_f64().unwrap());
        assert_eq!(number("length_m[3]"), line["options"][2]["length_m"].as_f64().unwrap());
        assert_eq!(number("probability[4]"), line["options"][3]["probability"].as_f64().unwrap());
    }
    let last = &lines[steps - 1]["accumulated_objective_cost_m"];
    assert_eq!(last.as_f64(), summary["accumulated_objective_cost_m"].as_f64());
    assert!(std::fs::read_to_string(&svg_file).unwrap().contains("</svg>"));
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 3, "nothing else is left behind: {names:?}");
}

#[test]
fn a_team_that_does_not_arrive_ends_with_3() {
    let output = cocarry(&["run", "--max-steps", "10", "--json"]);
    assert_eq!(output.status.code(), Some(3));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&told["outcome"], &told["steps"]), (&"out-of-time".into(), &10.into()));
}

#[test]
fn an_output_that_cannot_be_written_ends_with_4() {
    for (flag, file) in [("--ticks", "no/such/folder/file.csv"), ("--svg", "no/such/folder/file.svg")] {
        let output = cocarry(&["run", flag, file]);
        assert_eq!(output.status.code(), Some(4));
        assert!(stderr(&output).contains(file), "{}", stderr(&output));
    }
}

#[test]
fn what_cannot_be_served_ends_with_2() {
    for (arguments, said) in [
        (&["--live=localhost"][..], "must be an IP address and a port"),
        (&["--live=127.0.0.1"], "must be an IP address and a port"),
        (&["--live", "--live-rate", "0"], "must be a number from 0.01 to 1000"),
        (&["--live", "--live-rate", "NaN"], "must be a number from 0.01 to 1000"),
        (&["--live-rate", "2"], "--live"),
        (&["--live-wait"], "--live"),
    ] {
        let output = cocarry(&[&["run", "--plant", "point"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn a_study_of_nothing_ends_with_2() {
    let studies = [
        ["h2", "--humans"],
        ["h3", "--episodes"],
        ["h4", "--humans"],
        ["contacts", "--walks"],
        ["cycles", "--worlds"],
    ];
    for [claim, count] in studies {
        let output = cocarry(&["reproduce", claim, count, "0"]);
        assert_eq!(output.status.code(), Some(2), "{claim}");
        let error = stderr(&output);
        assert!(error.contains(count) && error.contains("0 is not in"), "{claim}: {error}");
    }
}

#[test]
#[cfg(not(feature = "live"))]
fn a_program_that_cannot_serve_says_how_to_get_one_that_can() {
    let output = cocarry(&["run", "--plant", "point", "--live"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--features live"), "{}", stderr(&output));
    assert!(output.stdout.is_empty(), "before anything is run");
}

/// A name with what a terminal would obey: a title, a colour, and a control character of one byte and two.
#[test]
fn names_do_not_command_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let name = "w\u{1b}]0;title\u{7}\u{1b}[31m\u{9b}2J";
    let world = format!(
        "name = {}\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [2, 0]\n",
        serde_json::to_string(name).unwrap()
    );
    std::fs::write(path("w.toml"), &world).unwrap();
    let opening = world.clone() + "[[opening]]\nname = \"o\\u001b[31m\"\nbetween = [\"a\", \"b\"]\n";
    std::fs::write(path("bad.toml"), opening).unwrap();
    std::fs::write(path("syntax.toml"), world + "x = \u{1b}[31m\n").unwrap();
    let (w, bad, syntax, recording) = (path("w.toml"), path("bad.toml"), path("syntax.toml"), path("r.mcap"));
    let record = ["run", &w, "--plant", "point", "--record", &recording];
    for arguments in [
        &record[..],
        &["run", &w, "--plant", "point", "--json"],
        &["world", &w],
        &["world", &w, "--json"],
        &["world", &bad],
        &["world", &syntax],
        &["inspect", &recording, "--csv", "/scene/world"],
    ] {
        let output = cocarry(arguments);
        for text in [stdout(&output), stderr(&output)] {
            let obeyed = text.chars().find(|c| c.is_control() && !"\n\t".contains(*c));
            assert_eq!(obeyed, None, "{arguments:?}: {text:?}");
        }
        if arguments.contains(&"--json") {
            let read: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            assert!(read.to_string().contains("title"), "{read}");
        }
    }
    let shown = stdout(&cocarry(&["world", &w]));
    assert!(shown.contains("w\\u001b]0;title\\u0007\\u001b[31m\\u009b2J"), "{shown}");
}

#[test]
fn a_belief_other_than_the_paper_changes_the_probabilities() {
    let probability = |arguments: &[&str]| {
        let world = json(&[&["world", "environment-4", "--json"], arguments].concat());
        world["options"][2]["probability"].as_f64().unwrap()
    };
    let paper = probability(&[]);
    assert_eq!(probability(&["--belief-alpha", "uniform(0.55,0.95)"]), paper);
    let narrow = probability(&[
        "--belief-alpha",
        "normal(0.9,0.02,0.55,0.95)",
        "--belief-gamma",
        "normal(1.05,0.02,0.5,1.1)",
    ]);
    assert!((narrow - paper).abs() > 0.1, "{narrow} and {paper}");
}

#[test]
fn help_names_every_command_and_exit_code() {
    let text = stdout(&cocarry(&["--help"]));
    for part in ["run", "world", "reproduce", "Exit codes", "2    bad input", "3    the team did not arrive"]
    {
        assert!(text.contains(part), "{part:?} is missing from:\n{text}");
    }
}

//! A human who changes their mind on the way: what they then do, what is told of it, and which changes a seed
//! draws.

use crate::support::{cocarry, json, stderr, stdout};
use serde_json::{Value, json};
use std::path::Path;

/// The human of the example in Environment 4, who prefers option 4 at the start.
const HUMAN: [&str; 5] = ["run", "--alpha", "0.747", "--gamma", "0.765"];

fn example(arguments: &[&str]) -> Value {
    json(&[&HUMAN, arguments, &["--json"]].concat())
}

/// The rows of a table of ticks, by column.
fn ticks(file: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(file).expect("a table of ticks");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn a_change_of_mind_makes_the_team_end_on_another_option() {
    for plant in ["point", "kinematic", "rapier"] {
        for (method, [alpha, gamma], after) in [("human-led", [0.95, 1.1], "3"), ("mutual", [0.6, 1.1], "2")]
        {
            let asked = ["--plant", plant, "--method", method, "--eta", "5"];
            assert_ne!(example(&asked)["last_option"], after, "{plant} {method}");
            let change = format!("10:{alpha},{gamma}");
            // on the kinematic plant the human turns on the spot, which may cost the object: that it arrives
            // is not asked
            let output = cocarry(&[&HUMAN[..], &asked, &["--change", &change, "--json"]].concat());
            let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert_eq!(told["last_option"], after, "{plant} {method}");
            let expected = json!([
                { "step": 10, "time_s": 2.0, "alpha": alpha, "gamma": gamma, "applied": true, "preferred": after }
            ]);
            assert_eq!(told["preference_changes"], expected, "{plant} {method}");
            let human = json!({ "alpha": 0.747, "gamma": 0.765 });
            assert_eq!(told["human"], human, "{plant} {method}: who sets out");
        }
    }
}

#[test]
fn every_change_is_told_when_it_happens() {
    // out of order, two at the same step, one after the end
    let changes = [
        "--change",
        "30:0.6,1.05",
        "--change",
        "12:0.9,0.5",
        "--change",
        "12:0.95,1.1",
        "--change",
        "5000:1,1",
    ];
    let asked = [&HUMAN[..], &["--plant", "point", "--method", "human-led"], &changes].concat();
    let output = cocarry(&asked);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    let told: Vec<&str> = text.lines().filter(|line| line.contains("preferences change")).collect();
    assert_eq!(told.len(), 2, "{text}");
    for (line, said) in told.iter().zip([
        ["step   12 (  2.4 s) at (", "alpha 0.9500, gamma 1.1000; they prefer option 3 from here"],
        ["step   30 (  6.0 s) at (", "alpha 0.6000, gamma 1.0500; they prefer option 2 from here"],
    ]) {
        assert!(said.iter().all(|part| line.contains(part)), "{line}");
    }
    let told = json(&[&asked[..], &["--json"]].concat());
    let summed: Vec<String> = told["preference_changes"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|c| format!("{} {} {} {}", c["step"], c["alpha"], c["applied"], c["preferred"].is_null()))
        .collect();
    assert_eq!(
        summed,
        ["12 0.9 false true", "12 0.95 true false", "30 0.6 true false", "5000 1.0 false true"]
    );
    assert_eq!(json(&["run", "--plant", "point", "--json"])["preference_changes"], json!([]));
}

/// A robot that leads does what it did, at every step and to the last bit; only the human would rather go
/// another way.
#[test]
fn the_robot_is_not_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let [same, other] = ["same.csv", "other.csv"].map(|name| folder.path().join(name));
    for plant in ["point", "kinematic"] {
        let asked = ["--plant", plant, "--method", "robot-led", "--overwrite", "--ticks"];
        let name = |file: &Path| file.to_str().expect("UTF-8").to_owned();
        example(&[&asked[..], &[&name(&same)]].concat());
        example(&[&asked[..], &[&name(&other), "--change", "20:0.95,1.1"]].concat());
        let (same, other) = (ticks(&same), ticks(&other));
        assert_eq!(same.len(), other.len());
        let mut differ = 0;
        for (i, (mut a, mut b)) in same.into_iter().zip(other).enumerate() {
            let [before, after] =
                [&mut a, &mut b].map(|row| ["preferred", "preferred_index"].map(|key| row.remove(key)));
            assert!(i >= 20 || before == after, "{plant}: before the change");
            differ += u32::from(before != after);
            assert!(a == b, "{plant}: step {i}");
        }
        assert!(differ > 0, "{plant}: the change changes what the human prefers");
    }
}

#[test]
fn without_model_the_option_preferred_at_the_start_is_kept() {
    for change in ["1:0.95,1.1", "40:0.95,1.1"] {
        let told = example(&["--plant", "point", "--method", "without-model", "--change", change]);
        assert_eq!((&told["last_option"], &told["option_changes"]), (&json!("4"), &json!([])));
    }
    // before the first choice, there is nothing to keep yet
    let told = example(&["--plant", "point", "--method", "without-model", "--change", "0:0.95,1.1"]);
    assert_eq!(told["first_option"], "3");
}

#[test]
fn preference_changes_do_not_move_the_human_or_the_gait_of_a_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let [kept, drawn] = ["kept.csv", "drawn.csv"].map(|name| folder.path().join(name));
    let run = |times: &str, file: &Path| {
        let ticks = file.to_str().expect("UTF-8");
        let asked =
            ["run", "--method", "human-led", "--seed", "8", "--sway", "0.03", "--preference-changes", times];
        json(&[&asked[..], &["--ticks", ticks, "--json"]].concat())
    };
    let (without, with) = (run("0", &kept), run("2", &drawn));
    assert_eq!(without["human"], with["human"]);
    let first = with["preference_changes"][0]["step"].as_u64().expect("a step") as usize;
    assert!(first > 5, "choose a seed whose first change is later");
    let (kept, drawn) = (ticks(&kept), ticks(&drawn));
    assert!(kept[..first] == drawn[..first], "up to the first change all is the same");
    assert!(kept != drawn);
}

#[test]
fn preference_changes_are_drawn_as_the_first_was_up_to_half_of_the_way_preferred() {
    let mut counts = [0; 3];
    let mut latest = 0.0_f64;
    for seed in 0..60 {
        let seed = seed.to_string();
        let asked =
            ["run", "--plant", "point", "--seed", &seed, "--belief-gamma", "uniform(0.7,0.8)", "--json"];
        let told = json(&[&asked[..], &["--preference-changes", "once-or-twice"]].concat());
        let changes = told["preference_changes"].as_array().expect("a list");
        counts[changes.len()] += 1;
        let preferred = told["options"]
            .as_array()
            .expect("options")
            .iter()
            .find(|o| o["name"] == told["preferred_at_start"]);
        let nominal = preferred.expect("an option")["length_m"].as_f64().expect("m") / 0.1;
        for change in changes {
            let number = |key: &str| change[key].as_f64().expect("a number");
            assert!(
                (0.55..=0.95).contains(&number("alpha")) && (0.7..=0.8).contains(&number("gamma")),
                "{change}"
            );
            assert!((1.0..=nominal / 2.0).contains(&number("step")), "{change} of {nominal} steps");
            latest = latest.max(number("step") / nominal);
        }
        // what is given stays
        let given = json(&[&asked[..], &["--preference-changes", "8", "--alpha", "0.7"]].concat());
        let changes = given["preference_changes"].as_array().expect("a list");
        assert!(
            changes.len() == 8
                && changes
                    .iter()
                    .all(|change| change["alpha"] == 0.7 && change["gamma"] != given["human"]["gamma"])
        );
    }
    assert!(counts[0] == 0 && counts[1] >= 15 && counts[2] >= 15, "a fair coin: {counts:?}");
    assert!(latest > 0.45, "{latest}");
}

#[test]
fn what_is_wrong_is_named() {
    let form = "must be STEP:ALPHA,GAMMA";
    let cases: [(&[&str], &[&str]); 16] = [
        (&["--change", "3"], &["--change", form]),
        (&["--change", "3:0.7"], &[form]),
        (&["--change", "3,0.7,0.5"], &[form]),
        (&["--change", ":0.7,0.5"], &[form, "STEP \"\"", "whole number of steps"]),
        (&["--change", "x:0.7,0.5"], &[form, "STEP \"x\"", "whole number of steps"]),
        (&["--change", "2.5:0.7,0.5"], &[form, "STEP \"2.5\""]),
        (&["--change", "3:20,0.5"], &[form, "ALPHA \"20\"", "greater than 0 and at most 10"]),
        (&["--change", "3:0.7,0"], &[form, "GAMMA \"0\"", "greater than 0 and at most 10"]),
        (&["--change", "3:0.7,nan"], &[form, "GAMMA \"nan\""]),
        (&["--change", "3:0.7,0.5,1"], &[form, "GAMMA \"0.5,1\""]),
        (&["--preference-changes", "9"], &["--preference-changes", "from 0 to 8, or \"once-or-twice\""]),
        (&["--preference-changes", "-1"], &["--preference-changes", "from 0 to 8, or \"once-or-twice\""]),
        (&["--preference-changes", "1.5"], &["from 0 to 8, or \"once-or-twice\""]),
        (&["--preference-changes", "twice"], &["from 0 to 8, or \"once-or-twice\""]),
        (
            &["--preference-changes", "1", "--change", "3:0.7,0.5"],
            &["--preference-changes", "--change", "cannot be used with"],
        ),
        (
            &["--preference-changes", "2", "--alpha", "0.7", "--gamma", "0.8"],
            &["--preference-changes 2", "both are given", "--change"],
        ),
    ];
    for (arguments, said) in cases {
        let output = cocarry(&[&["run", "--plant", "point"], arguments].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty() && error.starts_with("error: "), "{error}");
        for part in said {
            assert!(error.contains(part), "{arguments:?}: {part:?} is missing from: {error}");
        }
    }
}

#[test]
fn the_help_says_which_methods_ignore_preference_changes() {
    let help = stdout(&cocarry(&["run", "--help"]));
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "--change <STEP:ALPHA,GAMMA>",
        "--preference-changes <N>",
        "nor with --method without-model after the start",
    ] {
        assert!(help.contains(part), "{part:?} is missing from:\n{help}");
    }
}

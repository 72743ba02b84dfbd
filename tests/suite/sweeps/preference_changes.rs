//! Humans of a study who change their mind on the way.

use super::*;

/// The human of a seed, and what they change their mind to, are those of `cocarry run
/// --preference-changes`, whoever decides and whatever carries.
#[test]
fn humans_change_their_mind_as_those_of_run() {
    let bench = Bench::new(
        r#"worlds = ["environment-1", "environment-4"]
plants = ["point", "kinematic"]
methods = ["mutual", "without-model", "human-led"]
preference_changes = [0, 3, "once-or-twice"]
max_steps = 90
seeds = { first = 5, last = 7 }

[[human]]
name = "careful"
alpha = 0.6
gamma = "uniform(0.5,0.7)"
"#,
    );
    bench.good(&["study.toml"]);
    let rows = bench.rows("study.csv");
    assert_eq!(rows.len(), 2 * 2 * 3 * 3 * 3);
    for world in ["environment-1", "environment-4"] {
        for seed in ["5", "6", "7"] {
            for (times, count) in [("0", 0..=0), ("3", 3..=3), ("once-or-twice", 1..=2)] {
                let is_of = |r: &&Row| {
                    r["world"] == world && r["seed"] == seed && r["preference_changes_drawn"] == times
                };
                let of: Vec<&Row> = rows.iter().filter(is_of).collect();
                assert_eq!(of.len(), 6);
                let changes = &of[0]["preference_changes"];
                assert!(of.iter().all(|row| row["preference_changes"] == *changes), "{changes}");
                assert!(count.contains(&changes.split_whitespace().count()), "{times}: {changes:?}");
                let row =
                    of.iter().find(|r| r["plant"] == "point" && r["method"] == "human-led").expect("a row");
                let asked = ["run", world, "--plant", "point", "--method", "human-led", "--max-steps", "90"];
                let human = ["--alpha", "0.6", "--belief-gamma", "uniform(0.5,0.7)", "--seed", seed];
                let told =
                    cocarry(&[&asked[..], &human, &["--preference-changes", times, "--json"]].concat());
                let told: Value = serde_json::from_slice(&told.stdout).expect("JSON");
                agrees(row, &told, &[("gamma", "/human/gamma")]);
                let one = |c: &Value| format!("{}:{},{}", c["step"], c["alpha"], c["gamma"]);
                let drawn: Vec<String> =
                    told["preference_changes"].as_array().expect("a list").iter().map(one).collect();
                assert_eq!(drawn.join(" "), *changes);
                // the robot of the study believes something else, which a human who leads does not ask
                agrees(row, &told, &[("last_option", "/last_option"), ("walked_m", "/walked_m")]);
                // as the column has them, `--change` takes them
                let given: Vec<&str> =
                    changes.split(' ').filter(|c| !c.is_empty()).flat_map(|c| ["--change", c]).collect();
                let again = cocarry(&[&asked[..], &human, &given, &["--json"]].concat());
                let again: Value = serde_json::from_slice(&again.stdout).expect("JSON");
                assert_eq!(
                    (&again["walked_m"], &again["preference_changes"]),
                    (&told["walked_m"], &told["preference_changes"])
                );
            }
        }
    }
}

/// A robot wider than `robot_width_m` changes the openings that the team can pass, and not who carries with it.
#[test]
fn issue_another_width_another_human() {
    let bench = Bench::new(
        r#"worlds = ["environment-4"]
robots = ["wide.toml"]
plants = ["point", "kinematic"]
preference_changes = [2]
max_steps = [1]
seeds = { first = 1, last = 3 }
"#,
    );
    let folder = bench.path("");
    let text = std::fs::read_to_string(repository("assets/robots/porter.toml")).expect("a robot");
    let wide = text.replace("base_width_m = 0.5", "base_width_m = 0.70").replace(
        "urdf = \"porter.urdf\"",
        &format!("urdf = {:?}", repository("assets/robots/porter.urdf").display().to_string()),
    );
    std::fs::write(bench.path("wide.toml"), wide).expect("a robot file");
    bench.good(&["study.toml"]);
    let rows = bench.rows("study.csv");
    assert_eq!(rows.len(), 2 * 3);
    for row in &rows {
        let asked = ["run", "environment-4", "--max-steps", "1", "--preference-changes", "2", "--json"];
        let mut run = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        run.current_dir(&folder).args(asked).args(["--seed", &row["seed"], "--plant", &row["plant"]]);
        if row["plant"] != "point" {
            run.args(["--robot", "wide.toml"]);
        }
        let output = run.output().expect("the program starts");
        let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let one = |c: &Value| format!("{}:{},{}", c["step"], c["alpha"], c["gamma"]);
        let drawn: Vec<String> =
            told["preference_changes"].as_array().expect("a list").iter().map(one).collect();
        assert_eq!(drawn.join(" "), row["preference_changes"], "{} seed {}", row["plant"], row["seed"]);
        let same = rows.iter().filter(|other| other["seed"] == row["seed"]);
        assert!(same.into_iter().all(|other| other["preference_changes"] == row["preference_changes"]));
    }
    let steps = |seed: &str| {
        let row = rows.iter().find(|row| row["seed"] == seed).expect("a row");
        row["preference_changes"]
            .split(' ')
            .map(|c| c.split(':').next().unwrap_or_default().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(steps("1"), ["7", "58"]);
}

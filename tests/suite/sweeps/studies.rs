//! Studies that are wrong, and those that ship with the documentation.

use super::*;

#[test]
fn what_cannot_be_written_ends_with_4() {
    let bench = Bench::new(STUDY);
    bench.refused(&["study.toml", "--output", "no/such/folder/a.csv"], 4, &["no/such/folder/a.csv.partial"]);
}

/// Replaces the one place where `from` stands.
fn spoil(from: &str, to: &str, said: &[&str]) {
    assert_eq!(STUDY.matches(from).count(), 1, "{from:?}");
    let bench = Bench::new(&STUDY.replace(from, to));
    bench.refused(&["study.toml"], 2, said);
    assert!(!bench.path("study.csv.partial").exists(), "nothing is begun");
}

#[test]
fn what_is_wrong_in_a_study_is_named() {
    let worlds = "worlds = [\"environment-1\", \"environment-4\"]";
    spoil("seeds = 6", "seeds = = 6", &["study.toml: not a valid study file", "line 8"]);
    spoil("seeds = 6", "seed = 6", &["study.toml:8: seed: unknown key", "seeds"]);
    spoil("seeds = 6", "seeds = 0", &["study.toml:8: seeds = 0", "from 1 to 1000000000"]);
    spoil("seeds = 6", "seeds = { first = 7, last = 6 }", &["study.toml:8: seeds = { first = 7, last = 6 }"]);
    spoil("seeds = 6", "seeds = [1, 2]", &["study.toml:8: seeds = [1, 2]", "first = 100"]);
    spoil(worlds, "", &["study.toml:1: study: worlds is missing"]);
    spoil(worlds, "worlds = []", &["study.toml:3: worlds = []", "built-in world"]);
    spoil(worlds, "worlds = \"environment-5\"", &["study.toml:3: worlds: environment-5: no such world"]);
    spoil("\"environment-4\"]", "\"environment-1\"]", &["study.toml:3: worlds: duplicate \"environment-1\""]);
    spoil("[5, 10.5]", "[5,\n -1]", &["study.toml:7: eta = -1", "greater than 0 and at most 1000000"]);
    spoil("[5, 10.5]", "[5, \"ten\"]", &["study.toml:6: eta = \"ten\"", "a number"]);
    spoil("[5, 10.5]", "nan", &["study.toml:6: eta = nan"]);
    spoil("\"without-model\"", "\"telepathy\"", &["study.toml:5: methods = \"telepathy\"", "without-model"]);
    spoil("\"point\"", "\"paper\"", &["study.toml:4: plants = \"paper\"", "kinematic"]);
    spoil("plants = \"point\"", "plants = \"point\"\npose = \"arm\"", &["study.toml:5: pose", "a robot"]);
    spoil("plants = \"point\"", "sway_m = 0.01", &["study.toml:4: sway_m", "body"]);
    spoil(
        "plants = \"point\"",
        "postures = \"asleep\"",
        &["study.toml:4: postures = \"asleep\"", "elbow-out"],
    );
    spoil("plants = \"point\"", "max_steps = 0", &["study.toml:4: max_steps = 0"]);
    spoil("plants = \"point\"", "planning_step_s = 0", &["study.toml:4: planning_step_s = 0", "0.01 to 60"]);
    spoil(
        "plants = \"point\"",
        "period_s = 0.1",
        &["study.toml:4: period_s = 0.1", "planning_step_s", "control_period_s"],
    );
    spoil(
        "plants = \"point\"",
        "human_model = [\"preference\", \"robot\"]",
        &["study.toml:4: human_model = \"robot\"", "boltzmann(RATIONALITY)"],
    );
    spoil(
        "plants = \"point\"",
        "human_model = \"scripted(0:9)\"",
        &["study.toml", "human_model scripted(0:9)", "unknown option `9`"],
    );
    let times = "from 0 to 8, or \"once-or-twice\"";
    for bad in ["9", "-1", "1.5", "\"twice\"", "true"] {
        let to = format!("plants = \"point\"\npreference_changes = {bad}");
        spoil("plants = \"point\"", &to, &[&format!("study.toml:5: preference_changes = {bad}"), times]);
    }
    spoil(
        "plants = \"point\"",
        "preference_changes = [2, 2]",
        &["study.toml:4: preference_changes: duplicate 2"],
    );
    spoil(
        "plants = \"point\"",
        "preference_changes = [0, 2]",
        &["study.toml:4: preference_changes = 2", "`same`", "fixed numbers"],
    );
    spoil("\"same\"]", "\"other\"]", &["study.toml:7: humans = \"other\"", "\"all\", \"same\""]);
    spoil("name = \"same\"", "name = \"all\"", &["study.toml:15: name: duplicate \"all\""]);
    spoil("name = \"same\"\n", "", &["study.toml:15: [[human]]: name is missing"]);
    spoil("alpha = 0.747", "alpha = 0", &["study.toml:17: alpha = 0", "uniform(LOWER,UPPER)"]);
    spoil(
        "alpha = 0.747",
        "alpha = \"uniform(1,0)\"",
        &["study.toml:17: alpha = \"uniform(1,0)\"", "LOWER < UPPER"],
    );
    spoil("gamma = 0.765", "colour = 1", &["study.toml:18: colour: unknown key", "gamma"]);
    spoil("gamma = 0.765", "", &["[[human]]: gamma is missing"]);
    spoil("\"normal(0.75,0.05,0.55,0.95)\"", "0.7", &["study.toml:22: alpha = 0.7", "normal(MEAN"]);
    spoil("[[belief]]", "[belief]", &["study.toml:20: belief", "[[belief]]"]);
    spoil("seeds = 6", "seeds = 6\nrun = 3", &["study.toml:9: run = 3", "[[run]]"]);
}

#[test]
fn what_is_wrong_in_a_run_is_named() {
    let run =
        |text: &str, said: &[&str]| Bench::new(&format!("{STUDY}{text}")).refused(&["study.toml"], 2, said);
    run("[[run]]\nname = \"x\"\n", &["study.toml:25: name: unknown key", "worlds"]);
    run(
        "[[run]]\n[[run]]\neta = 5\n",
        &["study.toml:25: [[run]]: seed 0", "already covered by an earlier [[run]]", "eta 5"],
    );
    let many: Vec<String> = (1..400).map(|i| i.to_string()).collect();
    let many = many.join(", ");
    run(
        &format!("[[run]]\neta = [{many}]\nrisk_weight_m = [{many}]\n"),
        &["study.toml:24: [[run]]: more than 100000 combinations"],
    );
}

#[test]
fn what_is_wrong_on_the_command_line_is_named() {
    let bench = Bench::new(STUDY);
    bench.refused(&["nowhere.toml"], 2, &["nowhere.toml: cannot be read"]);
    for shard in ["0/3", "4/3", "1", "a/b"] {
        bench.refused(&["study.toml", "--shard", shard], 2, &["--shard", "1 <= I <= N"]);
    }
    bench.refused(&[], 2, &["<STUDY>"]);
    bench.refused(&["study.toml", "--summary", "study.csv"], 2, &["--summary"]);
    bench.refused(&["--summary", "nowhere.csv"], 2, &["nowhere.csv: cannot be read"]);
    bench.refused(&["--merge", "all.csv"], 2, &["--merge"]);
}

#[test]
fn the_studies_of_the_docs_run() {
    let folder = repository("docs/studies");
    let mut studies = 0;
    for entry in std::fs::read_dir(&folder).expect("the studies") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|end| end != "toml") {
            continue;
        }
        let bench = Bench::new("");
        bench.good(&[path.to_str().expect("UTF-8"), "--seeds", "1", "--output", "a.csv"]);
        assert!(bench.rows("a.csv").len() >= 12, "{}", path.display());
        studies += 1;
    }
    assert_eq!(studies, 3);
}

/// Slurm's part is played by the test: the tasks one after the other, with what Slurm tells them. Tasks 2 and
/// 3 are submitted again, without task 1: Slurm then counts two tasks.
#[cfg(unix)]
#[test]
fn the_job_array_of_the_docs_merges_to_the_whole() {
    let bench = Bench::new("");
    let program = Path::new(env!("CARGO_BIN_EXE_cocarry")).parent().expect("a folder");
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::join_paths([program.to_owned()].into_iter().chain(std::env::split_paths(&paths)));
    let study = repository("docs/studies/h2.toml");
    let study = study.to_str().expect("UTF-8");
    for (task, count) in [("1", "3"), ("2", "2"), ("3", "2")] {
        let output = Command::new("bash")
            .arg(repository("docs/studies/array.sh"))
            .args(["3", study, "--seeds", "2"])
            .env("PATH", paths.as_ref().expect("paths"))
            .env("SLURM_ARRAY_TASK_ID", task)
            .env("SLURM_ARRAY_TASK_COUNT", count)
            .env("SLURM_CPUS_PER_TASK", "2")
            .current_dir(bench.folder.path())
            .output()
            .expect("bash");
        assert!(output.status.success(), "{}", stderr(&output));
    }
    bench.good(&["--merge", "h2.csv", "h2.1-of-3.csv", "h2.2-of-3.csv", "h2.3-of-3.csv"]);
    bench.good(&[study, "--seeds", "2", "--output", "whole.csv"]);
    assert!(bench.read("h2.csv") == bench.read("whole.csv"));
    let script = std::fs::read_to_string(repository("docs/studies/array.sh")).expect("the script");
    assert!(script.contains("cocarry sweep --merge h2.csv h2.*-of-16.csv"));
    assert!(
        json(&["sweep", "--summary", bench.path("h2.csv").to_str().expect("UTF-8"), "--json"]).is_object()
    );
}

/// An alpha that experiments do not find is warned of as `cocarry run` does, once; a drawn one is not.
#[test]
fn humans_as_no_experiment_found_are_warned_of_once() {
    let said = "alpha = 7.47: experiments find values from 0.2 to 2 for people";
    let run = cocarry(&["run", "--plant", "point", "--alpha", "7.47", "--gamma", "0.765"]);
    assert!(stderr(&run).contains(said), "{}", stderr(&run));
    let bench = Bench::new(&STUDY.replace("alpha = 0.747", "alpha = 7.47"));
    let output = bench.good(&["study.toml", "--seeds", "1"]);
    assert_eq!(stderr(&output).matches(said).count(), 1, "{}", stderr(&output));
    assert_eq!(stderr(&output).matches("experiments find").count(), 1, "{}", stderr(&output));
    let bench = Bench::new(STUDY);
    assert!(!stderr(&bench.good(&["study.toml", "--seeds", "1"])).contains("experiments find"));
}

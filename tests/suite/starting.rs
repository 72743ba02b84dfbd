//! What a newcomer starts from, without a clone: `new`, `export`, `worlds`, completions, manual pages.

use crate::support::{cocarry, json, repository, stderr, stdout};
use std::path::Path;
use std::process::{Command, Output};

pub fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    program.args(arguments).env_remove("COLUMNS").current_dir(folder).output().expect("it starts")
}

pub fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = run_in(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

#[test]
fn new_files_run_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let told = succeeds(folder.path(), &["new", "kitchen"]);
    // the commands that it names are those to run
    let tried: Vec<&str> = told.lines().filter_map(|line| line.trim().strip_prefix("cocarry ")).collect();
    assert_eq!(tried.len(), 4, "{told}");
    for line in tried {
        succeeds(folder.path(), &line.split(' ').collect::<Vec<_>>());
    }
    for file in
        ["world.toml", "robot.toml", "robot.urdf", "study.toml", "answers.csv", "episode.html", "results.csv"]
    {
        assert!(folder.path().join("kitchen").join(file).is_file(), "{file}");
    }
    // and the commands in their comments
    let inside = folder.path().join("kitchen");
    for file in ["world.toml", "robot.toml", "study.toml", "answers.csv"] {
        let text = std::fs::read_to_string(inside.join(file)).unwrap();
        let command = text.lines().find_map(|line| line.strip_prefix("#   cocarry ")).expect("a command");
        succeeds(&inside, &command.split(' ').collect::<Vec<_>>());
    }
}

#[test]
fn a_new_folder_is_taken_by_the_fits() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["new", "kitchen"]);
    let told = succeeds(folder.path(), &["fit", "risk-weight", "kitchen", "--resamples", "40"]);
    // a range of one number is none
    assert!(told.contains("from the answers of 3 participants") && !told.contains("\nFrom "), "{told}");
    succeeds(folder.path(), &["infer", "kitchen", "--draws", "100"]);
    let refused = run_in(folder.path(), &["fit", "eta", "kitchen"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("kitchen: a folder without switches.csv"), "{}", stderr(&refused));
}

#[test]
fn the_commented_openings_and_options_of_a_new_world_can_be_used() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["new", "."]);
    let file = folder.path().join("world.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (found, named) = text.split_once("# Openings and options").unwrap();
    let named: Vec<&str> =
        named.lines().skip(2).map(|line| line.trim_start_matches("# ").trim_start_matches('#')).collect();
    std::fs::write(&file, format!("{found}{}\n", named.join("\n"))).unwrap();
    let world = run_in(folder.path(), &["world", "world.toml", "--json"]);
    assert!(world.status.success(), "{}", stderr(&world));
    let world: serde_json::Value = serde_json::from_slice(&world.stdout).unwrap();
    assert_eq!(world["options_enumerated"], false);
    assert_eq!(world["openings"][0]["name"], "narrow");
    assert_eq!(world["options"].as_array().unwrap().len(), 2);
}

#[test]
fn new_replaces_nothing_and_writes_all_files_or_none() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), "mine").unwrap();
    let output = run_in(folder.path(), &["new", "."]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("study.toml: exists already"), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    succeeds(folder.path(), &["new", ".", "--overwrite"]);
    assert!(std::fs::read_to_string(folder.path().join("study.toml")).unwrap().contains("worlds ="));
}

/// The folder stands for its file of the kind that the command takes.
#[test]
fn a_folder_of_new_is_understood_as_its_world_robot_or_study() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["new", "kitchen"]);
    let told = succeeds(folder.path(), &["world", "kitchen"]);
    assert_eq!(told, succeeds(folder.path(), &["world", "kitchen/world.toml"]));
    let told = succeeds(folder.path(), &["robot", "check", "kitchen"]);
    assert_eq!(told, succeeds(folder.path(), &["robot", "check", "kitchen/robot.toml"]));
    succeeds(
        folder.path(),
        &["run", "kitchen", "--robot", "kitchen", "--plant", "kinematic", "--max-steps", "9999"],
    );
    let told = succeeds(folder.path(), &["sweep", "kitchen", "--seeds", "1", "-o", "rows.csv"]);
    assert!(told.contains("rows.csv: "), "{told}");
}

#[test]
fn what_is_exported_is_what_is_built_in() {
    let folder = tempfile::tempdir().unwrap();
    for (name, sources) in [
        ("environment-1", &["worlds/environment-1.toml"][..]),
        ("environment-4", &["worlds/environment-4.toml"]),
        ("free-form", &["worlds/free-form.toml"]),
        ("carrier", &["assets/robots/carrier.toml", "assets/robots/carrier.urdf"]),
        ("h1", &["docs/studies/h1.toml"]),
        ("h2", &["docs/studies/h2.toml"]),
        ("h3", &["docs/studies/h3.toml"]),
        ("table-1-humans", &["docs/data/table-1-humans.csv"]),
    ] {
        let told = succeeds(folder.path(), &["export", name]);
        assert_eq!(told.lines().count(), sources.len());
        for source in sources {
            let file = folder.path().join(Path::new(source).file_name().unwrap());
            assert_eq!(std::fs::read(file).unwrap(), std::fs::read(repository(source)).unwrap(), "{source}");
        }
    }
    // a dash prints the same
    let told = run_in(folder.path(), &["export", "environment-4", "-"]);
    assert_eq!(told.stdout, std::fs::read(repository("worlds/environment-4.toml")).unwrap());
    // an exported robot is the built-in one
    let cost = |arguments: &[&str]| {
        let arguments = [&["run", "--plant", "kinematic", "--max-steps", "20", "--json"], arguments].concat();
        let output = run_in(folder.path(), &arguments);
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        told["accumulated_control_cost"].as_f64().expect("a cost")
    };
    assert_eq!(cost(&[]), cost(&["--robot", "carrier.toml"]));
    let again = run_in(folder.path(), &["export", "carrier"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("carrier.toml: exists already"), "{}", stderr(&again));
}

#[test]
fn every_world_of_the_repository_is_built_in_and_listed() {
    let listed = json(&["worlds", "--json"]);
    let names: Vec<&str> =
        listed["worlds"].as_array().unwrap().iter().map(|world| world["name"].as_str().unwrap()).collect();
    let files = crate::support::world_files();
    let stems: Vec<_> = files.iter().map(|file| file.file_stem().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, stems);
    let text = stdout(&cocarry(&["worlds"]));
    assert!(names.iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn completions_and_manual_pages_name_the_commands_and_options() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = stdout(&cocarry(&["completions", shell]));
        for word in ["sweep", "preference-changes", "export", "cite"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    // the names of worlds in the parts of the two commands that take one
    for (shell, before) in [("elvish", "cand "), ("powershell", "[CompletionResult]::new('")] {
        let script = stdout(&cocarry(&["completions", shell]));
        for part in ["'cocarry;run'", "'cocarry;world'"] {
            let (_, begin) = script.split_once(part).unwrap_or_else(|| panic!("{shell}: {part}"));
            let mut lines = begin.lines().skip(1);
            for name in ["environment-1", "environment-2", "environment-3", "environment-4"] {
                let line = lines.find(|line| line.trim_start().starts_with(&format!("{before}{name}")));
                assert!(line.is_some_and(|line| line.contains("built-in world")), "{shell}: {part}: {name}");
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let first = succeeds(folder.path(), &["man"]);
    assert!(first.starts_with(".ie") || first.contains(".TH cocarry 1"), "{}", &first[..200]);
    succeeds(folder.path(), &["man", "--output", "."]);
    for page in ["cocarry.1", "cocarry-run.1", "cocarry-fit-eta.1", "cocarry-reproduce-all.1"] {
        let text =
            std::fs::read_to_string(folder.path().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
        assert!(text.contains(".SH SYNOPSIS"), "{page}");
    }
}

/// bash itself accepts the script and completes a command with it.
#[test]
fn bash_completes_a_command() {
    let Ok(bash) = Command::new("bash").arg("--version").output() else { return };
    if !bash.status.success() {
        return;
    }
    let script = stdout(&cocarry(&["completions", "bash"]));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("complete.sh");
    let completed = |words: &[&str]| {
        let [.., before, word] = words else { panic!("{words:?}") };
        let (all, last) = (words.join(" "), words.len() - 1);
        let ask = format!(
            "COMP_WORDS=({all}); COMP_CWORD={last}; _cocarry cocarry {word} {before}; echo \"${{COMPREPLY[@]}}\""
        );
        // longer than an argument can be
        std::fs::write(&file, format!("{script}\n{ask}\n")).unwrap();
        let output = Command::new("bash").arg(&file).output().unwrap();
        stdout(&output).trim().to_owned()
    };
    assert_eq!(completed(&["cocarry", "reg"]), "regress");
    let environments = "environment-1 environment-2 environment-3 environment-4";
    assert_eq!(completed(&["cocarry", "run", "env"]), environments);
    assert_eq!(completed(&["cocarry", "world", "env"]), environments);
    // bash itself completes files where there is none of these
    assert_eq!(completed(&["cocarry", "run", "./wor"]), "");
}

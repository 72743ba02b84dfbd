//! Mistyped names: every error says what was probably meant.

use crate::support::{cocarry, stderr};

/// Runs the program in a folder with the files given, and checks that it ends with 2 and says something.
fn says(files: &[(&str, &str)], arguments: &[&str], said: &str) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_cocarry"));
    let output = program.args(arguments).env_remove("COLUMNS").current_dir(folder.path()).output().unwrap();
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.contains(said), "{arguments:?}: {said:?} is missing from:\n{error}");
    assert!(output.stdout.is_empty());
}

#[test]
fn mistyped_values_of_arguments_have_a_suggestion() {
    for (arguments, said) in [
        (&["run", "environmnt-4"][..], "did you mean `environment-4`?"),
        (&["world", "Environment-2"], "did you mean `environment-2`?"),
        (&["run", "env4"], "did you mean `environment-4`?"),
        (&["world", "4"], "did you mean `environment-4`?"),
        (&["run", "--plant", "kinematik"], "'kinematic'"),
        (&["run", "--method", "mutal"], "'mutual'"),
        (&["run", "--pose", "whole_body"], "'whole-body'"),
        (&["run", "--posture", "elbow-upp"], "did you mean `elbow-up`?"),
        (&["run", "--human", "boltzman(2)"], "did you mean `boltzmann(RATIONALITY)`?"),
        (&["run", "--human", "preferences"], "did you mean `preference`?"),
        (&["run", "--sed", "3"], "'--seed'"),
        (&["export", "environment4"], "'environment-4'"),
        (&["export", "carier"], "'carrier'"),
        (&["regres"], "'regress'"),
        (&["rnu"], "'run'"),
        (&["cluster", "gahter"], "'gather'"),
        (&["run", "-eta", "5"], "'--eta'"),
    ] {
        says(&[], arguments, said);
    }
    says(&[], &["run", "--robot", "carrier"], "the built-in robot is the default");
}

#[test]
fn mistyped_files_have_the_name_of_a_file_beside_them() {
    let study = "worlds = \"environment-1\"\nplants = \"point\"\n";
    says(&[("kitchen.toml", "")], &["run", "kitchn.toml"], "did you mean `kitchen.toml`?");
    says(&[("robot.toml", "")], &["run", "--robot", "robbot.toml"], "did you mean `robot.toml`?");
    says(&[("study.toml", study)], &["sweep", "studdy.toml"], "did you mean `study.toml`?");
    says(&[("robot.toml", "")], &["run", "--robot", "./robbot.toml"], "did you mean `./robot.toml`?");
    says(&[("answers.csv", "")], &["fit", "risk-weight", "answer.csv"], "did you mean `answers.csv`?");
}

#[test]
fn mistyped_keys_and_values_of_files_have_a_suggestion() {
    let study = |line: &str| format!("worlds = \"environment-1\"\n{line}\n");
    for (line, said) in [
        ("sedds = 3", "did you mean `seeds`?"),
        ("metods = \"mutual\"", "did you mean `methods`?"),
        ("methods = \"mutuall\"", "did you mean `mutual`?"),
        ("plants = \"rapir\"", "did you mean `rapier`?"),
        ("humans = \"papre\"", "did you mean `paper`?"),
        ("human_model = \"boltzman(3)\"", "did you mean `boltzmann(RATIONALITY)`?"),
        ("postures = \"elbowup\"", "did you mean `elbow-up`?"),
        ("robots = \"biult-in\"", "did you mean `built-in`?"),
    ] {
        says(&[("s.toml", &study(line))], &["sweep", "s.toml"], said);
    }
    let mistyped = "worlds = \"enviroment-1\"\n";
    says(&[("s.toml", mistyped)], &["sweep", "s.toml"], "did you mean `environment-1`?");
    let world = "nmae = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [2, 0]\n";
    says(&[("w.toml", world)], &["world", "w.toml"], "did you mean `name`?");
    let shape = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [2, 0]\n\
        [[obstacle]]\nname = \"a\"\nshape = \"cilinder\"\nheight_m = 1.0\n";
    says(&[("w.toml", shape)], &["world", "w.toml"], "did you mean `cylinder`?");
    let opening = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [5, 0]\n\
        [[obstacle]]\nname = \"island\"\nshape = \"cylinder\"\ncenter_m = [3, 3]\nradius_m = 1.0\nheight_m = 1.0\n\
        [[opening]]\nname = \"o\"\nbetween = [\"islnad\", \"wall\"]\n";
    says(&[("w.toml", opening)], &["world", "w.toml"], "did you mean `island`?");
}

/// A file of another kind is named, with where it belongs.
#[test]
fn a_file_given_where_another_kind_belongs_is_named() {
    let world = include_str!("../../worlds/environment-1.toml");
    let robot = "name = \"r\"\nurdf = \"r.urdf\"\n";
    let study = "worlds = \"environment-1\"\nplants = \"point\"\n";
    let files = [("w.toml", world), ("r.toml", robot), ("s.toml", study)];
    says(&files, &["run", "r.toml"], "error: r.toml: this is a robot file; give it as --robot");
    says(&files, &["world", "s.toml"], "error: s.toml: this is a study; run it with `cocarry sweep`");
    says(&files, &["sweep", "w.toml"], "error: w.toml: this is a world file; give it to `cocarry run`");
    says(&files, &["run", "--robot", "w.toml"], "error: w.toml: this is a world file");
    says(
        &files,
        &["sweep", "r.toml"],
        "error: r.toml: this is a robot file; give it as --robot to `cocarry run`",
    );
    says(&files, &["sweep", "r.toml"], "under `robots` in a study");
    says(
        &files,
        &["robot", "check", "w.toml"],
        "error: w.toml: this is a world file; give it to `cocarry run`",
    );
    says(
        &files,
        &["robot", "check", "s.toml"],
        "error: s.toml: this is a study; run it with `cocarry sweep`",
    );
    // and of those that are no TOML, with what to type
    let results = "episode,episodes,study,arithmetic,checksum,world\n0,1,5c7977ff164f90b7,aa7e1f03,,w\n";
    let answers = "# of people\nparticipant;world;option;percent\nanna;w;1;100\n";
    let switches = "participant,world,option,step\nanna,w,1,40\n";
    let urdf = "<?xml version=\"1.0\"?>\n<robot name=\"r\"/>\n";
    let files = [("r.csv", results), ("a.csv", answers), ("s.csv", switches), ("r.urdf", urdf)];
    for command in ["sweep", "world", "run"] {
        let said = "error: r.csv: these are the results of a sweep; `cocarry sweep --summary r.csv`";
        says(&files, &[command, "r.csv"], said);
        says(
            &files,
            &[command, "a.csv"],
            "answers of participants; give them to `cocarry fit risk-weight a.csv`",
        );
        says(&files, &[command, "s.csv"], "switches of participants; give them to `cocarry fit eta s.csv`");
        says(&files, &[command, "r.urdf"], "the URDF of a robot; `cocarry robot init r.urdf`");
    }
    let output = cocarry(&["run", "recordings/environment-1.mcap"]);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("this is a recording; see `cocarry inspect recordings/environment-1.mcap`"),
        "{error}"
    );
}

#[test]
fn a_former_argument_is_no_suggestion() {
    let output = cocarry(&["run", "--version"]);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("unexpected argument '--version'") && !error.contains("--period"), "{error}");
}

#[test]
fn a_number_that_is_not_whole_is_refused_in_words() {
    for value in ["1.5", "-1", "ten"] {
        let said =
            format!("invalid value '{value}' for '--seed <SEED>': expected a whole number of at least 0");
        says(&[], &["run", "--seed", value], &said);
    }
}

#[test]
fn a_name_like_none_has_no_suggestion() {
    let output = cocarry(&["run", "zebra"]);
    let error = stderr(&output);
    assert!(error.contains("no such world") && !error.contains("did you mean"), "{error}");
}

#[test]
fn another_extension_than_that_of_the_format_is_refused() {
    for arguments in [
        &["run", "--svg", "a.png"][..],
        &["world", "environment-1", "--svg", "map"],
        &["reproduce", "h2", "--svg", "a.pdf"],
        &["run", "--record", "a.bag"],
        &["run", "--render", "a.mp4"],
        &["run", "--ticks", "a.xlsx"],
    ] {
        says(&[], arguments, "expected");
    }
}

//! Standard input and output in pipes.

use crate::support::{repository, stderr, stdout};
use std::io::{Read, Write};
use std::process::{Command, Output, Stdio};

fn program(arguments: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    program.args(arguments).env_remove("COLUMNS").current_dir(repository("."));
    program
}

/// Runs the program with this on its standard input.
fn with_input(arguments: &[&str], input: &[u8]) -> Output {
    let mut program = program(arguments);
    let program = program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = program.spawn().expect("it starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    // the program may refuse the rest
    let _ = stdin.write_all(input);
    drop(stdin);
    child.wait_with_output().expect("it ends")
}

/// A reader that has enough, as `head`, is no failure, of standard output as of standard error.
#[test]
fn a_closed_pipe_is_no_failure() {
    for arguments in [
        &["world", "environment-4"][..],
        &["run", "--plant", "point"],
        &["man"],
        &["completions", "bash"],
        &["export", "carrier", "-"],
        &["worlds"],
        &["cite", "recordings/environment-1.mcap", "--quiet"],
        &["--help"],
        &["inspect", "recordings/environment-1.mcap", "--json"],
    ] {
        let mut program = program(arguments);
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        drop(child.stdout.take());
        let mut said = String::new();
        child.stderr.take().expect("a pipe").read_to_string(&mut said).expect("text");
        let code = child.wait().expect("it ends").code();
        assert!(code == Some(0) && said.is_empty(), "{arguments:?}: {code:?} {said}");
    }
    let mut program = program(&["run", "nowhere"]);
    let mut child = program.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
    drop(child.stderr.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(2));
}

/// Warnings and notes are printed once, or, with `--quiet`, not at all; errors are.
#[test]
fn quiet_leaves_warnings_out() {
    let warned = program(&["run", "--plant", "point", "--alpha", "7.47"]).output().expect("it starts");
    assert_eq!(stderr(&warned).matches("warning: ").count(), 1, "{}", stderr(&warned));
    for quiet in [
        &["-q", "run", "--plant", "point", "--alpha", "7.47"][..],
        &["run", "--plant", "point", "--alpha", "7.47", "--quiet"],
    ] {
        let output = program(quiet).output().expect("it starts");
        assert_eq!((stderr(&output).as_str(), &output.stdout), ("", &warned.stdout));
    }
    assert!(stderr(&program(&["run", "nowhere", "-q"]).output().expect("it starts")).starts_with("error: "));
}

/// `-` is a world on standard input, within the limit of world files.
#[test]
fn a_world_is_read_from_standard_input() {
    let world = std::fs::read(repository("worlds/environment-2.toml")).expect("a world");
    for arguments in [&["world", "-", "--json"][..], &["run", "-", "--plant", "point", "--json"]] {
        let output = with_input(arguments, &world);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
        let named = arguments.iter().map(|word| if *word == "-" { "environment-2" } else { word });
        let named = program(&named.collect::<Vec<_>>()).output().expect("it starts");
        let [found, mut expected]: [serde_json::Value; 2] =
            [&output, &named].map(|output| serde_json::from_slice(&output.stdout).expect("JSON"));
        assert_eq!(found["file"], "standard input");
        expected["file"] = found["file"].clone();
        assert_eq!(found, expected);
    }
    for (input, said) in [
        (b"name = ".to_vec(), "standard input: not a valid world file: TOML parse error at line 1, column 8"),
        (Vec::new(), "standard input"),
        (vec![b'#'; 80 << 20], "standard input: cannot be read: larger than"),
        (b"\xff".to_vec(), "standard input: cannot be read"),
    ] {
        let output = with_input(&["world", "-"], &input);
        assert_eq!((output.status.code(), stdout(&output).as_str()), (Some(2), ""), "{said}");
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    }
}

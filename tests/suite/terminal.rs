//! What a terminal shows: widths, colours, groups of options.

use crate::support::{repository, stderr, stdout};
use std::process::{Command, Output};
use unicode_width::UnicodeWidthStr;

fn cocarry(width: &str, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    program.args(arguments).env("COLUMNS", width).current_dir(repository(".")).output().expect("it starts")
}

/// The lines that are wider than `width`, except commands, which are to be copied whole.
fn too_wide(text: &str, width: usize) -> Vec<&str> {
    text.lines().filter(|line| line.width() > width && !line.trim_start().starts_with("cocarry ")).collect()
}

#[test]
fn every_output_fits_80_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(
        path("s.toml"),
        "worlds = [\"environment-1\", \"environment-2\"]\nplants = \"kinematic\"\neta = [5, 10.5]\n\
         methods = [\"mutual\", \"without-model\"]\nseeds = 2\nmax_steps = 40\n",
    )
    .unwrap();
    let (study, rows) = (path("s.toml"), path("rows.csv"));
    for arguments in [
        &["run", "--plant", "kinematic"][..],
        &["world", "free-form"],
        &["worlds"],
        &["cite", "recordings/environment-1.mcap", "--format", "text"],
        &["sweep", &study, "--output", &rows],
        &["reproduce", "h1"],
        &["reproduce", "h2"],
        &["inspect", "recordings/environment-1.mcap"],
        &["fit", "risk-weight", "docs/data/table-1-humans.csv", "--normalise", "--resamples", "40"],
        &["fit", "eta", "docs/data/simulated-switches.csv"],
    ] {
        let output = cocarry("80", arguments);
        let text = stdout(&output);
        assert!(text.lines().count() > 3, "{arguments:?}: {}", stderr(&output));
        assert_eq!(too_wide(&text, 80), [""; 0], "{arguments:?}:\n{text}");
        assert!(!text.contains('\u{1b}'), "colours in a pipe: {arguments:?}");
    }
    // a paragraph is wrapped once
    let eta = stdout(&crate::support::cocarry(&["fit", "eta", "docs/data/simulated-switches.csv"]));
    assert!(eta.contains("No participant's episodes contradict each other: eta is the same"), "{eta}");
    // a long line of a file is cut where it is wrong
    std::fs::write(path("w.toml"), format!("name = \"{}\" = 1\n", "x".repeat(200))).unwrap();
    let refused = stderr(&cocarry("80", &["world", &path("w.toml")]));
    assert_eq!(too_wide(&refused, 80), [""; 0], "{refused}");
    assert!(refused.contains("\n1 | …x") && refused.contains("x\" = 1\n"), "{refused}");
    let refused = cocarry("80", &["run", "environmnt-4", "--plant", "point"]);
    assert_eq!(too_wide(&stderr(&refused), 80), [""; 0]);
    for arguments in [
        &["run", "--human", "bolzmann"][..],
        &["run", "--record", "a folder of mine"],
        &["run", "--method", "a"],
    ] {
        let refused = cocarry("60", arguments);
        let text = stderr(&refused);
        assert_eq!(too_wide(&text, 60), [""; 0], "{text}");
        assert!(refused.status.code() == Some(2) && text.starts_with("error: "), "{text}");
    }
    // 0 columns are an unknown number
    assert_eq!(stdout(&cocarry("0", &["worlds"])), stdout(&crate::support::cocarry(&["worlds"])));
    let help = cocarry("80", &["--help"]);
    assert!(help.status.success() && stdout(&help).contains("Usage: cocarry"));
}

#[test]
fn the_help_of_every_command_fits_80_columns() {
    fn look(command: &mut clap::Command, looked_at: &mut usize) {
        let help = command.clone().term_width(80).render_long_help().to_string();
        assert_eq!(too_wide(&help, 80), [""; 0], "{}", command.get_name());
        if command.get_subcommands().next().is_none() {
            let (_, examples) =
                help.split_once("Examples:").unwrap_or_else(|| panic!("{}: no example", command.get_name()));
            for line in examples.lines().filter_map(|line| line.trim().strip_prefix("cocarry")) {
                assert!(line.len() < 78, "wraps: cocarry{line}");
                let line = line.split(" > ").next().unwrap();
                let words = ["cocarry"].into_iter().chain(line.split_whitespace());
                if let Err(error) = cocarry_program::command().try_get_matches_from(words) {
                    panic!("{line}: {error}");
                }
            }
        }
        *looked_at += 1;
        let names: Vec<String> = command
            .get_subcommands()
            .map(|below| below.get_name().to_owned())
            .filter(|name| name != "help")
            .collect();
        for name in names {
            look(command.find_subcommand_mut(&name).unwrap(), looked_at);
        }
    }
    let mut command = cocarry_program::command();
    command.build();
    let mut looked_at = 0;
    look(&mut command, &mut looked_at);
    assert!(looked_at > 20, "{looked_at}");
}

#[test]
fn the_options_of_run_are_in_groups() {
    let mut command = cocarry_program::command();
    command.build();
    let run = command.find_subcommand("run").unwrap();
    for argument in run.get_arguments().filter(|argument| !argument.is_positional()) {
        let heading = argument.get_help_heading();
        assert!(
            heading.is_some() || ["help", "quiet"].contains(&argument.get_id().as_str()),
            "{} is in no group",
            argument.get_id()
        );
    }
}

/// A terminal, by util-linux's `script`, where there is one.
fn in_a_terminal(arguments: &str, environment: &[(&str, &str)]) -> Option<String> {
    let has_script =
        Command::new("script").arg("--version").output().is_ok_and(|output| output.status.success());
    let line = format!("stty cols 80 rows 24; {} {arguments}", env!("CARGO_BIN_EXE_cocarry"));
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(repository("."));
    script
        .env_remove("COLUMNS")
        .env_remove("NO_COLOR")
        .env("TERM", "xterm")
        .envs(environment.iter().copied());
    has_script.then(|| stdout(&script.output().expect("it starts")).replace('\r', ""))
}

#[test]
fn a_terminal_has_colours_and_its_width_unless_told_otherwise() {
    let run = "run environment-4 --plant kinematic";
    let Some(coloured) = in_a_terminal(run, &[]) else { return };
    assert!(coloured.contains("\u{1b}[32m") || coloured.contains("\u{1b}[1m\u{1b}[32m"), "{coloured:?}");
    let Some(plain) = in_a_terminal(run, &[("NO_COLOR", "1")]) else { return };
    assert!(!plain.contains('\u{1b}'), "{plain:?}");
    assert!(plain.contains("arrived at B"), "{plain}");
    assert_eq!(too_wide(&plain, 80), [""; 0], "{plain}");
}

//! Xacros: a program of others, which runs code that is in the file, is started only where the user asks for
//! it, within limits. Tests begin in the order of their names: the one that waits must not be the last.
#![cfg(unix)]

use crate::spoiled_robot::{TOML, URDF, original};
use crate::support::stderr;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// A folder with the carrier as a xacro, and a program `xacro` that notes its arguments in the file `ran`, then
/// does `act`.
struct WithXacro(tempfile::TempDir);

impl WithXacro {
    fn new(act: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("bin")).unwrap();
        let ran = path("ran");
        let script =
            format!("#!/bin/sh\nfor argument; do echo \"$argument\"; done > '{}'\n{act}\n", ran.display());
        std::fs::write(path("bin/xacro"), script).unwrap();
        std::fs::set_permissions(path("bin/xacro"), PermissionsExt::from_mode(0o755)).unwrap();
        let xacro =
            original(URDF).replacen("<robot ", "<robot xmlns:xacro=\"http://wiki.ros.org/xacro\" ", 1);
        let xacro = xacro.replacen("</robot>", "<xacro:arm/></robot>", 1);
        std::fs::write(path(URDF), &xacro).unwrap();
        std::fs::write(path("robot.urdf.xacro"), &xacro).unwrap();
        std::fs::write(path("expanded"), original(URDF)).unwrap();
        std::fs::write(path(TOML), original(TOML)).unwrap();
        std::fs::write(path("s.toml"), "worlds = \"environment-1\"\nrobots = \"carrier.toml\"\nseeds = 1\n")
            .unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn cocarry(&self, arguments: &[&str]) -> Output {
        let path = std::env::var("PATH").unwrap();
        Command::new(env!("CARGO_BIN_EXE_cocarry"))
            .args(arguments)
            .env("PATH", format!("{}:{path}", self.path("bin").display()))
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// What the program was started with, if it was.
    fn ran(&self) -> Option<String> {
        std::fs::read_to_string(self.path("ran")).ok()
    }

    /// The error of a command that fails.
    fn refused(&self, arguments: &[&str]) -> String {
        let output = self.cocarry(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        stderr(&output)
    }
}

#[test]
fn no_command_expands_a_xacro_unless_it_is_asked_to() {
    let folder = WithXacro::new("cat expanded");
    for arguments in [
        &["run", "environment-1", "--robot", TOML][..],
        &["run", "environment-1", "--robot", URDF],
        &["robot", "check", TOML],
        &["robot", "init", "robot.urdf.xacro", "-o", "drafted.toml"],
        &["robot", "init", URDF, "-o", "drafted.toml"],
        &["sweep", "s.toml"],
    ] {
        let said = folder.refused(arguments);
        assert!(said.contains("xacro runs code that is in the file"), "{said}");
        assert!(said.contains("expand it first: `xacro -- "), "{said}");
    }
    assert_eq!(folder.ran(), None);
}

/// What is in backticks can be copied into a shell, whatever the name of the file.
#[test]
fn the_command_of_the_refusal_is_quoted() {
    let folder = WithXacro::new("cat expanded");
    std::fs::rename(folder.path("robot.urdf.xacro"), folder.path("$(touch x) y.urdf.xacro")).unwrap();
    let said = folder.refused(&["robot", "init", "$(touch x) y.urdf.xacro"]);
    assert!(said.contains("`xacro -- '$(touch x) y.urdf.xacro' > '$(touch x) y.urdf'`"), "{said}");
}

#[test]
fn a_xacro_is_expanded_where_the_user_asks_for_it_with_a_line_that_says_so() {
    let folder = WithXacro::new("cat expanded");
    let output = folder.cocarry(&["robot", "check", TOML, "--xacro"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("note: running `xacro -- carrier.urdf`"), "{}", stderr(&output));
    // a name is no option
    std::fs::rename(folder.path("robot.urdf.xacro"), folder.path("--help.xacro")).unwrap();
    let line = ["robot", "init", "--xacro", "-o", "drafted.toml", "--", "--help.xacro"];
    let output = folder.cocarry(&line);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(folder.ran().as_deref(), Some("--\n--help.xacro\n"));
}

#[test]
fn a_xacro_that_prints_without_end_fails_or_is_missing_is_refused() {
    let check = ["robot", "check", TOML, "--xacro"];
    let said = WithXacro::new("exec cat /dev/zero").refused(&check);
    assert!(said.contains("prints more than 16777216 bytes"), "{said}");
    // the reason comes before the files that lead there
    let missing = "echo 'warning: old' >&2; echo 'error: package not found: arm' >&2; echo 'when processing file: a.xacro' >&2; exit 2";
    let said = WithXacro::new(missing).refused(&check);
    let expected = "cannot expand it: package not found: arm; when processing file: a.xacro";
    assert!(said.contains(expected), "{said}");
    let python = "printf 'Traceback (most recent call last):\\n  File \"x\", line 1\\nModuleNotFoundError: no rospkg\\n' >&2; exit 1";
    let said = WithXacro::new(python).refused(&check);
    assert!(
        said.contains("carrier.urdf: `xacro` cannot expand it: ModuleNotFoundError: no rospkg"),
        "{said}"
    );
    let said = WithXacro::new("exec head -c 100 /dev/urandom").refused(&check);
    assert!(said.contains("carrier.urdf"), "{said}");
    let folder = WithXacro::new("cat expanded");
    std::fs::remove_file(folder.path("bin/xacro")).unwrap();
    let installed =
        std::env::split_paths(&std::env::var_os("PATH").unwrap()).any(|p| p.join("xacro").exists());
    if !installed {
        let said = folder.refused(&check);
        assert!(said.contains("needs the program `xacro` on the path"), "{said}");
    }
}

/// The limit of memory is the one that the shell of the child has.
#[test]
#[cfg(target_os = "linux")]
fn a_xacro_has_a_bounded_address_space() {
    let folder = WithXacro::new("ulimit -v > limit; cat expanded");
    assert!(folder.cocarry(&["robot", "check", TOML, "--xacro"]).status.success());
    assert_eq!(std::fs::read_to_string(folder.path("limit")).unwrap(), "2097152\n");
}

/// The one test that waits: 30 s, while others run.
#[test]
fn a_xacro_that_does_not_end_is_ended_with_what_it_started() {
    let folder = WithXacro::new("sleep 777 & echo $! > child; wait");
    let begun = Instant::now();
    let said = folder.refused(&["robot", "check", TOML, "--xacro"]);
    assert!(said.contains("`xacro` takes longer than 30 s"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(45));
    let child = std::fs::read_to_string(folder.path("child")).unwrap();
    // gone, or waiting for its parent to notice
    let is_gone = || {
        let state = std::fs::read_to_string(Path::new("/proc").join(child.trim()).join("stat"));
        state.map_or(true, |state| state.contains(") Z "))
    };
    while !is_gone() {
        assert!(begun.elapsed() < Duration::from_secs(45), "{child}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

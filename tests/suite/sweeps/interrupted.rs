//! Sweeps that are stopped, killed, or continued elsewhere: the file becomes the same.

use super::{Bench, STUDY};
use crate::support::stdout;
use cocarry_studies::study::{Study, Sweep, SweepOutputs};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Waits until the partial file has so many bytes; false if the process ends before.
fn is_under_way(child: &mut Child, partial: &Path, bytes: u64) -> bool {
    let begun = Instant::now();
    while std::fs::metadata(partial).map_or(0, |file| file.len()) < bytes {
        if child.try_wait().expect("a process").is_some() {
            return false;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "the sweep does not come on");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.try_wait().expect("a process").is_none()
}

/// Kills the process once the partial file has so many bytes; false if it was faster.
pub fn kill_at(mut child: Child, partial: &Path, bytes: u64) -> bool {
    let is_alive = is_under_way(&mut child, partial, bytes);
    if is_alive {
        child.kill().expect("a process");
        child.wait().expect("a process");
    }
    is_alive
}

#[test]
#[cfg(unix)]
fn a_sweep_that_is_interrupted_says_so_and_goes_on_to_the_same_file() {
    let bench = Bench::new(&STUDY.replace("seeds = 6", "seeds = 400"));
    bench.good(&["study.toml", "--output", "undisturbed.csv"]);
    let partial = bench.path("study.csv.partial");
    for signal in ["INT", "TERM"] {
        let mut command = bench.command(&["study.toml"]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let bytes = std::fs::metadata(&partial).map_or(0, |file| file.len()) + 1000;
        assert!(is_under_way(&mut child, &partial, bytes), "the sweep is too fast to be interrupted");
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().expect("kill");
        let output = child.wait_with_output().expect("a process");
        assert_eq!(output.status.code(), Some(130), "{signal}");
        let said = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
        assert!(said.contains("interrupted: study.csv.partial holds the rows so far"), "{said}");
    }
    let said = stdout(&bench.good(&["study.toml"]));
    assert!(said.contains("of them from the earlier run"), "{said}");
    assert!(bench.read("study.csv") == bench.read("undisturbed.csv"));
}

#[test]
fn rows_that_ran_elsewhere_are_appended_in_order_only() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--output", "undisturbed.csv"]);
    let study = Study::load(&bench.path("study.toml"), None).expect("a study");
    let out = bench.path("appended.csv");
    let open = || {
        let to = SweepOutputs { rows: &out, ticks: None, overwrite: false };
        Sweep::open(&study, None, to).expect("a sweep")
    };
    let mut sweep = open();
    sweep.append(&study.rows(0..5)).expect("the first rows");
    // again, with a gap, and damaged
    let mut damaged = study.rows(5..6);
    let at = damaged.len() / 2;
    damaged[at] ^= 1;
    for wrong in [study.rows(4..5), study.rows(6..7), damaged] {
        sweep.append(&wrong).expect_err("not the next row");
        assert_eq!(sweep.kept(), 5);
    }
    drop(sweep);
    let mut sweep = open();
    assert_eq!(sweep.kept(), 5);
    sweep.append(&study.rows(5..sweep.episodes())).expect("the others");
    sweep.run(&|| (), &AtomicBool::new(false)).expect("nothing is left to run");
    assert!(bench.read("appended.csv") == bench.read("undisturbed.csv"));
}

#[test]
fn a_sweep_that_is_killed_goes_on_to_the_same_file() {
    let study = STUDY.replace("seeds = 6", "seeds = 150");
    let bench = Bench::new(&study);
    bench.good(&["study.toml", "--output", "undisturbed.csv"]);
    let expected = bench.read("undisturbed.csv");
    let partial = bench.path("study.csv.partial");
    let mut killed = 0;
    for tenths in [0, 2, 5, 8] {
        let mut command = bench.command(&["study.toml"]);
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
        killed += u32::from(kill_at(child, &partial, expected.len() as u64 * tenths / 10));
        if let Ok(so_far) = std::fs::read(&partial) {
            assert!(expected.starts_with(&so_far), "after {tenths} tenths");
        }
    }
    assert!(killed >= 2, "the sweep is too fast to be killed");
    if !bench.path("study.csv").exists() {
        bench.good(&["study.toml"]);
    }
    assert!(bench.read("study.csv") == expected);
    assert!(!partial.exists());
}

//! A study on a cluster, without a scheduler: the tests with one are in `tests/cluster`.

use super::{Bench, STUDY};
use crate::support::{stderr, stdout};
use std::process::{Command, Output};

fn cluster(bench: &Bench, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    // where no scheduler's commands are
    command.env("PATH", "").env("SLURMD_NODENAME", "node-7");
    command
        .arg("cluster")
        .args(arguments)
        .current_dir(bench.folder.path())
        .output()
        .expect("the program starts")
}

fn good(bench: &Bench, arguments: &[&str]) -> String {
    let output = cluster(bench, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output) + &stderr(&output)
}

fn refused(bench: &Bench, arguments: &[&str], code: i32, said: &[&str]) {
    let output = cluster(bench, arguments);
    let text = stdout(&output) + &stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    for part in said {
        assert!(text.contains(part), "{arguments:?}: no `{part}` in: {text}");
    }
}

fn made(bench: &Bench, shards: &str) {
    good(bench, &["slurm", "study.toml", "--output", "a.csv", "--shards", shards, "--no-submit"]);
}

#[test]
fn shards_that_any_scheduler_runs_give_the_file_of_one_sweep() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--output", "one.csv"]);
    let options = ["--sbatch", "--time=1:00 --partition=short", "--sbatch=--mem=1G"];
    let said = good(
        &bench,
        &[&["slurm", "study.toml", "--output", "a.csv", "--shards", "3", "--no-submit"][..], &options]
            .concat(),
    );
    for part in
        ["96 episodes of 16 combinations, 3 shards", "--array=1-3", "--time=1:00 --partition=short --mem=1G"]
    {
        assert!(said.contains(part), "{said}");
    }
    refused(&bench, &["gather", "a.csv"], 1, &["3 of 3 shards are not complete: 1 to 3"]);
    assert!(good(&bench, &["shard", "a.csv", "2"]).contains("shard 2/3 on node-7: 32 episodes"));
    assert!(good(&bench, &["shard", "a.csv", "2"]).contains("complete before"));
    refused(&bench, &["gather", "a.csv"], 1, &["2 of 3 shards are not complete: 1, 3"]);
    let status = good(&bench, &["status", "a.csv"]);
    assert!(status.contains("1 of 3 shards done, 2 missing; 32 of 96 episodes"), "{status}");
    // a task that was killed within a row
    let rows = std::fs::read(bench.path("one.csv")).unwrap();
    let header = rows.iter().position(|byte| *byte == b'\n').unwrap();
    std::fs::write(bench.path("a.csv.job/shards/1-of-3.csv.partial"), &rows[..header + 1000]).unwrap();
    let said = good(&bench, &["shard", "a.csv", "1"]);
    assert!(said.contains("of them from an earlier run"), "{said}");
    good(&bench, &["shard", "a.csv", "3"]);
    let said = good(&bench, &["gather", "a.csv", "--audit", "5%"]);
    assert!(said.contains("audit: 6 episodes run again, all rows equal"), "{said}");
    assert_eq!(std::fs::read(bench.path("a.csv")).unwrap(), rows);
    refused(&bench, &["gather", "a.csv"], 2, &["a.csv", "--overwrite"]);
}

/// A machine that miscalculates: its rows have right checksums of wrong values.
#[test]
fn an_audit_names_the_node_and_the_value_that_differs() {
    let bench = Bench::new(STUDY);
    made(&bench, "2");
    for shard in ["1", "2"] {
        good(&bench, &["shard", "a.csv", shard]);
    }
    let file = bench.path("a.csv.job/shards/2-of-2.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let (head, _) = text.trim_end().rsplit_once('\n').unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let column = reader.headers().unwrap().iter().position(|name| name == "seed").unwrap();
    let record = reader.records().last().unwrap().unwrap();
    let mut cells: Vec<&str> = record.iter().collect();
    assert_eq!(cells[column], "5");
    cells[column] = "6";
    let line = |cells: &[&str]| {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(cells).unwrap();
        String::from_utf8(writer.into_inner().unwrap()).unwrap()
    };
    cells[4] = "";
    let checksum = format!("{:08x}", crc32fast::hash(line(&cells).as_bytes()));
    cells[4] = &checksum;
    std::fs::write(&file, format!("{head}\n{}", line(&cells))).unwrap();
    let said = ["episode 95 of shard 2/2, from node-7: seed is 6, and 5 here", "1 of 96 episodes differ"];
    refused(&bench, &["gather", "a.csv", "--audit", "100"], 1, &said);
    // the note of a machine reaches a terminal
    let nodes = bench.path("a.csv.job/shards/2-of-2.nodes");
    let noted = std::fs::read_to_string(&nodes).unwrap();
    std::fs::write(nodes, noted.replace("node-7", "\u{1b}[31mnode\u{202e}-7")).unwrap();
    let said = ["from \\u001b[31mnode\\u202e-7: seed is 6"];
    refused(&bench, &["gather", "a.csv", "--audit", "100", "--overwrite"], 1, &said);
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_overwritten() {
    let bench = Bench::new(STUDY);
    let slurm = |more: &[&'static str]| [&["slurm", "study.toml", "--output", "a.csv"], more].concat();
    refused(&bench, &["status", "a.csv"], 2, &["a.csv.job: there is no such job"]);
    refused(&bench, &slurm(&["--sbatch", "--wrap=x"]), 2, &["`--wrap` is set by cocarry"]);
    refused(&bench, &slurm(&["--shards", "0"]), 2, &["--shards"]);
    refused(&bench, &["slurm", "study.toml", "--output", "study.toml"], 2, &["study.toml"]);
    // without a scheduler nothing is left behind
    refused(&bench, &slurm(&[]), 2, &["scontrol: cannot be started", "--no-submit"]);
    assert!(!bench.path("a.csv.job").exists());
    good(&bench, &slurm(&["--no-submit"]));
    refused(&bench, &slurm(&["--no-submit"]), 2, &["there is a job for these results already"]);
    refused(&bench, &["shard", "a.csv", "17"], 2, &["shard 17", "shards 1 to 16"]);
    refused(&bench, &["shard", "a.csv", "0"], 2, &["shard 0"]);
    refused(&bench, &["gather", "a.csv", "--audit", "0"], 2, &["above 0 and at most 100"]);
    refused(&bench, &["gather", "a.csv", "--audit-seed", "1"], 2, &["--audit"]);
    let description = bench.path("a.csv.job/job.toml");
    let text = std::fs::read_to_string(&description).unwrap();
    let with = |change: &dyn Fn(&str) -> String| std::fs::write(&description, change(&text)).unwrap();
    with(&|text| text.replace("version = \"", "version = \"9."));
    refused(&bench, &["shard", "a.csv", "1"], 2, &["version 9.", "use one version"]);
    with(&|text| text.replace("arithmetic = \"", "arithmetic = \"f"));
    refused(&bench, &["shard", "a.csv", "1"], 2, &["node-7", "other last bits"]);
    with(&|text| text.replace("shards = ", "shard = "));
    refused(&bench, &["status", "a.csv"], 2, &["job.toml: not a valid job description", "shard"]);
    with(&str::to_owned);
    std::fs::write(bench.path("study.toml"), STUDY.replace("10.5", "11")).unwrap();
    for command in [&["shard", "a.csv", "1"][..], &["gather", "a.csv"], &["resubmit", "a.csv"]] {
        refused(&bench, command, 2, &["study.toml", "has changed since the job was made"]);
    }
    assert!(!bench.path("a.csv").exists());
    // a job that begins again has nothing of the former one; other files in its folder stay
    std::fs::write(bench.path("a.csv.job/notes.txt"), "mine").unwrap();
    good(&bench, &slurm(&["--no-submit", "--overwrite"]));
    good(&bench, &["shard", "a.csv", "1"]);
    good(&bench, &slurm(&["--no-submit", "--overwrite"]));
    assert!(!bench.path("a.csv.job/shards/1-of-16.csv").exists());
    assert_eq!(bench.read("a.csv.job/notes.txt"), b"mine");
}

/// Slurm's commands without a cluster, as on a machine where its package is installed.
#[cfg(unix)]
#[test]
fn a_scheduler_that_does_not_answer_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new(STUDY);
    let script = "#!/bin/sh\necho 'scontrol: error: Parsing error' >&2\n\
        echo 'scontrol: fatal: Could not establish a configuration source' >&2\nexit 1\n";
    let program = bench.path("bin/scontrol");
    std::fs::create_dir(bench.path("bin")).unwrap();
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    command.env("PATH", bench.path("bin")).env_remove("COLUMNS").current_dir(bench.folder.path());
    let output = command.args(["cluster", "slurm", "study.toml", "-o", "a.csv"]).output().unwrap();
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    let said = "scontrol: no Slurm cluster answers (Could not establish a configuration source); run this";
    assert!(error.contains(said) && error.contains("--no-submit"), "{error}");
    assert_eq!(error.matches("scontrol:").count(), 1, "{error}");
    assert!(!bench.path("a.csv.job").exists());
}

//! Whole commands of the program, start and output included.

mod rows;

use criterion::Criterion;
use rows::{Against, Bench, Declared};
use std::process::Command;
use std::time::{Duration, Instant};

const ROWS: &[Declared] = &[
    Declared {
        name: "`cocarry run` in Environments 1, 3 and 4",
        unit: "us",
        cases: &["run/environment-1", "run/environment-3", "run/environment-4"],
        against: &[Against::Peer(
            "the time that is simulated",
            &["simulated/environment-1", "simulated/environment-3", "simulated/environment-4"],
        )],
    },
    Declared {
        name: "`cocarry reproduce h2`, 25,920 episodes, two threads",
        unit: "us",
        cases: &["reproduce/h2"],
        against: &[Against::Peer("one thread", &["one thread/h2"])],
    },
];

/// How long a command takes, and what it prints.
fn run(arguments: &[&str]) -> (Duration, Vec<u8>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    let begun = Instant::now();
    let output = command.args(arguments).output().expect("the program");
    assert!(output.status.success(), "cocarry {arguments:?}");
    (begun.elapsed(), output.stdout)
}

fn episodes(criterion: &mut Criterion, bench: &mut Bench) {
    for world in ["environment-1", "environment-3", "environment-4"] {
        let arguments = ["run", world, "--json"];
        let mut group = criterion.benchmark_group("run");
        group.sample_size(10).measurement_time(Duration::from_secs(2));
        group.bench_function(world, |b| {
            b.iter_custom(|iterations| (0..iterations).map(|_| run(&arguments).0).sum());
        });
        group.finish();
        if bench.time(&format!("run/{world}")).is_some() {
            let told: serde_json::Value = serde_json::from_slice(&run(&arguments).1).expect("JSON");
            let seconds = told["time_s"].as_f64().expect("a duration");
            bench.give(&format!("simulated/{world}"), seconds * 1e6);
        }
    }
}

fn main() {
    rows::run("commands", ROWS, |criterion, bench| {
        episodes(criterion, bench);
        let h2 = |threads: &str| run(&["reproduce", "h2", "--threads", threads]).0;
        bench.in_turns(criterion, ("reproduce/h2", "one thread/h2"), || h2("2"), || h2("1"));
    });
}

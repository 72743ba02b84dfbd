//! An episode on the physical plant with a recording and without: what recording costs of it, against a
//! budget of 15 %, and how large the file is.

use cocarry::control;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PreparedScenario, RobotSetup, Scenario};
use cocarry::simulation::PhysicsSettings;
use cocarry_recording::recording::{Ending, FileRecorder};
use cocarry_studies::paper;
use criterion::{Criterion, criterion_group};
use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

/// The most that recording may cost of an episode's time.
const BUDGET: f64 = 0.15;
/// The largest that the recording of 36 s may be, B.
const MAX_SIZE: f64 = 3.0 * 1024.0 * 1024.0;
const EPISODES: usize = 15;

fn prepared(environment: usize) -> PreparedScenario {
    let robot = Robot::built_in().expect("the built-in robot");
    let posture = robot.postures[0].name.clone();
    let carrier = RobotSetup { posture, control: control::ControlSettings::default(), robot: robot.into() };
    let scenario = Scenario {
        seed: 1,
        world: paper::ENVIRONMENTS[environment].world().expect("a world of the repository").into(),
        human: paper::EXAMPLE_HUMAN,
        changes: Vec::new(),
        human_model: Default::default(),
        settings: Default::default(),
        plant: Plant::Rapier { setup: carrier, physics: PhysicsSettings::default() },
    };
    scenario.prepare().expect("a scenario")
}

/// Steps of an episode, recorded or not, and how long they took, the file's beginning and end included.
fn episode(prepared: &PreparedScenario, file: Option<&Path>) -> (u64, Duration) {
    let mut episode = prepared.episode().expect("room at the start");
    let begun = Instant::now();
    let mut recorder = file.map(|file| FileRecorder::create(file, true, prepared, &episode).expect("a file"));
    let outcome = loop {
        if let Some(outcome) = episode.step() {
            break outcome;
        }
        if let Some(recorder) = &mut recorder {
            recorder.step(&episode).expect("room on the disk");
        }
    };
    if let Some(recorder) = recorder {
        recorder.finish(&episode, Ending::Over(outcome)).expect("room on the disk");
    }
    (episode.summary().steps, begun.elapsed())
}

fn recording(c: &mut Criterion) {
    let prepared = prepared(3);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bench.mcap");
    let mut group = c.benchmark_group("episode_in_environment_4");
    group.sample_size(10);
    group.bench_function("not recorded", |b| b.iter(|| black_box(episode(&prepared, None))));
    group.bench_function("recorded", |b| b.iter(|| black_box(episode(&prepared, Some(&file)))));
    group.finish();
}

fn report() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bench.mcap");
    println!(
        "\nepisodes on the physical plant, recorded and not in turn, fastest of {EPISODES} (budget {BUDGET})"
    );
    for environment in [0, 2, 3] {
        let prepared = prepared(environment);
        let (mut plain, mut recorded, mut steps) = (Duration::MAX, Duration::MAX, 0);
        for _ in 0..EPISODES {
            plain = plain.min(episode(&prepared, None).1);
            let (taken, time) = episode(&prepared, Some(&file));
            (steps, recorded) = (taken, recorded.min(time));
        }
        let seconds = steps as f64 * prepared.scenario().settings.planning_step;
        let size = std::fs::metadata(&file).expect("the file").len() as f64;
        let share = recorded.as_secs_f64() / plain.as_secs_f64() - 1.0;
        println!(
            "  Environment {}: {seconds:.1} s in {:.0} ms, recorded {:.0} ms: {:.1} % more, {:.2} of the budget; {:.0} kB, which makes {:.2} MiB \
             for 36 s, {:.2} of what is allowed",
            environment + 1,
            1e3 * plain.as_secs_f64(),
            1e3 * recorded.as_secs_f64(),
            100.0 * share,
            share / BUDGET,
            size / 1e3,
            size / seconds * 36.0 / (1024.0 * 1024.0),
            size / seconds * 36.0 / MAX_SIZE,
        );
    }
}

criterion_group!(benches, recording);

fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    report();
}

//! An episode on the physical plant with a recording and without: what recording costs of it, against a
//! budget of 15 %, and how large the file is.

mod rows;

use cocarry::control;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PreparedScenario, RobotSetup, Scenario};
use cocarry::simulation::PhysicsSettings;
use cocarry_recording::recording::{Ending, FileRecorder};
use cocarry_studies::paper;
use rows::{Against, Declared};
use std::path::Path;
use std::time::{Duration, Instant};

const ROWS: &[Declared] = &[
    Declared {
        name: "what recording adds to an episode's time",
        unit: "%",
        cases: &["added/1", "added/3", "added/4"],
        against: &[Against::Budget(15.0)],
    },
    Declared {
        name: "what it adds to a tick",
        unit: "us",
        cases: &["added to a tick/1", "added to a tick/3", "added to a tick/4"],
        against: &[],
    },
    Declared {
        name: "size of a recording of 36 s",
        unit: "MiB",
        cases: &["size/1", "size/3", "size/4"],
        against: &[Against::Budget(3.0)],
    },
];

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

fn main() {
    rows::run("recording", ROWS, |criterion, bench| {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("bench.mcap");
        for environment in [1, 3, 4] {
            let prepared = prepared(environment - 1);
            let plain = format!("episode/Environment {environment}");
            let mut steps = 0;
            let ratio = bench.in_turns(
                criterion,
                (&plain, &format!("recorded/Environment {environment}")),
                || episode(&prepared, None).1,
                || {
                    let (taken, time) = episode(&prepared, Some(&file));
                    steps = taken;
                    time
                },
            );
            let (Some(ratio), Some(time)) = (ratio, bench.time(&plain)) else { continue };
            let seconds = steps as f64 * prepared.scenario().settings.planning_step;
            let size = std::fs::metadata(&file).expect("the file").len() as f64;
            bench.give(&format!("added/{environment}"), 100.0 * (ratio - 1.0));
            bench.give(&format!("added to a tick/{environment}"), (ratio - 1.0) * time / steps as f64);
            bench.give(&format!("size/{environment}"), size / seconds * 36.0 / (1024.0 * 1024.0));
        }
    });
}

//! Episodes in which the object is lost, and what is said of robots that hardly keep up.

use crate::support::{cocarry, repository, stderr};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The carrier with wheels that drive so fast at most (m/s), as a robot file in `folder`.
fn carrier_that_drives(speed: f64, folder: &Path) -> PathBuf {
    let read = |name: &str| std::fs::read_to_string(repository("assets/robots").join(name)).expect("text");
    let (urdf, text) = (read("carrier.urdf"), read("carrier.toml"));
    let limit = "velocity=\"17.4\"";
    assert_eq!(urdf.matches(limit).count(), 2, "both wheels");
    let slow = urdf.replace(limit, &format!("velocity=\"{}\"", speed / 0.06));
    std::fs::write(folder.join("carrier.urdf"), slow).expect("a file");
    let file = folder.join("carrier.toml");
    std::fs::write(&file, text).expect("a file");
    file
}

fn run(robot: &Path, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let robot = robot.to_str().expect("UTF-8");
    let output = cocarry(&[&["run", "environment-1", "--robot", robot, "--json"], arguments].concat());
    let told = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stderr(&output)));
    (output.status.code(), told, stderr(&output))
}

#[test]
fn a_robot_that_drives_too_slowly_loses_the_object() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let robot = carrier_that_drives(0.26, folder.path());
    let (code, told, said) = run(&robot, &["--plant", "kinematic"]);
    assert_eq!(code, Some(3), "{told}");
    assert_eq!(told["outcome"], "object-lost");
    assert_eq!(told["lost_by"], "robot");
    let distance = told["lost_distance_m"].as_f64().expect("a distance");
    // in one step, the team gets 4.8 cm ahead of it, and the second step beyond 10 cm ends the episode
    assert!(distance > 0.1 && distance < 0.21, "{distance}");
    assert_eq!(told["largest_position_error_m"].as_f64(), Some(distance));
    assert_eq!(told["lost_at_step"].as_u64().map(|step| step + 1), told["steps"].as_u64(), "it ends there");
    let words = "its wheels drive 0.260 m/s at most";
    assert!(told["warnings"][0].as_str().is_some_and(|warning| warning.contains(words)), "{told}");
    assert!(said.contains(words), "told at load: {said}");
}

//! The robots with meshes that the program exports: whole or not at all, and they carry.

use crate::starting::{run_in, succeeds};
use crate::support::{repository, stderr};
use cocarry::robot::{DriveKind, Robot};
use std::path::Path;

const OWN: [&str; 2] = ["porter", "shuttle"];

/// Outcomes of episodes: world, plant, and further arguments.
fn assert_it_arrives(folder: &Path, file: &str, episodes: &[(&str, &str)]) {
    for (world, plant) in episodes {
        let told =
            succeeds(folder, &["run", world, "--robot", file, "--plant", plant, "--seed", "1", "--json"]);
        let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
        assert_eq!(told["outcome"], "arrived", "{file}, {world}, {plant}: {told}");
        let error = told["position_error_rms_m"].as_f64().expect("a number");
        assert!(error < 0.03, "{file}, {world}, {plant}: {error}");
    }
}

fn listed(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort();
    names
}

#[test]
fn an_exported_robot_has_its_meshes_and_carries() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in OWN {
        let told = succeeds(folder.path(), &["export", name]);
        let meshes = listed(&repository("assets/robots").join(name));
        assert!(meshes.len() > 20);
        assert_eq!(told.lines().count(), meshes.len() + 2, "{told}");
        let of_robot = [format!("{name}.toml"), format!("{name}.urdf")];
        for file in meshes.iter().map(|mesh| format!("{name}/{mesh}")).chain(of_robot) {
            let written = std::fs::read(folder.path().join(&file)).expect("an exported file");
            let original = std::fs::read(repository("assets/robots").join(&file)).expect("a file");
            assert!(written == original, "{file}");
        }
        assert_eq!(listed(&folder.path().join(name)), meshes);
        let robot =
            Robot::load(&folder.path().join(format!("{name}.toml"))).unwrap_or_else(|e| panic!("{e}"));
        // nothing stands in for a mesh that is missing
        let notes: Vec<_> = robot.warnings.iter().map(ToString::to_string).collect();
        assert!(notes.len() == 1 && notes[0].contains("collide as their convex hulls"), "{notes:?}");
        assert!(robot.base_extent().expect("shapes") <= robot.drive.base_radius + 0.005);
        // the narrowest bend of all is that of environment 2 on the kinematic plant
        let episodes =
            [("environment-2", "kinematic"), ("environment-1", "rapier"), ("environment-4", "rapier")];
        assert_it_arrives(folder.path(), &format!("{name}.toml"), &episodes);
    }
}

#[test]
fn a_robot_is_exported_whole_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refused = |said: &str| {
        let output = run_in(folder.path(), &["export", "porter"]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    };
    let meshes = folder.path().join("porter");
    std::fs::write(&meshes, "mine").expect("a file");
    refused("exists and is not a folder");
    assert_eq!(listed(folder.path()), ["porter"]);
    std::fs::remove_file(&meshes).expect("removed");
    std::fs::create_dir(&meshes).expect("a folder");
    std::fs::write(meshes.join("wrist.stl"), "mine").expect("a file");
    refused("wrist.stl: exists already");
    assert_eq!(
        (listed(folder.path()), listed(&meshes)),
        (vec!["porter".to_owned()], vec!["wrist.stl".to_owned()])
    );
    succeeds(folder.path(), &["export", "porter", "--overwrite"]);
    assert_ne!(std::fs::read(meshes.join("wrist.stl")).expect("a file"), b"mine");
    // the folder must exist, and is not made by halves
    let output = run_in(folder.path(), &["export", "porter", "--output", "missing"]);
    assert_ne!(output.status.code(), Some(0));
    assert!(!folder.path().join("missing").exists());
}

#[test]
fn the_name_of_a_robot_in_place_of_its_file_leads_to_its_export() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let hints = |arguments: &[&str], name: &str| {
        let output = run_in(folder.path(), arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(&format!("`cocarry export {name}`")), "{said}");
    };
    for name in ["omni-carrier", "porter", "shuttle"] {
        hints(&["run", "--robot", name], name);
        hints(&["robot", "check", name], name);
    }
    hints(&["run", "--robot", "carrier"], "carrier");
    // a folder of that name is no robot file
    succeeds(folder.path(), &["export", "shuttle"]);
    hints(&["run", "--robot", "shuttle"], "shuttle");
}

/// `shuttle` on plain wheels that skid in turns.
#[test]
fn a_skid_steer_robot_carries() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    succeeds(folder.path(), &["export", "shuttle"]);
    for mesh in listed(&path("shuttle")) {
        let of_file = |name: &str| path("shuttle").join(name);
        std::fs::rename(of_file(&mesh), of_file(&mesh.replace("mecanum", "plain"))).expect("renamed");
    }
    let text = |name: &str| std::fs::read_to_string(path(name)).expect("text");
    let urdf = text("shuttle.urdf").replace("mecanum_joint", "wheel_joint").replace("mecanum", "plain");
    std::fs::write(path("shuttle.urdf"), urdf).expect("a file");
    let robot_file = text("shuttle.toml");
    let (before, rest) = robot_file.split_once("drive = ").expect("the drive");
    let (_, after) = rest.split_once("base_width_m").expect("the width");
    let drive = "drive = \"skid-steer\"\n\
        left_wheels = [\"front_left_wheel_joint\", \"rear_left_wheel_joint\"]\n\
        right_wheels = [\"front_right_wheel_joint\", \"rear_right_wheel_joint\"]\n";
    std::fs::write(path("skid.toml"), format!("{before}{drive}base_width_m{after}")).expect("a file");
    let robot = Robot::load(&path("skid.toml")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((robot.drive.kind, robot.wheels.len()), (DriveKind::SkidSteer, 4));
    assert_it_arrives(
        folder.path(),
        "skid.toml",
        &[("environment-1", "kinematic"), ("environment-1", "rapier"), ("environment-3", "rapier")],
    );
}

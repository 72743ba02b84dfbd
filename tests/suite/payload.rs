//! What a robot's motors hold: told, warned of, and refused, with the load that they can hold.

use crate::spoiled_robot::{Files, TOML};
use crate::support::{cocarry, stderr, stdout};
use serde_json::Value;

/// The carrier with this effort limit (Nm) of its elbow, which bears most of the load.
fn with_elbow(limit: &str) -> Files {
    let files =
        Files::new().within("name=\"elbow_flex_joint\"", "effort=\"66.18\"", &format!("effort=\"{limit}\""));
    files.load(TOML).expect("a valid robot");
    files
}

fn file(files: &Files) -> String {
    files.folder.path().join(TOML).display().to_string()
}

/// What the posture of the start holds at the grasp, kg, and its weakest joint.
fn holds(files: &Files) -> (f64, String) {
    let output = cocarry(&["robot", "check", &file(files), "--json"]);
    let checked: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let posture = &checked["postures"][0];
    let joint = posture["weakest_joint"].as_str().expect("a name");
    (posture["holds_kg"].as_f64().expect("a number"), joint.to_owned())
}

fn run(files: &Files, plant: &str) -> (Option<i32>, String) {
    let output = cocarry(&["run", "environment-3", "--eta", "5", "--plant", plant, "--robot", &file(files)]);
    (output.status.code(), stderr(&output))
}

#[test]
fn a_robot_that_cannot_hold_its_half_is_refused_with_what_it_can() {
    let weak = with_elbow("1");
    let (most, joint) = holds(&weak);
    assert!(joint == "elbow_flex_joint" && most < 2.0, "{joint}: {most}");
    let (code, said) = run(&weak, "rapier");
    let parts = [
        "2.00 kg of the 4.00 kg in environment-3",
        "`elbow_flex_joint`",
        "effort limit of 1.0 Nm",
        "mass_kg",
    ];
    assert!(code == Some(2) && parts.iter().all(|part| said.contains(part)), "{said}");
    assert!(said.contains(&format!("an object of {:.2} kg", 2.0 * most)), "{said}");
    // without forces it carries, and it is said that a real one would not
    let (code, said) = run(&weak, "kinematic");
    assert!(code == Some(0) && said.contains("warning") && said.contains("`elbow_flex_joint`"), "{said}");
}

#[test]
fn a_robot_near_its_limits_is_warned_of_and_motors_keep_them() {
    // the limit with which the elbow holds the half at 90 %
    let (at_one, _) = holds(&with_elbow("1"));
    let limit = 2.0 / at_one / 0.9;
    let near = with_elbow(&limit.to_string());
    let (code, said) = run(&near, "rapier");
    assert!(said.contains(&format!("needs {:.1} Nm of its effort limit", 0.9 * limit)), "{said}");
    assert!(code == Some(0) || code == Some(3), "{said}");
    let told = stdout(&cocarry(&["run", "environment-3", "--eta", "5", "--robot", &file(&near)]));
    let motors = told.lines().find(|line| line.contains("the arm's motors")).expect("a line");
    assert!(motors.contains("100 % of their effort limits: `elbow_flex_joint` for"), "{motors}");
}

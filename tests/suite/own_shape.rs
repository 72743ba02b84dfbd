//! A robot's own shape: parts that touch each other, arms that cannot place their grasp anywhere, and a grasp
//! beside the base.

use crate::spoiled_robot::{Files, TOML, URDF};
use crate::support::{cocarry, stdout};
use cocarry::robot::{JointVector, Robot};

fn touching(robot: &Robot, angles_deg: [f64; 7]) -> Option<[String; 2]> {
    let mut joints = JointVector::zeros();
    joints.iter_mut().zip(angles_deg).for_each(|(at, angle)| *at = angle.to_radians());
    let links = robot.self_contact(&joints, &mut Vec::new())?;
    Some(links.map(|link| robot.links[link].name.clone()))
}

#[test]
fn an_arm_that_reaches_into_the_robot_touches_it() {
    let robot = Robot::built_in().unwrap();
    for posture in &robot.postures {
        assert_eq!(robot.self_contact(&posture.joints, &mut Vec::new()), None, "{}", posture.name);
    }
    // stretched ahead, and hanging beside the base
    assert_eq!(touching(&robot, [0.0; 7]), None);
    // the shoulder down and the elbow back: the hand is in the base's column
    let inside = touching(&robot, [0.0, 80.0, 0.0, 125.0, 0.0, 30.0, 0.0]).expect("a contact");
    assert_eq!(inside[0], "base_link", "{inside:?}");
}

/// Five joints, the shoulder 10 cm to the left, and an axis that is tilted by calibration: the grasp is as level as
/// the arm can hold it, and the base keeps its place beside the object on both plants.
#[test]
fn an_arm_of_five_joints_beside_the_axis_carries() {
    let mut files = Files::new().with(
        URDF,
        "<origin xyz=\"0.12 0 0.349\"/>",
        "<origin xyz=\"0.12 0.1 0.349\" rpy=\"0.0004 0.0003 0\"/>",
    );
    for joint in ["upperarm_roll_joint", "forearm_roll_joint"] {
        let (from, to) =
            (format!("name=\"{joint}\" type=\"continuous\""), format!("name=\"{joint}\" type=\"fixed\""));
        files = files.with(URDF, &from, &to);
    }
    files = files.with(TOML, "upperarm_roll_joint = 0.0\n", "").with(TOML, "forearm_roll_joint = 0.0\n", "");
    // the first posture alone
    let postures: Vec<usize> = files.toml.match_indices("[[posture]]").map(|(at, _)| at).collect();
    files.toml.truncate(postures[1]);
    let robot = files.load(TOML).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(robot.joint_count(), 5);
    let grasp = robot.drive_from_grasp(&robot.postures[0].joints);
    let tilt = grasp.rotation.angle();
    assert!((1e-6..0.005).contains(&tilt), "{tilt} rad");
    assert!((grasp.translation.z - 0.7).abs() < 0.002, "{grasp}");
    assert!((grasp.translation.y - 0.1).abs() < 0.01, "{grasp}");
    let file = files.folder.path().join(TOML).display().to_string();
    for plant in ["kinematic", "rapier"] {
        let output =
            cocarry(&["run", "environment-1", "--plant", plant, "--robot", &file, "--seed", "1", "--json"]);
        let said: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON");
        let summary = said.to_string();
        assert!(summary.contains("\"arrived\""), "{plant}: {summary:.600}");
    }
}

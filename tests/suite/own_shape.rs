//! A robot's own shape: parts that touch each other, arms that cannot place their grasp anywhere, and a grasp
//! next to the base.

use crate::spoiled_robot::{Files, TOML, URDF};
use crate::support::{cocarry, stdout};
use cocarry::math;
use cocarry::robot::{JointVector, Robot};
use std::collections::BTreeMap;

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
    // stretched ahead, and hanging next to the base
    assert_eq!(touching(&robot, [0.0; 7]), None);
    // the shoulder down and the elbow back: the hand is in the base's column
    let inside = touching(&robot, [0.0, 80.0, 0.0, 125.0, 0.0, 30.0, 0.0]).expect("a contact");
    assert_eq!(inside[0], "base_link", "{inside:?}");
}

/// The carrier with its shoulder 10 cm to the left and turned as in a calibrated URDF, one posture, and these
/// joints fixed.
fn offset_shoulder(roll: f64, fixed: &[&str]) -> Files {
    let origin = format!("<origin xyz=\"0.12 0.1 0.349\" rpy=\"{roll} 0.0003 0\"/>");
    let mut files = Files::new().with(URDF, "<origin xyz=\"0.12 0 0.349\"/>", &origin);
    for joint in fixed {
        let of = |kind: &str| format!("name=\"{joint}\" type=\"{kind}\"");
        files = files.with(URDF, &of("continuous"), &of("fixed"));
    }
    let postures: Vec<usize> = files.toml.match_indices("[[posture]]").map(|(at, _)| at).collect();
    files.toml.truncate(postures[1]);
    let is_free = |line: &&str| !fixed.iter().any(|joint| line.starts_with(joint));
    files.toml = files.toml.lines().filter(is_free).map(|line| format!("{line}\n")).collect();
    files
}

/// With four joints, nothing makes up for a shoulder that is turned about x: a little is within the tolerance.
#[test]
fn an_arm_of_four_joints_is_as_level_as_it_can_be() {
    let fixed = ["upperarm_roll_joint", "forearm_roll_joint", "wrist_roll_joint"];
    let robot = offset_shoulder(0.003, &fixed).load(TOML).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(robot.joint_count(), 4);
    let grasp = robot.drive_from_grasp(&robot.postures[0].joints);
    let tilt = grasp.rotation.angle();
    assert!((0.002..0.005).contains(&tilt), "{tilt} rad");
    assert!((grasp.translation.z - 0.7).abs() < 0.002, "{grasp}");
    offset_shoulder(0.02, &fixed).says(&["moves its grasp in 4 of 6 directions", "0.002 m and 0.005 rad"]);
}

/// A grasp off the axis of a differential base: the base keeps its place next to the object.
#[test]
fn a_base_beside_its_object_stays_there() {
    let files = offset_shoulder(0.0, &[]);
    let robot = files.load(TOML).unwrap_or_else(|e| panic!("{e}"));
    let grasp = robot.drive_from_grasp(&robot.postures[0].joints);
    assert!((grasp.translation.y - 0.1).abs() < 0.01, "{grasp}");
    let file = files.folder.path().join(TOML).display().to_string();
    let ticks = files.folder.path().join("ticks.csv").display().to_string();
    let output =
        cocarry(&["run", "environment-1", "--robot", &file, "--seed", "1", "--json", "--ticks", &ticks]);
    let said: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!(said["outcome"], "arrived");
    let error = said["position_error_rms_m"].as_f64().expect("a number");
    assert!(error < 0.01, "{error} m");
    // how far the base is to the left of the object's axis
    let mut rows = csv::Reader::from_path(&ticks).expect("ticks");
    let mut offsets: Vec<f64> = rows
        .deserialize::<BTreeMap<String, String>>()
        .map(|row| {
            let row = row.expect("a row");
            let number = |key: &str| row[key].parse::<f64>().expect("a number");
            let (sin, cos) = math::sin_cos(number("object_yaw_deg").to_radians());
            let [x, y] =
                ["x_m", "y_m"].map(|key| number(&format!("base_{key}")) - number(&format!("object_{key}")));
            cos * y - sin * x
        })
        .collect();
    offsets.sort_by(f64::total_cmp);
    let median = offsets[offsets.len() / 2];
    assert!((median + 0.1).abs() < 0.03, "{median} m");
}

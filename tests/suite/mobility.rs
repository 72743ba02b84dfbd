//! Arms that are short, telescoping or beside the base's axis: the directions that they lack, the speed and
//! width of a team with them, and what is refused.

use crate::drafts::{NONE, Urdf, Y, Z, found};
use crate::spoiled_robot::{TOML, URDF, original};
use crate::support::{cocarry, json, repository, stderr};
use cocarry::robot::Robot;
use cocarry::scenario::{GivenWorld, Plant, PlantKind, PreparedScenario, RobotSetup, Scenario};
use cocarry::world::World;
use std::path::Path;

/// A lift with a telescope to the right and a wrist, as a mast on two wheels has them.
fn beside() -> Urdf {
    Urdf::on_wheels()
        .limb("prismatic", "lift", "base_link", ("0 0 0.6", NONE, Z))
        .limb("prismatic", "telescope", "lift", ("0 -0.2 0", NONE, "0 -1 0"))
        .limb("revolute", "wrist", "telescope", ("0 -0.05 0", NONE, Z))
        .frame("gripper", "wrist", "0.25 0 0", NONE)
}

/// An arm of four joints, of which the first turns it about an axis `x` (m) ahead of the axle.
fn hinged(x: f64) -> Urdf {
    let first = format!("{x} 0 0.1");
    let mut urdf =
        Urdf::on_wheels().with("0.45 0.4 0.2", "0.2 0.2 0.05").with("radius=\"0.1\"", "radius=\"0.04\"");
    for (i, (at, axis)) in
        [(first.as_str(), Z), ("0 0 0.04", Y), ("0.12 0 0", Y), ("0.12 0 0", Y)].into_iter().enumerate()
    {
        let parent = if i == 0 { "base_link".to_owned() } else { format!("a{}", i - 1) };
        urdf = urdf.limb("revolute", &format!("a{i}"), &parent, (at, NONE, axis));
    }
    urdf.frame("gripper", "a3", "0.12 0 0", NONE)
}

#[test]
fn dexterity_counts_directions_that_the_arm_lacks() {
    let robot = beside().drafted(&found()).robot;
    let joints = robot.postures[0].joints;
    assert!(robot.dexterity(&joints) < 1e-6, "{}", robot.dexterity(&joints));
    assert_eq!(robot.missing_motions(&joints), ["move it ahead", "roll it", "pitch it"]);
    // where the wrist is straight under the grasp's path, it moves it ahead as well
    let carrier = Robot::built_in().expect("the robot");
    let joints = carrier.postures[0].joints;
    assert!(carrier.dexterity(&joints) > 0.05 && carrier.missing_motions(&joints).is_empty());
    let robot = hinged(0.05).drafted(&found()).robot;
    assert_eq!(robot.missing_motions(&robot.postures[0].joints), ["move it sideways", "roll it"]);
}

/// The grasp goes straight ahead: an upright arm leaves its base behind it, and so does a hinge; a telescope to
/// the side does not.
#[test]
fn eq_7_turns_some_bases_away() {
    let carrier = Robot::built_in().expect("the robot");
    for (robot, turns) in [
        (carrier, false),
        (hinged(0.05).drafted(&found()).robot, false),
        (beside().drafted(&found()).robot, true),
    ] {
        assert_eq!(robot.turns_away(&robot.postures[0].joints), turns, "{}", robot.name);
    }
}

/// With the base's turning w and the hinge's -w, the grasp moves to the side at w times the hinge's distance d
/// from the axle; turning at w in place, at r from the hinge, takes -w r / d of the base and w (1 + r / d) of
/// the hinge.
#[test]
fn closed_form_speeds_of_a_hinged_arm() {
    let robot = hinged(0.05).drafted(&found()).robot;
    let joints = robot.postures[0].joints;
    let (d, r) = (0.05, robot.drive_from_grasp(&joints).translation.x - 0.05);
    let base = 2.0 * robot.drive.rim_speed_limit / robot.drive.track;
    let hinge = robot.joints[0].rate_limit;
    let speeds = robot.planar_speeds(&joints);
    let turning = (hinge / (1.0 + r / d)).min(base * d / r);
    assert!((speeds.sideways - d * hinge.min(base)).abs() < 1e-3, "{speeds:?}");
    assert!((speeds.turning - turning).abs() < 1e-3, "{speeds:?}, not {turning}");
    // ahead, the base does the most and the arm adds to it
    assert!(
        (robot.drive.rim_speed_limit..2.0 * robot.drive.rim_speed_limit).contains(&speeds.ahead),
        "{speeds:?}"
    );
}

#[test]
fn an_arm_that_makes_its_base_swing_round_is_refused() {
    hinged(0.05).drafted(&found());
    let words = [
        "direction: the arm moves its grasp to the side only by turning it about an axis 0.08 m behind the axle",
    ];
    hinged(-0.08).refused(&found(), &words);
    hinged(0.0).refused(&found(), &["direction: base and arm together cannot move the grasp to the side"]);
    // so is a robot file for it
    let (folder, urdf) = hinged(0.05).written();
    let file = folder.path().join("r.toml").display().to_string();
    let urdf = urdf.display().to_string();
    assert_eq!(cocarry(&["robot", "init", &urdf, "-o", &file]).status.code(), Some(0));
    let text = std::fs::read_to_string(&urdf).expect("the URDF");
    std::fs::write(&urdf, text.replace("0.05 0 0.1", "-0.08 0 0.1")).expect("a file");
    let checked = cocarry(&["robot", "check", &file]);
    assert_eq!(checked.status.code(), Some(2));
    let said = stderr(&checked);
    assert!(said.contains("posture `posture-1`: the robot cannot carry from here. direction: "), "{said}");
}

/// Environment 1 with all lengths in the plane scaled.
fn scaled(factor: f64, width: f64) -> String {
    let world = cocarry(&["export", "environment-1", "-"]);
    let text = String::from_utf8(world.stdout).expect("UTF-8");
    let is_length =
        |line: &str| ["center_m", "size_m", "start_m", "target_m"].iter().any(|key| line.starts_with(key));
    let lines = text.lines().map(|line| match line.split_once('=') {
        Some((key, list)) if is_length(line) => {
            let numbers = list.trim().trim_matches(['[', ']']).split(',');
            let numbers: Vec<String> =
                numbers.map(|n| (n.trim().parse::<f64>().expect("a number") * factor).to_string()).collect();
            format!("{key}= [{}]", numbers.join(", "))
        }
        Some(("robot_width_m ", _)) => format!("robot_width_m = {width}"),
        _ => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// The base moves beside the path of the grasp: the team needs that much more room, walks more slowly, and
/// arrives.
#[test]
fn a_telescope_beside_the_axis_carries() {
    let (folder, urdf) = beside().written();
    let file = folder.path().join("r.toml");
    let [name, urdf] = [&file, &urdf].map(|path: &std::path::PathBuf| path.display().to_string());
    assert_eq!(cocarry(&["robot", "init", &urdf, "-o", &name]).status.code(), Some(0));
    let checked = json(&["robot", "check", &name, "--json"]);
    let posture = &checked["postures"][0];
    let (offset, needed) = (
        posture["lateral_offset_m"].as_f64().expect("a number"),
        posture["needed_width_m"].as_f64().expect("a number"),
    );
    let width = checked["base"]["width_m"].as_f64().expect("a number");
    assert!((needed - 2.0 * (offset.abs() + width / 2.0)).abs() < 1e-9, "{offset} {needed} {width}");
    let notes = checked["notes"].to_string();
    assert!(notes.contains(&format!("needs openings of {needed:.2} m")), "{notes}");
    assert!(notes.contains("the arm alone cannot move it ahead"), "{notes}");
    let robot = Robot::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let world = folder.path().join("wide.toml");
    std::fs::write(&world, scaled(needed / 0.5, needed)).expect("a file");
    for kind in [PlantKind::Kinematic, PlantKind::Rapier] {
        let scenario = Scenario { plant: Plant::new(kind, RobotSetup::new(&robot)), ..wide(&world) };
        let prepared = scenario.prepare().unwrap_or_else(|error| panic!("{error}"));
        let slow = prepared.slow_drive().map(ToString::to_string).unwrap_or_default();
        assert!(slow.contains("m from the grasp's path"), "{slow}");
        let error = carried(&prepared);
        assert!(error < 0.03, "{kind:?}: {error} m");
    }
}

/// An arm that moves its grasp to the side only about a hinge goes round bends: the base trails the grasp.
#[test]
fn a_hinged_arm_carries_round_bends() {
    let robot = hinged(0.05).drafted(&found()).robot;
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("wide.toml");
    std::fs::write(&world, scaled(1.0, 0.5)).expect("a file");
    for kind in [PlantKind::Kinematic, PlantKind::Rapier] {
        let mut scenario = Scenario { plant: Plant::new(kind, RobotSetup::new(&robot)), ..wide(&world) };
        scenario.settings.speed = Scenario::defaults().settings.speed;
        let error = carried(&scenario.prepare().unwrap_or_else(|error| panic!("{error}")));
        assert!(error < 0.03, "{kind:?}: {error} m");
    }
}

/// An elbow that hardly bends leaves the arm 0.1 m of reach: the base trails the grasp. With bodies, it is 4 mm
/// off, and would be 14 if its base followed the path.
#[test]
fn an_arm_of_little_reach_carries_round_bends() {
    let folder = tempfile::tempdir().expect("a folder");
    let limits = r#"lower="-2.251" upper="2.251""#;
    let urdf = original(URDF);
    assert_eq!(urdf.matches(limits).count(), 1);
    std::fs::write(folder.path().join(URDF), urdf.replace(limits, r#"lower="1.5" upper="1.85""#))
        .expect("a file");
    let file = folder.path().join(TOML);
    std::fs::write(&file, original(TOML)).expect("a file");
    let robot = Robot::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let reach = robot.reach(&robot.postures[0].joints);
    assert!((0.05..0.25).contains(&reach.length()), "{reach:?}");
    for kind in [PlantKind::Kinematic, PlantKind::Rapier] {
        let plant = Plant::new(kind, RobotSetup::new(&robot));
        let mut scenario = Scenario { plant, ..wide(&repository("worlds/environment-1.toml")) };
        scenario.settings.speed = Scenario::defaults().settings.speed;
        let error = carried(&scenario.prepare().unwrap_or_else(|error| panic!("{error}")));
        assert!(error < 0.01, "{kind:?}: {error} m");
    }
}

/// An object that is held low is not on the floor.
#[test]
fn an_object_held_low_is_not_dropped() {
    let robot = hinged(0.05).drafted(&found()).robot;
    assert!(robot.grasp_height < 0.4, "{}", robot.grasp_height);
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
    let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
    let world = World::parse("w.toml", text).unwrap_or_else(|error| panic!("{error}"));
    let mut scenario = Scenario { plant, world: GivenWorld::from(world), ..Scenario::defaults() };
    scenario.settings.tick_limit = Some(20);
    let prepared = scenario.prepare().unwrap_or_else(|error| panic!("{error}"));
    let mut episode = prepared.episode().unwrap_or_else(|error| panic!("{error}"));
    while episode.step().is_none() {}
    assert_eq!(episode.summary().outcome.name(), "out-of-time", "after {} steps", episode.summary().steps);
}

/// The grasp's error (m, rms) of an episode that arrives.
#[track_caller]
fn carried(prepared: &PreparedScenario) -> f64 {
    let mut episode = prepared.episode().unwrap_or_else(|error| panic!("{error}"));
    while episode.step().is_none() {}
    let summary = episode.summary();
    assert_eq!(summary.outcome.name(), "arrived", "after {} steps", summary.steps);
    summary.control.map_or(0.0, |control| control.error_rms(summary.steps))
}

fn wide(world: &Path) -> Scenario {
    let text = std::fs::read_to_string(world).expect("the world");
    let parsed = World::parse("wide.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    let mut scenario = Scenario { world: GivenWorld::from(parsed), ..Scenario::defaults() };
    scenario.settings.speed = 1.0;
    scenario
}

//! A page that shows a robot in its postures: the 3-D player without an episode.

use super::player::filled;
use cocarry::Error;
use cocarry::geometry::{Footprint, PlanarPose, Point};
use cocarry::robot::{ArmJoint, Configuration, Geometry, JointVector, Motion, Robot, Shape};
use cocarry_output::player::{Meshes, colours, pose, read_mesh, shape, shapes};
use serde_json::{Value, json};

/// How long the robot stands in a posture, and how long it takes to the next one, s.
const STANDS_S: f64 = 2.0;
const MOVES_S: f64 = 1.5;
/// Poses between two postures.
const BETWEEN: u32 = 24;

/// The page that shows a robot in its postures one after the other, with the shapes of its URDF or those that
/// collide. `remarks` are sentences about it, which stand next to the picture. Equal robots give equal bytes.
///
/// # Errors
/// A mesh cannot be read.
pub fn robot_page(robot: &Robot, about: &str, remarks: &[String]) -> Result<String, Error> {
    let mut meshes = Meshes::new(Some(&read_mesh));
    let mut links = Vec::new();
    for link in &robot.links {
        links.push(json!({
            "name": link.name,
            "shapes": shapes(link, &mut meshes)?,
            "collisions": link.collisions.iter().filter_map(collision).collect::<Vec<_>>(),
        }));
    }
    let (times, joints) = motion(robot);
    let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let poses: Vec<_> =
        joints.iter().map(|joints| robot.link_poses(&Configuration { base, joints: *joints })).collect();
    let of_link = |l: usize| -> Vec<f64> { poses.iter().flat_map(|links| pose(&links[l])).collect() };
    let grasps: Vec<f64> = joints.iter().flat_map(|joints| pose(&robot.drive_from_grasp(joints))).collect();
    let begins = |p: usize| p as f64 * (STANDS_S + MOVES_S);
    let decided: Vec<f64> = (0..robot.postures.len()).map(begins).collect();
    let names = || robot.postures.iter().map(|posture| &posture.name);
    let footprint = match &robot.footprint {
        Footprint::Disc { .. } => None,
        Footprint::Polygon(corners) => Some(corners.iter().map(|c| [c.x, c.y]).collect::<Vec<_>>()),
    };
    Ok(filled(&json!({
        "title": robot.name,
        "world": {
            "name": robot.name, "robot_width_m": robot.width(),
            "footprint_m": footprint,
            "start": [-0.3, -0.3], "target": [0.9, 0.3], "object_m": [0.0, 0.0, 0.0],
            "obstacles": [], "openings": [],
        },
        "facts": { "about": about },
        "colours": colours(),
        "options": [],
        "robot": links,
        "meshes": meshes.data(),
        "frames": {
            "time_s": times,
            "links": (0..robot.links.len()).map(of_link).collect::<Vec<_>>(),
            "object": grasps, "hand": [], "torso": [],
        },
        "ahead": [],
        "steps": {
            "decided_s": decided, "done_s": [], "mode": [], "figures": {}, "preferred": [],
            "executed": names().collect::<Vec<_>>(),
        },
        "events": names().zip(&decided).map(|(name, time)| json!({
            "time_s": time, "about": "posture", "sentence": name,
        })).collect::<Vec<_>>(),
        "outcome": null,
        "postures": {
            "joints": robot.joints.iter().map(joint).collect::<Vec<_>>(),
            "at": joints.iter().map(|at| at.as_slice()[..robot.joint_count()].to_vec()).collect::<Vec<_>>(),
            "remarks": remarks,
        },
    })))
}

/// Times (s) and joint positions: every posture for a while, and the way to the next.
fn motion(robot: &Robot) -> (Vec<f64>, Vec<JointVector>) {
    let (mut times, mut joints) = (Vec::new(), Vec::new());
    for (p, posture) in robot.postures.iter().enumerate() {
        let begin = p as f64 * (STANDS_S + MOVES_S);
        times.extend([begin, begin + STANDS_S]);
        joints.extend([posture.joints; 2]);
        let Some(next) = robot.postures.get(p + 1) else { continue };
        for i in 1..BETWEEN {
            let part = f64::from(i) / f64::from(BETWEEN);
            // slow at both ends
            let done = part * part * (3.0 - 2.0 * part);
            times.push(begin + STANDS_S + part * MOVES_S);
            joints.push(posture.joints + (next.joints - posture.joints) * done);
        }
    }
    (times, joints)
}

/// Name, unit and limits of a joint, in degrees or metres; no limits of one that turns freely.
fn joint(joint: &ArmJoint) -> Value {
    let turns = joint.motion == Motion::Revolute;
    let limit = |value: f64| match value.is_finite() {
        true if turns => json!(value.to_degrees()),
        true => json!(value),
        false => Value::Null,
    };
    json!({ "name": joint.name, "turns": turns, "lower": limit(joint.lower), "upper": limit(joint.upper) })
}

/// A collision shape as the physical plant has it: a mesh is its hull.
fn collision(geometry: &Geometry) -> Option<Value> {
    match &geometry.shape {
        Shape::Mesh { hull, .. } if hull.is_empty() => None,
        Shape::Mesh { hull, .. } => Some(json!({
            "hull": hull.iter().map(|v| [v.x, v.y, v.z]).collect::<Vec<_>>(),
            "pose": pose(&geometry.link_from_shape),
        })),
        // reads no file
        _ => shape(geometry, &mut Meshes::new(None)).ok(),
    }
}

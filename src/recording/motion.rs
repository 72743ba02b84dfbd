//! The poses of an episode's frames, and the states of its joints.

use crate::episode::Episode;
use crate::geometry::Pose;
use crate::robot::Robot;
use crate::simulation::Observation;
use foxglove::messages::{
    FrameTransform, FrameTransforms, JointState, JointStates, Quaternion, Timestamp, Vector3,
};
use nalgebra::{Rotation3, UnitQuaternion};

/// The root frame.
pub(super) const WORLD: &str = "world";
pub(super) const OBJECT: &str = "object";
pub(super) const HAND: &str = "human/hand";
pub(super) const TORSO: &str = "human/torso";
/// The frame of the human on the kinematic plant: s.
pub(super) const HUMAN: &str = "human";

/// The frame of a robot's link. Its prefix distinguishes it from other frames.
pub(super) fn link_frame(link: &str) -> String {
    format!("robot/{link}")
}

/// Simulated time (ns) in the form of messages.
pub(super) fn timestamp(time: u64) -> Option<Timestamp> {
    Timestamp::new_checked(u32::try_from(time / 1_000_000_000).ok()?, (time % 1_000_000_000) as u32)
}

pub(super) fn vector(v: &nalgebra::Vector3<f64>) -> Option<Vector3> {
    Some(Vector3 { x: v.x, y: v.y, z: v.z })
}

pub(super) fn quaternion(rotation: &Rotation3<f64>) -> Option<Quaternion> {
    let q = UnitQuaternion::from_rotation_matrix(rotation);
    Some(Quaternion { x: q.i, y: q.j, z: q.k, w: q.w })
}

/// The poses of all frames; empty for a team that is a point.
pub(super) fn transforms(episode: &Episode, robot: Option<&Robot>, time: u64) -> FrameTransforms {
    let transform = |frame: String, pose: &Pose| FrameTransform {
        timestamp: timestamp(time),
        parent_frame_id: WORLD.to_owned(),
        child_frame_id: frame,
        translation: vector(&pose.translation.vector),
        rotation: quaternion(&pose.rotation),
    };
    let mut transforms = Vec::new();
    if let (Some(robot), Some(poses)) = (robot, episode.link_poses()) {
        let turned = episode.observation().map_or([0.0; 2], |seen| seen.wheel_angles);
        for (i, (link, pose)) in robot.links.iter().zip(&poses).enumerate() {
            let wheel = robot.wheel_links.iter().position(|&w| w == i);
            let pose = match (wheel, &link.joint) {
                (Some(wheel), Some(joint)) => pose * Rotation3::from_axis_angle(&joint.axis, turned[wheel]),
                _ => *pose,
            };
            transforms.push(transform(link_frame(&link.name), &pose));
        }
        if let Some(human) = episode.human() {
            transforms.push(transform(HUMAN.to_owned(), &human.at_height(robot.grasp_height)));
        }
    }
    if let Some(seen) = episode.observation() {
        let bodies = [(OBJECT, &seen.object), (HAND, &seen.hand), (TORSO, &seen.torso)];
        transforms.extend(bodies.map(|(frame, pose)| transform(frame.to_owned(), pose)));
    }
    FrameTransforms { transforms }
}

/// The joints in the order of the robot's, then the wheels. On the kinematic plant, rates are the last
/// commanded ones.
pub(super) fn joints(episode: &Episode, robot: &Robot, time: u64) -> JointStates {
    let seen = episode.observation();
    let positions = episode.configuration().map(|q| q.joints);
    let commanded = episode.tick().robot.map(|tick| tick.input);
    let arm = robot.joints.iter().enumerate().map(|(j, joint)| JointState {
        name: joint.name.clone(),
        position: positions.map(|p| p[j]),
        velocity: seen.map(|s| s.joint_rates[j]).or(commanded.map(|u| u[2 + j])),
        acceleration: None,
        // there are no efforts before the first step
        effort: seen.filter(|s| s.time > 0.0).map(|s| s.joint_efforts[j]),
    });
    let wheels = robot.wheel_links.iter().enumerate().map(|(w, &link)| JointState {
        name: robot.links[link].joint.as_ref().map_or(String::new(), |j| j.name.clone()),
        position: seen.map(|s: &Observation| s.wheel_angles[w]),
        velocity: (seen.map(|s| s.rim_speeds[w]).or(commanded.map(|u| u[w])))
            .map(|rim| rim / robot.drive.wheel_radius),
        acceleration: None,
        effort: None,
    });
    JointStates { timestamp: timestamp(time), joints: arm.chain(wheels).collect() }
}

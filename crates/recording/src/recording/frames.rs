//! The names of frames, and poses, times and vectors in the form of messages.

use cocarry::geometry::Pose;
use foxglove::messages::{FrameTransform, Quaternion, Timestamp, Vector3};
use nalgebra::{Rotation3, UnitQuaternion};

/// The root frame.
pub(super) const WORLD: &str = "world";
pub(super) const OBJECT: &str = "object";
pub(super) const HAND: &str = "human/hand";
pub(super) const TORSO: &str = "human/torso";
/// The human: on the floor below the torso. In recordings of earlier versions, on the kinematic plant, s.
pub(super) const HUMAN: &str = "human";
/// The frame in which the robot's base moves; the odometry is exact, so it is that of the world.
pub(super) const ODOM: &str = "odom";
/// s, the pose that the grasp should have, on the kinematic plant.
pub(super) const GRASP_GOAL: &str = "grasp_goal";

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

/// The pose of a frame in its parent.
pub(super) fn transform(parent: &str, frame: &str, pose: &Pose, time: u64) -> FrameTransform {
    FrameTransform {
        timestamp: timestamp(time),
        parent_frame_id: parent.to_owned(),
        child_frame_id: frame.to_owned(),
        translation: vector(&pose.translation.vector),
        rotation: quaternion(&pose.rotation),
    }
}

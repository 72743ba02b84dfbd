//! The observation of the physical plant: its present state, and forces and contacts since the observation
//! was [begun](super::PhysicalPlant::begin). An episode begins one in every planning step. Vectors in world
//! axes, SI units.

use super::Sharing;
use crate::geometry::{PlanarPose, Pose};
use crate::robot::{BaseInput, Configuration, JointVector, without_last};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// The state of the physical plant, and forces and contacts since the observation was begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Simulated time, s.
    pub time: f64,
    /// The measured configuration of the robot.
    pub configuration: Configuration,
    /// Measured rates of the base: those of its inputs.
    #[serde(rename = "rim_speeds", with = "without_last")]
    pub base_rates: BaseInput,
    /// Measured joint rates, rad/s or m/s.
    pub joint_rates: JointVector,
    /// Efforts of the joints' motors in the last step, Nm or N.
    pub joint_efforts: JointVector,
    /// Largest motor effort in a physics step since the observation was begun, as a share of the URDF's
    /// effort limit; 0 without such limits. Motors keep their limits within 0.1 %.
    pub effort_share: f64,
    /// How long each joint's motor was at its limit since the observation was begun, s.
    #[serde(default)]
    pub time_at_limit: JointVector,
    /// What has rolled since the start: angles of the left and the right wheels, rad. Omnidirectional:
    /// distances ahead and to the left, m, and the angle turned, rad. See
    /// [`Wheel::of`](crate::robot::Wheel::of).
    #[serde(rename = "wheel_angles", with = "without_last")]
    pub rolled: BaseInput,
    /// `world_from_grasp`.
    pub grasp: Pose,
    /// `world_from_object`; the origin is the object's centre, x points from the robot's end to the human's.
    pub object: Pose,
    /// Velocity of the object's centre (m/s), then its angular velocity (rad/s).
    pub object_twist: [f64; 6],
    /// `world_from_hand`, sway included; x ahead.
    pub hand: Pose,
    /// The hand's pose in the plane, without sway.
    pub hand_planar: PlanarPose,
    /// `world_from_torso`; the origin is the middle of the torso.
    pub torso: Pose,
    /// The robot's grip on the object, at the rear end.
    pub grip: Forces,
    /// The human's grip on the object, at the front end.
    pub hand_grip: Forces,
    /// How both share the object since the observation was begun.
    pub sharing: Sharing,
    /// Integral of the square of the jerk of the object's centre since the observation was begun, m^2/s^5.
    pub squared_jerk: f64,
    /// Contacts since the observation was begun, in a fixed order.
    pub contacts: Vec<Contact>,
    /// Present clearances.
    pub clearances: Clearances,
    /// The failure, if any.
    pub failure: Option<Failure>,
}

/// Smallest present distances; `None` where there is no such pair of bodies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clearances {
    /// Between the robot and an obstacle.
    pub robot_obstacle: Option<Clearance>,
    /// Between the object and an obstacle.
    pub object_obstacle: Option<Clearance>,
    /// Between the human and an obstacle.
    pub human_obstacle: Option<Clearance>,
    /// Between the robot and the human.
    pub robot_human: Option<Clearance>,
}

/// The smallest distance of a set of pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clearance {
    /// Distance, m; 0 where they touch.
    pub distance: f64,
    /// The two parts.
    pub between: [Part; 2],
}

/// A force and a torque on the object, at the place where it is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, Nm.
    pub torque: Vector3<f64>,
}

/// The forces of a grip since the observation was begun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forces {
    /// Mean over the physics steps.
    pub mean: Wrench,
    /// Wrench in the last step.
    pub last: Wrench,
    /// Largest magnitude of the force, N.
    pub peak: f64,
    /// Root mean square of the magnitude of the force, N.
    pub rms: f64,
    /// Noise: root mean square of the force's part above 10 Hz (a Butterworth high-pass filter of second order,
    /// whose gain is r^2 / sqrt(1 + r^4) at r times 10 Hz), N. It does not depend on the physics step.
    pub noise: f64,
    /// Work done on the object, J.
    pub work: f64,
    /// Largest distance between the two points that the grip joins, m.
    pub deflection: f64,
}

/// The kind of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum BodyKind {
    /// The robot.
    Robot,
    /// The carried object.
    Object,
    /// The human.
    Human,
    /// An obstacle.
    Obstacle,
}

impl BodyKind {
    /// Name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Object => "object",
            Self::Human => "human",
            Self::Obstacle => "obstacle",
        }
    }
}

/// A named part of a body.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Part {
    /// The kind of its body.
    pub kind: BodyKind,
    /// Name: the robot's link, the object's shape, `torso` or `hand`, or the obstacle.
    pub name: String,
}

/// Two parts that touched since the observation was begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The two parts, in the order of [`BodyKind`].
    pub between: [Part; 2],
    /// The contact point at the largest depth.
    pub point: Point3<f64>,
    /// Largest penetration depth, m.
    pub depth: f64,
    /// Largest normal force, N. 0 between the human and an obstacle, because the human is kinematic.
    pub force: f64,
}

/// The reason why an episode on this plant cannot continue.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// The state of a body, or a command, is no longer finite or is diverging (1000 m/s). The plant no longer
    /// steps.
    NonFinite {
        /// The robot's link, the object's shape or `command`.
        body: String,
    },
    /// The object lies on the floor or close to it.
    Dropped,
}

//! What is seen of the physical plant after a control period. Vectors in world axes, SI.

use crate::geometry::{PlanarPose, Pose};
use crate::robot::{Configuration, JointVector};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// The state of the physical plant, and what happened in the last control period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Simulated time, s.
    pub time: f64,
    /// The robot as measured.
    pub configuration: Configuration,
    /// Measured speeds of the left and the right rim, m/s.
    pub rim_speeds: [f64; 2],
    /// Measured joint rates, rad/s or m/s.
    pub joint_rates: JointVector,
    /// What the joints' motors exerted in the last step, Nm or N. See `effort_share` for how exactly they keep their limits.
    pub joint_efforts: JointVector,
    /// The most that a motor exerted in a step of the period, as a share of the URDF's effort limit; 0 without such limits. It may come to
    /// somewhat more than 1: a motor is cut to its limit as if its joint kept its rate during a physics step, and what it exerts follows from
    /// the rate that the joint comes to.
    pub effort_share: f64,
    /// How far the wheels have turned since the start, rad: left, right.
    pub wheel_angles: [f64; 2],
    /// `world_from_grasp`.
    pub grasp: Pose,
    /// `world_from_object`; its origin is its centre, its x from the robot's end to the human's.
    pub object: Pose,
    /// Velocity of the object's centre (m/s), then its angular velocity (rad/s).
    pub object_twist: [f64; 6],
    /// `world_from_hand`, sway included; x ahead.
    pub hand: Pose,
    /// Where the human walks: the hand without sway.
    pub hand_planar: PlanarPose,
    /// `world_from_torso`; the origin is in the middle of the torso.
    pub torso: Pose,
    /// What the robot does to the object at its rear end.
    pub grip: Forces,
    /// What the human does to the object at its front end.
    pub hand_grip: Forces,
    /// Integral over the period of the square of the jerk of the object's centre, m^2/s^5.
    pub squared_jerk: f64,
    /// What touched what in the period, in a fixed order.
    pub contacts: Vec<Contact>,
    /// How near they are now.
    pub clearances: Clearances,
    /// What went wrong, if anything.
    pub failure: Option<Failure>,
}

/// Nearest distances after a period; `None` where there are no two such bodies.
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

/// The nearest of all pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clearance {
    /// m; 0 where they touch.
    pub distance: f64,
    /// Which two.
    pub between: [Part; 2],
}

/// A force and a torque on the object, at the place where it is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// Nm.
    pub torque: Vector3<f64>,
}

/// What a grip did in a control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forces {
    /// Mean over the period.
    pub mean: Wrench,
    /// In the last step.
    pub last: Wrench,
    /// Largest magnitude of the force, N.
    pub peak: f64,
    /// Root of the mean square of the magnitude of the force, N.
    pub rms: f64,
    /// Root of the mean square of the change of the force from one step to the next, N.
    pub step_change: f64,
    /// Work done on the object, J.
    pub work: f64,
    /// Largest distance between the two points that the grip joins, m.
    pub stretch: f64,
}

/// Who something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Party {
    /// The robot.
    Robot,
    /// The object that is carried.
    Object,
    /// The human.
    Human,
    /// An obstacle.
    Obstacle,
}

impl Party {
    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Object => "object",
            Self::Human => "human",
            Self::Obstacle => "obstacle",
        }
    }
}

/// Something that can be touched.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Part {
    /// Who it belongs to.
    pub party: Party,
    /// The robot's link, the object's shape, `torso` or `hand`, or the obstacle.
    pub name: String,
}

/// Two parts that touched during a control period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Which two, in the order of [`Party`].
    pub between: [Part; 2],
    /// Where, when they were deepest in each other.
    pub point: Point3<f64>,
    /// How far they were in each other at most, m.
    pub depth: f64,
    /// Largest normal force, N. 0 between the human and an obstacle: nothing holds the human back.
    pub force: f64,
}

/// Why an episode on this plant cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// A body's state, or a command, stopped being a number, or is about to (1000 m/s). The plant no longer steps.
    NonFinite {
        /// The robot's link, the object's shape or `command`.
        body: String,
    },
    /// The object lies on the floor, or nearly.
    Dropped,
}

//! A validated [`Robot`] from a robot file and its URDF: differential drive, arm, grasp, forward kinematics
//! and B(q).
//!
//! Frames: `world` is on the floor, z up. `drive` is on the floor in the middle between the wheels, x ahead, y to the left: its pose is the
//! base's. `grasp` is where the object is held, x ahead.

mod arm;
mod error;
mod fault;
mod file;
mod kinematics;
mod link;
mod load;
mod mesh;
mod posture;
mod tree;
mod urdf;
mod wheels;

pub use error::{Place, RobotError};
pub use fault::{ArmFault, PostureFault, TreeFault, WheelFault};
pub use kinematics::{Kinematics, pose_difference};
pub use link::{Coupling, Geometry, Inertial, Joint, JointKind, Limits, Link, Mimic, Shape};
pub use load::RobotTexts;

use crate::geometry::{PlanarPose, Pose};
use nalgebra::{SMatrix, SVector, Unit, Vector3};
use thiserror::Error;

/// The most arm joints a robot may have that move on their own: seven, and a lift.
pub const MAX_JOINTS: usize = 8;
/// Inputs of a robot with that many joints: two wheels, then the joints.
pub const MAX_INPUTS: usize = MAX_JOINTS + 2;

/// One number a joint, in the order of [`Robot::joints`]; entries beyond their number are 0.
pub type JointVector = SVector<f64, MAX_JOINTS>;
/// u: rim speeds of the left and the right wheel, m/s, then joint rates, rad/s (prismatic: m/s); entries beyond are 0.
pub type InputVector = SVector<f64, MAX_INPUTS>;
/// d(grasp twist) / du: rows are the grasp's linear velocity (m/s) and angular velocity (rad/s) in world axes; columns as in
/// [`InputVector`], those beyond are 0.
pub type InputJacobian = SMatrix<f64, 6, MAX_INPUTS>;

/// d(a point's velocity) / du, world axes: columns as in [`InputJacobian`].
pub type PointJacobian = SMatrix<f64, 3, MAX_INPUTS>;

/// A mobile manipulator on two driven wheels.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// What it was made of.
    pub texts: RobotTexts,
    /// The wheels.
    pub drive: Drive,
    /// The joints of the arm that move on their own, from the base to the grasp. At most [`MAX_JOINTS`].
    pub joints: Vec<ArmJoint>,
    /// Height above the floor at which the object is held, m.
    pub grasp_height: f64,
    /// Postures to start from, in file order; at least one. All hold the grasp level, at [`Robot::grasp_height`], heading as the base.
    pub postures: Vec<Posture>,
    /// All links, parents before children.
    pub links: Vec<Link>,
    /// The base: index into [`Robot::links`].
    pub base_link: usize,
    /// The link whose frame is the grasp's: index into [`Robot::links`].
    pub grasp_link: usize,
    /// The left and the right wheel: indices into [`Robot::links`].
    pub wheel_links: [usize; 2],
    /// From the drive's frame to the base link's; they differ by a translation.
    pub(crate) drive_from_base: Pose,
    /// What the grasp's pose is made of, from the base outward.
    pub(crate) chain: Vec<ChainLink>,
    /// From the frame of the last joint of the chain to the grasp.
    pub(crate) last_from_grasp: Pose,
}

/// Two wheels on one axle, driven one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Distance between the wheels' middles, m.
    pub track: f64,
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
    /// The most that a rim may move, m/s.
    pub rim_speed_limit: f64,
    /// Radius around the middle of the axle that is kept out of obstacles, m.
    pub base_radius: f64,
}

/// A drive that is slower than its team is to walk: a warning, not an error.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "robot `{robot}`: its wheels drive {limit:.3} m/s at most (their limit velocity of {:.2} rad/s times their radius of {wheel_radius} m), \
     but the team is to walk {speed} m/s: the robot cannot keep up",
    limit / wheel_radius
)]
pub struct SlowDrive {
    /// Name of the robot.
    pub robot: String,
    /// The most that its rims may move, m/s.
    pub limit: f64,
    /// Radius of its wheels, m.
    pub wheel_radius: f64,
    /// Walking speed of the team, m/s.
    pub speed: f64,
}

/// A joint of the arm that moves on its own.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmJoint {
    /// Name in the URDF.
    pub name: String,
    /// How it moves.
    pub motion: Motion,
    /// Least position, rad or m; minus infinity for a continuous joint.
    pub lower: f64,
    /// Largest position, rad or m; infinity for a continuous joint.
    pub upper: f64,
    /// The fastest it may move, rad/s or m/s.
    pub rate_limit: f64,
    /// The most it can exert, Nm or N.
    pub effort_limit: f64,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// About its axis, rad.
    Revolute,
    /// Along its axis, m.
    Prismatic,
}

/// A named posture of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Name, unique in its robot.
    pub name: String,
    /// Joint positions.
    pub joints: JointVector,
}

/// One moving joint on the way from the base to the grasp; fixed joints are part of the constant transforms.
#[derive(Clone, Debug)]
pub(crate) struct ChainLink {
    /// From the frame before (the drive's, for the first) to this joint's frame at position 0.
    pub before_from_joint: Pose,
    /// Axis in the joint's frame.
    pub axis: Unit<Vector3<f64>>,
    pub motion: Motion,
    /// The arm joint that moves it: index into [`Robot::joints`].
    pub joint: usize,
    /// Its position is `ratio * (that joint's position) + offset`: 1 and 0 but for a joint that mimics another.
    pub ratio: f64,
    pub offset: f64,
}

/// Where the base stands and how the arm is bent: q.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Configuration {
    /// The drive frame in the world.
    pub base: PlanarPose,
    /// Joint positions.
    pub joints: JointVector,
}

impl Robot {
    /// Number of arm joints that move on their own.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// The drive's lack of speed, if the team is to walk at `speed` (m/s) and the wheels cannot.
    pub fn slow_drive(&self, speed: f64) -> Option<SlowDrive> {
        let Drive { rim_speed_limit: limit, wheel_radius, .. } = self.drive;
        let robot = self.name.clone();
        (limit < speed).then_some(SlowDrive { robot, limit, wheel_radius, speed })
    }

    /// The posture of that name.
    pub fn posture(&self, name: &str) -> Option<&Posture> {
        self.postures.iter().find(|p| p.name == name)
    }
}

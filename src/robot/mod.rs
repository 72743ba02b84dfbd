//! A validated [`Robot`] from a robot file and its URDF: differential drive, arm, grasp, forward kinematics
//! and B(q).
//!
//! Frames: `world` is on the floor, z up. `drive` is on the floor midway between the wheels, x ahead, y to
//! the left; its pose is the base's. `grasp` is where the object is held, x ahead.

mod arm;
mod collision;
mod draft;
mod draft_request;
mod draft_search;
mod error;
mod fault;
mod file;
mod hull;
mod kinematics;
mod link;
mod load;
mod mesh;
mod note;
mod posture;
mod postures;
mod reach;
mod tree;
mod urdf;
mod wheels;

pub use draft::Draft;
pub use draft_request::{DraftError, DraftRequest};
pub use error::RobotError;
pub use fault::{ArmFault, PostureFault, TreeFault, WheelFault};
pub use kinematics::{Kinematics, pose_difference};
pub use link::{Coupling, Geometry, Inertial, Joint, JointKind, Limits, Link, Mimic, Shape};
pub use load::RobotTexts;
pub use note::RobotNote;
pub use reach::Reach;

use crate::geometry::{PlanarPose, Pose};
use nalgebra::{SMatrix, SVector, Unit, Vector3};
use thiserror::Error;

/// The largest number of independently moving arm joints: seven and a lift.
pub const MAX_JOINTS: usize = 8;
/// The largest number of inputs: two wheels, then the joints.
pub const MAX_INPUTS: usize = MAX_JOINTS + 2;

/// One number per joint, in the order of [`Robot::joints`]; further entries are 0.
pub type JointVector = SVector<f64, MAX_JOINTS>;
/// The input u: rim speeds of the left and the right wheel, m/s, then joint rates, rad/s (prismatic: m/s);
/// further entries are 0.
pub type InputVector = SVector<f64, MAX_INPUTS>;
/// The Jacobian d(grasp twist) / du. Rows are the grasp's linear velocity (m/s) and angular velocity (rad/s)
/// in world axes; columns as in [`InputVector`], further columns are 0.
pub type InputJacobian = SMatrix<f64, 6, MAX_INPUTS>;

/// The Jacobian d(velocity of a point) / du in world axes; columns as in [`InputJacobian`].
pub type PointJacobian = SMatrix<f64, 3, MAX_INPUTS>;

/// A mobile manipulator on two driven wheels.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// The source texts.
    pub texts: RobotTexts,
    /// The differential drive.
    pub drive: Drive,
    /// The independently moving joints of the arm, from the base to the grasp. At most [`MAX_JOINTS`].
    pub joints: Vec<ArmJoint>,
    /// Height above the floor at which the object is held, m.
    pub grasp_height: f64,
    /// Starting postures in file order; at least one. All hold the grasp level at [`Robot::grasp_height`],
    /// heading as the base.
    pub postures: Vec<Posture>,
    /// All links, parents before children.
    pub links: Vec<Link>,
    /// The base link: index into [`Robot::links`].
    pub base_link: usize,
    /// The link whose frame is the grasp frame: index into [`Robot::links`].
    pub grasp_link: usize,
    /// The links of the left and the right wheel: indices into [`Robot::links`].
    pub wheel_links: [usize; 2],
    /// What its files lack and what stands in for it.
    pub notes: Vec<RobotNote>,
    /// From the drive's frame to the base link's; the two differ by a translation.
    pub(crate) drive_from_base: Pose,
    /// The kinematic chain of the grasp, from the base outward.
    pub(crate) chain: Vec<ChainLink>,
    /// From the frame of the last joint of the chain to the grasp.
    pub(crate) last_from_grasp: Pose,
}

/// A differential drive: two independently driven wheels on one axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Distance between the wheels' centres, m.
    pub track: f64,
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
    /// Largest rim speed, m/s.
    pub rim_speed_limit: f64,
    /// Radius of a disc around the middle of the axle that must stay clear of obstacles, m.
    pub base_radius: f64,
}

/// A warning: the drive is slower than the team's walking speed.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "robot `{robot}`: its wheels drive {limit:.3} m/s at most (their limit velocity of {:.2} rad/s times their radius of {wheel_radius} m), \
     but the team walks at {speed} m/s: the robot cannot keep up",
    limit / wheel_radius
)]
pub struct SlowDrive {
    /// Name of the robot.
    pub robot: String,
    /// Largest rim speed, m/s.
    pub limit: f64,
    /// Radius of its wheels, m.
    pub wheel_radius: f64,
    /// Walking speed of the team, m/s.
    pub speed: f64,
}

/// An independently moving joint of the arm.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmJoint {
    /// Name in the URDF.
    pub name: String,
    /// Kind of motion.
    pub motion: Motion,
    /// Lower limit, rad or m; minus infinity for a continuous joint.
    pub lower: f64,
    /// Upper limit, rad or m; infinity for a continuous joint.
    pub upper: f64,
    /// Largest rate, rad/s or m/s.
    pub rate_limit: f64,
    /// Largest effort, Nm or N.
    pub effort_limit: f64,
}

/// The motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A rotation about its axis, rad.
    Revolute,
    /// A translation along its axis, m.
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

/// A moving joint between the base and the grasp. Fixed joints are part of the constant transforms.
#[derive(Clone, Debug)]
pub(crate) struct ChainLink {
    /// From the previous frame (the drive's, for the first) to this joint's frame at position 0.
    pub before_from_joint: Pose,
    /// Axis in the joint's frame.
    pub axis: Unit<Vector3<f64>>,
    pub motion: Motion,
    /// The arm joint that moves it: index into [`Robot::joints`].
    pub joint: usize,
    /// The joint's position is `ratio * (the arm joint's position) + offset`: 1 and 0 unless it mimics
    /// another.
    pub ratio: f64,
    pub offset: f64,
}

/// The configuration q: the pose of the base and the positions of the arm's joints.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Configuration {
    /// Pose of the drive frame in the world.
    pub base: PlanarPose,
    /// Joint positions.
    pub joints: JointVector,
}

impl Robot {
    /// Number of independently moving arm joints.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// A warning if the wheels are too slow for a team that walks at `speed` (m/s).
    pub fn slow_drive(&self, speed: f64) -> Option<SlowDrive> {
        let Drive { rim_speed_limit: limit, wheel_radius, .. } = self.drive;
        let robot = self.name.clone();
        (limit < speed).then_some(SlowDrive { robot, limit, wheel_radius, speed })
    }

    /// The posture of this name.
    pub fn posture(&self, name: &str) -> Option<&Posture> {
        self.postures.iter().find(|p| p.name == name)
    }
}

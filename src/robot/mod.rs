//! A robot file (TOML) and its URDF in; a validated [`Robot`] out: differential drive, arm, grasp, with forward kinematics and B(q).
//!
//! Frames: `world` is on the floor, z up. `drive` is on the floor in the middle between the wheels, x ahead, y to the left: its pose is the
//! base's. `grasp` is where the object is held, x ahead.

mod kinematics;

pub use kinematics::{Kinematics, pose_difference};

use crate::geometry::{PlanarPose, Pose};
use nalgebra::{SMatrix, SVector, Unit, Vector3};

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

/// A mobile manipulator on two driven wheels.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// The robot file, as the caller named it.
    pub file: String,
    /// The wheels.
    pub drive: Drive,
    /// The joints of the arm that move on their own, from the base to the grasp. At most [`MAX_JOINTS`].
    pub joints: Vec<ArmJoint>,
    /// Height above the floor at which the object is held, m.
    pub grasp_height: f64,
    /// Postures to start from, in file order; at least one. All hold the grasp level, at [`Robot::grasp_height`], heading as the base.
    pub postures: Vec<Posture>,
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
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// The posture of that name.
    pub fn posture(&self, name: &str) -> Option<&Posture> {
        self.postures.iter().find(|p| p.name == name)
    }
}

#[cfg(test)]
pub(crate) fn carrier_for_tests() -> Robot {
    use nalgebra::{Rotation3, Translation3};
    let t = |x: f64, z: f64| Pose::from_parts(Translation3::new(x, 0.0, z), Rotation3::identity());
    let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
    let inf = f64::INFINITY;
    let spec = [
        ("pan", t(0.033, 0.726), z, -1.6056, 1.6056, 1.256),
        ("lift", t(0.117, 0.06), y, -1.221, 1.518, 1.454),
        ("upper roll", t(0.219, 0.0), x, -inf, inf, 1.571),
        ("elbow", t(0.133, 0.0), y, -2.251, 2.251, 1.521),
        ("fore roll", t(0.197, 0.0), x, -inf, inf, 1.571),
        ("wrist", t(0.1245, 0.0), y, -2.16, 2.16, 2.268),
        ("wrist roll", t(0.1385, 0.0), x, -inf, inf, 2.268),
    ];
    let joints = spec
        .iter()
        .map(|s| ArmJoint {
            name: s.0.to_owned(),
            motion: Motion::Revolute,
            lower: s.3,
            upper: s.4,
            rate_limit: s.5,
            effort_limit: 1.0,
        })
        .collect();
    let chain = spec
        .iter()
        .enumerate()
        .map(|(i, s)| ChainLink {
            before_from_joint: s.1,
            axis: s.2,
            motion: Motion::Revolute,
            joint: i,
            ratio: 1.0,
            offset: 0.0,
        })
        .collect();
    let (a, b, wx, wz): (f64, f64, f64, f64) = (0.352, 0.3215, 0.75 - 0.1385 - 0.16645, -0.086);
    let d = wx.hypot(wz);
    let inner = ((a * a + d * d - b * b) / (2.0 * a * d)).acos();
    let bend = std::f64::consts::PI - ((a * a + b * b - d * d) / (2.0 * a * b)).acos();
    let up = wz.atan2(wx) + inner;
    let mut posture = JointVector::zeros();
    posture[1] = -up;
    posture[3] = bend;
    posture[5] = up - bend;
    Robot {
        name: "carrier".to_owned(),
        file: String::new(),
        drive: Drive { track: 0.374, wheel_radius: 0.06, rim_speed_limit: 1.044, base_radius: 0.25 },
        joints,
        grasp_height: 0.7,
        postures: vec![Posture { name: "elbow-up".to_owned(), joints: posture }],
        chain,
        last_from_grasp: t(0.16645, 0.0),
    }
}

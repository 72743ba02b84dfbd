//! A validated [`Robot`] from a robot file and its URDF: drive, arm, grasp, forward kinematics and B(q).
//!
//! Frames: `world` is on the floor, z up. `drive` is on the floor midway between the wheels (below the base
//! link, where an omnidirectional base names none), x ahead, y to the left; its pose is the base's. `grasp` is
//! where the object is held, x ahead.

mod arm;
mod arm_limits;
mod collision;
mod described;
mod draft;
mod draft_approach;
mod draft_arms;
mod draft_drive;
mod draft_holds;
mod draft_legs;
mod draft_request;
mod draft_search;
mod draft_text;
mod draft_tree;
mod drive;
mod driven;
mod factor;
mod file;
mod footprint;
mod hull;
mod kinematics;
mod level;
mod link;
mod load;
mod mesh;
mod mesh_bounds;
mod mobility;
mod plausible;
mod posture;
mod postures;
mod reach;
mod self_contact;
mod solid;
mod statics;
mod texts;
mod tree;
mod tuck;
mod urdf;
mod urdf_check;
mod urdf_grammar;
mod urdf_lines;
mod urdf_mend;
mod urdf_notes;
mod urdf_shapes;
mod urdf_text;
mod urdf_xml;
mod warning;
mod wheel_search;
mod wheels;

pub use draft::Draft;
pub use draft_request::DraftRequest;
pub(crate) use drive::without_last;
pub use drive::{BaseInput, BaseTwist, Drive, DriveKind, MAX_BASE_INPUTS, SlowDrive, Wheel};
pub(crate) use factor::{Factor, Lanes};
pub use kinematics::{Kinematics, pose_difference};
pub use link::{Coupling, Geometry, Inertial, Joint, JointKind, Limits, Link, Mimic, Shape};
pub use mobility::PlanarSpeeds;
pub use reach::Reach;
pub(crate) use self_contact::SelfContacts;
pub(crate) use statics::GRAVITY;
pub use statics::WeakestJoint;
pub use texts::{Expand, RobotTexts};
pub use warning::{RobotWarning, WarningKind};

use crate::geometry::{Footprint, PlanarPose, Pose};
use nalgebra::{SMatrix, SVector};

/// The largest number of independently moving arm joints: seven and a lift.
pub const MAX_JOINTS: usize = 8;
/// The largest number of inputs: the base's, then the joints'.
pub const MAX_INPUTS: usize = MAX_JOINTS + MAX_BASE_INPUTS;

/// The largest number of names of links or joints that an error lists.
const MAX_LISTED: usize = 12;

/// One number per joint, in the order of [`Robot::joints`]; further entries are 0.
pub type JointVector = SVector<f64, MAX_JOINTS>;
/// The input u: the base's inputs ([`BaseInput`], as many as [`Drive::inputs`]), then joint rates, rad/s
/// (prismatic: m/s); further entries are 0.
pub type InputVector = SVector<f64, MAX_INPUTS>;
/// The Jacobian d(grasp twist) / du. Rows are the grasp's linear velocity (m/s) and angular velocity (rad/s)
/// in world axes; columns as in [`InputVector`], further columns are 0.
pub type InputJacobian = SMatrix<f64, 6, MAX_INPUTS>;

/// The Jacobian d(velocity of a point) / du in world axes; columns as in [`InputJacobian`].
pub type PointJacobian = SMatrix<f64, 3, MAX_INPUTS>;

/// A mobile manipulator.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// The source texts.
    pub texts: RobotTexts,
    /// The drive.
    pub drive: Drive,
    /// The outline of the base on the floor, in the drive's frame, which is kept off obstacles.
    pub footprint: Footprint,
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
    /// The driven wheels: those of the left side first. An omnidirectional base may have none.
    pub wheels: Vec<Wheel>,
    /// Parts that its files lack and their substitutes.
    pub warnings: Vec<RobotWarning>,
    /// From the drive's frame to the base link's; the two differ by a translation.
    pub(crate) drive_from_base: Pose,
    /// The kinematic chain of the grasp, from the base outward.
    pub(crate) chain: Vec<ChainLink>,
    /// From the frame of the last joint of the chain to the grasp.
    pub(crate) last_from_grasp: Pose,
    /// See [`Robot::width`].
    pub(crate) base_width: f64,
    /// Its bodies, for contacts with itself.
    self_contacts: SelfContacts,
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

impl Motion {
    /// The unit of an effort.
    pub fn effort_unit(self) -> &'static str {
        match self {
            Self::Revolute => "Nm",
            Self::Prismatic => "N",
        }
    }
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
    /// From the previous frame (the drive's, for the first) to this joint's frame at position 0. The joint's
    /// axis is the frame's z, as in the notation of Denavit and Hartenberg: a turn then mixes two columns.
    pub before_from_joint: Pose,
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

    /// The base's part of an input.
    pub fn base_input(&self, input: &InputVector) -> BaseInput {
        let third = if self.drive.inputs() == MAX_BASE_INPUTS { input[2] } else { 0.0 };
        BaseInput::new(input[0], input[1], third)
    }

    /// The arm's part of an input: joint rates.
    pub fn joint_rates(&self, input: &InputVector) -> JointVector {
        input.fixed_rows::<MAX_JOINTS>(self.drive.inputs()).into_owned()
    }

    /// The arm's columns of a Jacobian.
    pub fn arm_jacobian(&self, jacobian: &InputJacobian) -> SMatrix<f64, 6, MAX_JOINTS> {
        jacobian.fixed_columns::<MAX_JOINTS>(self.drive.inputs()).into_owned()
    }

    /// The largest magnitude of every input: m/s and rad/s.
    pub fn input_limits(&self) -> InputVector {
        let mut limits = InputVector::zeros();
        let base = self.drive.inputs();
        limits.rows_mut(0, base).copy_from(&self.drive.limits().rows(0, base));
        for (limit, joint) in limits.iter_mut().skip(base).zip(&self.joints) {
            *limit = joint.rate_limit;
        }
        limits
    }

    /// Width of the base, against which openings are measured, m.
    pub fn width(&self) -> f64 {
        self.base_width
    }

    /// The posture of this name.
    pub fn posture(&self, name: &str) -> Option<&Posture> {
        self.postures.iter().find(|p| p.name == name)
    }
}

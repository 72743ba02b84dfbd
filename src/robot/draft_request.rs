//! What is asked of the draft of a robot file, and why there may be none.

use super::drive::DriveKind;
use super::error::RobotError;
use thiserror::Error;

/// What a user gives in place of what would be found.
#[derive(Clone, Debug, Default)]
pub struct DraftRequest {
    /// The link at the end of the arm.
    pub tool: Option<String>,
    /// The drive.
    pub drive: Option<DriveKind>,
    /// The joints of the left and of the right driven wheel.
    pub wheels: Option<[String; 2]>,
    /// Height at which the object is held, m.
    pub grasp_height: Option<f64>,
}

/// The reason why no robot file can be drafted.
#[derive(Debug, Error)]
pub enum DraftError {
    /// The URDF, or the robot made of it, is not valid.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// No pair of driven wheels.
    #[error(
        "{file}: no pair of driven wheels: expected two continuous joints about the base's y axis, one on either side; {seen}; an omnidirectional base needs --drive omnidirectional"
    )]
    NoWheels {
        /// The URDF.
        file: String,
        /// What there is instead.
        seen: String,
    },
    /// More than one pair of wheels.
    #[error(
        "{file}: {count} wheels could be driven: {names}; say which drive it has: --drive skid-steer, --drive omnidirectional (mecanum), or, if only two are driven and the others roll freely, --drive differential with --left-wheel and --right-wheel"
    )]
    ManyWheels {
        /// The URDF.
        file: String,
        /// Their number.
        count: usize,
        /// Their joints.
        names: String,
    },
    /// No arm.
    #[error("{file}: no arm of 1 to 8 moving joints descends from `{base}`; name its last link with --tool")]
    NoArm {
        /// The URDF.
        file: String,
        /// The base link.
        base: String,
    },
    /// A wheel has no shape to measure.
    #[error("{file}: the radius of `{wheel}` cannot be measured: it has no shape; give one in the URDF")]
    NoRadius {
        /// The URDF.
        file: String,
        /// The joint of the wheel.
        wheel: String,
    },
    /// No posture holds the object.
    #[error(
        "{file}: no posture found that holds `{tool}` level and straight ahead at {heights} m; try --grasp-height or --tool{hint}"
    )]
    NoPosture {
        /// The URDF.
        file: String,
        /// The tool's link.
        tool: String,
        /// The heights tried, m.
        heights: String,
        /// Why that may be.
        hint: &'static str,
    },
}

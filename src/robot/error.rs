//! Errors in a robot file or its URDF, each with its file, item and numbers.

use super::fault::{ArmFault, DriveFault, FootprintFault, PostureFault, TreeFault, WheelFault};
use crate::located::{FileError, Place};
use crate::suggestion::{self, hint_of_listed};
use std::path::Path;
use thiserror::Error;

/// Why a robot was refused.
#[derive(Debug, Error)]
pub enum RobotError {
    /// A file cannot be read, or is neither TOML nor XML.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file of another kind.
    #[error(
        "{file}: expected a robot file (.toml), or a URDF (.urdf or .xml) with a robot file beside it{}",
        hint_of_file(file)
    )]
    Format {
        /// The file.
        file: String,
    },
    /// A xacro where a URDF belongs.
    #[error(
        "{file}: a xacro, not a URDF; expand it first: `xacro {file} > {expanded}` (`pip install xacro` has the program)"
    )]
    Xacro {
        /// The file.
        file: String,
        /// A name for the expanded URDF.
        expanded: String,
    },
    /// The program `xacro` could not expand a xacro.
    #[error("{file}: `xacro` cannot expand it: {said}")]
    XacroFailed {
        /// The file.
        file: String,
        /// The last line of its message.
        said: String,
    },
    /// A URDF without a robot file.
    #[error(
        "{urdf}: needs a robot file beside it, {needed}, which names urdf, base_link, grasp_frame, left_wheel and right_wheel (or another drive), base_width_m, grasp_height_m and a [[posture]]; `cocarry robot init {urdf}` drafts one"
    )]
    NoRobotFile {
        /// The URDF.
        urdf: String,
        /// The file that is missing.
        needed: String,
    },
    /// The robot file beside a URDF names another URDF.
    #[error("{place} = {found:?}; expected {asked}, which was asked for")]
    OtherUrdf {
        /// Where the URDF is named.
        place: Place,
        /// The URDF that it names.
        found: String,
        /// The URDF that was to be loaded.
        asked: String,
    },
    /// A number is out of its range.
    #[error("{place}: {field} = {value}; it must be {expected}")]
    Number {
        /// Where.
        place: Place,
        /// The key or attribute.
        field: String,
        /// The value found.
        value: f64,
        /// The values allowed.
        expected: String,
    },
    /// A missing item.
    #[error("{place}: missing {needed}")]
    Missing {
        /// Where.
        place: Place,
        /// What is missing.
        needed: String,
    },
    /// A position under the key for the other kind of joint.
    #[error("{place}: `{joint}` is {kind}; give its position as {key}")]
    Unit {
        /// Where.
        place: Place,
        /// The joint.
        joint: String,
        /// Its kind.
        kind: &'static str,
        /// The key to use instead.
        key: &'static str,
    },
    /// An unknown name.
    #[error("{place}: unknown {kind} `{name}`; expected one of: {known}{}", hint_of_listed(name, known))]
    Unknown {
        /// Where.
        place: Place,
        /// The kind of name, such as `link` or `joint`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// Two items of one kind have the same name.
    #[error("{place}: duplicate name; every {kind} needs a unique name")]
    Duplicate {
        /// The item.
        place: Place,
        /// The kind of item, such as `link` or `joint`.
        kind: &'static str,
    },
    /// The links do not form one tree.
    #[error("{place}: {why}")]
    NotATree {
        /// The link.
        place: Place,
        /// The fault.
        why: TreeFault,
    },
    /// No usable arm leads from the base to the grasp.
    #[error("{place}: {why}")]
    NotAnArm {
        /// The grasp frame or the joint.
        place: Place,
        /// The fault.
        why: ArmFault,
    },
    /// A wheel that cannot drive the base.
    #[error("{place}: not a wheel: {why}")]
    NotAWheel {
        /// The joint.
        place: Place,
        /// The fault.
        why: WheelFault,
    },
    /// A key that the robot's drive does not have.
    #[error("{place}: {key} does not apply to drive = \"{drive}\"; {instead}")]
    NoKey {
        /// Where.
        place: Place,
        /// The key.
        key: &'static str,
        /// The drive.
        drive: &'static str,
        /// What applies.
        instead: &'static str,
    },
    /// A base that moves in another way than its robot file says.
    #[error("{place}: {why}")]
    OtherDrive {
        /// The drive, or a wheel.
        place: Place,
        /// The fault.
        why: DriveFault,
    },
    /// A base without an outline.
    #[error("{place}: {why}")]
    Footprint {
        /// Where.
        place: Place,
        /// The fault.
        why: FootprintFault,
    },
    /// A lower limit that is not below the upper one.
    #[error("{place}: invalid limits: lower {lower} must be below upper {upper}")]
    Limits {
        /// The joint.
        place: Place,
        /// Least position, rad or m.
        lower: f64,
        /// Largest position, rad or m.
        upper: f64,
    },
    /// Joints that mimic each other in a circle.
    #[error("{place}: mimics itself: {circle}; a joint must follow one that moves independently")]
    MimicCircle {
        /// The joint.
        place: Place,
        /// The joints in the order in which they mimic each other.
        circle: String,
    },
    /// A posture that does not hold the object level at its height, heading ahead.
    #[error(
        "{place}: the given angles hold the grasp {height:.4} m above the floor, tilted by {tilt_deg:.2} deg and turned by {heading_deg:.2} deg from straight ahead; it must be level, straight ahead, at grasp_height_m = {needed} m: {why}"
    )]
    Posture {
        /// The posture.
        place: Place,
        /// Height of the grasp at the angles given, m.
        height: f64,
        /// Between the grasp's z and upright, degrees.
        tilt_deg: f64,
        /// Between the grasp's x and the base's, seen from above, degrees.
        heading_deg: f64,
        /// Height needed, m.
        needed: f64,
        /// The reason why the posture could not be closed.
        why: PostureFault,
    },
}

/// A hint for a file without a known ending: the built-in robot's name in studies, or a file beside it.
fn hint_of_file(file: &str) -> String {
    let path = Path::new(file);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match path.exists() {
        true => String::new(),
        false => Some(suggestion::hint(&name, ["built-in"]))
            .filter(|hint| !hint.is_empty())
            .unwrap_or_else(|| suggestion::hint_of_files(path)),
    }
}

/// A list of known names for [`RobotError::Unknown`].
pub(super) fn known<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST_NAMES: usize = 12;
    let names: Vec<String> = names.map(|n| format!("`{n}`")).collect();
    match names.len() {
        0 => "none".to_owned(),
        n if n <= MOST_NAMES => names.join(", "),
        n => format!("{} and {} more", names[..MOST_NAMES].join(", "), n - MOST_NAMES),
    }
}

//! What is asked of the draft of a robot file.

use super::drive::DriveKind;

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

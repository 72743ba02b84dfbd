//! Options of `robot init`.

use super::drive::DriveKind;

/// User overrides of the automatic detection.
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

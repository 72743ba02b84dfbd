//! Options of `robot init`.

use super::drive::DriveKind;

/// User overrides of the automatic detection.
#[derive(Clone, Debug, Default)]
pub struct DraftRequest {
    /// The link at the end of the arm.
    pub tool: Option<String>,
    /// The link that moves with the base.
    pub base: Option<String>,
    /// The drive.
    pub drive: Option<DriveKind>,
    /// The joints of the left and of the right driven wheel.
    pub wheels: Option<[String; 2]>,
    /// Radius of the wheels, m.
    pub wheel_radius: Option<f64>,
    /// Joints that stay fixed, and their positions, degrees or m.
    pub hold: Vec<(String, f64)>,
    /// Length, width and height of the base of a robot whose URDF has none, m.
    pub base_size: Option<[f64; 3]>,
    /// Mass of that base, kg.
    pub base_mass: Option<f64>,
    /// Height at which the object is held, m.
    pub grasp_height: Option<f64>,
}

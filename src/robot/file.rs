//! A robot file as written, each item with its line.

use super::drive::DriveKind;
use crate::error::Error;
use crate::located::Source;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use toml::Spanned;

/// A robot file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    pub name: String,
    pub urdf: Spanned<String>,
    pub base_link: Spanned<String>,
    pub grasp_frame: Spanned<String>,
    pub drive: Option<Spanned<DriveKind>>,
    pub left_wheel: Option<Spanned<String>>,
    pub right_wheel: Option<Spanned<String>>,
    pub left_wheels: Option<Vec<Spanned<String>>>,
    pub right_wheels: Option<Vec<Spanned<String>>>,
    pub mecanum_wheels: Option<Vec<Spanned<String>>>,
    pub omni_wheels: Option<Vec<Spanned<String>>>,
    pub base_width_m: Spanned<f64>,
    pub base_footprint: Option<Spanned<toml::Value>>,
    pub grasp_height_m: Spanned<f64>,
    pub wheel_radius_m: Option<Spanned<f64>>,
    pub wheel_separation_m: Option<Spanned<f64>>,
    pub wheel_rate_limit_rad_s: Option<Spanned<f64>>,
    pub arm_rate_limit_rad_s: Option<Spanned<f64>>,
    pub arm_rate_limit_m_s: Option<Spanned<f64>>,
    pub wheel_separation_multiplier: Option<Spanned<f64>>,
    pub base_speed_limit_m_s: Option<Spanned<f64>>,
    pub base_turn_limit_rad_s: Option<Spanned<f64>>,
    pub base_height_m: Option<Spanned<f64>>,
    pub base_size_m: Option<Spanned<[f64; 3]>>,
    pub base_mass_kg: Option<Spanned<f64>>,
    pub grasp_xyz_m: Option<Spanned<[f64; 3]>>,
    pub grasp_rpy_deg: Option<Spanned<[f64; 3]>>,
    #[serde(default)]
    pub packages: Vec<PathBuf>,
    #[serde(default)]
    pub hold: BTreeMap<String, Spanned<HoldEntry>>,
    #[serde(default, rename = "posture")]
    pub postures: Vec<Spanned<PostureEntry>>,
}

/// A joint under `[hold]`: exactly one of the two keys is given.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HoldEntry {
    pub angle_deg: Option<f64>,
    pub position_m: Option<f64>,
}

/// One `[[posture]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PostureEntry {
    pub name: String,
    #[serde(default)]
    pub angles_deg: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    pub positions_m: BTreeMap<String, Spanned<f64>>,
}

/// A number that must be in a range.
pub(super) fn number(
    source: Source,
    key: &str,
    spanned: &Spanned<f64>,
    is_good: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<f64, Error> {
    match *spanned.get_ref() {
        value if is_good(value) => Ok(value),
        value => Err(Error::number(source.place(spanned, "robot"), key, value, expected)),
    }
}

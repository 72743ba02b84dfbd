//! A robot file as written, each item with its line.

use super::error::{Place, RobotError};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A robot file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    pub name: String,
    pub urdf: Spanned<String>,
    pub base_link: Spanned<String>,
    pub grasp_frame: Spanned<String>,
    pub left_wheel: Spanned<String>,
    pub right_wheel: Spanned<String>,
    pub base_width_m: Spanned<f64>,
    pub grasp_height_m: Spanned<f64>,
    pub wheel_radius_m: Option<Spanned<f64>>,
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

/// A file's name and text, used to locate items in it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub file: &'a str,
    pub text: &'a str,
}

impl Source<'_> {
    pub fn parse(self) -> Result<RobotFile, RobotError> {
        toml::from_str(self.text)
            .map_err(|e| RobotError::Syntax { file: self.file.to_owned(), source: Box::new(e) })
    }

    /// The place of `item`, which was read from `spanned`.
    pub fn place<T>(self, spanned: &Spanned<T>, item: impl Into<String>) -> Place {
        let before = self.text.get(..spanned.span().start).unwrap_or("");
        let line = before.matches('\n').count() + 1;
        Place { file: self.file.to_owned(), line: Some(line), item: item.into() }
    }

    /// A number that must be in a range.
    pub fn number(
        self,
        field: &str,
        spanned: &Spanned<f64>,
        is_good: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<f64, RobotError> {
        let value = *spanned.get_ref();
        if is_good(value) {
            return Ok(value);
        }
        Err(RobotError::Number {
            place: self.place(spanned, "robot"),
            field: field.to_owned(),
            value,
            expected: expected.to_owned(),
        })
    }
}

//! A world file as written, each item with its line.

use super::error::{Place, WorldError};
use super::object::ObjectShape;
use serde::Deserialize;
use toml::Spanned;

/// A world file as written. Lengths in metres, angles in degrees: the loader converts.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorldFile {
    pub name: String,
    #[serde(default)]
    pub note: String,
    pub robot_width_m: Spanned<f64>,
    pub start_m: Spanned<Pair<f64>>,
    pub target_m: Spanned<Pair<f64>>,
    pub option_limit: Option<Spanned<i64>>,
    pub object: Option<ObjectEntry>,
    #[serde(default, rename = "obstacle")]
    pub obstacles: Vec<Spanned<ObstacleEntry>>,
    #[serde(default, rename = "opening")]
    pub openings: Vec<Spanned<OpeningEntry>>,
    #[serde(default, rename = "option")]
    pub options: Vec<Spanned<OptionEntry>>,
}

/// One `[[obstacle]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObstacleEntry {
    pub name: String,
    pub shape: ShapeEntry,
    pub center_m: Option<Pair<f64>>,
    pub size_m: Option<Pair<f64>>,
    pub yaw_deg: Option<f64>,
    pub radius_m: Option<f64>,
    pub vertices_m: Option<Vec<Pair<f64>>>,
    pub height_m: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShapeEntry {
    Box,
    Cylinder,
    Polygon,
}

/// The `[object]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectEntry {
    #[serde(default)]
    pub shape: ObjectShape,
    pub size_m: Spanned<Values<f64, 3>>,
    pub mass_kg: Spanned<f64>,
}

/// One `[[opening]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OpeningEntry {
    pub name: String,
    pub between: Pair<String>,
}

/// One `[[option]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OptionEntry {
    pub name: Option<String>,
    pub openings: Vec<String>,
}

/// Two values; more or fewer are an error.
pub(super) type Pair<T> = Values<T, 2>;

/// Exactly `N` values; more or fewer are an error.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "Vec<T>")]
#[serde(bound(deserialize = "T: Deserialize<'de>"))]
pub(super) struct Values<T, const N: usize>(pub [T; N]);

impl<T, const N: usize> TryFrom<Vec<T>> for Values<T, N> {
    type Error = String;

    fn try_from(values: Vec<T>) -> Result<Self, String> {
        let n = values.len();
        let expected = if N == 2 { "two" } else { "three" };
        values.try_into().map(Self).map_err(|_| format!("expected {expected} values, found {n}"))
    }
}

/// A file's name and text, used to locate items in it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub file: &'a str,
    pub text: &'a str,
}

impl Source<'_> {
    pub fn parse(self) -> Result<WorldFile, WorldError> {
        toml::from_str(self.text)
            .map_err(|e| WorldError::Syntax { file: self.file.to_owned(), source: Box::new(e) })
    }

    /// The place of `item`, which was read from `spanned`.
    pub fn place<T>(self, spanned: &Spanned<T>, item: impl Into<String>) -> Place {
        let before = self.text.get(..spanned.span().start).unwrap_or("");
        Place { file: self.file.to_owned(), line: before.matches('\n').count() + 1, item: item.into() }
    }
}

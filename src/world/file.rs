//! A world file as written, each item with its line.

use super::object::ObjectEntry;
use super::values::Pair;
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
    pub start_heading_deg: Option<Spanned<f64>>,
    pub option_limit: Option<Spanned<i64>>,
    pub free_passage_robot_widths: Option<Spanned<f64>>,
    pub origin_m: Option<Spanned<Pair<f64>>>,
    pub object: Option<ObjectEntry>,
    pub map: Option<Spanned<toml::Value>>,
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
    pub holes_m: Option<Vec<Vec<Pair<f64>>>>,
    pub height_m: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShapeEntry {
    Box,
    Cylinder,
    Polygon,
    /// The surroundings of a polygon: the walls of a room.
    Room,
}

impl ShapeEntry {
    /// The name in a world file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Cylinder => "cylinder",
            Self::Polygon => "polygon",
            Self::Room => "room",
        }
    }
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

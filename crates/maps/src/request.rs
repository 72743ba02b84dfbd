//! The request of a world for a map.

use cocarry::geometry::Point;
use serde::Deserialize;

/// The height of obstacles whose map gives none, m.
pub(crate) const HEIGHT_M: f64 = 2.0;

/// The request of a world for a map.
pub(crate) struct Request {
    /// The world file, for errors.
    pub file: String,
    pub start: Point,
    pub target: Point,
    /// The robot's width d_r, m.
    pub robot_width: f64,
    /// How far outlines may be from the cells' sides, m; a cell if not given.
    pub tolerance: Option<f64>,
    /// Height of the obstacles, m.
    pub height: f64,
    pub is_unknown_free: bool,
    pub unit: Unit,
}

/// The unit of a floor plan's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub(crate) enum Unit {
    #[default]
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "in")]
    Inch,
    #[serde(rename = "ft")]
    Foot,
}

impl Unit {
    /// Its length, m.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }
}

/// The `[map]` of a world file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MapEntry {
    pub file: String,
    pub tolerance_m: Option<f64>,
    pub height_m: Option<f64>,
    #[serde(default)]
    pub unknown: Unknown,
    #[serde(default)]
    pub unit: Unit,
}

/// The meaning of unknown cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Unknown {
    #[default]
    Occupied,
    Free,
}

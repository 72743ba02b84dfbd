//! The carried object.

use super::values::Values;
use crate::error::Error;
use crate::located::Source;
use serde::Deserialize;
use toml::Spanned;

/// Range of an object's length, width and height, m.
const SIZES: [(f64, f64); 3] = [(0.3, 4.0), (0.02, 1.0), (0.02, 1.0)];
/// Range of an object's mass, kg.
const MASSES: (f64, f64) = (0.1, 40.0);

/// The carried object: a homogeneous box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedObject {
    /// Its kind, a name only; all are boxes.
    pub shape: ObjectShape,
    /// Length (from the robot's end to the human's), width and height, m.
    pub size: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
}

/// The name of the carried object's kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ObjectShape {
    /// A beam.
    #[default]
    Beam,
    /// A box.
    Box,
    /// A board.
    Board,
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

impl ObjectShape {
    /// The name in a world file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beam => "beam",
            Self::Box => "box",
            Self::Board => "board",
        }
    }
}

impl Default for CarriedObject {
    /// A beam of 1.2 m x 0.1 m x 0.1 m and 4 kg.
    fn default() -> Self {
        Self { shape: ObjectShape::Beam, size: [1.2, 0.1, 0.1], mass: 4.0 }
    }
}

impl CarriedObject {
    pub(super) fn from_entry(source: Source, entry: &ObjectEntry) -> Result<Self, Error> {
        let number = |place, key: &str, value, (least, most), expected| match (least..=most).contains(&value)
        {
            true => Ok(value),
            false => Err(Error::number(place, key, value, expected)),
        };
        let size = entry.size_m.get_ref().0;
        let allowed = [
            "a length from 0.3 to 4 (metres) along the way",
            "a width from 0.02 to 1 (metres)",
            "a height from 0.02 to 1 (metres)",
        ];
        for (i, (limits, expected)) in SIZES.into_iter().zip(allowed).enumerate() {
            number(
                source.place(&entry.size_m, "object"),
                &format!("size_m[{i}]"),
                size[i],
                limits,
                expected,
            )?;
        }
        let mass = number(
            source.place(&entry.mass_kg, "object"),
            "mass_kg",
            *entry.mass_kg.get_ref(),
            MASSES,
            "a mass from 0.1 to 40 (kilograms)",
        )?;
        Ok(Self { shape: entry.shape, size, mass })
    }
}

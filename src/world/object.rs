//! The carried object.

use super::error::WorldError;
use super::file::{ObjectEntry, Source};
use serde::Deserialize;

/// Lengths that an object may have, m: along the way, across, high.
const SIZES: [(f64, f64); 3] = [(0.3, 4.0), (0.02, 1.0), (0.02, 1.0)];
/// Masses that an object may have, kg.
const MASSES: (f64, f64) = (0.1, 40.0);

/// The object that is carried: a homogeneous box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedObject {
    /// What it is called; all are boxes.
    pub shape: ObjectShape,
    /// Along the way (from the robot's end to the human's), across and high, m.
    pub size: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
}

/// What the object that is carried is called.
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

impl ObjectShape {
    /// What a world file calls it.
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
    pub(super) fn from_entry(source: Source, entry: &ObjectEntry) -> Result<Self, WorldError> {
        let number = |place, field: String, value, (least, most), expected| {
            if (least..=most).contains(&value) {
                return Ok(value);
            }
            Err(WorldError::Number { place, field, value, expected })
        };
        let size = entry.size_m.get_ref().0;
        let allowed = [
            "a length from 0.3 to 4 (metres) along the way",
            "a width from 0.02 to 1 (metres)",
            "a height from 0.02 to 1 (metres)",
        ];
        for (i, (limits, expected)) in SIZES.into_iter().zip(allowed).enumerate() {
            number(source.place(&entry.size_m, "object"), format!("size_m[{i}]"), size[i], limits, expected)?;
        }
        let mass = number(
            source.place(&entry.mass_kg, "object"),
            "mass_kg".to_owned(),
            *entry.mass_kg.get_ref(),
            MASSES,
            "a mass from 0.1 to 40 (kilograms)",
        )?;
        Ok(Self { shape: entry.shape, size, mass })
    }
}

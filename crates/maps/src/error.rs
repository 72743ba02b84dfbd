//! Errors in maps and floor plans, each with its file, place and value.

use cocarry::located::{FileError, Place};
use thiserror::Error;

/// Why a map was refused.
#[derive(Debug, Error)]
pub enum MapError {
    /// A file cannot be read, or has a syntax error.
    #[error(transparent)]
    File(#[from] FileError),
    /// A map without a start and a target.
    #[error(
        "{file}: a map has no start and no target; give --start and --target, or write a world file with them and `map = {{ file = \"{file}\" }}`"
    )]
    NoEnds {
        /// The map.
        file: String,
    },
    /// A value is missing, or is not what it must be.
    #[error("{place}: {found}; it must be {expected}")]
    Value {
        /// Where.
        place: Place,
        /// The key and the value found.
        found: String,
        /// The values allowed.
        expected: &'static str,
    },
    /// An image that cannot be read.
    #[error("{file}: {fault}")]
    Image {
        /// The file.
        file: String,
        /// What is wrong with it.
        fault: String,
    },
    /// The start or the target is not on free floor.
    #[error("{place} = ({x}, {y}) is on {cell} of {map}; choose a point on free floor")]
    NotFree {
        /// Where.
        place: Place,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// The kind of cell.
        cell: &'static str,
        /// The map.
        map: String,
    },
    /// The start and the target are not connected.
    #[error(
        "{map}: no way of free cells leads from ({}, {}) to ({}, {}), not even one {width:.2} m wide; {}",
        .start[0], .start[1], .target[0], .target[1],
        "if the floor between them is unknown, `unknown = \"free\"` opens it"
    )]
    NotConnected {
        /// The map.
        map: String,
        /// The start, m.
        start: [f64; 2],
        /// The target, m.
        target: [f64; 2],
        /// The width looked for, m.
        width: f64,
    },
    /// More corners than a world may have.
    #[error(
        "{map}: its outlines have {corners} corners within {tolerance} m, more than {most}; set a larger tolerance_m, or cut the map to the floor that the team walks on"
    )]
    TooMany {
        /// The map.
        map: String,
        /// The number of corners.
        corners: usize,
        /// The largest number.
        most: usize,
        /// The tolerance, m.
        tolerance: f64,
    },
}

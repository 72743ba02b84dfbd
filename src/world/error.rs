//! Errors in a world file, each with its file, line, item and numbers.

use crate::located::{FileError, Place};
use crate::suggestion::hint_of_listed;
use thiserror::Error;

/// Why a world file was refused.
#[derive(Debug, Error)]
pub enum WorldError {
    /// A file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] FileError),
    /// The map that a world file names is at fault.
    #[error(transparent)]
    Map(Box<dyn std::error::Error + Send + Sync>),
    /// A world that names a map was given as text alone.
    #[error(
        "{place}: the file of a map can be read only with the world file's folder; `cocarry world FILE --write` writes the world with the map's outlines"
    )]
    NamesMap {
        /// Where.
        place: Place,
    },
    /// There is no world file and no built-in world of that name.
    #[error("{name}: no such world; expected a world file, or one of the built-in worlds {known}{hint}")]
    NoSuchWorld {
        /// The name.
        name: String,
        /// The names of the built-in worlds.
        known: String,
        /// A similar name, as a sentence, or nothing.
        hint: String,
    },
    /// A number is out of its range.
    #[error("{place}: {field} = {value}; it must be {expected}")]
    Number {
        /// Where.
        place: Place,
        /// The key.
        field: String,
        /// The value found.
        value: f64,
        /// The values allowed.
        expected: &'static str,
    },
    /// A shape without a key that it needs.
    #[error("{place}: a {shape} needs {field}")]
    Missing {
        /// Where.
        place: Place,
        /// The obstacle's shape.
        shape: &'static str,
        /// The key that is missing.
        field: &'static str,
    },
    /// A shape with a key that it does not take.
    #[error("{place}: a {shape} takes no {field}")]
    Superfluous {
        /// Where.
        place: Place,
        /// The obstacle's shape.
        shape: &'static str,
        /// The key that does not belong.
        field: &'static str,
    },
    /// Two items of one kind have the same name.
    #[error("{place}: duplicate name; every {kind} needs a unique name")]
    Duplicate {
        /// The second occurrence of the name.
        place: Place,
        /// `obstacle`, `opening` or `option`.
        kind: &'static str,
    },
    /// A polygon has too few corners, or too many.
    #[error("{place}: {count} corners in {field}; a polygon needs 3 to 20000")]
    Corners {
        /// Where.
        place: Place,
        /// The key.
        field: String,
        /// The number of corners found.
        count: usize,
    },
    /// A polygon's outline crosses itself.
    #[error(
        "{place}: the side of its outline that begins at ({x}, {y}) crosses or touches another side; list the corners in order around the outline"
    )]
    Crossing {
        /// Where.
        place: Place,
        /// Where the side begins: x, m.
        x: f64,
        /// Its y, m.
        y: f64,
    },
    /// All corners of a polygon are on a line.
    #[error("{place}: all corners of an outline are on one line")]
    Flat {
        /// Where.
        place: Place,
    },
    /// A shape too thin for its length.
    #[error("{place}: its proportions are too extreme for a solid; use corners and a height of similar size")]
    Extreme {
        /// Where.
        place: Place,
    },
    /// An unknown name.
    #[error("{place}: unknown {kind} `{name}`; expected one of: {known}{}", hint_of_listed(name, known))]
    Unknown {
        /// Where.
        place: Place,
        /// `obstacle` or `opening`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// An opening between an obstacle and itself.
    #[error("{place}: between names `{obstacle}` twice; an opening lies between two obstacles")]
    SameObstacle {
        /// Where.
        place: Place,
        /// The obstacle.
        obstacle: String,
    },
    /// An opening that is too narrow.
    #[error(
        "{place}: {}, not more than the robot's {robot_width} m: impassable",
        match *width < 0.001 {
            true => format!("`{first}` and `{second}` touch or are less than 1 mm apart"),
            false => format!("the gap between `{first}` and `{second}` is {width:.4} m wide"),
        }
    )]
    Impassable {
        /// Where.
        place: Place,
        /// One obstacle.
        first: String,
        /// The other.
        second: String,
        /// Measured width, m.
        width: f64,
        /// Robot width, m.
        robot_width: f64,
    },
    /// An opening in which a third obstacle stands.
    #[error(
        "{place}: `{third}` stands {distance:.4} m from the middle of the gap between `{first}` and `{second}` ({width:.4} m wide); name the narrower gap beside it"
    )]
    Obstructed {
        /// Where.
        place: Place,
        /// One obstacle.
        first: String,
        /// The other.
        second: String,
        /// The obstacle in the way.
        third: String,
        /// Its distance from the middle of the gap, m.
        distance: f64,
        /// The gap's width, m.
        width: f64,
    },
    /// A gap declared twice.
    #[error("{place}: this is the same gap as opening `{other}`; declare it once")]
    SameGap {
        /// Where.
        place: Place,
        /// The opening declared before.
        other: String,
    },
    /// The start or the target is too close to an obstacle.
    #[error(
        "{place} = ({x}, {y}) is {distance:.4} m from obstacle `{obstacle}`; the team needs {needed} m (half of robot_width_m) around it{}",
        if *.distance == 0.0 { ": it lies inside the obstacle" } else { "" }
    )]
    Occupied {
        /// Where.
        place: Place,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// The obstacle.
        obstacle: String,
        /// Distance to it, m.
        distance: f64,
        /// Distance needed, m.
        needed: f64,
    },
}

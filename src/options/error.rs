//! Errors in the options of a world.

use thiserror::Error;

/// The reason why a world has no options.
#[derive(Debug, Error)]
pub enum OptionError {
    /// No path leads from the start to the target.
    #[error("{file}: the target ({tx}, {ty}) cannot be reached from the start ({sx}, {sy}): {reason}")]
    Unreachable {
        /// The world file.
        file: String,
        /// Start x, m.
        sx: f64,
        /// Start y, m.
        sy: f64,
        /// Target x, m.
        tx: f64,
        /// Target y, m.
        ty: f64,
        /// What blocks the path.
        reason: Blockage,
    },
    /// Too many obstacles have an open view of each other.
    #[error(
        "{file}: {obstacles} obstacles are too many for so open a world: {work}; use fewer obstacles, or fewer corners (a cylinder has none)"
    )]
    TooOpen {
        /// The world file.
        file: String,
        /// The number of obstacles.
        obstacles: usize,
        /// What would take too long.
        work: TooMuch,
    },
    /// A listed option is not walkable.
    #[error(
        "{file}:{line}: option `{option}`: no path leads from {from} to {to} with {clearance} m clear on either side and through no other opening"
    )]
    NotWalkable {
        /// The world file.
        file: String,
        /// Line of the option.
        line: usize,
        /// The option.
        option: String,
        /// Where the impossible leg begins.
        from: String,
        /// Where it ends.
        to: String,
        /// Half of the robot's width, m.
        clearance: f64,
    },
}

/// A part of the search for options that would take too long, or too much memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TooMuch {
    /// Straight lines between corners of obstacles to be tried.
    #[error("{found} straight lines between their corners would have to be tried, and at most {most} are")]
    Tried {
        /// Their number.
        found: u64,
        /// The largest number.
        most: u64,
    },
    /// Straight lines and arcs that paths may follow.
    #[error("paths may follow more than {most} straight lines between their corners")]
    Clear {
        /// The largest number.
        most: u64,
    },
    /// Ends of lines from which paths to the openings are searched.
    #[error("paths to the openings would be searched from {found} places, and at most {most} are")]
    Searched {
        /// Their number.
        found: u64,
        /// The largest number.
        most: u64,
    },
}

/// What blocks every path to a target.
#[derive(Debug, PartialEq)]
pub enum Blockage {
    /// No gap leads to the target.
    Walled,
    /// All gaps are too narrow; this is the widest.
    Gap {
        /// One obstacle.
        first: String,
        /// The other.
        second: String,
        /// Width, m.
        width: f64,
        /// Robot width, m.
        robot_width: f64,
    },
}

impl std::fmt::Display for Blockage {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Walled => write!(f, "obstacles enclose it"),
            Self::Gap { first, second, width, robot_width } => write!(
                f,
                "no opening leads there; the widest gap that is too narrow for the robot ({robot_width} m) is {width:.4} m wide, between `{first}` and `{second}`"
            ),
        }
    }
}

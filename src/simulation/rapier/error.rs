//! Errors in the setup of a physical plant.

use thiserror::Error;

/// The reason why a physical plant was refused.
#[derive(Debug, Error)]
pub enum PhysicsError {
    /// A setting is out of its range.
    #[error("physics: {field} = {value}; it must be from {least} to {most}")]
    Setting {
        /// The setting.
        field: &'static str,
        /// The value found.
        value: f64,
        /// Smallest value allowed.
        least: f64,
        /// Largest value allowed.
        most: f64,
    },
    /// A starting pose that is not finite.
    #[error("physics: the team cannot start at ({x}, {y}) heading {yaw} rad with these joint positions")]
    Start {
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// Heading, rad.
        yaw: f64,
    },
    /// The team does not fit at its start.
    #[error(
        "{file}: at the start, the {part} `{name}` is inside obstacle `{obstacle}`; the team is 2 to 3 m long, with the human ahead of ({x}, {y})"
    )]
    Occupied {
        /// The world file.
        file: String,
        /// `robot`, `object` or `human`.
        part: &'static str,
        /// The name of the part.
        name: String,
        /// The obstacle.
        obstacle: String,
        /// The object's centre, x, m.
        x: f64,
        /// The object's centre, y, m.
        y: f64,
    },
    /// The human has no room at the end of an option.
    #[error(
        "{file}: no room at the target: at the end of option `{option}`, the human walks on to ({x:.3}, {y:.3}) and comes within {distance:.3} m of obstacle `{obstacle}`; leave {needed} m on either side, up to {ahead:.2} m beyond target_m"
    )]
    NoRoomAtTarget {
        /// The world file.
        file: String,
        /// The option.
        option: String,
        /// The human's final position, x, m.
        x: f64,
        /// The human's final position, y, m.
        y: f64,
        /// The obstacle.
        obstacle: String,
        /// Distance between the human's path and the obstacle, m.
        distance: f64,
        /// Distance needed between the human's path and an obstacle, m.
        needed: f64,
        /// How far beyond the target the human walks, m.
        ahead: f64,
    },
}

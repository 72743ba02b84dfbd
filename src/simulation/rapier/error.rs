//! Why a physical plant cannot be set up.

use thiserror::Error;

/// Why a physical plant was refused.
#[derive(Debug, Error)]
pub enum PhysicsError {
    /// A setting is out of its range.
    #[error("physics: {field} = {value}; it must be from {least} to {most}")]
    Setting {
        /// The setting.
        field: &'static str,
        /// The value found.
        value: f64,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
    },
    /// The team was to start at a place that is not a number.
    #[error("physics: the team cannot start at ({x}, {y}) heading {yaw} rad with these joint positions")]
    Start {
        /// m.
        x: f64,
        /// m.
        y: f64,
        /// rad.
        yaw: f64,
    },
    /// The team does not fit where it was to start.
    #[error(
        "{file}: at the start the {part} `{name}` is inside obstacle `{obstacle}`; the team stands 2 to 3 m long, the human ahead of ({x}, {y})"
    )]
    Occupied {
        /// The world file.
        file: String,
        /// `robot`, `object` or `human`.
        part: &'static str,
        /// Which part of it.
        name: String,
        /// The obstacle.
        obstacle: String,
        /// The object's centre, m.
        x: f64,
        /// m.
        y: f64,
    },
    /// The human has no room where an option ends.
    #[error(
        "{file}: no room at the target: where option `{option}` ends, the human walks on to ({x:.3}, {y:.3}) and is {distance:.3} m from obstacle `{obstacle}` on the way; leave {needed} m on either side, as far as {ahead:.2} m beyond target_m"
    )]
    NoRoomAtTarget {
        /// The world file.
        file: String,
        /// The option.
        option: String,
        /// Where the human comes to stand, m.
        x: f64,
        /// m.
        y: f64,
        /// The obstacle.
        obstacle: String,
        /// How near the human comes to it, m.
        distance: f64,
        /// How near the middle of a human may come to an obstacle, m.
        needed: f64,
        /// How far beyond the target the human comes, m.
        ahead: f64,
    },
}

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
}

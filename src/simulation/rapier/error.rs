//! Errors in the setup of a physical plant.

use crate::geometry::Point;
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
    /// The team has no room at the start, at any heading.
    #[error("{}: no room at the start: {}", .0.file, .0.at_start())]
    NoRoomAtStart(NoRoom),
    /// The human has no room at the end of an option.
    #[error(
        "{file}: no room at the target: at the end of option `{option}`, the human walks on to ({x:.3}, {y:.3}) and comes within {distance:.3} m of obstacle `{obstacle}`; leave {needed} m on either side, up to {length:.2} m beyond target_m",
        file = room.file, x = room.x, y = room.y, distance = room.distance, obstacle = room.obstacle, needed = room.needed, length = room.length
    )]
    NoRoomAtTarget {
        /// The option.
        option: String,
        /// The room.
        room: NoRoom,
    },
}

/// A straight way of a carrier that comes too close to an obstacle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NoRoom {
    /// The world file.
    pub file: String,
    /// The end of the way, x, m.
    pub x: f64,
    /// The end of the way, y, m.
    pub y: f64,
    /// The obstacle.
    pub obstacle: String,
    /// Distance between the way and the obstacle, m.
    pub distance: f64,
    /// Distance needed, m.
    pub needed: f64,
    /// How far from `start_m` or `target_m` an obstacle may be in the way, m.
    pub length: f64,
    /// The nearest other start that has room.
    pub nearest: Option<Point>,
}

impl NoRoom {
    /// What is missing at the start, and where to start instead.
    fn at_start(&self) -> String {
        let Self { x, y, distance, obstacle, needed, length, nearest, .. } = self;
        let fault = match needed - distance {
            missing if missing > 0.0 => format!(
                "the robot comes from ({x:.3}, {y:.3}) and passes within {distance:.3} m of obstacle `{obstacle}`; leave {needed} m on either side, up to {length:.2} m behind start_m ({missing:.3} m are missing)"
            ),
            _ => format!("the team fits, but cannot turn onto its path: obstacle `{obstacle}` is too near"),
        };
        match nearest {
            Some(p) => format!("{fault}; the nearest start with room is ({:.2}, {:.2})", p.x, p.y),
            None => fault,
        }
    }
}

//! Notes on a valid robot: what its files lack and what stands in for it.

use thiserror::Error;

/// Something that a user should know about a robot that is valid all the same.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RobotNote {
    /// Meshes of visual shapes that cannot be found or read. Their shapes are not drawn.
    #[error("{count} meshes to draw are missing, the first of them `{first}`: {why}")]
    NotDrawn {
        /// Their number.
        count: usize,
        /// The first as the URDF names it.
        first: String,
        /// Where it was searched for, or why it cannot be read.
        why: String,
    },
    /// A collision mesh that cannot be used.
    #[error("link `{link}`: its collision mesh `{mesh}` has no shape: {why}")]
    NoHull {
        /// The link.
        link: String,
        /// The mesh as the URDF names it.
        mesh: String,
        /// Where it was searched for, or why it cannot be read.
        why: String,
    },
    /// Collision meshes that collide as their convex hulls.
    #[error("collision meshes of {count} links collide as their convex hulls: {links}")]
    Hulls {
        /// The number of links.
        count: usize,
        /// The links.
        links: String,
    },
    /// A collision mesh that fills little of its convex hull, and collides as convex parts.
    #[error(
        "link `{link}`: its collision mesh `{mesh}` fills {percent:.0} % of its convex hull, and collides as \
         {count} convex parts"
    )]
    Parts {
        /// The link.
        link: String,
        /// The mesh as the URDF names it.
        mesh: String,
        /// The share of the hull's volume, %.
        percent: f64,
        /// The number of parts.
        count: usize,
    },
    /// A base that collides as a cylinder or its footprint, because a shape of it is missing.
    #[error("{why}; the base collides as {shape}, {height} m high")]
    Footprint {
        /// The shape that is missing.
        why: String,
        /// What stands in for it.
        shape: &'static str,
        /// Height of that, m.
        height: f64,
    },
    /// A link of the arm that collides as a capsule, because it has no collision shape.
    #[error("link `{link}` has no collision shape; it collides as a capsule of {radius} m radius")]
    Capsule {
        /// The link.
        link: String,
        /// Radius of the capsule, m.
        radius: f64,
    },
    /// Links outside the base and the chain to the grasp that have collision meshes without a shape.
    #[error("left out of collisions: {links}")]
    LeftOut {
        /// The links.
        links: String,
    },
    /// A moving part of the arm without mass.
    #[error("link `{link}` moves but has no mass; the physical plant gives it 10 g")]
    Massless {
        /// The link.
        link: String,
    },
    /// An inertia that no body has, of a link that is rigidly part of a larger body which is sound.
    #[error(
        "link `{link}`: inertia that no body has (least principal moment {least:.2e} kg m^2); the body that it is part of is sound"
    )]
    Inertia {
        /// The link.
        link: String,
        /// Least principal moment, kg m^2.
        least: f64,
    },
    /// A wheel radius or track in the robot file that differs from the URDF's.
    #[error("{key} = {given} replaces {measured:.4} m, as measured in the URDF")]
    Calibrated {
        /// The key.
        key: &'static str,
        /// The value given, m.
        given: f64,
        /// The value measured, m.
        measured: f64,
    },
}

impl RobotNote {
    /// Whether collisions differ from those of the real robot's shapes because a shape is missing.
    pub fn is_about_missing_shapes(&self) -> bool {
        matches!(
            self,
            Self::NoHull { .. } | Self::Footprint { .. } | Self::Capsule { .. } | Self::LeftOut { .. }
        )
    }
}

/// The first few names of a list, each quoted.
pub(super) fn some_of(names: &[&str]) -> String {
    const MOST_NAMES: usize = 6;
    let first = names.iter().take(MOST_NAMES).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

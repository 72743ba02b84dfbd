//! A robot's links, and where each of them is at a [`Configuration`].

use super::{Configuration, Robot};
use crate::geometry::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Unit, Vector3};
use std::path::PathBuf;

/// A rigid part of a robot. Its frame is that of the joint that carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique in its robot.
    pub name: String,
    /// The link that carries it: index into [`Robot::links`], smaller than its own. `None` for the root.
    pub parent: Option<usize>,
    /// The joint between the two. `None` for the root.
    pub joint: Option<Joint>,
    /// Mass and inertia; `None` for a frame without any.
    pub inertial: Option<Inertial>,
    /// What it looks like.
    pub visuals: Vec<Geometry>,
    /// What it touches with.
    pub collisions: Vec<Geometry>,
}

/// What a link hangs on.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique in its robot.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// From the parent link's frame to the joint's at position 0.
    pub parent_from_joint: Pose,
    /// Axis in the joint's frame; x where the joint is fixed.
    pub axis: Unit<Vector3<f64>>,
    /// Limits as the URDF has them.
    pub limits: Limits,
    /// The joint that it follows, if any.
    pub mimic: Option<Mimic>,
    /// Where it is at a configuration: what holds, mimics and the arm's joints make of it.
    pub coupling: Coupling,
}

/// The kinds of joints that a URDF has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Does not move.
    Fixed,
    /// About its axis, between limits.
    Revolute,
    /// About its axis, without end.
    Continuous,
    /// Along its axis, between limits.
    Prismatic,
    /// Free; taken as standing at 0.
    Floating,
    /// In a plane; taken as standing at 0.
    Planar,
    /// About a point; taken as standing at 0.
    Spherical,
}

/// Limits of a joint. All 0 where the URDF gives none; minus infinity to infinity for a continuous joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least position, rad or m.
    pub lower: f64,
    /// Largest position, rad or m.
    pub upper: f64,
    /// Largest rate, rad/s or m/s.
    pub rate: f64,
    /// Largest effort, Nm or N; infinity where the URDF gives none.
    pub effort: f64,
}

/// A joint's position is `ratio * (the other's position) + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// The other joint.
    pub joint: String,
    /// rad or m per rad or m.
    pub ratio: f64,
    /// rad or m.
    pub offset: f64,
}

/// A joint's position is `ratio * (position of an arm joint) + offset`; without an arm joint it stays at `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Index into [`Robot::joints`].
    pub joint: Option<usize>,
    /// 1 for an arm joint itself.
    pub ratio: f64,
    /// rad or m; 0 for an arm joint itself.
    pub offset: f64,
}

/// Mass and inertia of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass, kg.
    pub mass: f64,
    /// `link_from_inertial`: where the centre of mass is, and the axes of `inertia`.
    pub center: Pose,
    /// About the centre of mass, in the inertial frame, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Where it is.
    pub link_from_shape: Pose,
    /// What it is.
    pub shape: Shape,
    /// Red, green, blue and opacity, each 0 to 1, where the URDF gives a colour.
    pub color: Option<[f32; 4]>,
}

/// A shape around its middle. Cylinders and capsules stand along z. Lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box.
    Box {
        /// Along x, y and z.
        size: Vector3<f64>,
    },
    /// A cylinder.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
    },
    /// A cylinder with half a sphere on either end.
    Capsule {
        /// Radius.
        radius: f64,
        /// Length of the cylinder alone.
        length: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A file of triangles.
    Mesh {
        /// The file, which exists.
        file: PathBuf,
        /// Along x, y and z.
        scale: Vector3<f64>,
    },
}

impl JointKind {
    /// What a URDF calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Floating => "floating",
            Self::Planar => "planar",
            Self::Spherical => "spherical",
        }
    }
}

impl Joint {
    /// The parent link's frame from the link's, at a position (rad or m).
    pub fn parent_from_link(&self, position: f64) -> Pose {
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => {
                self.parent_from_joint * Rotation3::from_axis_angle(&self.axis, position)
            }
            JointKind::Prismatic => self.parent_from_joint * Translation3::from(self.axis.scale(position)),
            JointKind::Fixed | JointKind::Floating | JointKind::Planar | JointKind::Spherical => {
                self.parent_from_joint
            }
        }
    }
}

impl Robot {
    /// `world_from_link` for every link, in the order of [`Robot::links`]. Joints that neither move with the arm nor are held or
    /// mimic, the wheels among them, stand at 0.
    pub fn link_poses(&self, q: &Configuration) -> Vec<Pose> {
        let mut root_from_link: Vec<Pose> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let pose = match (link.parent, &link.joint) {
                (Some(parent), Some(joint)) => {
                    let coupling = joint.coupling;
                    let position =
                        coupling.joint.map_or(0.0, |j| coupling.ratio * q.joints[j]) + coupling.offset;
                    root_from_link[parent] * joint.parent_from_link(position)
                }
                _ => Pose::identity(),
            };
            root_from_link.push(pose);
        }
        let world_from_base = q.base.at_height(0.0) * self.drive_from_base;
        let world_from_root = world_from_base * root_from_link[self.base_link].inverse();
        root_from_link.iter().map(|root_from_link| world_from_root * root_from_link).collect()
    }
}

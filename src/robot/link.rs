//! A robot's links and their poses at a [`Configuration`].

use super::{Configuration, Robot};
use crate::geometry::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Unit, Vector3};
use std::path::PathBuf;

/// A rigid part of a robot. Its frame is the frame of its parent joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique in its robot.
    pub name: String,
    /// The parent link: index into [`Robot::links`], smaller than the link's own. `None` for the root.
    pub parent: Option<usize>,
    /// The joint that connects it to its parent. `None` for the root.
    pub joint: Option<Joint>,
    /// Mass and inertia; `None` for a massless frame.
    pub inertial: Option<Inertial>,
    /// Visual geometry.
    pub visuals: Vec<Geometry>,
    /// Collision geometry.
    pub collisions: Vec<Geometry>,
}

/// The joint between a link and its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique in its robot.
    pub name: String,
    /// Kind of joint.
    pub kind: JointKind,
    /// From the parent link's frame to the joint's at position 0.
    pub parent_from_joint: Pose,
    /// Axis in the joint's frame; x where the joint is fixed.
    pub axis: Unit<Vector3<f64>>,
    /// Limits as given in the URDF.
    pub limits: Limits,
    /// The joint that it mimics, if any.
    pub mimic: Option<Mimic>,
    /// Its position at a configuration, as it follows from holds, mimics and the arm's joints.
    pub coupling: Coupling,
}

/// The kinds of joints that a URDF has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// A fixed joint.
    Fixed,
    /// A rotation about its axis, between limits.
    Revolute,
    /// A rotation about its axis, without limits.
    Continuous,
    /// A translation along its axis, between limits.
    Prismatic,
    /// A free joint; treated as fixed at 0.
    Floating,
    /// A motion in a plane; treated as fixed at 0.
    Planar,
    /// A rotation about a point; treated as fixed at 0.
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

/// A mimicking joint: its position is `ratio * (the other's position) + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// The other joint.
    pub joint: String,
    /// Ratio, rad or m per rad or m.
    pub ratio: f64,
    /// Offset, rad or m.
    pub offset: f64,
}

/// The coupling of a joint: its position is `ratio * (position of an arm joint) + offset`. Without an arm
/// joint it stays at `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// The arm joint: index into [`Robot::joints`].
    pub joint: Option<usize>,
    /// Ratio; 1 for an arm joint itself.
    pub ratio: f64,
    /// Offset, rad or m; 0 for an arm joint itself.
    pub offset: f64,
}

/// Mass and inertia of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass, kg.
    pub mass: f64,
    /// `link_from_inertial`: the centre of mass and the axes of `inertia`.
    pub center: Pose,
    /// Inertia about the centre of mass, in the inertial frame, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Pose of the shape in the link's frame.
    pub link_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
    /// Red, green, blue and opacity, each 0 to 1; `None` where the URDF gives no colour.
    pub color: Option<[f32; 4]>,
}

/// A shape around its centre. Cylinders and capsules are aligned with z. Lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box.
    Box {
        /// Size along x, y and z.
        size: Vector3<f64>,
    },
    /// A cylinder.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
    },
    /// A cylinder with a hemisphere on either end.
    Capsule {
        /// Radius.
        radius: f64,
        /// Length of the cylinder without the hemispheres.
        length: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A triangle mesh.
    Mesh {
        /// The file. That of a visual shape exists.
        file: PathBuf,
        /// Scale along x, y and z.
        scale: Vector3<f64>,
        /// Vertices of the convex hull of the mesh, or of a part of it, m; empty where there is none, as for
        /// visual shapes.
        hull: Vec<Vector3<f64>>,
    },
}

impl JointKind {
    /// The name in a URDF.
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
    /// The pose of the link's frame in the parent link's frame at a joint position (rad or m).
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
    /// Whether the visual shape of any link is a mesh.
    pub fn has_visual_meshes(&self) -> bool {
        let mut visuals = self.links.iter().flat_map(|link| &link.visuals);
        visuals.any(|geometry| matches!(geometry.shape, Shape::Mesh { .. }))
    }

    /// `world_from_link` for every link, in the order of [`Robot::links`]. Joints outside the arm that are
    /// neither held nor mimic another stay at 0; so do the wheels.
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

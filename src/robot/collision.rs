//! Shapes in place of collision shapes that are missing, and the check of inertias on merged bodies.

use super::link::{Geometry, Inertial, Link, Shape};
use super::urdf::Urdf;
use super::warning::{RobotWarning, WarningKind, some_of};
use super::{Configuration, JointVector, Robot};
use crate::error::Error;
use crate::geometry::{PlanarPose, Point, Pose};
use crate::math;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::path::PathBuf;

/// Height of the cylinder or prism in place of a base's shape, m. It ends below the objects that robots carry.
const FOOTPRINT_HEIGHT_M: f64 = 0.3;
/// Radius of the capsules in place of shapes of the arm, m.
const CAPSULE_RADIUS_M: f64 = 0.05;

/// Whether the physics can use a shape.
fn is_usable(geometry: &Geometry) -> bool {
    !matches!(&geometry.shape, Shape::Mesh { hull, .. } if hull.is_empty())
}

/// For every link, the link whose joint moves the body that it is part of: the link itself, one above it, or
/// the base. No other joint between the two moves with the arm.
pub(super) fn bodies(robot: &Robot) -> Vec<usize> {
    let mut body: Vec<usize> = Vec::with_capacity(robot.links.len());
    for (i, link) in robot.links.iter().enumerate() {
        let moves = link.joint.as_ref().is_some_and(|joint| joint.coupling.joint.is_some());
        let above = link.parent.map_or(robot.base_link, |parent| body[parent]);
        body.push(if moves { i } else { above });
    }
    body
}

/// Gives shapes to the base and to moving links of the chain that have none, and returns warnings about them.
/// A base with any mesh that is missing gets its `footprint`, or a cylinder, besides its other shapes.
pub(super) fn complete(robot: &mut Robot, footprint: Option<&[Point]>) -> Vec<RobotWarning> {
    let mut warnings = Vec::new();
    let body = bodies(robot);
    let of_body = |robot: &Robot, at: usize| -> Vec<usize> {
        (0..robot.links.len())
            .filter(|&i| body[i] == at && !robot.wheels.iter().any(|wheel| wheel.link == i))
            .collect()
    };
    let shapes = |robot: &Robot, at: usize| {
        of_body(robot, at).into_iter().flat_map(|i| robot.links[i].collisions.clone()).collect::<Vec<_>>()
    };
    let missing: Vec<&Link> = of_body(robot, robot.base_link)
        .into_iter()
        .map(|i| &robot.links[i])
        .filter(|link| !link.collisions.iter().all(is_usable))
        .collect();
    if !has_shapes(robot) || !missing.is_empty() {
        let names: Vec<&str> = missing.iter().map(|link| link.name.as_str()).collect();
        let why = match names.is_empty() {
            true => format!("`{}` has no collision shape", robot.links[robot.base_link].name),
            false => format!("the base lacks collision meshes of {}", some_of(&names)),
        };
        let (shape, named) = match footprint {
            Some(corners) => (prism(corners), "its base_footprint"),
            None => {
                let shape = Shape::Cylinder { radius: robot.width() / 2.0, length: FOOTPRINT_HEIGHT_M };
                (shape, "a cylinder as wide as base_width_m")
            }
        };
        let drive_from_shape = Pose::translation(0.0, 0.0, FOOTPRINT_HEIGHT_M / 2.0 + 0.01);
        let link_from_shape = robot.drive_from_base.inverse() * drive_from_shape;
        let base = robot.base_link;
        robot.links[base].collisions.push(Geometry { link_from_shape, shape, color: None });
        warnings.push(RobotWarning::of_kind(
            WarningKind::MissingBaseShape,
            format!("{why}; the base collides as {named}, {FOOTPRINT_HEIGHT_M} m high"),
        ));
    }
    let mut path: Vec<usize> = std::iter::successors(Some(robot.grasp_link), |&at| robot.links[at].parent)
        .take_while(|&at| at != robot.base_link)
        .collect();
    path.reverse();
    let zero = Configuration {
        base: PlanarPose { position: Point::origin(), yaw: 0.0 },
        joints: JointVector::zeros(),
    };
    let poses = robot.link_poses(&zero);
    let moving: Vec<usize> = path.iter().copied().filter(|&i| body[i] == i).collect();
    for (n, &at) in moving.iter().enumerate() {
        let next = moving.get(n + 1).copied().unwrap_or(robot.grasp_link);
        let own = shapes(robot, at);
        let along = (poses[at].inverse() * poses[next]).translation.vector;
        let length = along.norm();
        if own.iter().any(is_usable) || (own.is_empty() && length < CAPSULE_RADIUS_M) {
            continue;
        }

        let turn = Rotation3::rotation_between(&Vector3::z(), &along).unwrap_or_else(|| {
            // straight down, or no length at all
            Rotation3::from_axis_angle(
                &Vector3::x_axis(),
                if along.z < 0.0 { std::f64::consts::PI } else { 0.0 },
            )
        });
        let shape = match length > 1e-3 {
            true => Shape::Capsule { radius: CAPSULE_RADIUS_M, length },
            false => Shape::Sphere { radius: CAPSULE_RADIUS_M },
        };
        let link_from_shape = Pose::from_parts((along / 2.0).into(), turn);
        robot.links[at].collisions.push(Geometry { link_from_shape, shape, color: None });
        warnings.push(RobotWarning::of_kind(
            WarningKind::MissingShape,
            format!(
                "link `{}` has no collision shape; it collides as a capsule of {CAPSULE_RADIUS_M} m radius",
                robot.links[at].name
            ),
        ));
    }
    let is_told = |i: usize| body[i] == robot.base_link || moving.contains(&i);
    let left_out: Vec<&str> = (0..robot.links.len())
        .filter(|&i| !is_told(i) && !robot.links[i].collisions.iter().all(is_usable))
        .map(|i| robot.links[i].name.as_str())
        .collect();
    if !left_out.is_empty() {
        let text = format!("left out of collisions: {}", some_of(&left_out));
        warnings.push(RobotWarning::of_kind(WarningKind::MissingShape, text));
    }
    warnings
}

/// Whether the base has a collision shape that the physics can use, besides its wheels.
pub(super) fn has_shapes(robot: &Robot) -> bool {
    let body = bodies(robot);
    let is_base = |i: usize| body[i] == robot.base_link && !robot.wheels.iter().any(|w| w.link == i);
    (0..robot.links.len()).filter(|&i| is_base(i)).any(|i| robot.links[i].collisions.iter().any(is_usable))
}

/// An upright prism over these corners around its middle, as a hull.
fn prism(corners: &[Point]) -> Shape {
    let ends = [-0.5, 0.5].map(|end| end * FOOTPRINT_HEIGHT_M);
    let hull = ends.iter().flat_map(|&z| corners.iter().map(move |c| Vector3::new(c.x, c.y, z))).collect();
    Shape::Mesh { file: PathBuf::new(), scale: Vector3::repeat(1.0), hull }
}

/// The check of inertias and masses on the bodies that move as one. A link whose inertia no body has is a
/// fault only if its body's is not possible either.
pub(super) fn check_inertias(urdf: Urdf, robot: &Robot) -> (Vec<Error>, Vec<RobotWarning>) {
    let (mut faults, mut warnings) = (Vec::new(), Vec::new());
    let body = bodies(robot);
    let zero = Configuration {
        base: PlanarPose { position: Point::origin(), yaw: 0.0 },
        joints: JointVector::zeros(),
    };
    let poses = robot.link_poses(&zero);
    let is_possible = |inertia: &Matrix3<f64>| least(inertia) >= -1e-9 * inertia.amax();
    for at in 0..robot.links.len() {
        let members: Vec<usize> = (0..robot.links.len()).filter(|&i| body[i] == at).collect();
        let own = |i: usize| robot.links[i].inertial;
        if members.is_empty() {
            continue;
        }
        let massless = members.iter().filter_map(|&i| own(i)).all(|inertial| inertial.mass <= 0.0);
        let has_arm = robot.links[at].joint.as_ref().is_some_and(|j| j.coupling.joint.is_some());
        if massless && has_arm && at != robot.base_link {
            let link = &robot.links[at].name;
            warnings.push(RobotWarning::new(format!(
                "link `{link}` moves but has no mass; the physical plant gives it 10 g"
            )));
        }
        let bad = members.iter().filter_map(|&i| Some((i, own(i)?)));
        let bad: Vec<(usize, Inertial)> =
            bad.filter(|(_, inertial)| !is_possible(&inertial.inertia)).collect();
        if bad.is_empty() {
            continue;
        }
        let merged = is_possible(&merged(robot, &poses, &members));
        for (i, inertial) in bad {
            let (link, least) = (&robot.links[i].name, least(&inertial.inertia));
            match merged {
                true => warnings.push(RobotWarning::new(format!(
                    "link `{link}`: inertia that no body has (least principal moment {least:.2e} kg m^2); the body that it is part of is sound"
                ))),
                false => faults.push(Error::number(
                    urdf.place(format!("link `{link}`")),
                    "least principal moment of inertia",
                    least,
                    "at least 0",
                )),
            }
        }
    }
    (faults, warnings)
}

/// The least principal moment of an inertia.
fn least(inertia: &Matrix3<f64>) -> f64 {
    inertia.symmetric_eigenvalues().min()
}

/// The inertia of some links as one body, about its centre of mass, in world axes.
fn merged(robot: &Robot, poses: &[Pose], members: &[usize]) -> Matrix3<f64> {
    let bodies: Vec<(Inertial, Pose)> =
        members.iter().filter_map(|&i| Some((robot.links[i].inertial?, poses[i]))).collect();
    let mass: f64 = bodies.iter().map(|(b, _)| b.mass).sum();
    let at = |b: &Inertial, pose: &Pose| (pose * b.center).translation.vector;
    let moment: Vector3<f64> = bodies.iter().map(|(b, pose)| at(b, pose) * b.mass).sum();
    let center = if mass > 0.0 { moment / mass } else { Vector3::zeros() };
    let mut inertia = Matrix3::zeros();
    for (b, pose) in &bodies {
        let turn = (pose * b.center).rotation;
        let offset = at(b, pose) - center;
        let shift = Matrix3::identity() * offset.norm_squared() - offset * offset.transpose();
        inertia += turn.matrix() * b.inertia * turn.matrix().transpose() + shift * b.mass;
    }
    inertia
}

/// The collision shapes of the base and of all that is rigid with it, wheels included, with their poses in the
/// drive's frame.
pub(super) fn base_shapes(robot: &Robot) -> Vec<(Pose, &Shape)> {
    let body = bodies(robot);
    let zero = Configuration {
        base: PlanarPose { position: Point::origin(), yaw: 0.0 },
        joints: JointVector::zeros(),
    };
    let poses = robot.link_poses(&zero);
    let links = (0..robot.links.len()).filter(|&i| body[i] == robot.base_link);
    let shapes = links.flat_map(|i| robot.links[i].collisions.iter().map(move |g| (i, g)));
    shapes.map(|(i, g)| (poses[i] * g.link_from_shape, &g.shape)).collect()
}

/// The largest distance from the drive's frame of the base's collision shapes, seen from above, m; `None`
/// without shapes. Wheels count.
pub(super) fn base_extent(robot: &Robot) -> Option<f64> {
    let distances = base_shapes(robot).into_iter().flat_map(|(at, shape)| {
        corners(shape).into_iter().map(move |(corner, radius)| {
            let p = at * nalgebra::Point3::from(corner);
            math::hypot(p.x, p.y) + radius
        })
    });
    distances.reduce(f64::max)
}

/// Points of a shape in its frame, each with a radius around it; their hull is the shape or holds it.
pub(super) fn corners(shape: &Shape) -> Vec<(Vector3<f64>, f64)> {
    let signs = |half: Vector3<f64>| -> Vec<(Vector3<f64>, f64)> {
        let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        (0..8).map(|i| (half.component_mul(&Vector3::new(sign(i, 0), sign(i, 1), sign(i, 2))), 0.0)).collect()
    };
    match shape {
        Shape::Box { size } => signs(size / 2.0),
        Shape::Cylinder { radius, length } => (0..16)
            .flat_map(|i| {
                let turn = std::f64::consts::TAU * i as f64 / 16.0;
                [-0.5, 0.5].map(|end| {
                    (Vector3::new(radius * math::cos(turn), radius * math::sin(turn), end * length), 0.0)
                })
            })
            .collect(),
        Shape::Capsule { radius, length } => {
            [-0.5, 0.5].map(|end| (Vector3::new(0.0, 0.0, end * length), *radius)).to_vec()
        }
        Shape::Sphere { radius } => vec![(Vector3::zeros(), *radius)],
        Shape::Mesh { hull, .. } => hull.iter().map(|v| (*v, 0.0)).collect(),
    }
}

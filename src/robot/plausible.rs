//! Warnings about values of a URDF that are possible but hardly meant, with their likely cause: other units.

use super::collision::bodies;
use super::link::{Geometry, Link, Shape};
use super::solid;
use super::warning::{RobotWarning, first_few, some_of};
use super::{ArmJoint, Motion, Robot};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// The largest mass of a link, kg, without a warning: of the arm, and of the base.
const MAX_ARM_LINK_KG: f64 = 100.0;
const MAX_BASE_LINK_KG: f64 = 1000.0;
/// The largest angle of a limit without a warning, rad: two turns.
const MAX_ANGLE_RAD: f64 = 4.0 * PI;
/// The largest size of a shape without a warning, m.
const MAX_SIZE_M: f64 = 5.0;
/// The largest distance of a joint from its link's frame without a warning, m.
const MAX_OFFSET_M: f64 = 20.0;
/// The share of a mesh's longest side below which a side is flat.
const FLAT: f64 = 1e-3;

/// The warnings about a robot.
pub(super) fn warnings(robot: &Robot) -> Vec<RobotWarning> {
    let sentences =
        [masses(robot), inertias(robot), limits(&robot.joints), sizes(&robot.links), offsets(&robot.links)];
    sentences.into_iter().flatten().map(RobotWarning::new).collect()
}

/// Names and values of what exceeds its limit, the first few; `None` without any.
fn listed<'n>(found: impl Iterator<Item = (&'n str, String)>) -> Option<String> {
    let found: Vec<String> = found.map(|(name, value)| format!("`{name}` ({value})")).collect();
    (!found.is_empty()).then(|| first_few(&found))
}

fn masses(robot: &Robot) -> Option<String> {
    let body = bodies(robot);
    let limit = |i: usize| if body[i] == robot.base_link { MAX_BASE_LINK_KG } else { MAX_ARM_LINK_KG };
    let heavy = listed(robot.links.iter().enumerate().filter_map(|(i, link)| {
        let mass = link.inertial?.mass;
        (mass > limit(i)).then(|| (link.name.as_str(), format!("{mass} kg")))
    }))?;
    Some(format!("links of a mass that is hardly meant: {heavy}; a URDF has kg, not g"))
}

fn inertias(robot: &Robot) -> Option<String> {
    let impossible = listed(robot.links.iter().filter_map(|link| {
        let [largest, others] = solid::impossible(&link.inertial?.inertia)?;
        Some((link.name.as_str(), format!("{largest:.3e} > {others:.3e} kg m^2")))
    }))?;
    Some(format!(
        "links with an inertia that no body has, as its largest principal moment exceeds the sum of the two others: {impossible}; it is used as it is"
    ))
}

fn limits(joints: &[ArmJoint]) -> Option<String> {
    let turns = joints.iter().filter(|joint| joint.motion == Motion::Revolute);
    let wide = listed(turns.filter_map(|joint| {
        let largest = [joint.lower, joint.upper].into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let is_wide = largest.is_finite() && largest.abs() > MAX_ANGLE_RAD;
        is_wide.then(|| (joint.name.as_str(), format!("{largest} rad")))
    }))?;
    Some(format!("joints with limits of more than two turns: {wide}; a URDF has rad, not degrees"))
}

/// Sizes of a shape along its axes, m.
fn size(shape: &Shape) -> Vector3<f64> {
    match shape {
        Shape::Box { size } => *size,
        Shape::Cylinder { radius, length } => Vector3::new(2.0 * radius, 2.0 * radius, *length),
        Shape::Capsule { radius, length } => Vector3::new(2.0 * radius, 2.0 * radius, length + 2.0 * radius),
        Shape::Sphere { radius } => Vector3::repeat(2.0 * radius),
        Shape::Mesh { hull, .. } => extent(hull.iter().copied()),
    }
}

/// Sizes of the box around points, m.
pub(super) fn extent(points: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let ends = points.fold(None, |ends: Option<[Vector3<f64>; 2]>, p| {
        Some(ends.map_or([p, p], |[low, high]| [low.inf(&p), high.sup(&p)]))
    });
    ends.map_or_else(Vector3::zeros, |[low, high]| high - low)
}

fn sizes(links: &[Link]) -> Option<String> {
    let largest = |link: &Link| {
        let shapes = link.visuals.iter().chain(&link.collisions).map(|Geometry { shape, .. }| size(shape));
        shapes.max_by(|a, b| a.amax().total_cmp(&b.amax()))
    };
    let large = listed(links.iter().filter_map(|link| {
        let size = largest(link).filter(|size| size.amax() > MAX_SIZE_M)?;
        Some((link.name.as_str(), in_metres(&size)))
    }))?;
    Some(format!(
        "links with shapes of more than {MAX_SIZE_M} m: {large}; a URDF has m, and a mesh in mm needs scale=\"0.001 0.001 0.001\""
    ))
}

fn offsets(links: &[Link]) -> Option<String> {
    let far = listed(links.iter().filter_map(|link| {
        let joint = link.joint.as_ref()?;
        let offset = joint.parent_from_joint.translation.vector.amax();
        (offset > MAX_OFFSET_M).then(|| (joint.name.as_str(), format!("{offset} m")))
    }))?;
    Some(format!("joints with an origin that is hardly meant: {far}; a URDF has m, not mm"))
}

/// A size for a sentence.
fn in_metres(size: &Vector3<f64>) -> String {
    format!("{} x {} x {} m", rounded(size.x), rounded(size.y), rounded(size.z))
}

/// A number to three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The remark on a mesh that its scale makes flat or very small. Its `size` in its file's units is known of
/// meshes that collide.
pub(super) fn about_scale(size: Option<Vector3<f64>>, scale: &Vector3<f64>) -> Option<String> {
    /// The largest side of a mesh that is too small to be meant, m.
    const SMALL_M: f64 = 1e-3;
    let is_flat = |size: Vector3<f64>| size.amin() < FLAT * size.amax();
    let given = format!("{} {} {}", scale.x, scale.y, scale.z);
    let Some(size) = size else {
        return is_flat(scale.abs()).then(|| format!("is flattened by its scale {given}"));
    };
    let scaled = size.component_mul(&scale.abs());
    let metres = in_metres(&scaled);
    if is_flat(scaled) && !is_flat(size) {
        return Some(format!("is flattened by its scale {given}, to {metres}"));
    }
    let is_small = scaled.amax() < SMALL_M && size.amax() >= SMALL_M;
    is_small.then(|| format!("is {metres} large with its scale {given}: is it scaled twice?"))
}

/// The warning about joints of the arm that share something.
pub(super) fn about_joints(names: &[&str], what: &str) -> Option<RobotWarning> {
    (!names.is_empty()).then(|| RobotWarning::new(format!("joints of the arm {what}: {}", some_of(names))))
}

//! The wheels of a URDF, found by what they are and by their names.

use super::draft_tree::{carrier, independent, is_within, link_says, moving, shapes, upward};
use super::hull;
use super::link::{Geometry, Joint, JointKind, Link, Shape};
use crate::geometry::Pose;
use crate::math;
use nalgebra::{Point3, Vector3};

/// Parts of the names of wheels whose rollers let a base move in any direction, and of their meshes.
const ROLLING_SIDEWAYS: [&str; 4] = ["mecanum", "omni_wheel", "omniwheel", "swedish"];
/// Words in the names of wheels that roll freely.
const ROLLING_FREELY: [&str; 6] = ["caster", "castor", "passive", "swivel", "idler", "trailing"];
/// Largest difference in height of wheels of one size, m.
const SAME_HEIGHT_M: f64 = 5e-3;
/// The least range of a revolute joint that is a wheel's: exporters write a turn, or far too much, rad.
const MIN_WHEEL_RANGE: f64 = 6.2;
/// A wheel so near to the vertical axis of the joint above is steered by it, m. Farther off, two wheels steer
/// themselves on a turntable.
const STEERED_M: f64 = 0.12;
/// The least component of an axis along another to be parallel to it, and the largest of one across.
const PARALLEL: f64 = 0.999;
const ACROSS: f64 = 0.02;

/// Poses of the links in the root's frame with all joints at 0.
pub(super) fn poses(links: &[Link]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::with_capacity(links.len());
    for link in links {
        poses.push(match (link.parent, &link.joint) {
            (Some(parent), Some(joint)) => poses[parent] * joint.parent_from_joint,
            _ => Pose::identity(),
        });
    }
    poses
}

/// Whether a joint turns as a wheel's does: without limits, or by a turn and more.
pub(super) fn turns_freely(joint: &Joint) -> bool {
    let range = joint.limits.upper - joint.limits.lower;
    joint.kind == JointKind::Continuous || joint.kind == JointKind::Revolute && range >= MIN_WHEEL_RANGE
}

/// The axis of a link's joint in the root's frame.
fn axis(joint: &Joint, pose: &Pose) -> Vector3<f64> {
    pose.rotation * joint.axis.into_inner()
}

/// The joint of a link that may be a driven wheel: it turns freely, rolls nowhere by its name, and nothing
/// moves below it. A joint that is revolute must be named as a wheel.
fn rolling(links: &[Link], i: usize) -> Option<&Joint> {
    let joint = independent(links, i).filter(|joint| turns_freely(joint))?;
    let is_named = joint.kind == JointKind::Continuous || is_named(links, i);
    (is_named && !link_says(links, i, &ROLLING_FREELY) && !has_moving(links, i)).then_some(joint)
}

/// Whether names say that a link is a wheel.
pub(super) fn is_named(links: &[Link], i: usize) -> bool {
    link_says(links, i, &["wheel", "wheels"])
}

/// Whether a link turns without limits about the root's y axis, off its x axis, and is not a caster's.
pub(super) fn is_wheel(links: &[Link], poses: &[Pose], i: usize) -> bool {
    let turns = |joint: &Joint| axis(joint, &poses[i]).y.abs() > PARALLEL;
    rolling(links, i).is_some_and(turns) && poses[i].translation.y.abs() > 0.02
}

/// Whether a link is named as a wheel, or one that rolls sideways, and turns about any level axis.
pub(super) fn is_level_wheel(links: &[Link], poses: &[Pose], i: usize) -> bool {
    let is_named = is_named(links, i) || is_mecanum(links, i);
    is_named && rolling(links, i).is_some_and(|joint| axis(joint, &poses[i]).z.abs() < ACROSS)
}

/// The direction of a wheel's axis in the plane, rad, up to half a turn.
pub(super) fn direction(links: &[Link], poses: &[Pose], i: usize) -> f64 {
    let axis = moving(links, i).map_or(Vector3::y(), |joint| axis(joint, &poses[i]));
    math::atan2(axis.y, axis.x).rem_euclid(std::f64::consts::PI)
}

/// The link whose joint steers a wheel: the next one above that moves, if that turns about a vertical axis
/// close to the wheel.
pub(super) fn steering(links: &[Link], poses: &[Pose], i: usize) -> Option<usize> {
    let above = above(links, poses, i)?;
    let lever = poses[i].translation.vector - poses[above].translation.vector;
    (math::hypot(lever.x, lever.y) < STEERED_M).then_some(above)
}

/// The link of a turntable under the robot that carries all of these wheels, which steer by their speeds.
pub(super) fn turntable(links: &[Link], poses: &[Pose], wheels: &[usize]) -> Option<usize> {
    let table = above(links, poses, *wheels.first()?)?;
    let is_free = links[table].joint.as_ref().is_some_and(turns_freely);
    (is_free && wheels.iter().all(|&wheel| above(links, poses, wheel) == Some(table))).then_some(table)
}

/// The next link above whose joint moves, if that turns about a vertical axis.
fn above(links: &[Link], poses: &[Pose], i: usize) -> Option<usize> {
    let above = upward(links, i).skip(1).find(|&at| moving(links, at).is_some())?;
    let joint = moving(links, above).filter(|joint| joint.kind != JointKind::Prismatic)?;
    (axis(joint, &poses[above]).z.abs() > PARALLEL).then_some(above)
}

/// Whether a joint moves below a link, as below the joints of arms.
fn has_moving(links: &[Link], at: usize) -> bool {
    (at + 1..links.len()).any(|i| {
        let moves = links[i].joint.as_ref().is_some_and(|j| j.kind != JointKind::Fixed);
        // a mecanum wheel is a wheel
        let moves = moves && !links[i].name.to_lowercase().contains("roller");
        moves && upward(links, i).skip(1).any(|p| p == at)
    })
}

/// Whether names say that a link is a mecanum or omnidirectional wheel, or it has rollers.
pub(super) fn is_mecanum(links: &[Link], i: usize) -> bool {
    let says = |name: &str| ROLLING_SIDEWAYS.iter().any(|part| name.to_lowercase().contains(part));
    let mut meshes = shapes(&links[i]).filter_map(|geometry| match &geometry.shape {
        Shape::Mesh { file, .. } => file.file_name().map(|name| name.to_string_lossy()),
        _ => None,
    });
    let rollers = links.iter().filter(|link| {
        let turns = link.joint.as_ref().is_some_and(|j| j.kind == JointKind::Continuous);
        turns && link.parent == Some(i) && link.name.to_lowercase().contains("roller")
    });
    says(&links[i].name)
        || links[i].joint.as_ref().is_some_and(|joint| says(&joint.name))
        || meshes.any(|name| says(&name))
        || rollers.count() >= 4
}

/// The wheels besides those named that are of the same size and may be driven.
pub(super) fn others(links: &[Link], named: &[usize]) -> Vec<usize> {
    let poses = poses(links);
    let height = |i: usize| poses[i].translation.z;
    let is_of_size = |i: usize| named.iter().any(|&other| (height(i) - height(other)).abs() < SAME_HEIGHT_M);
    (0..links.len()).filter(|&i| !named.contains(&i) && is_wheel(links, &poses, i) && is_of_size(i)).collect()
}

/// The cylinder or sphere of the largest radius, and that radius.
pub(super) fn round(shapes: &[Geometry]) -> Option<(&Geometry, f64)> {
    let round = shapes.iter().filter_map(|g| match g.shape {
        Shape::Cylinder { radius, .. } | Shape::Sphere { radius } => Some((g, radius)),
        _ => None,
    });
    round.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The radius of a wheel as its shapes show it, m: of a cylinder or sphere, or the largest distance of a mesh
/// from the axis.
pub(super) fn radius(links: &[Link], poses: &[Pose], wheel: usize) -> Option<f64> {
    let own = round(&links[wheel].collisions).or_else(|| round(&links[wheel].visuals));
    own.map(|(_, radius)| radius).or_else(|| mesh_radius(links, poses, wheel))
}

/// The largest distance of a wheel's meshes from its axis, m.
pub(super) fn mesh_radius(links: &[Link], poses: &[Pose], wheel: usize) -> Option<f64> {
    let axis = links[wheel].joint.as_ref()?.axis;
    // a tyre may be fixed to its hub
    let is_rigid = |i: usize| is_within(links, i, wheel) && carrier(links, 0, i) == wheel;
    let rigid = (wheel..links.len()).filter(|&i| is_rigid(i));
    let of_link = |i: usize| {
        let wheel_from_link = poses[wheel].inverse() * poses[i];
        let mut radii = shapes(&links[i]).filter_map(|geometry| {
            let Shape::Mesh { file, scale, .. } = &geometry.shape else { return None };
            let vertices = hull::vertices(file).ok()?;
            let distance = |v: &[f64; 3]| {
                let at = Point3::from(Vector3::from(*v).component_mul(scale));
                axis.cross(&(wheel_from_link * geometry.link_from_shape * at).coords).norm()
            };
            vertices.iter().map(distance).reduce(f64::max)
        });
        radii.next()
    };
    rigid.filter_map(of_link).reduce(f64::max)
}

//! The wheels of a URDF, found by what they are and by their names.

use super::link::{JointKind, Link, Shape};
use crate::geometry::Pose;

/// Parts of the names of wheels whose rollers let a base move in any direction, and of their meshes.
const ROLLING_SIDEWAYS: [&str; 4] = ["mecanum", "omni_wheel", "omniwheel", "swedish"];
/// Largest difference in height of wheels of one size, m.
const SAME_HEIGHT_M: f64 = 5e-3;

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

/// Whether a link turns without limits about the root's y axis, off its x axis, and is not a caster's.
pub(super) fn is_wheel(links: &[Link], poses: &[Pose], i: usize) -> bool {
    let Some(joint) = &links[i].joint else { return false };
    let axis = poses[i].rotation * joint.axis.into_inner();
    let is_named =
        |part: &str| joint.name.to_lowercase().contains(part) || links[i].name.to_lowercase().contains(part);
    joint.kind == JointKind::Continuous
        && joint.mimic.is_none()
        && axis.y.abs() > 0.999
        && poses[i].translation.y.abs() > 0.02
        && !is_named("caster")
        && !has_moving(links, i)
}

/// Whether a joint moves below a link, as below the joints of arms.
fn has_moving(links: &[Link], at: usize) -> bool {
    (at + 1..links.len()).any(|i| {
        let above = std::iter::successors(links[i].parent, |&p| links[p].parent);
        let moves = links[i].joint.as_ref().is_some_and(|j| j.kind != JointKind::Fixed);
        // a mecanum wheel is a wheel
        let moves = moves && !links[i].name.to_lowercase().contains("roller");
        moves && above.into_iter().any(|p| p == at)
    })
}

/// Whether names say that a link is a mecanum or omnidirectional wheel, or it has rollers.
pub(super) fn is_mecanum(links: &[Link], i: usize) -> bool {
    let says = |name: &str| ROLLING_SIDEWAYS.iter().any(|part| name.to_lowercase().contains(part));
    let shapes = links[i].collisions.iter().chain(&links[i].visuals);
    let mut meshes = shapes.filter_map(|geometry| match &geometry.shape {
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

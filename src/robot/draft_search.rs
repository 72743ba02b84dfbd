//! The base, the driven wheels and the tool of a URDF, found by what they are and then by their names.

use super::draft_drive::{Found, common, drive, joint_name, standing};
use super::draft_request::DraftRequest;
use super::link::{Joint, JointKind, Link, Shape};
use super::wheel_search::poses;
use super::{MAX_JOINTS, hull};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::BTreeSet;

/// The parts found in a URDF.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub base: String,
    pub tool: String,
    /// The keys of the drive, a line each.
    pub drive: Vec<String>,
    /// Radius of the wheels where the loader would not find it, m.
    pub radius: Option<f64>,
    /// Assumed rate limit of the wheels where the URDF gives none, rad/s.
    pub rate: Option<f64>,
    /// Entries under `[hold]`, a line each: the joints between the base and its wheels.
    pub holds: Vec<String>,
    /// The grasp's axes in the tool's frame: x along the arm's end.
    pub tool_from_grasp: Rotation3<f64>,
    pub assumed: Vec<String>,
}

/// Speed of a base whose wheels have no limit, m/s.
const ASSUMED_SPEED: f64 = 1.0;
/// Parts of the names of tools, the likeliest first.
const TOOLS: [&str; 11] = [
    "grasping_frame",
    "grasp",
    "tcp",
    "tool",
    "end_effector",
    "ee_link",
    "gripper_link",
    "gripper",
    "palm",
    "hand",
    "wrist",
];
/// The most prismatic joints of an arm: a lift, and a telescope of four.
const MAX_SLIDES: usize = 5;
/// Words in the names of links at an arm's end that do not hold an object.
const NO_TOOLS: [&str; 16] = [
    "finger", "thumb", "index", "middle", "ring", "little", "camera", "optical", "sensor", "safety", "ft",
    "laser", "imu", "head", "screw", "led",
];

/// Finds the parts. Names that the request gives are taken as they are.
pub(super) fn find(file: &str, links: &[Link], request: &DraftRequest) -> Result<Parts, Error> {
    let poses = poses(links);
    let mut assumed = Vec::new();
    let drive = drive(file, links, &poses, request, &mut assumed)?;
    let wheels = drive.wheels();
    let base = match wheels[..] {
        [] => standing(links),
        _ => common(links, &wheels),
    };
    assumed.push(format!("the base is `{}`, with x ahead", links[base].name));
    let tool = match &request.tool {
        // an unknown name is an error of the robot file
        Some(name) => links.iter().position(|l| l.name == *name).unwrap_or(base),
        None => tool(links, base, &wheels).ok_or_else(|| {
            let base = &links[base].name;
            Error::at(
                Place::file(file),
                format_args!(
                    "no arm of 1 to 8 moving joints descends from `{base}`; name its last link with --tool"
                ),
            )
        })?,
    };
    let tool_name = request.tool.clone().unwrap_or_else(|| links[tool].name.clone());
    if request.tool.is_none() {
        assumed.push(format!("the tool is `{tool_name}` (--tool)"));
    }
    let (tool_from_grasp, axis) = approach(links, &poses, base, tool);
    assumed.push(format!("the tool points along its {axis} axis, which becomes the grasp's x"));
    let measurable = |i: usize| {
        let shapes = links[i].collisions.iter().chain(&links[i].visuals);
        shapes.into_iter().any(|g| matches!(g.shape, Shape::Cylinder { .. } | Shape::Sphere { .. }))
    };
    let radius = match wheels.first() {
        Some(&wheel) if !measurable(wheel) => Some(mesh_radius(&links[wheel]).ok_or_else(|| {
            let wheel = joint_name(links, wheel);
            Error::at(
                Place::file(file),
                format_args!(
                    "the radius of `{wheel}` cannot be measured: it has no shape; give one in the URDF"
                ),
            )
        })?),
        _ => None,
    };
    let has_rate = wheels.iter().all(|&wheel| {
        links[wheel].joint.as_ref().is_some_and(|j| j.limits.rate > 0.0 && j.limits.rate.is_finite())
    });
    let needs_rate = !matches!(drive, Found::Omnidirectional { .. }) && !has_rate;
    let rate = needs_rate.then(|| ASSUMED_SPEED / radius.unwrap_or(0.1));
    if rate.is_some() {
        assumed.push("the URDF does not limit the wheels' rate; it is assumed".to_owned());
    }
    let suspension = suspension(links, base, &wheels);
    if !suspension.is_empty() {
        let names = suspension.iter().map(|joint| format!("`{}`", joint.name)).collect::<Vec<_>>().join(", ");
        assumed.push(format!("the wheels' suspension stays fixed: {names} (under [hold])"));
    }
    let holds = suspension.into_iter().map(held).collect();
    let base = links[base].name.clone();
    let drive = drive.keys(links);
    Ok(Parts { base, tool: tool_name, drive, radius, rate, holds, tool_from_grasp, assumed })
}

/// The joints that move between the base and its wheels.
fn suspension<'l>(links: &'l [Link], base: usize, wheels: &[usize]) -> Vec<&'l Joint> {
    let above = |wheel: usize| std::iter::successors(links[wheel].parent, |&at| links[at].parent);
    let between = |wheel| above(wheel).take_while(|&at| at != base).filter_map(|at| links[at].joint.as_ref());
    let moving = wheels.iter().copied().flat_map(between).filter(|joint| joint.kind != JointKind::Fixed);
    // wheels may share one, such as a rocker
    let mut seen = BTreeSet::new();
    moving.filter(|joint| joint.mimic.is_none() && seen.insert(&joint.name)).collect()
}

/// The entry under `[hold]` that keeps a joint at 0, or as near to it as its limits allow.
fn held(joint: &Joint) -> String {
    let at = 0f64.max(joint.limits.lower).min(joint.limits.upper);
    let name = toml::Value::String(joint.name.clone());
    match joint.kind {
        JointKind::Prismatic => format!("{name} = {{ position_m = {at} }}"),
        _ => format!("{name} = {{ angle_deg = {} }}", at.to_degrees()),
    }
}

/// Whether a name says that its link does not hold an object. Short words must stand alone: `left_` has `ft_`
/// in it.
fn is_no_tool(name: &str) -> bool {
    let name = name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_ascii_alphanumeric());
    words.any(|word| NO_TOOLS.iter().any(|&no| word == no || (no.len() > 4 && word.contains(no))))
}

/// The link at the end of an arm of at most [`MAX_JOINTS`] joints: by its name, then by the length of its
/// arm.
fn tool(links: &[Link], base: usize, wheels: &[usize]) -> Option<usize> {
    let arm = |tool: usize| -> Option<usize> {
        let path = std::iter::successors(Some(tool), |&at| links[at].parent);
        let path: Vec<usize> = path.take_while(|&at| at != base).collect();
        let hangs = path.last().and_then(|&last| links[last].parent) == Some(base);
        let kinds = path.iter().filter_map(|&at| links[at].joint.as_ref());
        let moving = kinds.clone().filter(|j| j.kind != JointKind::Fixed && j.mimic.is_none());
        let slides = kinds.clone().filter(|j| j.kind == JointKind::Prismatic).count();
        let is_arm = !path.iter().any(|at| wheels.contains(at)) && slides <= MAX_SLIDES;
        let is_possible = kinds.clone().all(|j| {
            matches!(
                j.kind,
                JointKind::Fixed | JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic
            )
        });
        let count = moving.count();
        (hangs && is_arm && is_possible && (1..=MAX_JOINTS).contains(&count)).then_some(count)
    };
    let candidates =
        (0..links.len()).filter_map(|i| Some((i, arm(i)?))).filter(|(i, _)| !is_no_tool(&links[*i].name));
    // six joints place a grasp anywhere; the name then decides, and then the end of the tree
    candidates
        .max_by_key(|&(i, count)| {
            let name = links[i].name.to_lowercase();
            let rank = TOOLS.iter().position(|part| name.contains(part)).unwrap_or(TOOLS.len());
            (count.min(6), TOOLS.len() - rank, count, std::cmp::Reverse(i))
        })
        .map(|(i, _)| i)
}

/// The grasp's axes in the tool's frame, x along the axis that points from the last moving joint outward, and
/// that axis' name.
fn approach(links: &[Link], poses: &[Pose], base: usize, tool: usize) -> (Rotation3<f64>, String) {
    let moves = |i: usize| links[i].joint.as_ref().is_some_and(|j| j.kind != JointKind::Fixed);
    let path = std::iter::successors(Some(tool), |&at| links[at].parent).take_while(|&at| at != base);
    let last = path.into_iter().find(|&i| moves(i)).unwrap_or(tool);
    let below = (last..links.len())
        .filter(|&i| std::iter::successors(Some(i), |&at| links[at].parent).any(|at| at == last))
        .collect::<Vec<_>>();
    let sum: Vector3<f64> = below.iter().map(|&i| poses[i].translation.vector).sum();
    let outward = sum / below.len() as f64 - poses[last].translation.vector;
    let outward = poses[tool].rotation.inverse() * outward;
    let largest = outward.iamax();
    let largest = if outward.norm() < 5e-3 { 2 } else { largest };
    let sign = if outward[largest] < 0.0 { -1.0 } else { 1.0 };
    let mut x = Vector3::zeros();
    x[largest] = sign;
    // any axis across may be up; the search for postures tries all four
    let z = if largest == 2 { Vector3::x() } else { Vector3::z() };
    let y = z.cross(&x);
    let name = format!("{}{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][largest]);
    (Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[x, y, z])), name)
}

/// The largest distance of a wheel's mesh from its axis, m.
fn mesh_radius(link: &Link) -> Option<f64> {
    let axis = link.joint.as_ref()?.axis;
    let shapes = link.collisions.iter().chain(&link.visuals);
    let mut radii = shapes.filter_map(|geometry| {
        let Shape::Mesh { file, scale, .. } = &geometry.shape else { return None };
        let vertices = hull::vertices(file).ok()?;
        let distance = |v: &[f64; 3]| {
            let p = geometry.link_from_shape * Point3::from(Vector3::from(*v).component_mul(scale));
            axis.cross(&p.coords).norm()
        };
        vertices.iter().map(distance).reduce(f64::max)
    });
    radii.next()
}

//! The direction in which a tool points: that of the grasp's x.

use super::draft_tree::{is_within, moving, path, says, shapes};
use super::link::{Link, Shape};
use crate::geometry::Pose;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

/// The direction of a tool.
#[derive(Clone, Debug)]
pub(super) struct Approach {
    /// The grasp's axes in the tool's frame: x along the arm's end.
    pub tool_from_grasp: Rotation3<f64>,
    /// The name of the axis, and why it is that one, in words.
    pub told: String,
}

/// What lies nearer to the last joint tells no direction, m.
const MIN_OUTWARD_M: f64 = 0.01;
/// How many times as far something must lie along one axis as along any other.
const MARGIN: f64 = 1.25;
/// The least cosine of two parallel axes.
const PARALLEL: f64 = 0.9;
/// Words in the names of links that are beside a tool.
const BESIDE: [&str; 8] = ["camera", "optical", "sensor", "realsense", "kinect", "aruco", "marker", "imu"];

/// The axis of the tool's frame that points from the last moving joint outward: to the frames beyond it, or
/// else to the shapes. Where neither tells, the last joint's axis, and then z, as frames of tools have it.
pub(super) fn approach(links: &[Link], poses: &[Pose], base: usize, tool: usize) -> Approach {
    let path = path(links, base, tool).unwrap_or_default();
    let last = path.iter().copied().rev().find(|&i| moving(links, i).is_some()).unwrap_or(tool);
    let beyond: Vec<usize> = (last..links.len())
        .filter(|&i| is_within(links, i, last) && (i == last || !says(&links[i].name, &BESIDE)))
        .collect();
    let origin = poses[last].translation.vector;
    let in_tool = |point: Vector3<f64>| poses[tool].rotation.inverse() * (point - origin);
    let frames: Vec<Vector3<f64>> = beyond.iter().map(|&i| poses[i].translation.vector).collect();
    let bodies: Vec<Vector3<f64>> = beyond.iter().flat_map(|&i| middles(&links[i], &poses[i])).collect();
    let of_shapes = || mean(&bodies).map(in_tool).and_then(|outward| along(&outward));
    if let Some(axis) = mean(&frames).map(in_tool).and_then(|outward| along(&outward)).or_else(of_shapes) {
        return Approach::new(axis, "");
    }
    let turn = moving(links, last)
        .map(|joint| poses[tool].rotation.inverse() * (poses[last].rotation * joint.axis.into_inner()));
    let axis = turn.filter(|turn| turn.x.abs() > PARALLEL).map_or(2, |_| 0);
    // the shapes may still tell one sense from the other
    let sense = mean(&bodies).map_or(0.0, |point| in_tool(point)[axis]);
    let sign = if sense < -MIN_OUTWARD_M { -1.0 } else { 1.0 };
    Approach::new((axis, sign), ", by convention: no frame beyond its last joint tells")
}

impl Approach {
    fn new((axis, sign): (usize, f64), why: &str) -> Self {
        let mut x = Vector3::zeros();
        x[axis] = sign;
        // any axis across may be up; the search for postures tries all four
        let z = if axis == 2 { Vector3::x() } else { Vector3::z() };
        let tool_from_grasp = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
        let name = format!("{}{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][axis]);
        let told = format!("the tool points along its {name} axis, which becomes the grasp's x{why}");
        Self { tool_from_grasp, told }
    }
}

/// The axis along which a vector points by a margin, and its sign.
fn along(outward: &Vector3<f64>) -> Option<(usize, f64)> {
    let axis = outward.iamax();
    let others = (0..3).filter(|&other| other != axis).map(|other| outward[other].abs()).fold(0.0, f64::max);
    let is_clear = outward[axis].abs() >= MIN_OUTWARD_M.max(MARGIN * others);
    is_clear.then(|| (axis, outward[axis].signum()))
}

fn mean(points: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let count = points.len() as f64;
    (!points.is_empty()).then(|| points.iter().sum::<Vector3<f64>>() / count)
}

/// The middles of a link's shapes, where they are known.
fn middles(link: &Link, pose: &Pose) -> Vec<Vector3<f64>> {
    let of_shape = |shape: &Shape| match shape {
        Shape::Mesh { hull, .. } => mean(hull),
        _ => Some(Vector3::zeros()),
    };
    let middles = shapes(link).filter_map(|geometry| {
        let middle = of_shape(&geometry.shape)?;
        Some((pose * geometry.link_from_shape * Point3::from(middle)).coords)
    });
    middles.collect()
}

//! The convex hull of a mesh file. No other file uses `mesh_loader`.

use crate::located;
use crate::math;
use nalgebra::Vector3;
use parry3d::shape::{ConvexPolyhedron, Shape};
use std::collections::BTreeSet;
use std::path::Path;

/// The largest mesh file that is read, bytes.
const LARGEST_MESH: u64 = 64 << 20;
/// The number of directions in which a hull has its vertices. On a ball, the hull of as many vertices is within
/// 1 % of the radius.
const DIRECTIONS: usize = 256;
/// The largest coordinate of a vertex in the file's units.
const LARGEST_COORDINATE: f64 = 1e6;
/// Extent of a flat mesh's hull across it, in the file's units.
const LEAST_EXTENT: f64 = 1e-4;
/// The largest number of triangles of a mesh whose volume is measured.
const MOST_MEASURED: usize = 300_000;

/// The convex hull of a mesh.
pub(super) struct Hull {
    /// Its vertices, in the file's units.
    pub vertices: Vec<[f64; 3]>,
    /// The share of its volume that the mesh fills; `None` for a mesh that is flat, not closed, or large.
    pub filled: Option<f64>,
}

/// The convex hull of all triangles of an STL, OBJ or COLLADA file: of its farthest vertices in 256 directions
/// spread over the sphere. The error says why there is none.
pub(super) fn read(file: &Path) -> Result<Hull, String> {
    let format = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let bytes = located::read_bytes(LARGEST_MESH, file).map_err(|e| e.to_string())?;
    // a library of materials beside an OBJ has no shapes
    let loader = mesh_loader::Loader::default().merge_meshes(true).custom_reader(|_| Ok(Vec::new()));
    let scene = match format.as_str() {
        "stl" => loader.load_stl_from_slice(&bytes, file),
        "obj" => loader.load_obj_from_slice(&bytes, file),
        "dae" => loader.load_collada_from_slice(&bytes, file),
        _ => return Err("expected STL, OBJ or COLLADA (.stl, .obj, .dae)".to_owned()),
    };
    let scene = scene.map_err(|e| e.to_string())?;
    let points: Vec<Vector3<f64>> = scene
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.vertices)
        .map(|vertex| Vector3::from(vertex.map(f64::from)))
        .collect();
    if points.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    if !points.iter().all(|p| p.amax() <= LARGEST_COORDINATE) {
        return Err(format!("a vertex is not a number or beyond {LARGEST_COORDINATE}"));
    }
    let mut chosen = extreme(&points);
    let solid = hull(&chosen);
    let filled = solid.as_ref().zip(closed_volume(&scene.meshes)).map(|(solid, volume)| {
        let whole = solid.mass_properties(1.0).mass();
        (volume / whole).min(1.0)
    });
    if solid.is_none() {
        // a flat or thin mesh: its bounding box, with some thickness
        let (mut low, mut high) = (points[0], points[0]);
        points.iter().for_each(|p| (low, high) = (low.inf(p), high.sup(p)));
        let least = Vector3::repeat(LEAST_EXTENT.max((high - low).amax() * 1e-3) / 2.0);
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).sup(&least));
        chosen = (0..8)
            .map(|i| {
                let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                middle + half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)))
            })
            .collect();
    }
    Ok(Hull { vertices: chosen.into_iter().map(Into::into).collect(), filled })
}

/// The volume of a mesh, if it is closed: every edge of a triangle is one of another in the other direction.
fn closed_volume(meshes: &[mesh_loader::Mesh]) -> Option<f64> {
    let count: usize = meshes.iter().map(|mesh| mesh.faces.len()).sum();
    if count > MOST_MEASURED {
        return None;
    }
    let key = |vertex: [f32; 3]| vertex.map(|x| (x + 0.0).to_bits());
    let mut edges = Vec::with_capacity(3 * count);
    let mut volume = 0.0;
    for (mesh, face) in meshes.iter().flat_map(|mesh| mesh.faces.iter().map(move |face| (mesh, face))) {
        let corner = |i: usize| mesh.vertices.get(face[i] as usize).copied();
        let corners = [corner(0)?, corner(1)?, corner(2)?];
        let [a, b, c] = corners.map(|corner| Vector3::from(corner.map(f64::from)));
        volume += a.dot(&b.cross(&c)) / 6.0;
        for i in 0..3 {
            let (from, to) = (key(corners[i]), key(corners[(i + 1) % 3]));
            edges.push(if from < to { (from, to, 1) } else { (to, from, -1) });
        }
    }
    edges.sort_unstable();
    let is_closed = edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)).all(|same| {
        let turns: i32 = same.iter().map(|edge| edge.2).sum();
        turns == 0
    });
    // triangles that face inward enclose a negative volume
    is_closed.then_some(volume.abs())
}

/// The convex hull of these points; `None` where they are flat.
fn hull(points: &[Vector3<f64>]) -> Option<ConvexPolyhedron> {
    let points: Vec<_> = points.iter().map(|p| parry3d::math::Vector::new(p.x, p.y, p.z)).collect();
    if points.len() < 4 {
        return None;
    }
    ConvexPolyhedron::from_convex_hull(&points)
}

/// The farthest points in directions spread evenly over the sphere, each once, in the order of the points.
fn extreme(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let farthest = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let turn = GOLDEN_ANGLE * i as f64;
        let along = Vector3::new(radius * math::cos(turn), radius * math::sin(turn), z);
        (0..points.len()).max_by(|&a, &b| points[a].dot(&along).total_cmp(&points[b].dot(&along)))
    };
    let chosen: BTreeSet<usize> = (0..DIRECTIONS).filter_map(farthest).collect();
    let mut seen = BTreeSet::new();
    let is_new = |p: &Vector3<f64>| seen.insert([p.x, p.y, p.z].map(f64::to_bits));
    chosen.into_iter().map(|i| points[i]).filter(is_new).collect()
}

/// Whether the points have a hull that the physics can use.
pub(super) fn is_solid(points: &[Vector3<f64>]) -> bool {
    hull(points).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism over a polygon, 1 m high, as an OBJ file; open without its lid.
    fn prism(corners: &[[f64; 2]], lids: &[[usize; 3]], is_open: bool) -> Hull {
        let n = corners.len();
        let mut text = String::new();
        for z in [0.0, 1.0] {
            corners.iter().for_each(|[x, y]| text += &format!("v {x} {y} {z}\n"));
        }
        let mut face = |[a, b, c]: [usize; 3]| text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        for i in 0..n {
            let next = (i + 1) % n;
            face([i, next, n + next]);
            face([i, n + next, n + i]);
        }
        for &[a, b, c] in lids {
            face([c, b, a]);
            if !is_open {
                face([n + a, n + b, n + c]);
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("prism.obj");
        std::fs::write(&file, text).unwrap();
        read(&file).unwrap()
    }

    #[test]
    fn closed_form_an_angle_fills_half_of_its_hull() {
        // two legs of 3 m by 0.5 m: 2.75 of 5.875 square metres
        let angle = [[0.0, 0.0], [3.0, 0.0], [3.0, 0.5], [0.5, 0.5], [0.5, 3.0], [0.0, 3.0]];
        let lids = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let filled = prism(&angle, &lids, false).filled.unwrap();
        assert!((filled - 2.75 / 5.875).abs() < 1e-6, "{filled}");
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let lids = [[0, 1, 2], [0, 2, 3]];
        assert!((prism(&square, &lids, false).filled.unwrap() - 1.0).abs() < 1e-6);
        assert_eq!(prism(&square, &lids, true).filled, None, "open");
    }
}

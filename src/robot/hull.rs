//! Vertices of a mesh file's convex hull. No other file uses `mesh_loader`.

use crate::located;
use crate::math;
use nalgebra::Vector3;
use parry3d::shape::ConvexPolyhedron;
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

/// Vertices of the convex hull of all triangles of an STL, OBJ or COLLADA file, in the file's units: its
/// farthest vertices in 256 directions spread over the sphere. The error says why there are none.
pub(super) fn vertices(file: &Path) -> Result<Vec<[f64; 3]>, String> {
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
    if hull(&chosen).is_none() {
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
    Ok(chosen.into_iter().map(Into::into).collect())
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

//! The convex hull of a mesh file, or of its convex parts. No other file uses `mesh_loader`.

use super::mesh_bounds::{check_collada, check_obj, check_stl, remark_on_stl};
use crate::bounds;
use crate::guarded;
use crate::located;
use crate::math;
use nalgebra::Vector3;
use parry3d::shape::{ConvexPolyhedron, Shape};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d::transformation::voxelization::FillMode;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// The number of directions in which a hull has its vertices. On a ball, the hull of as many vertices is
/// within 1 % of the radius.
const DIRECTIONS: usize = 256;
/// The largest coordinate of a vertex in the file's units.
const MAX_COORDINATE: f64 = 1e6;
/// Extent of a flat mesh's hull across it, in the file's units.
const MIN_EXTENT: f64 = 1e-4;
/// The spacing of the grid to which corners of triangles are rounded to tell whether they are one, as a share
/// of the largest coordinate.
const SAME: f64 = 1e-6;
/// The largest number of triangles of a mesh whose volume is measured.
const MAX_MEASURED: usize = 300_000;

/// The share of its convex hull that a mesh fills at least to collide as that.
const MIN_FILLED: f64 = 0.4;
/// Parts are the hulls of cubes; this many of them lie along a mesh's longest extent. Nothing of a mesh lies
/// outside its parts.
const CUBES: u32 = 64;
/// The share of the whole hull's volume by which a part's hull exceeds the part, above which it is cut again.
const CONCAVITY: f64 = 0.02;
/// The depth of cuts: parts are cut in two at most five times, so there are 32 of them at most.
const PARTS_ASKED: u32 = 16;

/// The convex hull of a mesh.
struct Hull {
    /// Its vertices, in the file's units.
    vertices: Vec<[f64; 3]>,
    /// The share of its volume that the mesh fills; `None` for a mesh that is flat, not closed, or large.
    filled: Option<f64>,
    /// What is odd about the file.
    remark: Option<String>,
    points: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// A mesh file: what it collides as, the share of its hull that it fills, and what is odd about it.
pub(super) struct Collision {
    pub convex: Convex,
    /// As in [`Hull`].
    pub filled: Option<f64>,
    /// As in [`Hull`].
    pub remark: Option<String>,
}

/// The shape as which a mesh collides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Convex {
    /// The vertices of its convex hull, in the units of its file.
    Hull(Vec<[f64; 3]>),
    /// The vertices of the hulls of its parts.
    Parts(Vec<Vec<[f64; 3]>>),
}

impl Convex {
    /// The vertices of each hull.
    pub fn hulls(&self) -> &[Vec<[f64; 3]>] {
        match self {
            Self::Hull(vertices) => std::slice::from_ref(vertices),
            Self::Parts(parts) => parts,
        }
    }
}

impl Hull {
    /// The hull, or convex parts of a mesh that fills less than 40 % of it, by approximate convex
    /// decomposition (V-HACD: Mamou, Volumetric Hierarchical Approximate Convex Decomposition, 2016).
    fn convex(self) -> Convex {
        if self.filled.is_none_or(|filled| filled >= MIN_FILLED) {
            return Convex::Hull(self.vertices);
        }
        // no preferred direction of cuts: it needs an arc cosine of the system's
        let parameters = VHACDParameters {
            beta: 0.0,
            concavity: CONCAVITY,
            fill_mode: FillMode::FloodFill { detect_cavities: false },
            max_convex_hulls: PARTS_ASKED,
            resolution: CUBES,
            ..VHACDParameters::default()
        };
        let points: Vec<_> = self.points.iter().copied().map(to_parry).collect();
        let parts = VHACD::decompose(&parameters, &points, &self.triangles, false);
        let parts = parts.voxel_parts().iter().filter(|part| !part.is_empty()).map(|part| {
            // all its vertices, so that nothing of the mesh lies outside
            part.compute_convex_hull(1).0.into_iter().map(|c| [c.x, c.y, c.z]).collect()
        });
        Convex::Parts(parts.collect())
    }
}

fn to_parry(p: Vector3<f64>) -> parry3d::math::Vector {
    parry3d::math::Vector::new(p.x, p.y, p.z)
}

/// What an STL, OBJ or COLLADA file collides as. The error says why it has no shape.
pub(super) fn collision(file: &Path) -> Result<Collision, String> {
    made(file, |hull| {
        let (filled, remark) = (hull.filled, hull.remark.clone());
        Collision { convex: hull.convex(), filled, remark }
    })
}

/// The vertices of the convex hull of a mesh file, in its units.
pub(super) fn vertices(file: &Path) -> Result<Vec<[f64; 3]>, String> {
    made(file, |hull| hull.vertices)
}

/// Applies `make` to the hull of a mesh file. The error says why that failed: also that the parser, or the
/// geometry computed from the mesh, panicked.
fn made<T: Send>(file: &Path, make: impl FnOnce(Hull) -> T + Send) -> Result<T, String> {
    let bytes = located::read_bytes(&bounds::MESH, file).map_err(|e| e.to_string())?;
    let made = guarded::on_thread(|| of_bytes(&bytes, file).map(make));
    made.unwrap_or_else(|panic| Err(format!("it cannot be read: {panic}")))
}

/// The convex hull of all triangles of a mesh file: of its farthest vertices in 256 directions spread over the
/// sphere. The error says why there is none.
fn of_bytes(bytes: &[u8], file: &Path) -> Result<Hull, String> {
    let format = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    // a library of materials next to an OBJ has no shapes
    let loader = mesh_loader::Loader::default().merge_meshes(true).custom_reader(|_| Ok(Vec::new()));
    let scene = match format.as_str() {
        "stl" => check_stl(bytes).map(|()| loader.load_stl_from_slice(bytes, file)),
        "obj" => check_obj(bytes).map(|()| loader.load_obj_from_slice(bytes, file)),
        // without a folder: textures are not searched for
        "dae" => check_collada(bytes).map(|()| loader.load_collada_from_slice(bytes, "")),
        _ => Err("expected STL, OBJ or COLLADA (.stl, .obj, .dae)".to_owned()),
    };
    let scene = scene?.map_err(|e| e.to_string())?;
    let (mut points, mut triangles) = (Vec::<Vector3<f64>>::new(), Vec::new());
    for mesh in &scene.meshes {
        let before = points.len() as u32;
        points.extend(mesh.vertices.iter().map(|vertex| Vector3::from(vertex.map(f64::from))));
        triangles.extend(mesh.faces.iter().map(|face| face.map(|i| i.saturating_add(before))));
    }
    if points.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    // the largest of some numbers would pass over a NaN
    if !points.iter().flatten().all(|x| x.abs() <= MAX_COORDINATE) {
        return Err(format!("a vertex is NaN or exceeds {MAX_COORDINATE:e}"));
    }
    let mut chosen = extreme(&points);
    let solid = hull(&chosen);
    let filled = solid.as_ref().zip(closed_volume(&points, &triangles)).map(|(solid, volume)| {
        let whole = solid.mass_properties(1.0).mass();
        (volume / whole).min(1.0)
    });
    if solid.is_none() {
        // a flat or thin mesh: its bounding box, with some thickness
        let (mut low, mut high) = (points[0], points[0]);
        points.iter().for_each(|p| (low, high) = (low.inf(p), high.sup(p)));
        let least = Vector3::repeat(MIN_EXTENT.max((high - low).amax() * 1e-3) / 2.0);
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).sup(&least));
        chosen = (0..8)
            .map(|i| {
                let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                middle + half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)))
            })
            .collect();
    }
    let remark = if format == "stl" { remark_on_stl(bytes, triangles.len()) } else { None };
    Ok(Hull { vertices: chosen.into_iter().map(Into::into).collect(), filled, remark, points, triangles })
}

/// The volume of a mesh, if it is closed: every edge of a triangle is one of another in the other direction,
/// where corners within a millionth of the largest coordinate are one.
fn closed_volume(points: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Option<f64> {
    if triangles.len() > MAX_MEASURED {
        return None;
    }
    let spacing = SAME * points.iter().map(|p| p.amax()).fold(0.0, f64::max);
    let key = |corner: Vector3<f64>| <[i64; 3]>::from(corner.map(|x| (x / spacing).round() as i64));
    let mut edges = Vec::with_capacity(3 * triangles.len());
    let mut volume = 0.0;
    for triangle in triangles {
        let corner = |i: usize| points.get(triangle[i] as usize).copied();
        let corners = [corner(0)?, corner(1)?, corner(2)?];
        let [a, b, c] = corners;
        volume += a.dot(&b.cross(&c)) / 6.0;
        let keys = corners.map(key);
        for i in 0..3 {
            let (from, to) = (keys[i], keys[(i + 1) % 3]);
            if from != to {
                edges.push(if from < to { (from, to, 1) } else { (to, from, -1) });
            }
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

/// The convex hull of these points; `None` where they are flat, or so nearly that it cannot be made.
fn hull(points: &[Vector3<f64>]) -> Option<ConvexPolyhedron> {
    let points: Vec<_> = points.iter().copied().map(to_parry).collect();
    if points.len() < 4 || !points.iter().all(|p| p.is_finite()) {
        return None;
    }
    guarded::here(|| ConvexPolyhedron::from_convex_hull(&points)).ok().flatten()
}

/// The farthest points in directions spread evenly over the sphere, each once, in the order of the points.
fn extreme(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    // files repeat corners in every triangle; of equals the last counts
    let last: HashMap<[u64; 3], usize> =
        points.iter().enumerate().map(|(i, p)| ([p.x, p.y, p.z].map(f64::to_bits), i)).collect();
    let mut distinct: Vec<usize> = last.into_values().collect();
    distinct.sort_unstable();
    let farthest = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let turn = GOLDEN_ANGLE * i as f64;
        let along = Vector3::new(radius * math::cos(turn), radius * math::sin(turn), z);
        distinct.iter().copied().max_by(|&a, &b| points[a].dot(&along).total_cmp(&points[b].dot(&along)))
    };
    let chosen: BTreeSet<usize> = (0..DIRECTIONS).filter_map(farthest).collect();
    chosen.into_iter().map(|i| points[i]).collect()
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
        of_bytes(text.as_bytes(), "prism.obj".as_ref()).unwrap()
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

    /// Files repeat corners, and round them in more than one way.
    #[test]
    fn nearly_equal_corners_are_one() {
        let corners = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let volume = |off: f64| {
            let moved =
                |(i, &corner): (usize, &usize)| corners[corner] + Vector3::repeat(off * (i % 3) as f64);
            let points: Vec<_> = faces.iter().flatten().enumerate().map(moved).collect();
            let triangles: Vec<_> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            closed_volume(&points, &triangles)
        };
        assert!((volume(1e-8).unwrap() - 1.0 / 6.0).abs() < 1e-6);
        assert_eq!(volume(1e-3), None);
    }

    /// What an angle with thin legs leaves free stays free, and nothing of it is left out.
    #[test]
    fn a_hollow_mesh_is_its_parts() {
        let w = 0.25;
        let angle = [[0.0, 0.0], [3.0, 0.0], [3.0, w], [w, w], [w, 3.0], [0.0, 3.0]];
        let lids = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let mesh = prism(&angle, &lids, false);
        let filled = mesh.filled.unwrap();
        assert!((filled - (6.0 * w - w * w) / (9.0 - (3.0 - w) * (3.0 - w) / 2.0)).abs() < 1e-6, "{filled}");
        let Convex::Parts(parts) = mesh.convex() else { panic!("{filled} of the hull is filled") };
        let parts: Vec<_> = parts
            .iter()
            .map(|part| {
                hull(&part.iter().copied().map(Vector3::from).collect::<Vec<_>>()).expect("a solid part")
            })
            .collect();
        let holds = |x: f64, y: f64, z: f64| {
            use parry3d::query::PointQuery;
            parts.iter().any(|part| part.contains_local_point(to_parry(Vector3::new(x, y, z))))
        };
        for along in (0..=60).map(|i| f64::from(i) / 20.0) {
            for (across, z) in [(0.0, 0.0), (w, 0.0), (w, 1.0), (w / 2.0, 0.5)] {
                assert!(holds(along, across, z) && holds(across, along, z), "{along} {across} {z}");
            }
        }
        // a cube is 4.8 cm
        let free = w + 0.06;
        assert!(!holds(free, free, 0.5) && !holds(1.0, free, 0.5) && !holds(free, 2.0, 0.5));
        let volume: f64 = parts.iter().map(|part| part.mass_properties(1.0).mass()).sum();
        assert!(volume < 1.35 * (6.0 * w - w * w), "{volume}");
    }
}

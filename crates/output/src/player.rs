//! The data of the 3-D player: worlds, options and robots as it draws them.

use crate::drawing::{option_colour, option_dash, risk_colour};
use crate::palette::{self, hex};
use base64::Engine;
use base64::prelude::BASE64_STANDARD as STANDARD;
use cocarry::Error;
use cocarry::bounds;
use cocarry::error::Place;
use cocarry::geometry::{Footprint, Point, Pose};
use cocarry::located::{self, unreadable};
use cocarry::options::OptionSet;
use cocarry::robot::{Geometry, Link, Shape};
use cocarry::world::World;
use nalgebra::UnitQuaternion;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The largest distance of a drawn arc from its chords, m.
const SAGITTA: f64 = 0.01;

/// The largest total length of the mesh files of a page, bytes.
const MAX_MESHES: u64 = 256 << 20;
/// The colours of bodies.
pub fn colours() -> Value {
    json!({
        "robot": hex(palette::ROBOT),
        "object": hex(palette::OBJECT),
        "human": hex(palette::HUMAN),
        "hair": hex(palette::HAIR),
        "skin": hex(palette::SKIN),
        "trousers": hex(palette::TROUSERS),
        "shoes": hex(palette::SHOES),
    })
}

/// A coordinate (m) or a part of a quaternion, to a tenth of a millimetre: of a picture, not of a figure.
fn rounded(value: f64) -> f64 {
    // not to -0
    (value * 1e4).round() / 1e4 + 0.0
}

/// A point (m), to a tenth of a millimetre.
pub fn point(p: Point) -> Value {
    json!([rounded(p.x), rounded(p.y)])
}

/// Position (m) and quaternion (x, y, z, w).
pub fn pose(pose: &Pose) -> [f64; 7] {
    let (at, q) = (pose.translation.vector, UnitQuaternion::from_rotation_matrix(&pose.rotation));
    [at.x, at.y, at.z, q.i, q.j, q.k, q.w].map(rounded)
}

/// A world: obstacles, openings, A and B.
pub fn world(world: &World) -> Value {
    let parts =
        world.obstacles.iter().flat_map(|obstacle| obstacle.footprints().map(move |part| (obstacle, part)));
    let obstacles = parts.map(|(obstacle, part)| {
        let mut drawn = json!({ "name": obstacle.name, "height_m": obstacle.height });
        match part {
            Footprint::Polygon(corners) => {
                drawn["corners"] = corners.iter().map(|c| point(*c)).collect();
            }
            Footprint::Disc { center, radius } => {
                (drawn["center"], drawn["radius"]) = (point(*center), rounded(*radius).into());
            }
        }
        drawn
    });
    let openings = world.openings.iter().map(|opening| {
        let risk = opening.risk(world.robot_width);
        json!({
            "name": opening.name,
            "ends": opening.ends.map(point),
            "width_m": opening.width,
            "risk": risk,
            "colour": risk_colour(risk),
        })
    });
    json!({
        "name": world.name,
        "robot_width_m": world.robot_width,
        "start": point(world.start),
        "target": point(world.target),
        "object_m": world.object.size,
        "obstacles": obstacles.collect::<Vec<_>>(),
        "openings": openings.collect::<Vec<_>>(),
    })
}

/// An option as it is at the start, with the colour of every picture: name, names of its openings, path.
pub fn option(option: usize, options: &OptionSet, world: &World) -> Value {
    let of = &options.options()[option];
    let path = options.path(&options.begin(), option).map_or_else(Vec::new, |path| path.polyline(SAGITTA));
    let openings = of.crossings.iter().map(|c| &world.openings[c.opening].name);
    json!({
        "name": of.name,
        "openings": openings.collect::<Vec<_>>(),
        "colour": option_colour(option),
        "dash": option_dash(option),
        "path": path.into_iter().map(point).collect::<Vec<_>>(),
    })
}

/// The meshes of a robot: the bytes of each file once.
pub struct Meshes<'a> {
    /// The reader of their files; `None` where they cannot be found.
    read: Option<&'a ReadMesh>,
    known: BTreeMap<PathBuf, usize>,
    /// The total length of the files, bytes.
    bytes: u64,
    /// Format and base64 of each.
    data: Vec<Value>,
}

/// The bytes of a mesh file.
pub type ReadMesh = dyn Fn(&Path) -> Result<Vec<u8>, Error>;

/// Reads a mesh file of the system.
///
/// # Errors
/// The file cannot be read, or is too large.
pub fn read_mesh(file: &Path) -> Result<Vec<u8>, Error> {
    located::read_bytes(&bounds::MESH, file).map_err(|source| unreadable(file.display(), source))
}

impl<'a> Meshes<'a> {
    /// No meshes yet. `read` reads their files; `None` where they cannot be found.
    pub fn new(read: Option<&'a ReadMesh>) -> Self {
        Self { read, known: BTreeMap::new(), bytes: 0, data: Vec::new() }
    }

    /// Format and base64 of each so far.
    pub fn data(&self) -> &[Value] {
        &self.data
    }

    /// The index of a file's data.
    fn index(&mut self, file: &Path) -> Result<usize, Error> {
        if let Some(&index) = self.known.get(file) {
            return Ok(index);
        }
        let format = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if !["stl", "obj", "dae"].contains(&&*format) {
            let sentence = "a mesh of an unknown format; expected .stl, .obj or .dae";
            return Err(Error::at(Place::file(file.display().to_string()), sentence));
        }
        let bytes = self.read.map_or_else(|| read_mesh(file), |read| read(file))?;
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_MESHES {
            let sentence = format_args!("it and the meshes to draw before it exceed {MAX_MESHES} bytes");
            return Err(Error::at(Place::file(file.display().to_string()), sentence));
        }
        self.data.push(json!({ "format": format, "base64": STANDARD.encode(&bytes) }));
        self.known.insert(file.to_owned(), self.data.len() - 1);
        Ok(self.data.len() - 1)
    }
}

/// The shapes of a link to draw: the visual ones, or else those of the collision shapes that can be drawn. A
/// collision mesh that cannot be is left out: the robot has a warning about it.
///
/// # Errors
/// A mesh of a visual shape cannot be read.
pub fn shapes(link: &Link, meshes: &mut Meshes<'_>) -> Result<Vec<Value>, Error> {
    let can_be_found = meshes.read.is_some();
    let is_drawn = |g: &&Geometry| can_be_found || !matches!(g.shape, Shape::Mesh { .. });
    if link.visuals.iter().any(|g| is_drawn(&g)) {
        return link.visuals.iter().filter(is_drawn).map(|geometry| shape(geometry, meshes)).collect();
    }
    let collisions = link.collisions.iter().filter(is_drawn);
    Ok(collisions.filter_map(|geometry| shape(geometry, meshes).ok()).collect())
}

/// A shape of a link.
///
/// # Errors
/// Its mesh cannot be read.
pub fn shape(geometry: &Geometry, meshes: &mut Meshes<'_>) -> Result<Value, Error> {
    let mut drawn = match &geometry.shape {
        Shape::Box { size } => json!({ "box": [size.x, size.y, size.z] }),
        Shape::Cylinder { radius, length } => json!({ "cylinder": [radius, length] }),
        Shape::Capsule { radius, length } => json!({ "capsule": [radius, length] }),
        Shape::Sphere { radius } => json!({ "sphere": radius }),
        Shape::Mesh { file, scale, .. } => {
            json!({ "mesh": meshes.index(file)?, "scale": [scale.x, scale.y, scale.z] })
        }
    };
    drawn["pose"] = pose(&geometry.link_from_shape).to_vec().into();
    drawn["colour"] = geometry.color.map(|colour| colour.to_vec()).into();
    Ok(drawn)
}

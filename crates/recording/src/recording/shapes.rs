//! The shapes of a scene in the form of messages.

use super::frames::{quaternion, timestamp, vector};
use cocarry::geometry::{Point, Pose};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, LinePrimitive, ModelPrimitive, Point3, SceneEntity,
    SpherePrimitive, TextPrimitive, TriangleListPrimitive,
};
use nalgebra::Vector3;

/// Height of letters, px: they stay legible at any distance.
pub(super) const LETTERS: f64 = 15.0;

/// An opaque colour, each part 0 to 1.
pub(super) fn rgba([r, g, b]: [u8; 3]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|c| f32::from(c) / 255.0);
    [r, g, b, 1.0]
}

pub(super) fn color([r, g, b, a]: [f32; 4]) -> Option<Color> {
    Some(Color { r: r.into(), g: g.into(), b: b.into(), a: a.into() })
}

pub(super) fn pose(pose: &Pose) -> Option<foxglove::messages::Pose> {
    let (position, orientation) = (vector(&pose.translation.vector), quaternion(&pose.rotation));
    Some(foxglove::messages::Pose { position, orientation })
}

pub(super) fn at(x: f64, y: f64, z: f64) -> Option<foxglove::messages::Pose> {
    pose(&Pose::translation(x, y, z))
}

/// An entity that stays until it is replaced.
pub(super) fn entity(frame: &str, id: String, time: u64) -> SceneEntity {
    SceneEntity { timestamp: timestamp(time), frame_id: frame.to_owned(), id, ..SceneEntity::default() }
}

/// An entity that moves with its frame.
pub(super) fn moving(frame: &str, time: u64) -> SceneEntity {
    SceneEntity { frame_locked: true, ..entity(frame, frame.to_owned(), time) }
}

pub(super) fn line(points: &[Point], z: f64, thickness: f64, rgba: [f32; 4]) -> LinePrimitive {
    LinePrimitive {
        pose: at(0.0, 0.0, 0.0),
        thickness,
        points: points.iter().map(|p| Point3 { x: p.x, y: p.y, z }).collect(),
        color: color(rgba),
        ..LinePrimitive::default()
    }
}

/// Words that face the viewer.
pub(super) fn text(words: &str, point: Point, z: f64, rgba: [f32; 4]) -> TextPrimitive {
    TextPrimitive {
        pose: at(point.x, point.y, z),
        billboard: true,
        font_size: LETTERS,
        scale_invariant: true,
        color: color(rgba),
        text: words.to_owned(),
    }
}

/// A convex outline extruded from the floor. Every triangle is counter-clockwise seen from outside.
pub(super) fn prism(corners: &[Point], height: f64, rgba: [f32; 4]) -> TriangleListPrimitive {
    let n = corners.len();
    let vertex = |i: usize, z: f64| Point3 { x: corners[i % n].x, y: corners[i % n].y, z };
    let (low, high) = (|i| vertex(i, 0.0), |i| vertex(i, height));
    let sides = (0..n).flat_map(|i| [low(i), low(i + 1), high(i + 1), low(i), high(i + 1), high(i)]);
    let ends =
        (1..n.saturating_sub(1)).flat_map(|i| [high(0), high(i), high(i + 1), low(0), low(i + 1), low(i)]);
    TriangleListPrimitive {
        pose: at(0.0, 0.0, 0.0),
        points: sides.chain(ends).collect(),
        color: color(rgba),
        ..TriangleListPrimitive::default()
    }
}

/// Solid shapes of an entity. Cylinders, capsules and limbs lie along z.
pub(super) trait Shapes {
    fn cube(&mut self, at: &Pose, size: Vector3<f64>, rgba: [f32; 4]);
    /// An ellipsoid with these diameters.
    fn ball(&mut self, at: &Pose, size: Vector3<f64>, rgba: [f32; 4]);
    fn cylinder(&mut self, at: &Pose, radius: f64, length: f64, rgba: [f32; 4]);
    /// A cylinder between two balls.
    fn capsule(&mut self, at: &Pose, radius: f64, length: f64, rgba: [f32; 4]);
    /// A cone between two balls with these radii, from the frame's origin on.
    fn limb(&mut self, radii: [f64; 2], length: f64, rgba: [f32; 4]);
    /// A 3-D file; in its own colours where none is given.
    fn model(&mut self, at: &Pose, scale: Vector3<f64>, rgba: Option<[f32; 4]>, file: (&str, Vec<u8>));
}

impl Shapes for SceneEntity {
    fn cube(&mut self, at: &Pose, size: Vector3<f64>, rgba: [f32; 4]) {
        self.cubes.push(CubePrimitive { pose: pose(at), size: vector(&size), color: color(rgba) });
    }

    fn ball(&mut self, at: &Pose, size: Vector3<f64>, rgba: [f32; 4]) {
        self.spheres.push(SpherePrimitive { pose: pose(at), size: vector(&size), color: color(rgba) });
    }

    fn cylinder(&mut self, at: &Pose, radius: f64, length: f64, rgba: [f32; 4]) {
        self.cylinders.push(CylinderPrimitive {
            pose: pose(at),
            size: vector(&Vector3::new(2.0 * radius, 2.0 * radius, length)),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: color(rgba),
        });
    }

    fn capsule(&mut self, at: &Pose, radius: f64, length: f64, rgba: [f32; 4]) {
        self.cylinder(at, radius, length, rgba);
        for z in [-length / 2.0, length / 2.0] {
            self.ball(&(at * Pose::translation(0.0, 0.0, z)), Vector3::repeat(2.0 * radius), rgba);
        }
    }

    fn limb(&mut self, [from, to]: [f64; 2], length: f64, rgba: [f32; 4]) {
        self.cylinder(&Pose::translation(0.0, 0.0, length / 2.0), from, length, rgba);
        if let Some(cone) = self.cylinders.last_mut() {
            cone.top_scale = to / from;
        }
        for (z, radius) in [(0.0, from), (length, to)] {
            self.ball(&Pose::translation(0.0, 0.0, z), Vector3::repeat(2.0 * radius), rgba);
        }
    }

    fn model(&mut self, at: &Pose, scale: Vector3<f64>, rgba: Option<[f32; 4]>, file: (&str, Vec<u8>)) {
        self.models.push(ModelPrimitive {
            pose: pose(at),
            scale: vector(&scale),
            color: color(rgba.unwrap_or([1.0; 4])),
            override_color: rgba.is_some(),
            media_type: file.0.to_owned(),
            data: file.1.into(),
            ..ModelPrimitive::default()
        });
    }
}

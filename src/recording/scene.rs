//! The scene of a recording: the shapes of world, robot and episode that a viewer draws.
//!
//! Every message of a channel has the channel's complete scene, so that a viewer who jumps in time only needs
//! the latest message.

use super::motion::{HAND, HUMAN, OBJECT, TORSO, WORLD, link_frame, quaternion, timestamp, vector};
use crate::episode::Tick;
use crate::geometry::{Footprint, Path, Point, Pose, Vector, angle_of, cross};
use crate::options::OptionSet;
use crate::robot::{Geometry, Link, Robot, Shape};
use crate::simulation::{HAND_RADIUS, TORSO_HEIGHT, TORSO_RADIUS};
use crate::world::{Obstacle, Opening, World};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, SceneEntity, SceneUpdate,
    SpherePrimitive, TextPrimitive, TriangleListPrimitive,
};
use nalgebra::{Rotation3, Vector3};

/// The largest distance of an arc from its chords, m.
const SAGITTA: f64 = 0.01;
/// The resolution of P_o in the drawing.
const PROBABILITY_STEP: f64 = 0.02;

const OBSTACLE: [f32; 4] = [0.55, 0.55, 0.58, 1.0];
const ROBOT: [f32; 4] = [0.85, 0.87, 0.9, 1.0];
const OBJECT_COLOR: [f32; 4] = [0.72, 0.5, 0.26, 1.0];
const HUMAN_COLOR: [f32; 4] = [0.2, 0.45, 0.8, 1.0];
const WALKED: [f32; 4] = [0.85, 0.1, 0.1, 1.0];
const AHEAD: [f32; 4] = [0.85, 0.1, 0.1, 0.45];
/// The colours of the options, in turn.
const OPTION_COLORS: [[f32; 3]; 6] = [
    [0.0, 0.45, 0.7],
    [0.9, 0.6, 0.0],
    [0.0, 0.62, 0.45],
    [0.8, 0.47, 0.65],
    [0.84, 0.37, 0.0],
    [0.34, 0.71, 0.91],
];

fn color([r, g, b, a]: [f32; 4]) -> Option<Color> {
    Some(Color { r: r.into(), g: g.into(), b: b.into(), a: a.into() })
}

fn pose(pose: &Pose) -> Option<foxglove::messages::Pose> {
    let (position, orientation) = (vector(&pose.translation.vector), quaternion(&pose.rotation));
    Some(foxglove::messages::Pose { position, orientation })
}

fn at(x: f64, y: f64, z: f64) -> Option<foxglove::messages::Pose> {
    pose(&Pose::translation(x, y, z))
}

/// An entity that stays until it is replaced.
fn entity(frame: &str, id: String, time: u64) -> SceneEntity {
    SceneEntity { timestamp: timestamp(time), frame_id: frame.to_owned(), id, ..SceneEntity::default() }
}

/// An entity that moves with its frame.
fn moving(frame: &str, time: u64) -> SceneEntity {
    SceneEntity { frame_locked: true, ..entity(frame, frame.to_owned(), time) }
}

fn line(points: &[Point], z: f64, thickness: f64, rgba: [f32; 4]) -> LinePrimitive {
    LinePrimitive {
        pose: at(0.0, 0.0, 0.0),
        thickness,
        points: points.iter().map(|p| Point3 { x: p.x, y: p.y, z }).collect(),
        color: color(rgba),
        ..LinePrimitive::default()
    }
}

fn text(words: &str, point: Point, z: f64) -> TextPrimitive {
    TextPrimitive {
        pose: at(point.x, point.y, z),
        billboard: true,
        font_size: 0.25,
        scale_invariant: false,
        color: color([0.05, 0.05, 0.05, 1.0]),
        text: words.to_owned(),
    }
}

/// The world: obstacles, openings coloured by their risk, start and target.
pub(super) fn world(world: &World, time: u64) -> SceneUpdate {
    let obstacles = world.obstacles.iter().map(|o| obstacle(o, time));
    let top = world.obstacles.iter().map(|o| o.height).fold(0.0, f64::max);
    let openings = world.openings.iter().map(|o| opening(o, world.robot_width, top + 0.2, time));
    let end = |name: &str, place: Point| {
        let disc = CylinderPrimitive {
            pose: at(place.x, place.y, 0.005),
            size: vector(&Vector3::new(0.3, 0.3, 0.01)),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: color([0.1, 0.1, 0.1, 0.8]),
        };
        let entity = entity(WORLD, format!("end/{name}"), time);
        SceneEntity { cylinders: vec![disc], texts: vec![text(name, place, 0.3)], ..entity }
    };
    let ends = [end("A", world.start), end("B", world.target)];
    SceneUpdate { deletions: Vec::new(), entities: obstacles.chain(openings).chain(ends).collect() }
}

fn obstacle(obstacle: &Obstacle, time: u64) -> SceneEntity {
    let mut drawn = entity(WORLD, format!("obstacle/{}", obstacle.name), time);
    let height = obstacle.height;
    match &obstacle.footprint {
        Footprint::Disc { center, radius } => drawn.cylinders.push(CylinderPrimitive {
            pose: at(center.x, center.y, height / 2.0),
            size: vector(&Vector3::new(2.0 * radius, 2.0 * radius, height)),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: color(OBSTACLE),
        }),
        Footprint::Polygon(corners) if obstacle.shape_name() == "box" && corners.len() == 4 => {
            let (along, across) = (corners[1] - corners[0], corners[3] - corners[0]);
            let middle = nalgebra::center(&corners[0], &corners[2]);
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_of(along));
            drawn.cubes.push(CubePrimitive {
                pose: pose(&Pose::from_parts(Vector3::new(middle.x, middle.y, height / 2.0).into(), turned)),
                size: vector(&Vector3::new(along.norm(), across.norm(), height)),
                color: color(OBSTACLE),
            });
        }
        Footprint::Polygon(corners) => drawn.triangles.push(prism(corners, height)),
    }
    drawn
}

/// A convex outline extruded from the floor. Every triangle is counter-clockwise seen from outside.
fn prism(corners: &[Point], height: f64) -> TriangleListPrimitive {
    let n = corners.len();
    let vertex = |i: usize, z: f64| Point3 { x: corners[i % n].x, y: corners[i % n].y, z };
    let (low, high) = (|i| vertex(i, 0.0), |i| vertex(i, height));
    let sides = (0..n).flat_map(|i| [low(i), low(i + 1), high(i + 1), low(i), high(i + 1), high(i)]);
    let ends =
        (1..n.saturating_sub(1)).flat_map(|i| [high(0), high(i), high(i + 1), low(0), low(i + 1), low(i)]);
    TriangleListPrimitive {
        pose: at(0.0, 0.0, 0.0),
        points: sides.chain(ends).collect(),
        color: color(OBSTACLE),
        ..TriangleListPrimitive::default()
    }
}

/// An opening. Its label is above all obstacles, which would hide it.
fn opening(opening: &Opening, robot_width: f64, above: f64, time: u64) -> SceneEntity {
    let risk = opening.risk(robot_width);
    let (high, low) = (risk as f32, 1.0 - risk as f32);
    let words = format!("{}: {:.2} m, risk {risk:.2}", opening.name, opening.width);
    SceneEntity {
        lines: vec![line(&opening.ends, 0.02, 0.08, [0.1 + 0.8 * high, 0.1 + 0.6 * low, 0.1, 1.0])],
        texts: vec![text(&words, opening.center(), above)],
        ..entity(WORLD, format!("opening/{}", opening.name), time)
    }
}

/// The shapes of the team: the robot; with bodies (`physics`) the object and the human; otherwise the human
/// as a pose.
pub(super) fn team(robot: &Robot, world: &World, physics: bool, time: u64) -> SceneUpdate {
    let mut entities: Vec<SceneEntity> = robot.links.iter().filter_map(|l| link(l, time)).collect();
    let here = Pose::identity();
    if physics {
        let mut object = moving(OBJECT, time);
        object.cubes.push(cube(&here, world.object.size.into(), OBJECT_COLOR));
        let mut hand = moving(HAND, time);
        hand.spheres.push(sphere(&here, HAND_RADIUS, HUMAN_COLOR));
        let mut torso = moving(TORSO, time);
        capsule(&mut torso, &here, (TORSO_RADIUS, TORSO_HEIGHT - 2.0 * TORSO_RADIUS), HUMAN_COLOR);
        entities.extend([object, hand, torso]);
    } else {
        let mut human = moving(HUMAN, time);
        human.spheres.push(sphere(&here, 0.1, HUMAN_COLOR));
        entities.push(human);
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

/// A link's visual shapes, or its collision shapes if the visual ones are meshes, or none.
fn link(link: &Link, time: u64) -> Option<SceneEntity> {
    let plain = |g: &&Geometry| !matches!(g.shape, Shape::Mesh { .. });
    let shapes = if link.visuals.iter().any(|g| plain(&g)) { &link.visuals } else { &link.collisions };
    let mut drawn = moving(&link_frame(&link.name), time);
    for geometry in shapes.iter().filter(plain) {
        let (at, rgba) = (&geometry.link_from_shape, geometry.color.unwrap_or(ROBOT));
        match &geometry.shape {
            Shape::Box { size } => drawn.cubes.push(cube(at, *size, rgba)),
            Shape::Cylinder { radius, length } => {
                drawn.cylinders.push(cylinder(at, (*radius, *length), rgba));
            }
            Shape::Capsule { radius, length } => capsule(&mut drawn, at, (*radius, *length), rgba),
            Shape::Sphere { radius } => drawn.spheres.push(sphere(at, *radius, rgba)),
            Shape::Mesh { .. } => {}
        }
    }
    (drawn.cubes.len() + drawn.cylinders.len() + drawn.spheres.len() > 0).then_some(drawn)
}

fn cube(at: &Pose, size: Vector3<f64>, rgba: [f32; 4]) -> CubePrimitive {
    CubePrimitive { pose: pose(at), size: vector(&size), color: color(rgba) }
}

fn sphere(at: &Pose, radius: f64, rgba: [f32; 4]) -> SpherePrimitive {
    SpherePrimitive { pose: pose(at), size: vector(&Vector3::repeat(2.0 * radius)), color: color(rgba) }
}

fn cylinder(at: &Pose, (radius, length): (f64, f64), rgba: [f32; 4]) -> CylinderPrimitive {
    CylinderPrimitive {
        pose: pose(at),
        size: vector(&Vector3::new(2.0 * radius, 2.0 * radius, length)),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: color(rgba),
    }
}

/// A capsule along z: a cylinder between two balls.
fn capsule(drawn: &mut SceneEntity, at: &Pose, (radius, length): (f64, f64), rgba: [f32; 4]) {
    drawn.cylinders.push(cylinder(at, (radius, length), rgba));
    let end = |z: f64| sphere(&(at * Pose::translation(0.0, 0.0, z)), radius, rgba);
    drawn.spheres.extend([end(-length / 2.0), end(length / 2.0)]);
}

/// The options from the start. Width and opacity show their probability.
#[derive(Clone, Debug)]
pub(super) struct Ways {
    lines: Vec<(String, Vec<Point>)>,
    shown: Vec<u32>,
}

impl Ways {
    pub fn new(options: &OptionSet) -> Self {
        let start = options.begin();
        let drawn = options.options().iter().enumerate().map(|(o, option)| {
            let path = options.path(&start, o).unwrap_or_default();
            (option.name.clone(), path.polyline(SAGITTA))
        });
        Self { lines: drawn.collect(), shown: Vec::new() }
    }

    /// The lines; `None` if they look the same as before.
    pub fn update(&mut self, tick: &Tick, time: u64) -> Option<SceneUpdate> {
        // options without P_o are drawn as improbable
        let level = |p: f64| (p.max(0.0) / PROBABILITY_STEP).round() as u32;
        let levels: Vec<u32> = tick.options.iter().map(|o| level(o.probability)).collect();
        if levels == self.shown {
            return None;
        }
        self.shown = levels;
        let entities = self.lines.iter().zip(&self.shown).enumerate().map(|(o, ((name, points), level))| {
            let probability = (f64::from(*level) * PROBABILITY_STEP).min(1.0);
            let [r, g, b] = OPTION_COLORS[o % OPTION_COLORS.len()];
            let rgba = [r, g, b, 0.25 + 0.75 * probability as f32];
            // options on the same path are drawn one above the other
            let z = 0.03 + 0.005 * o as f64;
            let line = line(points, z, 0.02 + 0.18 * probability, rgba);
            SceneEntity { lines: vec![line], ..entity(WORLD, format!("option/{name}"), time) }
        });
        Some(SceneUpdate { deletions: Vec::new(), entities: entities.collect() })
    }
}

/// The path walked, and the path ahead.
pub(super) fn path(walked: &[Point], ahead: &Path, time: u64) -> SceneUpdate {
    let ahead = ahead.polyline(SAGITTA);
    let drawn = [("walked", walked, 0.06, WALKED), ("ahead", &ahead, 0.03, AHEAD)];
    let entities = drawn.map(|(id, points, thickness, rgba)| SceneEntity {
        lines: vec![line(points, 0.1, thickness, rgba)],
        ..entity(WORLD, id.to_owned(), time)
    });
    SceneUpdate { deletions: Vec::new(), entities: entities.into() }
}

/// Whether `b` lies on the straight line from `a` to `c`, so that a line through all three does not need it.
pub(super) fn is_between(a: Point, b: Point, c: Point) -> bool {
    let (to, on): (Vector, Vector) = (c - a, b - a);
    let length = to.norm();
    length > 0.0 && (cross(to, on) / length).abs() < 0.002 && on.dot(&to) >= 0.0
}

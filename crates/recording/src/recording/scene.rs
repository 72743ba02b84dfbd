//! The scene of a recording: the shapes of world, robot and episode that a viewer draws.
//!
//! Every message of a channel has the channel's complete scene, so that a viewer who jumps in time only needs
//! the latest message.

use super::frames::{OBJECT, WORLD, link_frame, vector};
use super::human;
use super::meshes::Meshes;
use super::overview::Overview;
use super::shapes::{Shapes, at, color, entity, line, moving, pose, prism, rgba, text};
use cocarry::episode::Tick;
use cocarry::geometry::{Footprint, Path, Point, Pose, Vector, angle_of, cross};
use cocarry::options::OptionSet;
use cocarry::robot::{Geometry, Link, Robot, Shape};
use cocarry::world::{Obstacle, Opening, World};
use cocarry_output::palette;
use foxglove::messages::{CubePrimitive, CylinderPrimitive, SceneEntity, SceneUpdate};
use nalgebra::{Rotation3, Vector3};

/// The largest distance of an arc from its chords, m.
const SAGITTA: f64 = 0.01;
/// The largest number of options with a label.
const MAX_LABELS: usize = 20;
/// The resolution of P_o in the drawing.
const PROBABILITY_STEP: f64 = 0.02;

const OBSTACLE: [f32; 4] = [0.55, 0.55, 0.58, 1.0];
/// The line between an opening and its label.
const LEADER: [f32; 4] = [0.1, 0.1, 0.1, 0.5];

/// The world: obstacles, openings coloured by their risk, start and target.
pub(super) fn world(world: &World, options: &OptionSet, time: u64) -> SceneUpdate {
    let obstacles = world.obstacles.iter().map(|o| obstacle(o, time));
    let labels = opening_labels(world, options);
    let openings = world
        .openings
        .iter()
        .zip(&labels)
        .map(|(o, (words, place))| opening(o, world.robot_width, words, *place, time));
    let end = |name: &str, place: Point| {
        let disc = CylinderPrimitive {
            pose: at(place.x, place.y, 0.005),
            size: vector(&Vector3::new(0.3, 0.3, 0.01)),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: color([0.1, 0.1, 0.1, 0.8]),
        };
        let entity = entity(WORLD, format!("end/{name}"), time);
        SceneEntity {
            cylinders: vec![disc],
            texts: vec![text(name, place, 0.3, rgba(palette::INK))],
            ..entity
        }
    };
    let ends = [end("A", world.start), end("B", world.target)];
    SceneUpdate { deletions: Vec::new(), entities: obstacles.chain(openings).chain(ends).collect() }
}

fn obstacle(obstacle: &Obstacle, time: u64) -> SceneEntity {
    let mut drawn = entity(WORLD, format!("obstacle/{}", obstacle.name), time);
    obstacle.footprints().for_each(|part| add_part(&mut drawn, obstacle, part));
    drawn
}

fn add_part(drawn: &mut SceneEntity, obstacle: &Obstacle, part: &Footprint) {
    let height = obstacle.height;
    match part {
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
        Footprint::Polygon(corners) => drawn.triangles.push(prism(corners, height, OBSTACLE)),
    }
}

/// The words on every opening, and their place (floor, height): above all obstacles, which would hide them, and
/// apart in the view of the whole scene.
pub(super) fn opening_labels(world: &World, options: &OptionSet) -> Vec<(String, (Point, f64))> {
    let words = |o: &Opening| {
        let risk = o.risk(world.robot_width);
        (o.center(), format!("{}: {:.2} m\nrisk {risk:.2}", o.name, o.width))
    };
    let labels: Vec<(Point, String)> = world.openings.iter().map(words).collect();
    let top = world.obstacles.iter().map(|o| o.height).fold(0.0, f64::max);
    let places = Overview::of(world, options).places(&labels, top + 0.25);
    labels.into_iter().map(|(_, words)| words).zip(places).collect()
}

/// An opening, with words at a place and a line to them.
fn opening(
    opening: &Opening,
    robot_width: f64,
    words: &str,
    (floor, height): (Point, f64),
    time: u64,
) -> SceneEntity {
    let bar = line(&opening.ends, 0.02, 0.08, rgba(palette::risk_colour(opening.risk(robot_width))));
    let mut leader = line(&[opening.center(), floor], 0.02, 0.02, LEADER);
    leader.points[1].z = height;
    SceneEntity {
        lines: vec![bar, leader],
        texts: vec![text(words, floor, height, rgba(palette::INK))],
        ..entity(WORLD, format!("opening/{}", opening.name), time)
    }
}

/// The shapes of the team: the robot, the object and the human. `meshes` are the files of its visual shapes;
/// links whose files it lacks are drawn with their collision shapes.
pub(super) fn team(robot: &Robot, world: &World, meshes: &Meshes, time: u64) -> SceneUpdate {
    let mut entities: Vec<SceneEntity> = robot.links.iter().filter_map(|l| link(l, meshes, time)).collect();
    let mut object = moving(OBJECT, time);
    object.cube(&Pose::identity(), world.object.size.into(), rgba(palette::OBJECT));
    entities.push(object);
    entities.extend(human::shapes(time));
    SceneUpdate { deletions: Vec::new(), entities }
}

/// A link's visual shapes, or its collision shapes if the visual ones are meshes that are missing, or
/// none.
fn link(link: &Link, meshes: &Meshes, time: u64) -> Option<SceneEntity> {
    let is_drawn = |g: &&Geometry| match &g.shape {
        Shape::Mesh { file, .. } => meshes.get(file).is_some(),
        _ => true,
    };
    let shapes = if link.visuals.iter().any(|g| is_drawn(&g)) { &link.visuals } else { &link.collisions };
    let mut drawn = moving(&link_frame(&link.name), time);
    for geometry in shapes.iter().filter(is_drawn) {
        let (at, given) = (&geometry.link_from_shape, geometry.color);
        let rgba = given.unwrap_or(rgba(palette::ROBOT));
        match &geometry.shape {
            Shape::Box { size } => drawn.cube(at, *size, rgba),
            Shape::Cylinder { radius, length } => drawn.cylinder(at, *radius, *length, rgba),
            Shape::Capsule { radius, length } => drawn.capsule(at, *radius, *length, rgba),
            Shape::Sphere { radius } => drawn.ball(at, Vector3::repeat(2.0 * radius), rgba),
            Shape::Mesh { file, scale, .. } => {
                if let Some(mesh) = meshes.get(file) {
                    mesh.draw(&mut drawn, at, *scale, given);
                }
            }
        }
    }
    let solids = drawn.cubes.len() + drawn.cylinders.len() + drawn.spheres.len() + drawn.models.len();
    (solids > 0).then_some(drawn)
}

/// The options from the start. Width and opacity show their probability.
#[derive(Clone, Debug)]
pub(super) struct OptionLines {
    lines: Vec<OptionLine>,
    shown: Vec<u32>,
}

/// An option's path, and where its name is.
#[derive(Clone, Debug)]
struct OptionLine {
    name: String,
    points: Vec<Point>,
    label: Option<Point>,
}

/// The point of a path that is farthest from all others: there its label is not mistaken.
fn apart(path: &[Point], others: &[&Vec<Point>]) -> Option<Point> {
    const STEP_M: f64 = 0.25;
    let spaced = |line: &[Point]| -> Vec<Point> {
        let parts = line.windows(2).flat_map(|part| {
            let steps = ((part[1] - part[0]).norm() / STEP_M).ceil().clamp(1.0, 400.0) as usize;
            let [from, to] = [part[0], part[1]];
            (0..steps).map(move |i| from + (to - from) * (i as f64 / steps as f64))
        });
        parts.take(2000).collect()
    };
    let others: Vec<Point> = others.iter().flat_map(|other| spaced(other)).collect();
    let gap = |p: &Point| others.iter().map(|q| (p - q).norm()).fold(4.0, f64::min);
    spaced(path)
        .into_iter()
        .map(|p| (p, gap(&p)))
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
        .map(|(p, _)| p)
}

impl OptionLines {
    pub fn new(options: &OptionSet) -> Self {
        let start = options.begin();
        let all = 0..options.options().len();
        let paths: Vec<Vec<Point>> = all
            .map(|o| options.path(&start, o).expect("an option has a path from the start").polyline(SAGITTA))
            .collect();
        let lines = options.options().iter().zip(&paths).enumerate().map(|(o, (option, points))| {
            let others = paths.iter().enumerate().filter(|(other, _)| *other != o && o < MAX_LABELS);
            let others: Vec<&Vec<Point>> = others.take(MAX_LABELS).map(|(_, path)| path).collect();
            let label = if o < MAX_LABELS { apart(points, &others) } else { None };
            OptionLine { name: option.name.clone(), points: points.clone(), label }
        });
        Self { lines: lines.collect(), shown: Vec::new() }
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
        let entities = self.lines.iter().zip(&self.shown).enumerate().map(|(o, (drawn, level))| {
            let probability = (f64::from(*level) * PROBABILITY_STEP).min(1.0);
            let [r, g, b, opaque] = rgba(palette::option_colour(o));
            let faded = [r, g, b, 0.35 + 0.65 * probability as f32];
            // options on the same path are drawn one above the other
            let z = 0.03 + 0.005 * o as f64;
            let line = line(&drawn.points, z, 0.02 + 0.18 * probability, faded);
            let words = format!("option {}", drawn.name);
            // on a light ground
            let label =
                drawn.label.map(|place| text(&words, place, 0.15, [0.7 * r, 0.7 * g, 0.7 * b, opaque]));
            let entity = entity(WORLD, format!("option/{}", drawn.name), time);
            SceneEntity { lines: vec![line], texts: label.into_iter().collect(), ..entity }
        });
        Some(SceneUpdate { deletions: Vec::new(), entities: entities.collect() })
    }
}

/// Colour of the path walked, and of the path ahead, which is not an option's.
const WALKED: [f32; 4] = [0.1, 0.1, 0.1, 1.0];
const AHEAD: [f32; 4] = [0.1, 0.1, 0.1, 0.45];

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

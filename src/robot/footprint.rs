//! The outline of a base on the floor: a disc about its drive, or what `base_footprint` of its robot file
//! says.

use super::Robot;
use super::collision;
use super::link::Shape;
use crate::error::{Error, Place};
use crate::geometry::{Footprint, Point, Pose, Vector, convex_hull, direction, with_fewer_corners};
use crate::located::Source;
use crate::math;
use nalgebra::{Point3, Vector3};
use toml::{Spanned, Value};

/// The key.
const KEY: &str = "base_footprint";
/// The least number of corners of a list, the largest number, and the largest number around shapes.
const MIN_CORNERS: usize = 3;
const MAX_CORNERS: usize = 64;
const MAX_CORNERS_OF_SHAPES: usize = 32;
/// The largest coordinate of a corner, m.
const MAX_COORDINATE_M: f64 = 10.0;
/// The least extent of a footprint in any direction, m.
const MIN_EXTENT_M: f64 = 0.01;
/// How far (m) a footprint may be outside the shapes that it is around, for fewer corners.
const LEFT_OUT_M: f64 = 0.002;
/// Corners of the polygon around a circle.
const CORNERS_OF_CIRCLE: u32 = 24;

/// The footprint that a robot file asks for.
pub(super) enum Asked {
    /// A disc about the drive, as wide as the base.
    Disc,
    /// A polygon around the base's collision shapes, with the place of the key.
    Collision(Place),
    /// These corners, counter-clockwise.
    Corners(Vec<Point>),
}

impl Asked {
    /// The corners that are given.
    pub fn corners(&self) -> Option<&[Point]> {
        match self {
            Self::Corners(corners) => Some(corners),
            Self::Disc | Self::Collision(_) => None,
        }
    }
}

/// The footprint that the key asks for.
pub(super) fn asked(source: Source, entry: &Option<Spanned<Value>>) -> Result<Asked, Error> {
    let Some(spanned) = entry else { return Ok(Asked::Disc) };
    let place = || source.place(spanned, "robot");
    let refused = |why: String| Error::at(place(), why);
    let list = match spanned.get_ref() {
        Value::String(word) if word == "collision" => return Ok(Asked::Collision(place())),
        Value::Array(list) => list,
        other => {
            return Err(refused(format!(
                "{KEY} = {}; it must be \"collision\", or a list of corners [[x, y], ...] in metres",
                shortened(other)
            )));
        }
    };
    if !(MIN_CORNERS..=MAX_CORNERS).contains(&list.len()) {
        let count = list.len();
        return Err(refused(format!(
            "{KEY} has {count} corners; it must have {MIN_CORNERS} to {MAX_CORNERS}"
        )));
    }
    let mut corners = Vec::with_capacity(list.len());
    for (i, entry) in list.iter().enumerate() {
        let numbers = entry.as_array().map(|pair| pair.iter().map(number).collect::<Option<Vec<f64>>>());
        let Some(Some([x, y])) = numbers.as_ref().map(|n| n.as_deref()) else {
            let found = shortened(entry);
            return Err(refused(format!("{KEY}[{i}] = {found}; it must be a corner [x, y] in metres")));
        };
        for (axis, value) in [x, y].into_iter().enumerate() {
            if value.is_nan() || value.abs() > MAX_COORDINATE_M {
                let expected = format!("from -{MAX_COORDINATE_M} to {MAX_COORDINATE_M} (metres)");
                return Err(Error::number(place(), &format!("{KEY}[{i}][{axis}]"), *value, &expected));
            }
        }
        corners.push(Point::new(*x, *y));
    }
    checked(corners).map(Asked::Corners).map_err(refused)
}

/// Gives the robot the footprint that is asked for. `has_shapes`: before others stand in for those that are
/// missing.
pub(super) fn set(robot: &mut Robot, asked: Asked, has_shapes: bool) -> Result<(), Error> {
    let corners = match asked {
        Asked::Disc => return Ok(()),
        Asked::Corners(corners) => corners,
        Asked::Collision(place) if !has_shapes => {
            let base = &robot.links[robot.base_link].name;
            return Err(Error::at(
                place,
                format_args!(
                    "{KEY} = \"collision\", but `{base}` has no collision shape; give corners [[x, y], ...] in metres"
                ),
            ));
        }
        Asked::Collision(place) => around_shapes(robot).map_err(|why| Error::at(place, why))?,
    };
    robot.drive.base_radius = corners.iter().map(|c| math::hypot(c.x, c.y)).fold(0.0, f64::max);
    robot.footprint = Footprint::Polygon(corners);
    Ok(())
}

/// Twice the largest distance of a footprint from the middle of the base, m: the width of an opening that
/// it needs when it goes straight.
pub(super) fn across(footprint: &Footprint) -> f64 {
    2.0 * footprint.reach(Vector::y()).max(footprint.reach(-Vector::y()))
}

/// The corners of the polygon around the base's collision shapes, wheels included.
pub(super) fn around_shapes(robot: &Robot) -> Result<Vec<Point>, String> {
    let mut points = Vec::new();
    for (drive_from_shape, shape) in collision::base_shapes(robot) {
        add_outline(&drive_from_shape, shape, &mut points);
    }
    let hull = convex_hull(&points);
    checked(with_fewer_corners(hull, MAX_CORNERS_OF_SHAPES, LEFT_OUT_M))
}

/// Adds points whose hull has the shape, seen from above, inside.
fn add_outline(drive_from_shape: &Pose, shape: &Shape, points: &mut Vec<Point>) {
    let mut add = |v: Vector3<f64>| points.push((drive_from_shape * Point3::from(v)).xy());
    // around a circle of radius 1
    let around = || {
        let part = std::f64::consts::TAU / f64::from(CORNERS_OF_CIRCLE);
        let out = 1.0 / math::cos(part / 2.0);
        (0..CORNERS_OF_CIRCLE).map(move |i| direction(f64::from(i) * part) * out)
    };
    let ends = |length: f64| [-length / 2.0, length / 2.0];
    match shape {
        Shape::Cylinder { radius, length } => {
            for z in ends(*length) {
                around().for_each(|at| add(Vector3::new(radius * at.x, radius * at.y, z)));
            }
        }
        Shape::Capsule { radius, length } => {
            for z in ends(*length) {
                let middle = (drive_from_shape * Point3::new(0.0, 0.0, z)).xy();
                points.extend(around().map(|at| middle + at * *radius));
            }
        }
        Shape::Sphere { radius } => {
            let middle = drive_from_shape.translation.vector.xy();
            points.extend(around().map(|at| Point::from(middle + at * *radius)));
        }
        Shape::Box { .. } | Shape::Mesh { .. } => {
            collision::corners(shape).into_iter().for_each(|(corner, _)| add(corner));
        }
    }
}

/// The convex hull of some corners, if it is a footprint.
fn checked(corners: Vec<Point>) -> Result<Vec<Point>, String> {
    let hull = convex_hull(&corners);
    let n = hull.len();
    let across = |i: usize| {
        let (a, b) = (hull[i], hull[(i + 1) % n]);
        let along = (b - a).normalize();
        hull.iter().map(|c| crate::geometry::cross(along, c - a)).fold(0.0, f64::max)
    };
    let narrowest = if n < 3 { 0.0 } else { (0..n).map(across).fold(f64::INFINITY, f64::min) };
    if narrowest < MIN_EXTENT_M {
        return Err(format!(
            "{KEY} is {narrowest:.4} m across where it is narrowest; its corners must be around an area at least {MIN_EXTENT_M} m across"
        ));
    }
    let (least, most) = hull.iter().fold((hull[0], hull[0]), |(a, b), c| (a.inf(c), b.sup(c)));
    let hull = Footprint::Polygon(hull);
    if hull.separation(Point::origin()).0 >= 0.0 {
        return Err(format!(
            "{KEY}, from x = {:.3} to {:.3} and y = {:.3} to {:.3} m, does not have the middle of the drive (0, 0) inside; its corners must be around it, x ahead and y to the left",
            least.x, most.x, least.y, most.y
        ));
    }
    let Footprint::Polygon(corners) = hull else { return Ok(corners) };
    Ok(corners)
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// A value as in a file, its beginning only where it is long.
fn shortened(value: &Value) -> String {
    const MAX_CHARACTERS: usize = 40;
    let text = value.to_string();
    match text.char_indices().nth(MAX_CHARACTERS) {
        Some((at, _)) => format!("{}...", &text[..at]),
        None => text,
    }
}

//! Upright obstacles with their outlines and solids.

use super::file::{ObstacleEntry, ShapeEntry};
use super::values::Pair;
use crate::error::{Error, Place};
use crate::geometry::{Bounds, Footprint, Outline, Point, RingFault, Vector, cross, direction, left_of};
use crate::math;
use parry3d::math::{Pose, Rotation, Vec3};
use parry3d::shape::{Shape, SharedShape};

/// Largest coordinate, m. Larger ones are mistakes of units and exceed what the tolerances can resolve.
const MAX_COORDINATE_M: f64 = 1e4;
/// Largest coordinate of `origin_m`, m: doubles resolve 15 nm there.
const MAX_ORIGIN_M: f64 = 1e8;
/// Shortest side of an obstacle, m.
const MIN_LENGTH_M: f64 = 1e-3;

/// The largest number of corners of an outline.
const MAX_CORNERS: usize = 20_000;
/// Convex polygons with more corners than this are covered by several parts.
const MAX_PART_CORNERS: usize = 64;
/// The thickness of a room's walls where they are thinnest, m.
const ROOM_WALL_M: f64 = 0.2;

/// An upright obstacle that stands on the floor.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name, unique in its world.
    pub name: String,
    /// Height, m.
    pub height: f64,
    /// Convex parts that cover it: one, unless it is concave.
    pub parts: Vec<Part>,
    /// The outline of a concave one.
    pub outline: Option<Outline>,
    shape: ShapeEntry,
}

/// A convex part of an obstacle.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its outline on the floor.
    pub footprint: Footprint,
    height: f64,
    solid: Solid,
    shape: SharedShape,
}

/// The parameters from which the outline and the shape of a part are made.
#[derive(Clone, Debug, PartialEq)]
enum Solid {
    Box { center: Point, size: [f64; 2], yaw: f64 },
    Cylinder { center: Point, radius: f64 },
    Prism { corners: Vec<Point> },
}

impl Obstacle {
    /// The obstacle of an entry whose coordinates are relative to `origin`.
    pub(super) fn from_entry(entry: &ObstacleEntry, place: &Place, origin: Vector) -> Result<Self, Error> {
        let check = Check { place, origin };
        let shape = entry.shape.name();
        let given = [
            ("center_m", entry.center_m.is_some(), "box cylinder"),
            ("size_m", entry.size_m.is_some(), "box"),
            ("yaw_deg", entry.yaw_deg.is_some(), "box"),
            ("radius_m", entry.radius_m.is_some(), "cylinder"),
            ("vertices_m", entry.vertices_m.is_some(), "polygon room"),
            ("holes_m", entry.holes_m.is_some(), "polygon"),
        ];
        for (field, is_given, shapes) in given {
            if is_given && !shapes.contains(shape) {
                return Err(Error::at(place.clone(), format_args!("a {shape} takes no {field}")));
            }
        }
        let missing = |field| Error::at(place.clone(), format_args!("a {shape} needs {field}"));
        let extreme = || {
            Error::at(
                place.clone(),
                "its proportions are too extreme for a solid; use corners and a height of similar size",
            )
        };
        let height = check.size("height_m", entry.height_m)?;
        type Shape = (Vec<Part>, Option<Outline>);
        let single = |solid: Solid| -> Result<Shape, Error> {
            let part = Part::new(solid, height).ok_or_else(extreme)?;
            Ok((vec![part], None))
        };
        let concave = |outline: Result<Outline, RingFault>| -> Result<Shape, Error> {
            let outline = outline.map_err(|fault| check.fault(fault))?;
            let parts = outline.parts().ok_or_else(extreme)?;
            let parts = parts.into_iter().filter_map(|corners| Part::new(Solid::Prism { corners }, height));
            Ok((parts.collect(), Some(outline)))
        };
        let (parts, outline) = match entry.shape {
            ShapeEntry::Box => {
                let size = entry.size_m.ok_or_else(|| missing("size_m"))?.0;
                single(Solid::Box {
                    center: check.point("center_m", entry.center_m.ok_or_else(|| missing("center_m"))?.0)?,
                    size: [check.size("size_m[0]", size[0])?, check.size("size_m[1]", size[1])?],
                    yaw: check.angle("yaw_deg", entry.yaw_deg.unwrap_or(0.0))?.to_radians(),
                })
            }
            ShapeEntry::Cylinder => single(Solid::Cylinder {
                center: check.point("center_m", entry.center_m.ok_or_else(|| missing("center_m"))?.0)?,
                radius: check.size("radius_m", entry.radius_m.ok_or_else(|| missing("radius_m"))?)?,
            }),
            ShapeEntry::Polygon | ShapeEntry::Room => {
                let vertices = entry.vertices_m.as_ref().ok_or_else(|| missing("vertices_m"))?;
                let ring = check.ring("vertices_m", vertices)?;
                match (entry.shape, &entry.holes_m) {
                    (ShapeEntry::Room, _) => concave(Outline::around(ring, ROOM_WALL_M)),
                    (_, Some(holes)) => {
                        let hole = |(i, hole): (usize, &Vec<_>)| check.ring(&format!("holes_m[{i}]"), hole);
                        let holes = holes.iter().enumerate().map(hole).collect::<Result<_, _>>()?;
                        concave(Outline::with_holes(ring, holes))
                    }
                    _ => match convex(&ring).filter(|corners| corners.len() <= MAX_PART_CORNERS) {
                        Some(corners) => single(Solid::Prism { corners }),
                        None => concave(Outline::inside(ring)),
                    },
                }
            }
        }?;
        Ok(Self { name: entry.name.clone(), height, parts, outline, shape: entry.shape })
    }

    /// The convex outlines that cover it.
    pub fn footprints(&self) -> impl Iterator<Item = &Footprint> {
        self.parts.iter().map(|part| &part.footprint)
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Bounds {
        let corners = self.footprints().map(Footprint::bounds).flat_map(|b| [b.min, b.max]);
        Bounds::around(corners).unwrap_or(Bounds { min: Point::origin(), max: Point::origin() })
    }

    /// Distance (m) from `p`; 0 inside.
    pub fn distance_to_point(&self, p: Point) -> f64 {
        self.footprints().map(|part| part.distance_to_point(p)).fold(f64::INFINITY, f64::min)
    }

    /// Distance (m) from the segment `a b`; 0 where they meet.
    pub fn distance_to_segment(&self, a: Point, b: Point) -> f64 {
        self.footprints().map(|part| part.distance_to_segment(a, b)).fold(f64::INFINITY, f64::min)
    }

    /// It alone, as what paths keep clear of.
    pub(super) fn solid(&self) -> crate::geometry::Solid {
        match &self.outline {
            None => crate::geometry::Solid::single(self.parts[0].footprint.clone()),
            Some(outline) => crate::geometry::Solid {
                parts: self.footprints().cloned().collect(),
                corners: outline.corners().collect(),
            },
        }
    }

    /// The rectangle of a box: its centre, its size along and across, m, and its yaw, rad; `None` for another
    /// shape.
    pub fn rectangle(&self) -> Option<(Point, [f64; 2], f64)> {
        match (self.shape, self.parts.first().map(|part| &part.solid)) {
            (ShapeEntry::Box, Some(Solid::Box { center, size, yaw })) => Some((*center, *size, *yaw)),
            _ => None,
        }
    }

    /// The name of the shape in a world file.
    pub fn shape_name(&self) -> &'static str {
        self.shape.name()
    }

    /// A point inside the outline, used to place a label.
    pub fn middle(&self) -> Point {
        let extent = |part: &&Part| part.footprint.bounds().size().norm_squared();
        let widest = self.parts.iter().max_by(|a, b| extent(a).total_cmp(&extent(b)));
        widest.map_or(self.bounds().min, Part::middle)
    }
}

impl Part {
    fn new(solid: Solid, height: f64) -> Option<Self> {
        let shape = solid.shape(height)?;
        Some(Self { footprint: solid.footprint(), height, solid, shape })
    }

    pub(super) fn is_box(&self) -> bool {
        matches!(self.solid, Solid::Box { .. })
    }

    /// The solid as a parry shape with its pose, `world_from_solid`. Its base is at z = 0.
    pub fn solid(&self) -> (Pose, &dyn Shape) {
        let middle = self.middle();
        let translation = Vec3::new(middle.x, middle.y, self.height / 2.0);
        let rotation = match &self.solid {
            Solid::Box { yaw, .. } => Rotation::from_rotation_z(*yaw),
            // parry's cylinder is aligned with y
            Solid::Cylinder { .. } => Rotation::from_rotation_x(std::f64::consts::FRAC_PI_2),
            Solid::Prism { .. } => Rotation::IDENTITY,
        };
        (Pose::from_parts(translation, rotation), &*self.shape)
    }

    fn middle(&self) -> Point {
        match &self.solid {
            Solid::Box { center, .. } | Solid::Cylinder { center, .. } => *center,
            Solid::Prism { corners } => centroid(corners),
        }
    }
}

impl Solid {
    /// The shape around its centre; `None` if its proportions are too extreme for parry.
    fn shape(&self, height: f64) -> Option<SharedShape> {
        let half_height = height / 2.0;
        match self {
            Self::Box { size, .. } => Some(SharedShape::cuboid(size[0] / 2.0, size[1] / 2.0, half_height)),
            Self::Cylinder { radius, .. } => Some(SharedShape::cylinder(half_height, *radius)),
            Self::Prism { corners } => {
                let middle = centroid(corners);
                let level =
                    |z: f64| corners.iter().map(move |c| Vec3::new(c.x - middle.x, c.y - middle.y, z));
                let points: Vec<Vec3> = level(-half_height).chain(level(half_height)).collect();
                SharedShape::convex_hull(&points)
            }
        }
    }

    fn footprint(&self) -> Footprint {
        match self {
            Self::Box { center, size, yaw } => {
                let along = direction(*yaw) * (size[0] / 2.0);
                let across = left_of(direction(*yaw)) * (size[1] / 2.0);
                Footprint::Polygon(vec![
                    center - along - across,
                    center + along - across,
                    center + along + across,
                    center - along + across,
                ])
            }
            Self::Cylinder { center, radius } => Footprint::Disc { center: *center, radius: *radius },
            Self::Prism { corners } => Footprint::Polygon(corners.clone()),
        }
    }
}

fn centroid(corners: &[Point]) -> Point {
    Point::from(corners.iter().map(|c| c.coords).sum::<crate::geometry::Vector>() / corners.len() as f64)
}

/// Checks of single numbers. Errors name the place.
pub(super) struct Check<'a> {
    pub place: &'a Place,
    /// The file's `origin_m`, which points are read relative to.
    pub origin: Vector,
}

impl Check<'_> {
    fn number(&self, field: &str, value: f64, good: bool, expected: &str) -> Result<f64, Error> {
        if good { Ok(value) } else { Err(Error::number(self.place.clone(), field, value, expected)) }
    }

    pub fn size(&self, field: &str, value: f64) -> Result<f64, Error> {
        let good = (MIN_LENGTH_M..=MAX_COORDINATE_M).contains(&value);
        self.number(field, value, good, "a length from 0.001 to 10000 (metres)")
    }

    /// A point in the world frame, from its coordinates in the file.
    pub fn point(&self, field: &str, [x, y]: [f64; 2]) -> Result<Point, Error> {
        let expected = "a coordinate from -10000 to 10000 (metres); for larger ones, as in maps, give origin_m = [x, y] near the room";
        let point = Point::new(x, y) - self.origin;
        self.number(&format!("{field}[0]"), x, point.x.abs() <= MAX_COORDINATE_M, expected)?;
        self.number(&format!("{field}[1]"), y, point.y.abs() <= MAX_COORDINATE_M, expected)?;
        Ok(point)
    }

    /// The origin of a file's coordinates.
    pub fn origin(&self, [x, y]: [f64; 2]) -> Result<Vector, Error> {
        let expected = "a coordinate from -100000000 to 100000000 (metres)";
        self.number("origin_m[0]", x, x.abs() <= MAX_ORIGIN_M, expected)?;
        self.number("origin_m[1]", y, y.abs() <= MAX_ORIGIN_M, expected)?;
        Ok(Vector::new(x, y))
    }

    pub fn angle(&self, field: &str, value: f64) -> Result<f64, Error> {
        self.number(field, value, value.abs() <= 360.0, "an angle from -360 to 360 (degrees)")
    }

    /// The corners of a polygon. The last may repeat the first.
    fn ring(&self, field: &str, vertices: &[Pair<f64>]) -> Result<Vec<Point>, Error> {
        let mut corners: Vec<Point> = vertices
            .iter()
            .enumerate()
            .map(|(i, v)| self.point(&format!("{field}[{i}]"), v.0))
            .collect::<Result<_, _>>()?;
        if corners.len() > 3 && corners.first() == corners.last() {
            corners.pop();
        }
        if !(3..=MAX_CORNERS).contains(&corners.len()) {
            let count = corners.len();
            let sentence = format_args!("{count} corners in {field}; a polygon needs 3 to {MAX_CORNERS}");
            return Err(Error::at(self.place.clone(), sentence));
        }
        Ok(corners)
    }

    fn fault(&self, fault: RingFault) -> Error {
        let place = self.place.clone();
        match fault {
            RingFault::Flat => Error::at(place, "all corners of an outline are on one line"),
            RingFault::Crossing { from } => Error::at(
                place,
                format_args!(
                    "the side of its outline that begins at ({}, {}) crosses or touches another side; list the corners in order around the outline",
                    from.x, from.y
                ),
            ),
        }
    }
}

/// The corners of a convex polygon, counter-clockwise; `None` if it is not convex, has corners that are closer
/// together than a millimetre, or three on a line.
fn convex(corners: &[Point]) -> Option<Vec<Point>> {
    let n = corners.len();
    let area: f64 = (0..n).map(|i| cross(corners[i].coords, corners[(i + 1) % n].coords)).sum::<f64>() / 2.0;
    let clockwise = area < 0.0;
    let mut turned = 0.0;
    for i in 0..n {
        let before = corners[i] - corners[(i + n - 1) % n];
        let after = corners[(i + 1) % n] - corners[i];
        let turn = cross(before, after) * if clockwise { -1.0 } else { 1.0 };
        // a star turns left at every corner too, but more than once around
        turned += math::atan2(turn, before.dot(&after));
        let once_around = turned < std::f64::consts::TAU + 1e-6;
        if turn <= 1e-9 * before.norm() * after.norm() || before.norm() < MIN_LENGTH_M || !once_around {
            return None;
        }
    }
    let mut corners = corners.to_vec();
    if clockwise {
        corners.reverse();
    }
    Some(corners)
}

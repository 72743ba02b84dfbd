//! How far the straight lines that leave a circle, or a point, can lead before an obstacle or a closed gap
//! ends them. Lines that would be longer need not be tried.

use super::space::{LOOKUP_MARGIN_M, Space};
use crate::geometry::{Bounds, Footprint, Nearby, Point, Vector, angle_of, wrap_angle};
use crate::math;
use std::f64::consts::TAU;

/// The radius (m) around a source within which blocks are first looked for.
const FIRST_RADIUS_M: f64 = 2.0;
/// The factor by which this radius grows until the blocks within it hide all that is farther away.
const RADIUS_GROWTH: f64 = 1.5;
/// The number of blocks within the radius at which the view counts as open.
const MAX_BLOCKS: usize = 600;
/// The number of obstacles up to which all lines are tried at once.
const FEW_OBSTACLES: usize = 50;
/// The part of a block that is closer to a point than this (m) is left out.
const MIN_RADIUS_M: f64 = 1e-6;
/// The angle (rad) between two blocks below which no line passes between them: their ends lie in obstacles.
const NO_GAP_RAD: f64 = 1e-9;
/// The largest distance (m) from an obstacle to the end of a gap next to it.
const AT_OUTLINE_M: f64 = 1e-3;

/// Segments that no clear line crosses. There are none where obstacles are few, or where so few gaps join them
/// that nearly every view is open.
pub(super) struct Sight {
    blocks: Vec<[Point; 2]>,
    near: Nearby,
}

impl Sight {
    /// The sides of the obstacles, the barriers, and `closed` gaps, which are too narrow. Every gap is
    /// extended into the obstacles next to it, so that no slit is left at its ends.
    pub fn new(space: &Space, closed: &[[Point; 2]]) -> Self {
        let obstacles = space.obstacles.len();
        if obstacles <= FEW_OBSTACLES || space.barriers.len() + closed.len() < obstacles {
            return Self { blocks: Vec::new(), near: Nearby::new([]) };
        }
        let gaps = || space.barriers.iter().chain(closed);
        let mut blocks: Vec<[Point; 2]> = space.obstacles.iter().flat_map(|(o, _)| sides(o)).collect();
        blocks.extend(gaps());
        for end in gaps().flatten() {
            let within = AT_OUTLINE_M.min(space.clearance / 2.0);
            let near = Bounds { min: *end, max: *end }.grown(within);
            space.near_obstacles.any_meeting(near, |i| {
                let outline = &space.obstacles[i].0;
                if outline.distance_to_point(*end) <= within {
                    blocks.push([*end, inside(outline)]);
                }
                false
            });
        }
        let near = Nearby::new(blocks.iter().map(|[a, b]| Bounds { min: a.inf(b), max: a.sup(b) }));
        Self { blocks, near }
    }

    /// A bound of the distance (m) from `center` to the far end of any clear line that leaves the circle of
    /// this radius (m) in the direction of travel around it: counter-clockwise where `turn` is 1 and
    /// clockwise where it is -1. Infinite where the view is open.
    ///
    /// Such a line leaves the circle where the normal has some angle. Every point that is not inside the
    /// circle is on exactly one of these lines. A block ends the lines of all angles between those of its
    /// ends, because the angle changes continuously along it.
    pub fn limit(&self, center: Point, radius: f64, turn: f64) -> f64 {
        let radius = radius.max(MIN_RADIUS_M);
        let (mut before, mut within) = (0.0, radius + FIRST_RADIUS_M);
        let (mut ended, mut ended_angle) = (Vec::new(), 0.0);
        loop {
            let mut count = 0;
            self.near.any_meeting(Bounds { min: center, max: center }.grown(within), |i| {
                count += 1;
                let [a, b] = self.blocks[i].map(|p| p - center);
                let far = a.norm().max(b.norm());
                if before < far && far <= within {
                    outside(a, b, radius).into_iter().flatten().for_each(|[a, b]| {
                        let [first, last] = angles(a, b, radius, turn);
                        ended_angle += last - first;
                        ended.push([first, last]);
                        ended.push([first - TAU, last - TAU]);
                    });
                }
                false
            });
            if ended_angle > TAU - 1.0 && is_whole_turn(&mut ended) {
                return within + LOOKUP_MARGIN_M;
            }
            if count >= MAX_BLOCKS || count == self.blocks.len() {
                return f64::INFINITY;
            }
            (before, within) = (within, within * RADIUS_GROWTH);
        }
    }
}

/// The sides of an outline, or of a square in a disc.
fn sides(outline: &Footprint) -> Vec<[Point; 2]> {
    let corners = match outline {
        Footprint::Polygon(corners) => corners.clone(),
        Footprint::Disc { center, radius } => {
            let (x, y) = (Vector::x() * *radius, Vector::y() * *radius);
            vec![center - x, center - y, center + x, center + y]
        }
    };
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]).collect()
}

fn inside(outline: &Footprint) -> Point {
    match outline {
        Footprint::Polygon(corners) => nalgebra::center(&corners[0], &corners[corners.len() / 2]),
        Footprint::Disc { center, .. } => *center,
    }
}

/// The parts of the segment `a b` outside of the circle of this radius (m) around the origin.
fn outside(a: Vector, b: Vector, radius: f64) -> [Option<[Vector; 2]>; 2] {
    let along = b - a;
    let (qa, qb, qc) = (along.norm_squared(), a.dot(&along), a.norm_squared() - radius * radius);
    let discriminant = qb * qb - qa * qc;
    if discriminant <= 0.0 || qa == 0.0 {
        return [(qc >= 0.0).then_some([a, b]), None];
    }
    let root = discriminant.sqrt();
    let [enters, leaves] = [(-qb - root) / qa, (-qb + root) / qa];
    if enters >= 1.0 || leaves <= 0.0 {
        return [Some([a, b]), None];
    }
    [(enters > 0.0).then(|| [a, a + along * enters]), (leaves < 1.0).then(|| [a + along * leaves, b])]
}

/// The angles (rad) of the normals between which the lines from a circle around the origin meet the segment
/// `a b`, ascending, the first from 0 to a full turn.
fn angles(a: Vector, b: Vector, radius: f64, turn: f64) -> [f64; 2] {
    // the line that touches at the normal's angle has this angle more at a distance from the centre
    let ahead = |p: Vector| turn * math::acos((radius / p.norm()).min(1.0));
    let from = angle_of(a) - ahead(a);
    let by = wrap_angle(angle_of(b) - angle_of(a)) - (ahead(b) - ahead(a));
    let first = from.min(from + by).rem_euclid(TAU);
    [first, first + by.abs()]
}

/// Whether these intervals, sorted here, leave no gap between 0 and a full turn.
fn is_whole_turn(intervals: &mut [[f64; 2]]) -> bool {
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut to = 0.0;
    for [first, last] in intervals {
        if *first > to + NO_GAP_RAD {
            return false;
        }
        to = last.max(to);
    }
    to >= TAU - NO_GAP_RAD
}

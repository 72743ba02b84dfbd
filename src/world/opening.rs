//! Gaps between obstacles, measured between their outlines, and the openings among them.
//!
//! An opening is a local constriction of free space: of all obstacle points, the two ends of its gap are the
//! nearest to its middle. The number of obstacles in a wall therefore does not matter. Where several touch or
//! overlap, only their common outline counts.

use super::obstacle::{Obstacle, Part};
use crate::geometry::{Bounds, Footprint, Nearby, Point, Solid, Vector, left_of};
use parry3d::query::{ClosestPoints, closest_points};
use std::collections::BTreeSet;

/// The width in robot widths above which an opening is free passage, unless the world gives another (Sec.
/// III-A, footnote 1).
pub const FREE_PASSAGE: f64 = 5.0;

/// Obstacles this close to each other (m) touch.
pub(super) const TOUCHING_M: f64 = 1e-6;
/// Points of a side within this distance (m) of the closest ones count as closest too: parallel faces, whose
/// corners a file gives to a micrometre.
const SAME_FACE_M: f64 = 1e-5;
/// The distance (m) between the bounds of obstacles that may touch.
const TOUCHING_BOUNDS_M: f64 = 1e-5;
/// The distance (m) from a face within which the bounds of what is flush with it are.
const FACE_BOUNDS_M: f64 = 2e-5;
/// The largest number of pairs of sides, of walls and parts of outlines that are near each other: each pair is
/// measured.
const MAX_PAIRS: usize = 40_000_000;
/// Accuracy of a gap's width, m. A gap wider than the robot by no more than this is impassable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;
/// Directions that differ by no more than this (rad) count as equal.
const SAME_DIRECTION_RAD: f64 = 1e-3;
/// Gaps whose ends differ by no more than this (m) are one gap, measured between different parts of the same
/// walls.
const SAME_GAP_M: f64 = 3e-4;

/// A passage between two obstacles.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Name, unique in its world.
    pub name: String,
    /// The two obstacles, as indices into the world's obstacles. Where several touching obstacles form a
    /// side, one of them.
    pub between: [usize; 2],
    /// The end points of the gap: on the outline of the first obstacle and on that of the second. Between
    /// parallel faces the gap is at their middle. A face includes touching obstacles that are flush with it.
    pub ends: [Point; 2],
    /// Width w, m: the distance between the two obstacles.
    pub width: f64,
    /// The width in robot widths above which it is free passage.
    pub free_passage: f64,
    /// The share (0 to 1) of its risk that counts; less than 1 near a narrower gap of the same passage.
    pub share: f64,
}

impl Opening {
    /// The middle of the gap.
    pub fn center(&self) -> Point {
        nalgebra::center(&self.ends[0], &self.ends[1])
    }

    /// The unit vector perpendicular to the gap, from the opening's side 0 to its side 1.
    pub fn axis(&self) -> Vector {
        left_of((self.ends[1] - self.ends[0]) / self.width)
    }

    /// Whether the robot fits through: the gap is wider than d_r.
    pub(super) fn is_passable(&self, robot_width: f64) -> bool {
        self.width > robot_width + WIDTH_TOLERANCE_M
    }

    /// Whether it is exactly as wide as the robot. A path through the middle would then keep d_r / 2 from
    /// either side, although the gap is impassable (Sec. III-A).
    pub(crate) fn is_exactly_closed(&self, robot_width: f64) -> bool {
        !self.is_passable(robot_width) && self.width >= robot_width - WIDTH_TOLERANCE_M
    }

    /// Whether it is the same gap as another one, in either direction.
    fn is_same(&self, other: &Self) -> bool {
        let [a, b] = other.ends;
        [[a, b], [b, a]]
            .iter()
            .any(|ends| ends.iter().zip(&self.ends).all(|(p, q)| (p - q).norm() <= 3.0 * SAME_GAP_M))
    }

    /// The risk S_xi = d_r / w of passing (Sec. III-A): 0 in free passage, 1 where w <= d_r. Of a gap near a
    /// narrower one of the same passage, its share of that.
    ///
    /// DEVIATION (Sec. III-A): the paper's openings have no share; grooves and ribs would count as doors.
    pub fn risk(&self, robot_width: f64) -> f64 {
        if self.width > self.free_passage * robot_width {
            return 0.0;
        }
        self.share * (robot_width / self.width).min(1.0)
    }
}

/// Convex outlines by place, with the gaps between them.
pub(super) struct Gaps<'a> {
    obstacles: &'a [Obstacle],
    sides: Vec<Side<'a>>,
    bounds: Vec<Bounds>,
    nearby: Nearby,
}

/// A convex outline that may be a side of a gap.
struct Side<'a> {
    footprint: &'a Footprint,
    /// The box that it is; `None` where it is something else, or a part of several obstacles that touch.
    rectangle: Option<&'a Part>,
    /// The obstacles to which it belongs.
    obstacles: &'a [usize],
}

impl<'a> Gaps<'a> {
    fn new(obstacles: &'a [Obstacle], sides: Vec<Side<'a>>) -> Self {
        let bounds: Vec<Bounds> = sides.iter().map(|side| side.footprint.bounds()).collect();
        let nearby = Nearby::new(bounds.iter().copied());
        Self { obstacles, sides, bounds, nearby }
    }

    /// The gaps between solids, each of which consists of some of the obstacles.
    pub fn between(obstacles: &'a [Obstacle], solids: &'a [Solid], members: &'a [Vec<usize>]) -> Self {
        let sides = solids.iter().zip(members).flat_map(|(solid, members)| {
            solid.parts.iter().enumerate().map(move |(i, footprint)| {
                let part = if let [alone] = members[..] { obstacles[alone].parts.get(i) } else { None };
                Side { footprint, rectangle: part.filter(|part| part.is_box()), obstacles: members }
            })
        });
        Self::new(obstacles, sides.collect())
    }

    /// The unnamed gap between two convex outlines; `None` where they touch.
    ///
    /// The width and the direction come from the closest points of the outlines; of two boxes from parry's of
    /// the solids, which stand on the floor, so that these points are at the same height. (parry's are off by
    /// up to 2e-4 m along the outline of a cylinder.)
    fn measure(&self, between: [usize; 2]) -> Option<Opening> {
        let [first, second] = between.map(|i| &self.sides[i]);
        let [p1, p2] = match (first.rectangle, second.rectangle) {
            (Some(first), Some(second)) => closest([first, second])?,
            _ => first.footprint.closest_points(second.footprint),
        };
        let width = (p2 - p1).norm();
        if width < TOUCHING_M {
            return None;
        }
        let toward = across([first.footprint, second.footprint], (p2 - p1) / width, width);
        let left = left_of(toward);
        let part1 = self.face(between[0], toward);
        let part2 = self.face(between[1], -toward);
        // the second obstacle's axis points the other way
        let (low, high) = (part1[0].max(-part2[1]), part1[1].min(-part2[0]));
        let shift = if low < high { (low + high) / 2.0 - left.dot(&p1.coords) } else { 0.0 };
        let ends = [p1 + left * shift, p2 + left * shift];
        Some(Opening { name: String::new(), between, ends, width, free_passage: FREE_PASSAGE, share: 1.0 })
    }

    /// A gap measured between outlines, between the obstacles at its ends.
    pub fn named(&self, gap: Opening) -> Opening {
        let at = |end: usize| {
            let obstacles = self.sides[gap.between[end]].obstacles;
            if let [alone] = obstacles {
                return *alone;
            }
            let obstacles = obstacles.iter().copied();
            let distance = |i: usize| self.obstacles[i].distance_to_point(gap.ends[end]);
            obstacles.map(|i| (i, distance(i))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
        };
        Opening { between: [at(0), at(1)], ..gap }
    }

    /// The face of an outline that lies farthest along the unit vector `toward`, extended by the outlines
    /// that touch it and are flush with it. Returned as an interval on the axis to the left of `toward`, m
    /// from the world's origin.
    fn face(&self, side: usize, toward: Vector) -> [f64; 2] {
        let outline = self.sides[side].footprint;
        let reach = outline.reach(toward);
        let mut face = outline.farthest_face(toward, SAME_FACE_M, SAME_DIRECTION_RAD);
        let mut seen = BTreeSet::from([side]);
        loop {
            let ends = face.map(|along| Point::from(toward * reach + left_of(toward) * along));
            let Some(bounds) = Bounds::around(ends) else { return face };
            let before = face;
            self.nearby.any_meeting(bounds.grown(FACE_BOUNDS_M), |next| {
                let outline = self.sides[next].footprint;
                if !seen.contains(&next) && (outline.reach(toward) - reach).abs() <= TOUCHING_M {
                    let [low, high] = outline.farthest_face(toward, SAME_FACE_M, SAME_DIRECTION_RAD);
                    if low <= face[1] + TOUCHING_M && high >= face[0] - TOUCHING_M {
                        face = [face[0].min(low), face[1].max(high)];
                        seen.insert(next);
                    }
                }
                false
            });
            if face == before {
                return face;
            }
        }
    }

    /// Whether a third outline is nearer to the middle of a gap than the gap's own two: the constriction is
    /// then elsewhere. An outline whose nearest point is an end of the gap is part of that side.
    fn is_obstructed(&self, gap: &Opening) -> bool {
        let center = gap.center();
        let within = gap.width / 2.0 + TOUCHING_M;
        let around = Bounds { min: center, max: center }.grown(within + TOUCHING_BOUNDS_M);
        self.nearby.any_meeting(around, |i| self.obstructs(i, gap).is_some())
    }

    /// The distance (m) of an outline from the middle of a gap, if it obstructs it.
    fn obstructs(&self, i: usize, gap: &Opening) -> Option<f64> {
        if gap.between.contains(&i) {
            return None;
        }
        let (center, outline) = (gap.center(), self.sides[i].footprint);
        let distance = outline.distance_to_point(center);
        if distance > gap.width / 2.0 + TOUCHING_M {
            return None;
        }
        let (depth, away) = outline.separation(center);
        let nearest = center - away * depth;
        // what the middle is inside of fills the gap
        let is_part_of_a_side =
            depth > 0.0 && gap.ends.iter().any(|end| (nearest - end).norm() <= SAME_GAP_M);
        (!is_part_of_a_side).then_some(distance)
    }

    /// The outline that obstructs a gap and is nearest to its middle: its index and distance (m).
    fn obstructing(&self, gap: &Opening) -> Option<(usize, f64)> {
        let center = gap.center();
        let within = gap.width / 2.0 + TOUCHING_M;
        self.nearby
            .meeting(Bounds { min: center, max: center }.grown(within + TOUCHING_BOUNDS_M))
            .into_iter()
            .filter_map(|i| Some((i, self.obstructs(i, gap)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The gaps between obstacles as they are, those that touch apart.
    pub fn of(obstacles: &'a [Obstacle], numbers: &'a [usize]) -> Self {
        let sides = obstacles.iter().zip(numbers).flat_map(|(obstacle, number)| {
            let obstacles = std::slice::from_ref(number);
            obstacle.parts.iter().map(move |part| Side {
                footprint: &part.footprint,
                rectangle: Some(part).filter(|part| part.is_box()),
                obstacles,
            })
        });
        Self::new(obstacles, sides.collect())
    }

    /// The narrowest gap between two obstacles; `None` where they touch.
    pub fn narrowest(&self, between: [usize; 2]) -> Option<Opening> {
        let [first, second] = between
            .map(|obstacle| (0..self.sides.len()).filter(move |&i| self.sides[i].obstacles == [obstacle]));
        let gaps = first.flat_map(|i| second.clone().map(move |j| self.measure([i, j])));
        let gaps: Option<Vec<Opening>> = gaps.collect();
        gaps?.into_iter().min_by(|a, b| a.width.total_cmp(&b.width))
    }

    /// The third obstacle nearest to the middle of a gap, if it is nearer than the gap's own two, and its
    /// distance (m).
    pub fn obstructed(&self, gap: &Opening) -> Option<(usize, f64)> {
        self.obstructing(gap).map(|(side, distance)| (self.sides[side].obstacles[0], distance))
    }

    /// Whether there are too many outlines within `widest` (m) of each other to measure the gaps between them.
    pub fn are_too_many(&self, widest: f64) -> bool {
        let mut pairs = 0;
        let count = |side: &Side| side.footprint.corners().map_or(1, <[Point]>::len);
        self.sides.iter().zip(&self.bounds).any(|(side, bounds)| {
            self.nearby.any_meeting(bounds.grown(widest), |other| {
                pairs += count(side) * count(&self.sides[other]);
                // each is met twice
                pairs > 2 * MAX_PAIRS
            })
        })
    }

    /// The gaps no wider than `widest` (m), in the order of their outlines.
    fn up_to(&self, widest: f64) -> impl Iterator<Item = Opening> {
        (0..self.sides.len())
            .flat_map(move |i| {
                let near = self.nearby.meeting(self.bounds[i].grown(widest));
                near.into_iter().filter(move |j| *j > i).map(move |j| [i, j])
            })
            .filter_map(move |between| self.measure(between))
            .filter(move |gap| gap.width <= widest)
    }

    /// Every opening, without a name: wider than d_r, no wider than `widest` (m), and no third outline in the
    /// disc over the gap.
    ///
    /// DEVIATION (design): a gap counts only if the disc that has it for a diameter is free of other
    /// obstacles, which is stronger than a free gap segment. Without it the diagonals between four pillars
    /// count as well: the same constriction twice, and gaps that cross.
    pub fn detect(&self, robot_width: f64, widest: f64) -> Vec<Opening> {
        let is_opening = |gap: &Opening| gap.is_passable(robot_width) && !self.is_obstructed(gap);
        let gaps: Vec<Opening> = self.up_to(widest).filter(is_opening).collect();
        let mut is_new = vec![false; gaps.len()];
        for (i, same) in same_gaps(&gaps).into_iter().enumerate() {
            is_new[i] = !same.into_iter().any(|j| is_new[j]);
        }
        gaps.into_iter().zip(is_new).filter(|(_, is_new)| *is_new).map(|(gap, _)| self.named(gap)).collect()
    }

    /// Whether the middle of a gap is inside an outline: between parts of one solid.
    fn is_filled(&self, gap: &Opening) -> bool {
        let center = gap.center();
        let here = Bounds { min: center, max: center };
        self.nearby.any_meeting(here, |i| self.sides[i].footprint.contains(center))
    }

    /// The gaps that are too narrow for the robot.
    pub fn impassable(&self, robot_width: f64) -> Vec<Opening> {
        let gaps = self.up_to(robot_width + WIDTH_TOLERANCE_M).filter(|gap| !self.is_filled(gap));
        gaps.map(|gap| self.named(gap)).collect()
    }
}

/// For every gap, the ones before it that are the same.
pub(super) fn same_gaps(gaps: &[Opening]) -> Vec<Vec<usize>> {
    let centers = gaps.iter().map(Opening::center);
    let nearby = Nearby::new(centers.map(|center| Bounds { min: center, max: center }));
    let same = |(i, gap): (usize, &Opening)| {
        let center = gap.center();
        let near = nearby.meeting(Bounds { min: center, max: center }.grown(4.0 * SAME_GAP_M));
        near.into_iter().filter(|&j| j < i && gaps[j].is_same(gap)).collect()
    };
    gaps.iter().enumerate().map(same).collect()
}

/// The closest points of two solids, on the floor; `None` where they meet.
fn closest(parts: [&Part; 2]) -> Option<[Point; 2]> {
    let [(pose1, shape1), (pose2, shape2)] = parts.map(Part::solid);
    match closest_points(&pose1, shape1, &pose2, shape2, f64::MAX).ok()? {
        ClosestPoints::WithinMargin(p1, p2) => Some([p1, p2].map(|p| Point::new(p.x, p.y))),
        _ => None,
    }
}

/// The direction of a gap of this `width` (m) from the first to the second of two outlines, measured as
/// `toward`. A direction that is perpendicular to a side within the accuracy of the measurement is made
/// exactly perpendicular.
fn across([first, second]: [&Footprint; 2], toward: Vector, width: f64) -> Vector {
    let sides = [(first, 1.0), (second, -1.0)].into_iter().flat_map(|(outline, sign)| {
        let corners: &[Point] = match outline {
            Footprint::Polygon(corners) => corners,
            Footprint::Disc { .. } => &[],
        };
        let next = |i: usize| corners[(i + 1) % corners.len()];
        corners.iter().enumerate().map(move |(i, c)| left_of((next(i) - c).normalize()) * -sign)
    });
    let is_across = |normal: &Vector| {
        let gap = -second.reach(-normal) - first.reach(*normal);
        (normal - toward).norm() <= SAME_DIRECTION_RAD && (gap - width).abs() <= WIDTH_TOLERANCE_M
    };
    sides
        .filter(is_across)
        .min_by(|a, b| (a - toward).norm().total_cmp(&(b - toward).norm()))
        .unwrap_or(toward)
}

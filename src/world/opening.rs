//! Gaps between obstacles, measured with parry, and the openings among them.
//!
//! An opening is a local constriction of free space: of all obstacle points, the two ends of its gap are the
//! nearest to its middle. The number of obstacles in a wall therefore does not matter. Where several touch or
//! overlap, only their common outline counts.

use super::obstacle::Obstacle;
use crate::geometry::{Bounds, Footprint, Nearby, Point, Vector, left_of};
use parry3d::query::{ClosestPoints, closest_points};
use std::collections::BTreeSet;

/// The width in robot widths above which an opening is free passage (Sec. III-A, footnote 1).
pub const FREE_PASSAGE: f64 = 5.0;

/// Outline parts within this distance (m) of the closest ones count as closest too: parallel faces. Obstacles
/// this close to each other touch.
const PARALLEL_TOLERANCE_M: f64 = 1e-6;
/// The distance (m) between the bounds of obstacles that may touch.
const TOUCHING_BOUNDS_M: f64 = 1e-5;
/// Accuracy of a gap's width, m. A gap wider than the robot by no more than this is impassable.
const WIDTH_TOLERANCE_M: f64 = 1e-6;
/// Directions that differ by no more than this (rad) count as equal.
const SAME_DIRECTION_RAD: f64 = 1e-3;
/// Gaps whose ends differ by no more than this (m) are one gap, measured between different parts of the same
/// walls. Closest points of cylinders are off by up to 2e-4 m along the outline.
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

    /// The risk S_xi = d_r / w of passing (Sec. III-A): 0 where w > 5 d_r, 1 where w <= d_r.
    pub fn risk(&self, robot_width: f64) -> f64 {
        if self.width > FREE_PASSAGE * robot_width { 0.0 } else { (robot_width / self.width).min(1.0) }
    }
}

/// The obstacles of a world by place, with the gaps between them.
pub(super) struct Gaps<'a> {
    obstacles: &'a [Obstacle],
    bounds: Vec<Bounds>,
    nearby: Nearby,
}

impl<'a> Gaps<'a> {
    pub fn new(obstacles: &'a [Obstacle]) -> Self {
        let bounds: Vec<Bounds> = obstacles.iter().map(|o| o.footprint.bounds()).collect();
        let nearby = Nearby::new(bounds.iter().copied());
        Self { obstacles, bounds, nearby }
    }

    /// The unnamed gap between two obstacles; `None` where they touch.
    ///
    /// The width and the direction come from parry's closest points of the two solids. Both stand on the
    /// floor, so these points are at the same height.
    pub fn measure(&self, between: [usize; 2]) -> Option<Opening> {
        let [first, second] = between.map(|i| &self.obstacles[i]);
        let ((pose1, shape1), (pose2, shape2)) = (first.solid(), second.solid());
        let found = closest_points(&pose1, shape1, &pose2, shape2, f64::MAX).ok()?;
        let ClosestPoints::WithinMargin(p1, p2) = found else {
            return None;
        };
        let (p1, p2) = (Point::new(p1.x, p1.y), Point::new(p2.x, p2.y));
        let width = (p2 - p1).norm();
        if width < PARALLEL_TOLERANCE_M {
            return None;
        }
        let toward = across([&first.footprint, &second.footprint], (p2 - p1) / width, width);
        let left = left_of(toward);
        let part1 = self.face(between[0], toward);
        let part2 = self.face(between[1], -toward);
        // the second obstacle's axis points the other way
        let (low, high) = (part1[0].max(-part2[1]), part1[1].min(-part2[0]));
        let shift = if low < high { (low + high) / 2.0 - left.dot(&p1.coords) } else { 0.0 };
        let ends = [p1 + left * shift, p2 + left * shift];
        Some(Opening { name: String::new(), between, ends, width })
    }

    /// The face of an obstacle that lies farthest along the unit vector `toward`, extended by the obstacles
    /// that touch it and are flush with it. Returned as an interval on the axis to the left of `toward`, m
    /// from the world's origin.
    fn face(&self, obstacle: usize, toward: Vector) -> [f64; 2] {
        let outline = &self.obstacles[obstacle].footprint;
        let reach = outline.reach(toward);
        let mut face = outline.farthest_part(toward, PARALLEL_TOLERANCE_M);
        let mut seen = BTreeSet::from([obstacle]);
        let mut queue = vec![obstacle];
        while let Some(part) = queue.pop() {
            for next in self.nearby.meeting(self.bounds[part].grown(TOUCHING_BOUNDS_M)) {
                let outline = &self.obstacles[next].footprint;
                let is_flush = (outline.reach(toward) - reach).abs() <= PARALLEL_TOLERANCE_M;
                let [low, high] = outline.farthest_part(toward, PARALLEL_TOLERANCE_M);
                let is_apart = low > face[1] + PARALLEL_TOLERANCE_M || high < face[0] - PARALLEL_TOLERANCE_M;
                if is_flush && !is_apart && seen.insert(next) {
                    face = [face[0].min(low), face[1].max(high)];
                    queue.push(next);
                }
            }
        }
        face
    }

    /// The third obstacle nearest to the middle of a gap, if it is nearer than the gap's own two: the
    /// constriction is then elsewhere. An obstacle whose nearest point is an end of the gap is part of that
    /// side. Returns its index and distance (m).
    pub fn obstructed(&self, gap: &Opening) -> Option<(usize, f64)> {
        let center = gap.center();
        let is_part_of_a_side = |o: &Obstacle| {
            let (distance, away) = o.footprint.separation(center);
            let nearest = center - away * distance;
            gap.ends.iter().any(|end| (nearest - end).norm() <= SAME_GAP_M)
        };
        let within = gap.width / 2.0 + PARALLEL_TOLERANCE_M;
        self.nearby
            .meeting(Bounds { min: center, max: center }.grown(within + TOUCHING_BOUNDS_M))
            .into_iter()
            .filter(|i| !gap.between.contains(i))
            .map(|i| (i, self.obstacles[i].footprint.distance_to_point(center)))
            .filter(|&(i, distance)| distance <= within && !is_part_of_a_side(&self.obstacles[i]))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The gaps no wider than `widest` (m), in the order of their obstacles.
    fn up_to(&self, widest: f64) -> impl Iterator<Item = Opening> {
        (0..self.obstacles.len())
            .flat_map(move |i| {
                let near = self.nearby.meeting(self.bounds[i].grown(widest));
                near.into_iter().filter(move |j| *j > i).map(move |j| [i, j])
            })
            .filter_map(move |between| self.measure(between))
            .filter(move |gap| gap.width <= widest)
    }

    /// Every opening between two of the obstacles: d_r < w <= 5 d_r, and no third obstacle in the disc over
    /// the gap.
    ///
    /// DEVIATION (design): a gap counts only if the disc that has it for a diameter is free of other
    /// obstacles, which is stronger than a free gap segment. Without it the diagonals between four pillars
    /// count as well: the same constriction twice, and gaps that cross.
    pub fn detect(&self, robot_width: f64) -> Vec<Opening> {
        let is_opening = |gap: &Opening| gap.is_passable(robot_width) && self.obstructed(gap).is_none();
        let gaps: Vec<Opening> = self.up_to(FREE_PASSAGE * robot_width).filter(is_opening).collect();
        let mut is_new = vec![false; gaps.len()];
        for (i, same) in same_gaps(&gaps).into_iter().enumerate() {
            is_new[i] = !same.into_iter().any(|j| is_new[j]);
        }
        let new = gaps.into_iter().zip(is_new).filter(|(_, is_new)| *is_new).enumerate();
        new.map(|(i, (gap, _))| Opening { name: format!("xi{}", i + 1), ..gap }).collect()
    }

    /// The gaps that are too narrow for the robot.
    pub fn impassable(&self, robot_width: f64) -> Vec<Opening> {
        self.up_to(robot_width + WIDTH_TOLERANCE_M).collect()
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

//! An opening as the team crosses it: straight through its middle, or between pillars in one of three lanes.

use super::alignment::Alignment;
use super::roadmap::{Space, Straight};
use super::sites::MAX_LANES;
use crate::geometry::{Point, Vector, cross, left_of};
use crate::world::Opening;

/// An opening as the team crosses it: straight through its middle, perpendicular to the gap, or between
/// pillars.
#[derive(Clone, Debug)]
pub(super) struct Passage {
    pub center: Point,
    /// Unit vector from side 0 to side 1.
    pub axis: Vector,
    /// Length of the straight part on either side, m.
    pub reach: [f64; 2],
    /// The risk S_xi.
    pub risk: f64,
    /// Half the width of the gap, m. A step that meets the gap's line within it crosses the opening.
    half_width: f64,
    /// The distance (m) of the outer lanes from the middle; `None` where paths go through the middle alone.
    lane_offset: Option<f64>,
}

/// A passage crossed in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Crossing {
    /// The opening, as an index into the world's openings.
    pub opening: usize,
    /// The side that the crossing leads to, 0 or 1: see [`Opening::axis`].
    pub into: usize,
}

impl Crossing {
    /// The same opening, crossed in the other direction.
    pub fn back(self) -> Self {
        Self { opening: self.opening, into: 1 - self.into }
    }
}

/// The distance (m) between a path through a lane that is not straight and the gap's line, where it arrives
/// and leaves: more than the tolerance within which lines meet the gap.
const OFF_GAP_M: f64 = 1e-7;
/// The distance of outer lanes from a pillar beyond the clearance, m.
const FROM_PILLAR_M: f64 = 1e-6;
/// Where lanes would be this near (m) to each other, there is one.
const MIN_LANE_DISTANCE_M: f64 = 0.01;
/// The length (m) by which the straight part beyond the gap shortens for every metre that the team is off the
/// axis. The part thus narrows to a point, where the path through it and the path past it coincide.
const NARROWING: f64 = 2.0;
/// The distance (m) from the axis within which the team is on it up to rounding.
const ON_AXIS_M: f64 = 1e-6;

/// The path ahead of a team beyond the gap.
pub(super) enum Exit {
    /// Along the axis to the end of the straight part.
    Axis(Point),
    /// From off the axis, parallel to it, to this point.
    OffAxis(Point),
}

impl Passage {
    /// The passage through `opening`, straight as `alignment` says or less if an obstacle or another opening
    /// is closer. Between pillars paths go through it in any direction and in one of three lanes, in the
    /// middle or as near to either pillar as the team may.
    pub fn new(
        opening: &Opening,
        others: &[[Point; 2]],
        space: &Space,
        robot_width: f64,
        alignment: Alignment,
    ) -> Self {
        let (center, axis) = (opening.center(), opening.axis());
        let (risk, half_width) = (opening.risk(robot_width), opening.width / 2.0);
        let lane_offset = alignment.off_middle * (half_width - robot_width / 2.0 - FROM_PILLAR_M);
        let lane_offset = (lane_offset > MIN_LANE_DISTANCE_M).then_some(lane_offset);
        let reach =
            [(-axis, alignment.straight[0]), (axis, alignment.straight[1])].map(|(outward, straight)| {
                let free = others
                    .iter()
                    .filter_map(|gap| meets(center, outward, *gap))
                    // two openings that face each other share the distance between them
                    .map(|distance| distance / 2.0)
                    .fold(straight, f64::min);
                longest_clear(center, outward, free, space).max(OFF_GAP_M)
            });
        Self { center, axis, reach, risk, half_width, lane_offset }
    }

    /// The number of lanes: the first is in the middle.
    pub fn lanes(&self) -> usize {
        if self.lane_offset.is_some() { MAX_LANES } else { 1 }
    }

    /// The place of a lane in the gap.
    pub fn middle(&self, lane: usize) -> Point {
        match (self.lane_offset, lane) {
            (Some(lane_offset), 1) => self.center + left_of(self.axis) * lane_offset,
            (Some(lane_offset), 2) => self.center - left_of(self.axis) * lane_offset,
            _ => self.center,
        }
    }

    /// The straight parts of all lanes, in the order of their sites; `opening` is the index of its opening.
    pub fn straights(&self, opening: usize) -> impl Iterator<Item = Straight> + '_ {
        (0..self.lanes()).flat_map(move |lane| {
            [0, 1].map(|side| Straight {
                center: self.middle(lane),
                outward: self.outward(side),
                reach: self.reach[side],
                barrier: Some(opening),
            })
        })
    }

    /// The point of a lane's axis at a distance (m) from the gap on one side.
    pub fn at(&self, lane: usize, side: usize, depth: f64) -> Point {
        self.middle(lane) + self.outward(side) * depth
    }

    /// Distance (m) of `p` from the gap's line, positive on the given side.
    pub fn depth(&self, p: Point, side: usize) -> f64 {
        (p - self.center).dot(&self.outward(side))
    }

    /// Whether a team at `p` that crossed the gap to a side is still in the straight part there.
    pub fn keeps(&self, p: Point, side: usize) -> bool {
        self.depth(p, side) >= 0.0 && self.left(p, side, self.reach[side]) > 0.0
    }

    /// Where a team at `p`, in the straight part on one side, leaves it if that part reaches `reach` (m) from
    /// the gap along the axis; `None` if the team is out of it.
    pub fn exit(&self, p: Point, side: usize, reach: f64) -> Option<Exit> {
        let left = self.left(p, side, reach);
        if left <= 0.0 {
            return None;
        }
        if self.off_axis(p) <= ON_AXIS_M {
            return Some(Exit::Axis(self.at(0, side, reach)));
        }
        Some(Exit::OffAxis(p + self.outward(side) * left))
    }

    /// How much of a straight part of length `reach` (m) is ahead of a team at `p`, m; 0 where it is no more
    /// than rounding.
    fn left(&self, p: Point, side: usize, reach: f64) -> f64 {
        let left = reach - NARROWING * self.off_axis(p) - self.depth(p, side);
        if left > 2.0 * NARROWING * ON_AXIS_M { left } else { 0.0 }
    }

    /// `p`, or the point [`OFF_GAP_M`] off the gap's line next to it, if `p` is nearer to it: no path leads
    /// from the line itself. Points on it are on side 1, as for [`Passage::crossed`].
    pub fn off_gap(&self, p: Point) -> Point {
        let depth = self.depth(p, 1);
        if depth.abs() >= OFF_GAP_M || self.off_axis(p) > self.half_width {
            return p;
        }
        p + self.axis * (if depth < 0.0 { -OFF_GAP_M } else { OFF_GAP_M } - depth)
    }

    /// The fraction (0 to 1) of the step from `a` to `b` at which it crosses the gap, and the side that it
    /// leads to.
    pub fn crossed(&self, a: Point, b: Point) -> Option<(f64, usize)> {
        let (before, after) = (self.depth(a, 1), self.depth(b, 1));
        let into = match (before < 0.0, after < 0.0) {
            (true, false) => 1,
            (false, true) => 0,
            _ => return None,
        };
        let t = before / (before - after);
        (self.off_axis(a + (b - a) * t) <= self.half_width).then_some((t, into))
    }

    fn outward(&self, side: usize) -> Vector {
        if side == 1 { self.axis } else { -self.axis }
    }

    fn off_axis(&self, p: Point) -> f64 {
        cross(self.axis, p - self.center).abs()
    }
}

/// Distance (m) along a ray at which it meets a segment.
fn meets(from: Point, toward: Vector, [a, b]: [Point; 2]) -> Option<f64> {
    let along = b - a;
    let slope = cross(toward, along);
    if slope == 0.0 {
        return None;
    }
    let distance = cross(a - from, along) / slope;
    let t = cross(a - from, toward) / slope;
    (distance > 0.0 && (0.0..=1.0).contains(&t)).then_some(distance)
}

/// The length (m) of the longest clear straight line, at most `most`.
fn longest_clear(from: Point, toward: Vector, most: f64, space: &Space) -> f64 {
    let clear = |length: f64| space.is_clear_of_obstacles(from, from + toward * length);
    if clear(most) {
        return most;
    }
    let (mut clear_to, mut blocked_at) = (0.0, most);
    for _ in 0..48 {
        let middle = (clear_to + blocked_at) / 2.0;
        *(if clear(middle) { &mut clear_to } else { &mut blocked_at }) = middle;
    }
    clear_to
}

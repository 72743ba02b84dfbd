//! The straight part of an opening on one side, and where paths join it.
//!
//! A path joins the straight part as far out as it can without doubling back: at the far end, or where it
//! would otherwise turn by more than acos(-[`MAX_BACKWARD`]). There the path is cheapest if every metre of
//! the straight part that it leaves out costs [`MAX_BACKWARD`] metres, because moving the joining point
//! outward by ds lengthens the line by -cos(turn) ds.

use crate::geometry::{Point, Vector, cross, left_of};

/// How far back a path may lead, per metre, where it joins or leaves a straight part. This is minus the
/// cosine of the largest turn there, 99.8 degrees. Paths along one wall, from opening to opening, turn by 90
/// degrees.
pub(in crate::options) const MAX_BACKWARD: f64 = 0.17;

/// The end of a line on a straight part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Join {
    pub to: Point,
    /// Length of the line, m.
    pub length: f64,
    /// Distance from the gap, m.
    pub depth: f64,
    /// Cost, m: see [`Straight::cost`].
    pub cost: f64,
}

/// The straight part on one side of an opening. A point is a straight part of length 0.
#[derive(Clone, Debug)]
pub(in crate::options) struct Straight {
    /// The middle of the gap.
    pub center: Point,
    /// Unit vector away from the gap.
    pub outward: Vector,
    /// Length, m.
    pub reach: f64,
    /// The barrier that closes its gap.
    pub barrier: Option<usize>,
}

impl From<Point> for Straight {
    fn from(center: Point) -> Self {
        Self { center, outward: Vector::x(), reach: 0.0, barrier: None }
    }
}

impl Straight {
    /// The far end.
    pub fn portal(&self) -> Point {
        self.at(self.reach)
    }

    /// The point at a distance (m) from the gap.
    pub fn at(&self, depth: f64) -> Point {
        self.center + self.outward * depth
    }

    /// Distance (m) of `p` from the gap's line, positive on this side.
    pub fn depth(&self, p: Point) -> f64 {
        (p - self.center).dot(&self.outward)
    }

    /// The directions of the lines that join with the largest turn allowed, from the left and from the right.
    pub(super) fn backward(&self) -> impl Iterator<Item = Vector> + use<> {
        let ahead = (1.0 - MAX_BACKWARD * MAX_BACKWARD).sqrt();
        let (across, back) = (left_of(self.outward) * ahead, self.outward * MAX_BACKWARD);
        let is_point = self.reach <= 0.0;
        [back - across, back + across].into_iter().filter(move |_| !is_point)
    }

    /// The joining point of the line from `p` in one of these directions; `None` if it does not meet the
    /// straight part.
    pub(super) fn join_along(&self, p: Point, along: Vector) -> Option<Join> {
        let offset = cross(self.outward, p - self.center);
        let toward = -cross(self.outward, along);
        (offset * toward > 0.0).then(|| self.join_at_offset(p, offset.abs())).flatten()
    }

    /// The joining point, before the far end, of a line from `p`; `None` if it is at the far end or `p` is
    /// behind the gap.
    pub(super) fn join_from(&self, p: Point) -> Option<Join> {
        self.join_at_offset(p, cross(self.outward, p - self.center).abs())
    }

    fn join_at_offset(&self, p: Point, offset: f64) -> Option<Join> {
        let depth = self.ideal_depth(p, offset);
        (0.0 <= depth && depth < self.reach).then(|| self.join(p, self.at(depth), depth))
    }

    /// The depth at which a path from a point `offset` (m) off the axis would join if the axis were endless.
    fn ideal_depth(&self, p: Point, offset: f64) -> f64 {
        self.depth(p) + offset * MAX_BACKWARD / (1.0 - MAX_BACKWARD * MAX_BACKWARD).sqrt()
    }

    /// The best joining point of a line from `p`; `None` from behind the gap, unless that is along a straight
    /// line.
    pub(super) fn best_join(&self, p: Point) -> Option<Join> {
        let is_behind =
            || self.reach > 0.0 && self.ideal_depth(p, cross(self.outward, p - self.center).abs()) < 0.0;
        self.join_from(p).or_else(|| (!is_behind()).then(|| self.join_at_portal(p)))
    }

    /// The line from `p` to the far end.
    pub(super) fn join_at_portal(&self, p: Point) -> Join {
        self.join(p, self.portal(), self.reach)
    }

    fn join(&self, p: Point, to: Point, depth: f64) -> Join {
        let length = (to - p).norm();
        Join { to, length, depth, cost: length + MAX_BACKWARD * (self.reach - depth) }
    }
}

//! Free space: whether lines and arcs keep a clearance.

use super::disc::{CLEARANCE_TOLERANCE_M, Disc, arc_crosses};
use super::straight::Straight;
use crate::geometry::{Bounds, Footprint, Point, segments_meet};
use std::f64::consts::PI;

/// Obstacles, which paths keep clear of, and barriers, which paths do not cross.
#[derive(Clone, Debug)]
pub(in crate::options) struct Space {
    pub(super) obstacles: Vec<(Footprint, Bounds)>,
    barriers: Vec<[Point; 2]>,
    pub(super) clearance: f64,
}

impl Space {
    pub fn new(
        obstacles: impl Iterator<Item = Footprint>,
        barriers: Vec<[Point; 2]>,
        clearance: f64,
    ) -> Self {
        let obstacles = obstacles.map(|o| (o.clone(), o.bounds())).collect();
        Self { obstacles, barriers, clearance }
    }

    /// Whether the team can walk straight from `a` to `b`.
    pub fn is_clear(&self, a: Point, b: Point) -> bool {
        self.is_clear_by(a, b, self.clearance)
    }

    /// Whether the straight line from `a` to `b` keeps the full clearance, without tolerance. Barriers may be
    /// crossed.
    pub fn is_clear_of_obstacles(&self, a: Point, b: Point) -> bool {
        self.keeps(a, b, self.clearance)
    }

    fn keeps(&self, a: Point, b: Point, distance: f64) -> bool {
        self.obstacles.iter().all(|(o, bounds)| o.clears_segment(*bounds, a, b, distance))
    }

    /// As [`Space::is_clear`], with another clearance, m.
    pub fn is_clear_by(&self, a: Point, b: Point, clearance: f64) -> bool {
        self.keeps(a, b, clearance - CLEARANCE_TOLERANCE_M) && !self.crosses_barrier(a, b)
    }

    /// Whether the straight line from `a` to `b` crosses a barrier.
    pub fn crosses_barrier(&self, a: Point, b: Point) -> bool {
        self.barriers.iter().any(|[c, d]| segments_meet(a, b, *c, *d, CLEARANCE_TOLERANCE_M))
    }

    /// Whether the team can walk straight from `p` onto a straight part. The part's own gap does not count as
    /// a barrier, because it may be as close as rounding.
    pub fn can_join(&self, p: Point, to: Point, straight: &Straight) -> bool {
        self.can_join_by(p, to, straight, self.clearance)
    }

    /// As [`Space::can_join`], with another clearance, m.
    pub fn can_join_by(&self, p: Point, to: Point, straight: &Straight, clearance: f64) -> bool {
        let in_front = straight.depth(p) >= 0.0;
        let mut others =
            self.barriers.iter().enumerate().filter(|(i, _)| !(in_front && straight.barrier == Some(*i)));
        self.keeps(p, to, clearance - CLEARANCE_TOLERANCE_M)
            && !others.any(|(_, [c, d])| segments_meet(p, to, *c, *d, CLEARANCE_TOLERANCE_M))
    }

    /// Distance (m) from `p` to the nearest obstacle.
    pub fn clearance_at(&self, p: Point) -> f64 {
        self.obstacles.iter().map(|(o, _)| o.distance_to_point(p)).fold(f64::INFINITY, f64::min)
    }

    /// Whether an arc keeps clear. No distance changes faster than the arc length, so an arc is clear if its
    /// middle has more room than half its length. Other arcs are halved.
    pub fn is_arc_clear(&self, disc: &Disc, from_angle: f64, sweep: f64) -> bool {
        let crosses_barrier = self.barriers.iter().any(|[a, b]| arc_crosses(disc, from_angle, sweep, *a, *b));
        // between two taut angles of a corner the arc is less than half a turn; a longer one leads through
        // the obstacle
        let through = disc.between.is_some() && sweep.abs() > PI;
        if crosses_barrier || through || !disc.is_taut(from_angle) || !disc.is_taut(from_angle + sweep) {
            return false;
        }
        let half = disc.radius * sweep.abs() / 2.0;
        let middle = disc.at(from_angle + sweep / 2.0);
        self.obstacles
            .iter()
            .enumerate()
            // a taut arc touches its own obstacle and does not enter it
            .filter(|(i, _)| *i != disc.obstacle)
            .map(|(_, obstacle)| obstacle)
            .filter(|(_, bounds)| {
                let near = bounds.grown(self.clearance + half);
                near.min <= middle && middle <= near.max
            })
            .all(|(obstacle, _)| self.is_arc_clear_of(obstacle, disc, from_angle, sweep, 0))
    }

    fn is_arc_clear_of(
        &self,
        obstacle: &Footprint,
        disc: &Disc,
        from_angle: f64,
        sweep: f64,
        depth: u32,
    ) -> bool {
        let room = obstacle.distance_to_point(disc.at(from_angle + sweep / 2.0)) - self.clearance;
        let half = disc.radius * sweep.abs() / 2.0;
        if room >= half {
            return true;
        }
        if room < -CLEARANCE_TOLERANCE_M {
            return false;
        }
        // where walls share a corner, the arc touches both along its length, so the room is 0 at any depth
        depth == 12
            || [from_angle, from_angle + sweep / 2.0]
                .iter()
                .all(|&from| self.is_arc_clear_of(obstacle, disc, from, sweep / 2.0, depth + 1))
    }
}

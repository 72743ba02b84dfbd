//! Free space: whether lines and arcs keep a clearance.

use super::disc::{CLEARANCE_TOLERANCE_M, Disc, arc_crosses};
use super::straight::Straight;
use crate::geometry::{Bounds, Footprint, Nearby, Point, Solid, Vector, segments_meet};
use std::f64::consts::PI;

/// The distance (m) beyond what a query needs at which obstacles and barriers are looked up: more than any
/// rounding.
pub(super) const LOOKUP_MARGIN_M: f64 = 1e-6;

/// The length (m) of the first part of a line that is looked at, and the factor by which it grows.
const FIRST_LOOK_M: f64 = 4.0;
const LOOK_GROWTH: f64 = 4.0;

/// Convex parts of obstacles, which paths keep clear of, and barriers, which paths do not cross.
#[derive(Clone, Debug)]
pub(in crate::options) struct Space {
    pub(super) obstacles: Vec<(Footprint, Bounds)>,
    pub(super) near_obstacles: Nearby,
    /// The discs that taut strings bend around.
    pub(super) discs: Vec<Disc>,
    pub(super) barriers: Vec<[Point; 2]>,
    near_barriers: Nearby,
    pub(super) clearance: f64,
}

impl Space {
    pub fn new(solids: &[Solid], barriers: Vec<[Point; 2]>, clearance: f64) -> Self {
        let parts = solids.iter().flat_map(|solid| &solid.parts);
        let obstacles: Vec<_> = parts.map(|o| (o.clone(), o.bounds())).collect();
        let mut first = 0;
        let mut discs = Vec::new();
        for solid in solids {
            discs.extend(Disc::all_of(first, solid, clearance));
            first += solid.parts.len();
        }
        let near_obstacles = Nearby::new(obstacles.iter().map(|(_, bounds)| *bounds));
        let near_barriers =
            Nearby::new(barriers.iter().map(|[c, d]| Bounds { min: c.inf(d), max: c.sup(d) }));
        Self { obstacles, near_obstacles, discs, barriers, near_barriers, clearance }
    }

    /// The number of corners and cylinders that paths bend around.
    pub fn corners(&self) -> usize {
        self.discs.len()
    }

    /// Whether the team can walk straight from `a` to `b`.
    pub fn is_clear(&self, a: Point, b: Point) -> bool {
        self.is_clear_by(a, b, self.clearance)
    }

    /// As [`Space::is_clear`]. `blocker` is an obstacle to try first, and is set to the one that blocks: lines
    /// in similar directions are often blocked by the same.
    pub fn is_clear_trying(&self, blocker: &mut usize, a: Point, b: Point) -> bool {
        let distance = self.clearance - CLEARANCE_TOLERANCE_M;
        let blocks = |i: usize| {
            let (obstacle, bounds) = &self.obstacles[i];
            !obstacle.clears_segment(*bounds, a, b, distance)
        };
        if *blocker < self.obstacles.len() && blocks(*blocker) {
            return false;
        }
        // most lines that are blocked are blocked near their start
        let share = FIRST_LOOK_M / (b - a).norm();
        let looks = std::iter::successors(Some(share), |share| Some(LOOK_GROWTH * share));
        let mut ends = looks.take_while(|share| *share < 1.0).map(|share| a + (b - a) * share).chain([b]);
        let is_blocked = ends.any(|end| {
            self.near_obstacles.any_along(a, end, distance.max(0.0) + LOOKUP_MARGIN_M, |i| {
                let found = blocks(i);
                if found {
                    *blocker = i;
                }
                found
            })
        });
        !is_blocked && !self.crosses_barrier(a, b)
    }

    /// Whether no clear line can touch a disc, as obstacles are closer wherever a taut string may touch it. Not
    /// every such disc is found.
    pub fn is_buried(&self, disc: &Disc) -> bool {
        let distance = self.clearance - CLEARANCE_TOLERANCE_M - LOOKUP_MARGIN_M;
        disc.touched_within().all(|corners| {
            let [a, b, c] = corners;
            let around = Bounds { min: a.inf(&b).inf(&c), max: a.sup(&b).sup(&c) };
            self.near_obstacles.any_meeting(around.grown(distance.max(0.0)), |i| {
                corners.iter().all(|p| self.obstacles[i].0.distance_to_point(*p) < distance)
            })
        })
    }

    /// Whether the straight line from `a` to `b` keeps the full clearance, without tolerance. Barriers may be
    /// crossed.
    pub fn is_clear_of_obstacles(&self, a: Point, b: Point) -> bool {
        self.keeps(a, b, self.clearance)
    }

    fn keeps(&self, a: Point, b: Point, distance: f64) -> bool {
        !self.near_obstacles.any_along(a, b, distance.max(0.0) + LOOKUP_MARGIN_M, |i| {
            let (obstacle, bounds) = &self.obstacles[i];
            !obstacle.clears_segment(*bounds, a, b, distance)
        })
    }

    /// As [`Space::is_clear`], with another clearance, m.
    pub fn is_clear_by(&self, a: Point, b: Point, clearance: f64) -> bool {
        self.keeps(a, b, clearance - CLEARANCE_TOLERANCE_M) && !self.crosses_barrier(a, b)
    }

    /// Whether the straight line from `a` to `b` crosses a barrier.
    pub fn crosses_barrier(&self, a: Point, b: Point) -> bool {
        self.crosses_barrier_but(None, a, b)
    }

    /// Whether the straight line from `a` to `b` crosses a barrier other than `own`.
    fn crosses_barrier_but(&self, own: Option<usize>, a: Point, b: Point) -> bool {
        self.near_barriers.any_along(a, b, LOOKUP_MARGIN_M, |i| {
            let [c, d] = self.barriers[i];
            own != Some(i) && segments_meet(a, b, c, d, CLEARANCE_TOLERANCE_M)
        })
    }

    /// Whether the team can walk straight from `p` onto a straight part. The part's own gap does not count as
    /// a barrier, because it may be as close as rounding.
    pub fn can_join(&self, p: Point, to: Point, straight: &Straight) -> bool {
        self.can_join_by(p, to, straight, self.clearance)
    }

    /// As [`Space::can_join`], with another clearance, m.
    pub fn can_join_by(&self, p: Point, to: Point, straight: &Straight, clearance: f64) -> bool {
        let own = straight.barrier.filter(|_| straight.depth(p) >= 0.0);
        self.keeps(p, to, clearance - CLEARANCE_TOLERANCE_M) && !self.crosses_barrier_but(own, p, to)
    }

    /// Distance (m) from `p` to the nearest obstacle, at most the clearance.
    pub fn clearance_at(&self, p: Point) -> f64 {
        let mut room = self.clearance;
        let near = Bounds { min: p, max: p }.grown(self.clearance + LOOKUP_MARGIN_M);
        self.near_obstacles.any_meeting(near, |i| {
            room = room.min(self.obstacles[i].0.distance_to_point(p));
            false
        });
        room
    }

    /// The distance (m) from `p` along the unit vector `toward` to the first obstacle, at most `most`; 0 inside
    /// one.
    pub fn free_along(&self, p: Point, toward: Vector, most: f64) -> f64 {
        let mut free = most;
        self.near_obstacles.any_along(p, p + toward * most, LOOKUP_MARGIN_M, |i| {
            if let Some([enters, _]) = self.obstacles[i].0.along_ray(p, toward) {
                free = free.min(enters);
            }
            free <= 0.0
        });
        free
    }

    /// The length (m) along the unit vector `toward` for which a ray from the outline point `p` leads through
    /// obstacles without a gap, at most `most`. Outlines within `tolerance` (m) touch.
    pub fn filled_along(&self, p: Point, toward: Vector, most: f64, tolerance: f64) -> f64 {
        let mut within = Vec::new();
        self.near_obstacles.any_along(p, p + toward * most, LOOKUP_MARGIN_M, |i| {
            within.extend(self.obstacles[i].0.along_ray(p, toward));
            false
        });
        within.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let join = |to: f64, [from, until]: [f64; 2]| if from <= to + tolerance { to.max(until) } else { to };
        within.into_iter().fold(0.0, join).min(most)
    }

    /// Whether an arc keeps clear. No distance changes faster than the arc length, so an arc is clear if its
    /// middle has more room than half its length. Other arcs are halved.
    pub fn is_arc_clear(&self, disc: &Disc, from_angle: f64, sweep: f64) -> bool {
        // between two taut angles of a corner the arc is less than half a turn; a longer one leads through
        // the obstacle
        let through = disc.between.is_some() && sweep.abs() > PI;
        if through || !disc.is_taut(from_angle) || !disc.is_taut(from_angle + sweep) {
            return false;
        }
        let crosses = |i: usize| {
            let [a, b] = self.barriers[i];
            arc_crosses(disc, from_angle, sweep, a, b)
        };
        if self.near_barriers.any_meeting(disc.bounds().grown(LOOKUP_MARGIN_M), crosses) {
            return false;
        }
        let half = disc.radius * sweep.abs() / 2.0;
        let middle = disc.at(from_angle + sweep / 2.0);
        let near = Bounds { min: middle, max: middle }.grown(self.clearance + half + LOOKUP_MARGIN_M);
        !self.near_obstacles.any_meeting(near, |i| {
            // a taut arc touches its own obstacle and does not enter it
            !disc.parts.contains(&i)
                && !self.is_arc_clear_of(&self.obstacles[i].0, disc, from_angle, sweep, 0)
        })
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

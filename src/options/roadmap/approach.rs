//! Shortest paths from any point: the point's own tangents, and the roadmap's paths from there on.

use super::disc::{Disc, SAME_ANGLE_RAD, turn};
use super::straight::Join;
use super::{LENGTH_TOLERANCE_M, Leg, Roadmap, Site, Stop, Way};
use crate::geometry::{Path, Piece, Point, Vector, angle_of, direction, left_of};
use petgraph::graph::NodeIndex;
use std::f64::consts::TAU;

/// The first steps of a path from a point.
#[derive(Clone, Copy, Debug)]
enum Approach {
    /// Straight to the site's straight part.
    Straight(Join),
    /// Straight to the point `touch` of a disc, and around it to the next stop of the ring. Each disc has two
    /// rings, one for either direction around it.
    Around {
        /// Index of the ring, half of which is the disc's.
        ring: usize,
        touch: Point,
        /// The angle of `touch` on the disc, rad.
        from_angle: f64,
        /// The signed angle from there to the stop, rad.
        sweep: f64,
        next: NodeIndex,
    },
}

/// The path from a point to a site.
#[derive(Clone, Copy, Debug)]
struct FoundApproach {
    approach: Approach,
    /// The cost by which paths are compared, m.
    cost: f64,
    leg: Leg,
}

impl FoundApproach {
    fn straight(join: Join) -> Self {
        let leg = Leg { length: join.length, depth: join.depth };
        Self { approach: Approach::Straight(join), cost: join.cost, leg }
    }
}

impl Roadmap {
    /// The path from `p` to a site.
    pub fn leg(&self, p: Point, site: usize) -> Leg {
        self.approach(p, site).map_or(Leg::NONE, |found| found.leg)
    }

    /// The initial direction of the path from `p` to a site; `None` where there is no path. At a point of the
    /// straight part, the direction along it.
    pub fn departure(&self, p: Point, site: usize) -> Option<Vector> {
        match self.approach(p, site)?.approach {
            Approach::Straight(join) if join.length <= LENGTH_TOLERANCE_M => {
                Some(-self.sites[site].straight.outward)
            }
            Approach::Straight(join) => Some((join.to - p) / join.length),
            Approach::Around { ring, touch, from_angle, .. } if (touch - p).norm() <= LENGTH_TOLERANCE_M => {
                Some(left_of(direction(from_angle)) * turn(ring))
            }
            Approach::Around { touch, .. } => Some((touch - p).normalize()),
        }
    }

    /// Adds the path from `p` to a site to `path`. Returns the end point on the site, `None` where there is
    /// no path.
    pub fn extend(&self, path: &mut Path, p: Point, site: usize) -> Option<Point> {
        let mut node = match self.approach(p, site)?.approach {
            Approach::Straight(join) => {
                // a point that is on the straight part up to rounding needs no line to it
                if join.length > LENGTH_TOLERANCE_M {
                    path.line(p, join.to);
                }
                return Some(join.to);
            }
            Approach::Around { ring, touch, from_angle, sweep, next } => {
                path.line(p, touch);
                let Disc { center, radius, .. } = self.space.discs[ring / 2];
                path.push(Piece::Arc { center, radius, from_angle, sweep });
                next
            }
        };
        loop {
            let edge = self.paths_to(site).onward[self.components.place(node)]?;
            match self.graph[edge] {
                Way::Line { from, to, .. } => path.line(from, to),
                Way::Join { from, join } => {
                    path.line(from, join.to);
                    return Some(join.to);
                }
                Way::Arc { disc, from_angle, sweep, .. } => {
                    let Disc { center, radius, .. } = self.space.discs[disc];
                    path.push(Piece::Arc { center, radius, from_angle, sweep });
                }
            }
            node = self.graph.edge_endpoints(edge)?.1;
        }
    }

    /// The cheapest path from `p` to a site: straight, or around discs.
    fn approach(&self, p: Point, site: usize) -> Option<FoundApproach> {
        let straight = &self.sites[site].straight;
        let direct = straight.best_join(p);
        let joined = |room: f64| direct.filter(|join| self.space.can_join_by(p, join.to, straight, room));
        if let Some(join) = joined(self.space.clearance) {
            return Some(FoundApproach::straight(join));
        }
        self.approach_around(p, site, self.space.clearance).or_else(|| {
            // a team that is closer to an obstacle than the clearance may leave along it
            let room = self.space.clearance_at(p);
            if let Some(join) = joined(room) {
                return Some(FoundApproach::straight(join));
            }
            self.approach_around(p, site, room)
        })
    }

    /// The cheapest path from `p` that keeps `clearance` (m) up to its first disc, or to the far end of the
    /// straight part.
    fn approach_around(&self, p: Point, site: usize, clearance: f64) -> Option<FoundApproach> {
        let Site { straight, component, .. } = &self.sites[site];
        let goal = self.paths_to(site);
        // the far end of the straight part may be visible where the best joining point is not
        let portal = straight.join_at_portal(p);
        let in_sight = straight.reach > 0.0 && self.space.is_clear_by(p, portal.to, clearance);
        let mut best = in_sight.then(|| FoundApproach::straight(portal));
        for &(ring, nearest) in &goal.rings {
            let cheapest = best.map_or(f64::INFINITY, |found| found.cost);
            if nearest >= cheapest {
                break;
            }
            let disc = &self.space.discs[ring / 2];
            let least = (p - disc.center).norm() - disc.radius;
            if nearest + least.max(0.0) >= cheapest {
                continue;
            }
            let (mut touch, mut to_touch) = disc.bend(turn(ring)).touch_from(p);
            if clearance < self.space.clearance {
                // from closer to a wall than its corner's disc, the tangent ends before the corner: start
                // where the disc's arc begins
                touch = disc.at(disc.nearest_taut(angle_of(touch - disc.center)));
                to_touch = (touch - p).norm();
            }
            let from_angle = angle_of(touch - disc.center);
            let Some((next, sweep, known_open)) = self.next_stop(ring, from_angle) else { continue };
            if self.components.of(next) != *component {
                continue;
            }
            let place = self.components.place(next);
            let Leg { length: onward, depth } = goal.legs[place];
            let to_next = to_touch + disc.radius * sweep.abs();
            let cost = to_next + goal.from_node[place];
            if cost < cheapest
                && disc.is_taut(from_angle)
                && self.space.is_clear_by(p, touch, clearance)
                && (known_open || self.space.is_arc_clear(disc, from_angle, sweep))
            {
                let approach = Approach::Around { ring, touch, from_angle, sweep, next };
                best = Some(FoundApproach { approach, cost, leg: Leg { length: to_next + onward, depth } });
            }
        }
        best
    }

    /// The first stop at or after `angle` along a ring, the signed angle to it, and whether the arc to it is
    /// known to be open.
    fn next_stop(&self, ring: usize, angle: f64) -> Option<(NodeIndex, f64, bool)> {
        let stops = &self.rings[ring];
        let ahead = |stop: &Stop| {
            let ahead = ((stop.angle - angle) * turn(ring)).rem_euclid(TAU);
            if ahead > TAU - SAME_ANGLE_RAD { 0.0 } else { ahead }
        };
        let (next, sweep) = stops.iter().map(ahead).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let before = &stops[(next + stops.len() - 1) % stops.len()];
        Some((stops[next].node, sweep * turn(ring), sweep == 0.0 || before.open_to_next))
    }
}

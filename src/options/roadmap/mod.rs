//! Obstacles, a clearance and a few sites in; shortest collision-free paths between sites, and from any point to a site, out.
//!
//! A shortest path among obstacles with clearance r is a taut string among discs: every corner of an obstacle is a disc of radius r, every
//! cylinder one of radius R + r, and the path is made of lines tangent to two discs and of arcs along them. The roadmap holds all such lines
//! and arcs that keep clear of every obstacle and cross no barrier; Dijkstra's algorithm from each site gives exact distances. A query from
//! a free point adds its own tangents only.

mod disc;
mod space;

pub(super) use space::Space;

use crate::geometry::{Path, Piece, Point, angle_of};
use disc::{Disc, SAME_ANGLE};
use petgraph::Direction;
use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use petgraph::visit::{EdgeRef, Reversed};
use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

/// The free space of a team, with what its shortest paths are made of.
#[derive(Clone, Debug)]
pub(super) struct Roadmap {
    space: Space,
    discs: Vec<Disc>,
    /// Two rings a disc: the ways around it, counter-clockwise at `2 d` and clockwise at `2 d + 1`.
    rings: Vec<Vec<Stop>>,
    graph: DiGraph<(), Way>,
    sites: Vec<Site>,
}

/// A graph node on a ring: where a line touches the disc, and whether one may go on along the ring to the next stop.
#[derive(Clone, Debug)]
struct Stop {
    angle: f64,
    node: NodeIndex,
    kind: StopKind,
    open_to_next: bool,
}

/// At one angle, lines that arrive come before those that leave, so that one may pass from the first to the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum StopKind {
    Arrive,
    Leave,
}

/// How an edge is walked.
#[derive(Clone, Copy, Debug)]
enum Way {
    Line { from: Point, to: Point, length: f64 },
    Arc { disc: usize, from_angle: f64, sweep: f64, length: f64 },
}

impl Way {
    fn length(&self) -> f64 {
        match self {
            Self::Line { length, .. } | Self::Arc { length, .. } => *length,
        }
    }
}

/// A place that paths are asked to lead to.
#[derive(Clone, Debug)]
struct Site {
    point: Point,
    node: NodeIndex,
    /// Distance to the site from every node, m; infinite where there is no way.
    from_node: Vec<f64>,
    /// The way on from every node.
    onward: Vec<Option<EdgeIndex>>,
    /// Rings from which the site can be reached, with a lower bound of the distance from any stop on them, nearest first.
    rings: Vec<(usize, f64)>,
    component: usize,
}

/// The first steps of a query's answer.
#[derive(Clone, Copy, Debug)]
enum Approach {
    Straight,
    Around { ring: usize, touch: Point, from_angle: f64, sweep: f64, next: NodeIndex },
}

impl Roadmap {
    /// The roadmap of `space`, with shortest paths to each of `sites`.
    pub fn new(space: Space, sites: &[Point]) -> Self {
        let discs: Vec<Disc> = space
            .obstacles
            .iter()
            .enumerate()
            .flat_map(|(i, (outline, _))| Disc::all_of(i, outline, space.clearance))
            .collect();
        let mut graph = DiGraph::new();
        let mut rings: Vec<Vec<Stop>> = vec![Vec::new(); 2 * discs.len()];
        let nodes: Vec<NodeIndex> = sites.iter().map(|_| graph.add_node(())).collect();
        let mut stop = |graph: &mut DiGraph<(), Way>, ring: usize, at: Point, kind: StopKind| {
            let node = graph.add_node(());
            let angle = angle_of(at - discs[ring / 2].center);
            // one value for the direction of -x, which is both pi and -pi
            let angle = if angle < SAME_ANGLE - PI { angle + TAU } else { angle };
            rings[ring].push(Stop { angle, node, kind, open_to_next: false });
            node
        };
        for (i, &a) in sites.iter().enumerate() {
            for (j, &b) in sites.iter().enumerate().skip(i + 1) {
                if space.is_clear(a, b) {
                    let length = (b - a).norm();
                    graph.add_edge(nodes[i], nodes[j], Way::Line { from: a, to: b, length });
                    graph.add_edge(nodes[j], nodes[i], Way::Line { from: b, to: a, length });
                }
            }
            for ring in 0..2 * discs.len() {
                if let Some((touch, length)) = tangent_from(&discs[ring / 2], ring, a, &space) {
                    // the way back runs around the disc the other way
                    let arrive = stop(&mut graph, ring, touch, StopKind::Arrive);
                    let leave = stop(&mut graph, ring ^ 1, touch, StopKind::Leave);
                    graph.add_edge(nodes[i], arrive, Way::Line { from: a, to: touch, length });
                    graph.add_edge(leave, nodes[i], Way::Line { from: touch, to: a, length });
                }
            }
        }
        for from in 0..2 * discs.len() {
            for to in (0..2 * discs.len()).filter(|to| to / 2 != from / 2) {
                let ends = [&discs[from / 2], &discs[to / 2]];
                if let Some([a, b]) = ends[0].bend(turn(from)).line_to(&ends[1].bend(turn(to)))
                    && ends[0].is_taut(angle_of(a - ends[0].center))
                    && ends[1].is_taut(angle_of(b - ends[1].center))
                    && space.is_clear(a, b)
                {
                    let leave = stop(&mut graph, from, a, StopKind::Leave);
                    let arrive = stop(&mut graph, to, b, StopKind::Arrive);
                    graph.add_edge(leave, arrive, Way::Line { from: a, to: b, length: (b - a).norm() });
                }
            }
        }
        for (ring, stops) in rings.iter_mut().enumerate() {
            link(ring, &discs[ring / 2], stops, &space, &mut graph);
        }
        let mut map = Self { space, discs, rings, graph, sites: Vec::new() };
        let components = map.components();
        map.sites = sites
            .iter()
            .zip(&nodes)
            .map(|(&point, &node)| map.site(point, node, components[node.index()]))
            .collect();
        map
    }

    fn site(&self, point: Point, node: NodeIndex, component: usize) -> Site {
        let mut from_node = vec![f64::INFINITY; self.graph.node_count()];
        let found =
            petgraph::algo::dijkstra(Reversed(&self.graph), node, None, |edge| edge.weight().length());
        for (n, distance) in found {
            from_node[n.index()] = distance;
        }
        let onward = self.onward(node, &from_node);
        let mut rings: Vec<(usize, f64)> = self
            .rings
            .iter()
            .enumerate()
            .map(|(ring, stops)| {
                let nearest = stops.iter().map(|s| from_node[s.node.index()]).fold(f64::INFINITY, f64::min);
                (ring, nearest)
            })
            .filter(|(_, nearest)| nearest.is_finite())
            .collect();
        rings.sort_by(|a, b| a.1.total_cmp(&b.1));
        Site { point, node, from_node, onward, rings, component }
    }

    /// The first edge of a shortest way from every node: a breadth-first tree over the edges that shortest ways consist of, since following
    /// these edges freely may go around a loop of length 0.
    fn onward(&self, goal: NodeIndex, from_node: &[f64]) -> Vec<Option<EdgeIndex>> {
        let mut onward = vec![None; self.graph.node_count()];
        let mut queue = VecDeque::from([goal]);
        while let Some(to) = queue.pop_front() {
            for edge in self.graph.edges_directed(to, Direction::Incoming) {
                let from = edge.source();
                let shortest = from_node[to.index()] + edge.weight().length() == from_node[from.index()];
                if shortest && from != goal && onward[from.index()].is_none() {
                    onward[from.index()] = Some(edge.id());
                    queue.push_back(from);
                }
            }
        }
        onward
    }

    fn components(&self) -> Vec<usize> {
        let mut union = petgraph::unionfind::UnionFind::new(self.graph.node_count());
        for edge in self.graph.edge_references() {
            union.union(edge.source().index(), edge.target().index());
        }
        union.into_labeling()
    }

    /// The connected part of the team's free space that a site lies in: equal numbers for one part.
    pub fn component(&self, site: usize) -> usize {
        self.sites[site].component
    }

    /// Whether the straight way from `a` to `b` crosses a barrier.
    pub fn crosses_barrier(&self, a: Point, b: Point) -> bool {
        self.space.crosses_barrier(a, b)
    }

    /// Where a site lies.
    pub fn point(&self, site: usize) -> Point {
        self.sites[site].point
    }

    /// Length (m) of the shortest path from one site to another; infinite where there is none.
    pub fn between(&self, from: usize, to: usize) -> f64 {
        self.sites[to].from_node[self.sites[from].node.index()]
    }

    /// Length (m) of the shortest path from `p` to a site; infinite where there is none.
    pub fn distance(&self, p: Point, site: usize) -> f64 {
        self.approach(p, site).map_or(f64::INFINITY, |(_, length)| length)
    }

    /// Adds the shortest path from `p` to a site to `path`; returns false where there is none.
    pub fn extend(&self, path: &mut Path, p: Point, site: usize) -> bool {
        let goal = &self.sites[site];
        let mut node = match self.approach(p, site) {
            None => return false,
            Some((Approach::Straight, _)) => {
                path.line(p, goal.point);
                return true;
            }
            Some((Approach::Around { ring, touch, from_angle, sweep, next }, _)) => {
                path.line(p, touch);
                let Disc { center, radius, .. } = self.discs[ring / 2];
                path.push(Piece::Arc { center, radius, from_angle, sweep });
                next
            }
        };
        while node != goal.node {
            let Some(edge) = goal.onward[node.index()] else { return false };
            match self.graph[edge] {
                Way::Line { from, to, .. } => path.line(from, to),
                Way::Arc { disc, from_angle, sweep, .. } => {
                    let Disc { center, radius, .. } = self.discs[disc];
                    path.push(Piece::Arc { center, radius, from_angle, sweep });
                }
            }
            let Some((_, next)) = self.graph.edge_endpoints(edge) else { return false };
            node = next;
        }
        true
    }

    fn approach(&self, p: Point, site: usize) -> Option<(Approach, f64)> {
        let goal = &self.sites[site];
        if self.space.is_clear(p, goal.point) {
            return Some((Approach::Straight, (goal.point - p).norm()));
        }
        self.approach_around(p, goal, self.space.clearance).or_else(|| {
            // a team that stands nearer to an obstacle than it should may leave along it
            let room = self.space.clearance_at(p).min(self.space.clearance);
            if self.space.is_clear_by(p, goal.point, room) {
                return Some((Approach::Straight, (goal.point - p).norm()));
            }
            self.approach_around(p, goal, room)
        })
    }

    fn approach_around(&self, p: Point, goal: &Site, clearance: f64) -> Option<(Approach, f64)> {
        let mut best: Option<(Approach, f64)> = None;
        for &(ring, nearest) in &goal.rings {
            let shortest = best.map_or(f64::INFINITY, |(_, length)| length);
            if nearest >= shortest {
                break;
            }
            let disc = &self.discs[ring / 2];
            let least = (p - disc.center).norm() - disc.radius;
            if nearest + least.max(0.0) >= shortest {
                continue;
            }
            let (mut touch, mut to_touch) = disc.bend(turn(ring)).touch_from(p);
            if clearance < self.space.clearance {
                // from nearer to a wall than its corner's disc, the tangent ends before the corner: go where the disc's arc begins
                touch = disc.at(disc.nearest_taut(angle_of(touch - disc.center)));
                to_touch = (touch - p).norm();
            }
            let from_angle = angle_of(touch - disc.center);
            let Some((next, sweep, known_open)) = self.next_stop(ring, from_angle) else { continue };
            let onward = goal.from_node[next.index()];
            let length = to_touch + disc.radius * sweep.abs() + onward;
            if length < shortest
                && disc.is_taut(from_angle)
                && self.space.is_clear_by(p, touch, clearance)
                && (known_open || self.space.is_arc_clear(disc, from_angle, sweep))
            {
                best = Some((Approach::Around { ring, touch, from_angle, sweep, next }, length));
            }
        }
        best
    }

    /// The first stop at or after `angle` along a ring, the signed angle to it, and whether the way there is known to be open.
    fn next_stop(&self, ring: usize, angle: f64) -> Option<(NodeIndex, f64, bool)> {
        let stops = &self.rings[ring];
        let ahead = |stop: &Stop| {
            let ahead = ((stop.angle - angle) * turn(ring)).rem_euclid(TAU);
            if ahead > TAU - SAME_ANGLE { 0.0 } else { ahead }
        };
        let (next, sweep) = stops.iter().map(ahead).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let before = &stops[(next + stops.len() - 1) % stops.len()];
        Some((stops[next].node, sweep * turn(ring), sweep == 0.0 || before.open_to_next))
    }
}

/// +1 on counter-clockwise rings, -1 on clockwise ones.
fn turn(ring: usize) -> f64 {
    if ring.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn tangent_from(disc: &Disc, ring: usize, p: Point, space: &Space) -> Option<(Point, f64)> {
    let (touch, length) = disc.bend(turn(ring)).touch_from(p);
    let taut = disc.is_taut(angle_of(touch - disc.center));
    (taut && space.is_clear(p, touch)).then_some((touch, length))
}

/// Joins the stops of a ring in its direction of travel by the arcs that are clear.
fn link(ring: usize, disc: &Disc, stops: &mut [Stop], space: &Space, graph: &mut DiGraph<(), Way>) {
    let turn = turn(ring);
    let order = |a: &Stop, b: &Stop| {
        (a.angle * turn).total_cmp(&(b.angle * turn)).then(a.kind.cmp(&b.kind)).then(a.node.cmp(&b.node))
    };
    stops.sort_by(order);
    for i in 1..stops.len() {
        if (stops[i].angle - stops[i - 1].angle).abs() <= SAME_ANGLE {
            stops[i].angle = stops[i - 1].angle;
        }
    }
    stops.sort_by(order);
    let n = stops.len();
    for i in 0..n {
        let next = (i + 1) % n;
        let from_angle = stops[i].angle;
        let ahead = ((stops[next].angle - from_angle) * turn).rem_euclid(TAU);
        // the last stop leads on to the first only around the disc
        if next == 0 && ahead == 0.0 {
            continue;
        }
        let sweep = ahead * turn;
        if ahead == 0.0 || space.is_arc_clear(disc, from_angle, sweep) {
            let length = disc.radius * ahead;
            stops[i].open_to_next = true;
            let way = Way::Arc { disc: ring / 2, from_angle, sweep, length };
            graph.add_edge(stops[i].node, stops[next].node, way);
        }
    }
}

#[cfg(test)]
mod tests;

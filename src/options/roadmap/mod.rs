//! Shortest collision-free paths between sites, and from any point to a site. Sites are points and the
//! straight parts of openings.
//!
//! A shortest path among obstacles with clearance r is a taut string among discs. Every corner of an obstacle
//! is a disc of radius r and every cylinder one of radius R + r. The path consists of lines tangent to two
//! discs and of arcs along discs. The roadmap holds all such lines and arcs that keep clear of every obstacle
//! and cross no barrier. Dijkstra's algorithm from each site gives exact distances. A query from a free point
//! adds only its own tangents.

mod approach;
mod components;
mod disc;
mod reachable;
mod sight;
mod space;
mod straight;
mod through;

pub(super) use space::Space;
pub(super) use straight::{MAX_BACKWARD, Straight};

use crate::geometry::{Point, angle_of, left_of};
use components::Components;
use disc::{Disc, SAME_ANGLE_RAD, turn};
use petgraph::Direction;
use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use petgraph::visit::EdgeRef;
use reachable::Reachable;
use sight::{Sight, View};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;
use straight::Join;

/// The largest number of lines between obstacles with an open view that are tried: less than a minute of work.
const MAX_TRIED: u64 = 400_000_000;
/// The largest number of clear lines and joins: less than 1 GB.
const MAX_CLEAR_LINES: usize = 4_000_000;

/// Lines shorter than this (m) are rounding.
const LENGTH_TOLERANCE_M: f64 = 1e-10;

/// The free space of a team as a graph of tangents and arcs, with the shortest paths to the sites.
#[derive(Clone, Debug)]
pub(super) struct Roadmap {
    space: Space,
    /// Two rings per disc, one for each direction around it: counter-clockwise at `2 d` and clockwise at
    /// `2 d + 1`.
    rings: Vec<Vec<Stop>>,
    graph: DiGraph<(), Way>,
    components: Components,
    sites: Vec<Site>,
}

/// A graph node on a ring: where a line touches the disc, and whether the arc to the next stop is open.
#[derive(Clone, Debug)]
struct Stop {
    angle: f64,
    node: NodeIndex,
    kind: StopKind,
    open_to_next: bool,
}

/// At the same angle, arriving lines come before leaving ones, so that a path may connect the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum StopKind {
    Arrive,
    Leave,
}

/// The shape of an edge.
#[derive(Clone, Copy, Debug)]
enum Way {
    Line {
        from: Point,
        to: Point,
        length: f64,
    },
    /// A line onto a straight part, joined at this depth (m) before the gap.
    Join {
        from: Point,
        join: Join,
    },
    Arc {
        disc: usize,
        from_angle: f64,
        sweep: f64,
        length: f64,
    },
}

impl Way {
    fn length(&self) -> f64 {
        match self {
            Self::Line { length, .. } | Self::Arc { length, .. } => *length,
            Self::Join { join, .. } => join.length,
        }
    }

    fn cost(&self) -> f64 {
        match self {
            Self::Join { join, .. } => join.cost,
            _ => self.length(),
        }
    }
}

/// A path to a site.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    /// Length, m; infinite where there is no path.
    pub length: f64,
    /// Distance (m) before the gap at which the path joins the straight part; 0 for points.
    pub depth: f64,
}

impl Leg {
    const NONE: Self = Self { length: f64::INFINITY, depth: 0.0 };
}

/// A destination of paths.
#[derive(Clone, Debug)]
struct Site {
    straight: Straight,
    /// Its far end, from which paths may continue.
    node: NodeIndex,
    /// Where paths to it end.
    goal: NodeIndex,
    component: usize,
    /// Computed when first asked for: most sites of a large world are on no option.
    paths: OnceLock<PathsTo>,
}

/// The shortest paths to a site from every node of its component.
#[derive(Clone, Debug)]
struct PathsTo {
    /// Cost (m) of the path to the site from every node; infinite where there is none.
    from_node: Vec<f64>,
    /// The path to the site from every node.
    legs: Vec<Leg>,
    /// The next edge toward the site from every node.
    onward: Vec<Option<EdgeIndex>>,
    /// Rings from which the site can be reached, each with a lower bound of the distance from any of its
    /// stops, nearest first.
    rings: Vec<(usize, f64)>,
}

impl Roadmap {
    /// The roadmap of `space`, with shortest paths to each of `sites`. `closed` are the gaps that are too
    /// narrow for the team.
    ///
    /// # Errors
    /// Too many lines to be tried, or too many clear ones.
    pub fn new(space: Space, sites: &[Straight], closed: &[[Point; 2]]) -> Result<Self, String> {
        Self::in_sight(&Sight::new(&space, closed), space, sites)
    }

    fn in_sight(sight: &Sight, space: Space, sites: &[Straight]) -> Result<Self, String> {
        let discs = space.discs.clone();
        let mut graph = DiGraph::new();
        let mut rings: Vec<Vec<Stop>> = vec![Vec::new(); 2 * discs.len()];
        let nodes: Vec<NodeIndex> = sites.iter().map(|_| graph.add_node(())).collect();
        // paths end where they join a straight part, and continue from its far end only
        let goals: Vec<NodeIndex> = sites.iter().map(|_| graph.add_node(())).collect();
        let mut stop = |graph: &mut DiGraph<(), Way>, ring: usize, at: Point, kind: StopKind| {
            let node = graph.add_node(());
            let angle = angle_of(at - discs[ring / 2].center);
            // -x has one angle, although atan2 gives both pi and -pi
            let angle = if angle < SAME_ANGLE_RAD - PI { angle + TAU } else { angle };
            rings[ring].push(Stop { angle, node, kind, open_to_next: false });
            node
        };
        let reachable = Reachable::new(sight, &space, &discs, sites);
        if reachable.lines() > MAX_TRIED {
            return Err(format!(
                "{} lines between their corners to test; the limit is {MAX_TRIED}",
                reachable.lines()
            ));
        }
        let check = |graph: &DiGraph<(), Way>| match graph.edge_count() > MAX_CLEAR_LINES {
            true => Err(format!(
                "more than {MAX_CLEAR_LINES} clear lines between their corners, which is the limit"
            )),
            false => Ok(()),
        };
        for (i, site) in sites.iter().enumerate() {
            check(&graph)?;
            let a = site.portal();
            graph.add_edge(nodes[i], goals[i], Way::Join { from: a, join: site.join_at_portal(a) });
            let (others, near_discs) = reachable.reached_from_site(i);
            let is_hidden = |to: Point| reachable.view_from_site(i).hides_along(to - a);
            let mut blocker = 0;
            for &j in others.iter().filter(|j| **j > i) {
                let b = sites[j].portal();
                if !is_hidden(b) && space.is_clear(a, b) {
                    let length = (b - a).norm();
                    graph.add_edge(nodes[i], nodes[j], Way::Line { from: a, to: b, length });
                    graph.add_edge(nodes[j], nodes[i], Way::Line { from: b, to: a, length });
                }
            }
            for &j in others.iter().filter(|j| **j != i) {
                let other = &sites[j];
                let is_open = |join: &Join| !is_hidden(join.to) && space.can_join(a, join.to, other);
                if let Some(join) = other.join_from(a).filter(is_open) {
                    graph.add_edge(nodes[i], goals[j], Way::Join { from: a, join });
                }
            }
            let rings =
                near_discs.into_iter().flat_map(|(disc, is_seen)| [0, 1].map(|i| (2 * disc + i, is_seen)));
            for (ring, is_seen) in rings {
                if is_seen
                    && let Some((touch, length)) =
                        tangent_from(&discs[ring / 2], ring, a, is_hidden, &space, &mut blocker)
                {
                    // the reverse path follows the disc in the other direction
                    let arrive = stop(&mut graph, ring, touch, StopKind::Arrive);
                    let leave = stop(&mut graph, ring ^ 1, touch, StopKind::Leave);
                    graph.add_edge(nodes[i], arrive, Way::Line { from: a, to: touch, length });
                    graph.add_edge(leave, nodes[i], Way::Line { from: touch, to: a, length });
                }
                for along in site.backward() {
                    let (disc, turn) = (&discs[ring / 2], turn(ring));
                    let out = -left_of(along) * turn;
                    let touch = disc.center + out * disc.radius;
                    if let Some(join) = site.join_along(touch, along)
                        && disc.is_taut(angle_of(out))
                        && space.can_join(touch, join.to, site)
                    {
                        let leave = stop(&mut graph, ring, touch, StopKind::Leave);
                        graph.add_edge(leave, goals[i], Way::Join { from: touch, join });
                    }
                }
            }
        }
        for (disc, views, others) in reachable.discs(&discs) {
            check(&graph)?;
            for (from, view) in [2 * disc, 2 * disc + 1].into_iter().zip(views) {
                for (to, [a, b]) in clear_lines(&discs, (from, view), &others, &space) {
                    let leave = stop(&mut graph, from, a, StopKind::Leave);
                    let arrive = stop(&mut graph, to, b, StopKind::Arrive);
                    graph.add_edge(leave, arrive, Way::Line { from: a, to: b, length: (b - a).norm() });
                }
            }
        }
        for (ring, stops) in rings.iter_mut().enumerate() {
            link(ring, &discs[ring / 2], stops, &space, &mut graph);
        }
        let components =
            Components::new(&graph, rings.iter().map(|stops| stops.iter().map(|stop| stop.node)));
        let sites = sites.iter().zip(nodes.iter().zip(&goals));
        let sites = sites
            .map(|(straight, (&node, &goal))| Site {
                straight: straight.clone(),
                node,
                goal,
                component: components.of(node),
                paths: OnceLock::new(),
            })
            .collect();
        Ok(Self { space, rings, graph, components, sites })
    }

    /// The shortest paths to a site.
    fn paths_to(&self, site: usize) -> &PathsTo {
        let Site { straight, goal, component, paths, .. } = &self.sites[site];
        paths.get_or_init(|| self.shortest(straight, *goal, *component))
    }

    /// Forgets the shortest paths to a site, which take memory, until they are asked for again.
    pub fn forget_paths_to(&mut self, site: usize) {
        self.sites[site].paths.take();
    }

    /// The number of places from which shortest paths to a site are searched.
    pub fn places_around(&self, site: usize) -> u64 {
        self.components.size(self.sites[site].component) as u64
    }

    fn shortest(&self, straight: &Straight, goal: NodeIndex, component: usize) -> PathsTo {
        let from_node = self.costs_to(goal, component);
        let here = Leg { length: 0.0, depth: straight.reach };
        let (onward, legs) = self.onward(goal, &from_node, here);
        let nearest = |&ring: &usize| {
            let stops = self.rings[ring].iter().filter(|stop| self.components.of(stop.node) == component);
            let nearest =
                stops.map(|s| from_node[self.components.place(s.node)]).fold(f64::INFINITY, f64::min);
            (ring, nearest)
        };
        let mut rings: Vec<(usize, f64)> = self
            .components
            .rings(component)
            .iter()
            .map(nearest)
            .filter(|(_, nearest)| nearest.is_finite())
            .collect();
        rings.sort_by(|a, b| a.1.total_cmp(&b.1));
        PathsTo { from_node, legs, onward, rings }
    }

    /// The cost (m) of the path to `goal` from every node of its component; infinite where there is none.
    /// Dijkstra's algorithm.
    fn costs_to(&self, goal: NodeIndex, component: usize) -> Vec<f64> {
        let mut costs = vec![f64::INFINITY; self.components.size(component)];
        costs[self.components.place(goal)] = 0.0;
        // costs are not negative, so that their bits have their order
        let mut queue = BinaryHeap::from([(Reverse(0.0_f64.to_bits()), goal)]);
        while let Some((Reverse(bits), to)) = queue.pop() {
            let cost = f64::from_bits(bits);
            if cost > costs[self.components.place(to)] {
                continue;
            }
            for edge in self.graph.edges_directed(to, Direction::Incoming) {
                let known = &mut costs[self.components.place(edge.source())];
                let through = cost + edge.weight().cost();
                if through < *known {
                    *known = through;
                    queue.push((Reverse(through.to_bits()), edge.source()));
                }
            }
        }
        costs
    }

    /// The first edge of a shortest path from every node. The result is a breadth-first tree over the edges
    /// of shortest paths, because following these edges freely may loop along cycles of length 0.
    fn onward(&self, goal: NodeIndex, from_node: &[f64], here: Leg) -> (Vec<Option<EdgeIndex>>, Vec<Leg>) {
        let place = |node: NodeIndex| self.components.place(node);
        let mut onward = vec![None; from_node.len()];
        let mut legs = vec![Leg::NONE; from_node.len()];
        legs[place(goal)] = here;
        let mut queue = VecDeque::from([goal]);
        while let Some(to) = queue.pop_front() {
            for edge in self.graph.edges_directed(to, Direction::Incoming) {
                let from = edge.source();
                let way = edge.weight();
                let shortest = from_node[place(to)] + way.cost() == from_node[place(from)];
                if shortest && from != goal && onward[place(from)].is_none() {
                    onward[place(from)] = Some(edge.id());
                    let after = legs[place(to)];
                    legs[place(from)] = match way {
                        Way::Join { join, .. } => Leg { length: join.length, depth: join.depth },
                        _ => Leg { length: after.length + way.length(), ..after },
                    };
                    queue.push_back(from);
                }
            }
        }
        (onward, legs)
    }

    /// The connected part of free space that a site lies in; equal numbers mean the same part.
    pub fn component(&self, site: usize) -> usize {
        self.sites[site].component
    }

    /// The straight part of a site.
    pub fn straight(&self, site: usize) -> &Straight {
        &self.sites[site].straight
    }

    /// Whether the straight line from `a` to `b` crosses a barrier.
    pub fn crosses_barrier(&self, a: Point, b: Point) -> bool {
        self.space.crosses_barrier(a, b)
    }

    /// The path from one site to another; from a straight part it begins at the far end.
    pub fn between(&self, from: usize, to: usize) -> Leg {
        let from = &self.sites[from];
        if from.component != self.sites[to].component {
            return Leg::NONE;
        }
        self.paths_to(to).legs[self.components.place(from.node)]
    }
}

/// The clear lines that leave a ring, with its view, and touch one of `others`, each with the ring that it leads
/// to and its ends.
fn clear_lines(
    discs: &[Disc],
    (from, view): (usize, &View),
    others: &[usize],
    space: &Space,
) -> impl Iterator<Item = (usize, [Point; 2])> {
    let disc = &discs[from / 2];
    let bend = disc.bend(turn(from));
    let is_near = |other: &usize| {
        let distance = (discs[*other].center - disc.center).norm();
        *other != from / 2 && distance <= view.farthest + discs[*other].radius
    };
    let may_lead = |to: &usize| disc.may_lead(turn(from), &discs[to / 2], turn(*to));
    let mut lines: Vec<(usize, [Point; 2], f64)> = Vec::new();
    let others = others.iter().copied().filter(is_near);
    for to in others.flat_map(|disc| [2 * disc, 2 * disc + 1]).filter(may_lead) {
        let other = &discs[to / 2];
        if let Some([a, b]) = bend.line_to(&other.bend(turn(to)))
            && !disc.is_slack(a)
            && !other.is_slack(b)
        {
            let angle = angle_of(a - disc.center);
            let is_hidden = view.hides(angle, (b - disc.center).norm());
            if !is_hidden && disc.is_taut(angle) && other.is_taut(angle_of(b - other.center)) {
                lines.push((to, [a, b], angle));
            }
        }
    }
    // lines in similar directions are often blocked by the same obstacle
    let mut order: Vec<usize> = (0..lines.len()).collect();
    order.sort_unstable_by(|&i, &j| lines[i].2.total_cmp(&lines[j].2));
    let mut is_clear = vec![false; lines.len()];
    let mut blocker = 0;
    for i in order {
        let [a, b] = lines[i].1;
        is_clear[i] = space.is_clear_trying(&mut blocker, a, b);
    }
    lines.into_iter().zip(is_clear).filter(|(_, is_clear)| *is_clear).map(|((to, ends, _), _)| (to, ends))
}

fn tangent_from(
    disc: &Disc,
    ring: usize,
    p: Point,
    is_hidden: impl Fn(Point) -> bool,
    space: &Space,
    blocker: &mut usize,
) -> Option<(Point, f64)> {
    let (touch, length) = disc.bend(turn(ring)).touch_from(p);
    let taut = !disc.is_slack(touch) && !is_hidden(touch) && disc.is_taut(angle_of(touch - disc.center));
    (taut && space.is_clear_trying(blocker, p, touch)).then_some((touch, length))
}

/// Links the stops of a ring in its direction of travel by the arcs that are clear.
fn link(ring: usize, disc: &Disc, stops: &mut [Stop], space: &Space, graph: &mut DiGraph<(), Way>) {
    let turn = turn(ring);
    let order = |a: &Stop, b: &Stop| {
        (a.angle * turn).total_cmp(&(b.angle * turn)).then(a.kind.cmp(&b.kind)).then(a.node.cmp(&b.node))
    };
    stops.sort_by(order);
    for i in 1..stops.len() {
        if (stops[i].angle - stops[i - 1].angle).abs() <= SAME_ANGLE_RAD {
            stops[i].angle = stops[i - 1].angle;
        }
    }
    stops.sort_by(order);
    let n = stops.len();
    for i in 0..n {
        let next = (i + 1) % n;
        let from_angle = stops[i].angle;
        let ahead = ((stops[next].angle - from_angle) * turn).rem_euclid(TAU);
        // the last stop leads to the first only by going around the disc
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

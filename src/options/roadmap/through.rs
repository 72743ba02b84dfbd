//! The shortest path through given gaps in order, wherever it passes them.
//!
//! The search is Dijkstra's algorithm over pairs of a node and the number of gaps crossed. An edge that crosses
//! the next gaps in order leads on; an edge that crosses any other does not.

use super::{Roadmap, Way};
use crate::geometry::Point;
use crate::options::passage::Crossing;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The largest angle (rad) of the chords by which arcs are followed.
const CHORD_RAD: f64 = 0.05;

impl Roadmap {
    /// Length (m) of the shortest path from one site to another, both points, that makes these crossings in
    /// this order and no other; infinite where there is none. `crossings` gives those of a straight step, in
    /// order. The gaps must not be barriers of this roadmap.
    pub fn length_through(
        &self,
        [from, to]: [usize; 2],
        route: &[Crossing],
        crossings: impl Fn(Point, Point) -> Vec<Crossing>,
    ) -> f64 {
        let positions = self.positions();
        let [from, to] = [from, to].map(|site| self.sites[site].node);
        // the crossings of every edge, computed when first asked for
        let mut crossed: Vec<Option<Vec<Crossing>>> = vec![None; self.graph.edge_count()];
        let place = |node: NodeIndex, made: usize| node.index() * (route.len() + 1) + made;
        let mut least = vec![f64::INFINITY; self.graph.node_count() * (route.len() + 1)];
        least[place(from, 0)] = 0.0;
        // the order of floats that are not negative is that of their bits
        let mut queue = BinaryHeap::from([Reverse((0.0_f64.to_bits(), from, 0))]);
        while let Some(Reverse((length, node, made))) = queue.pop() {
            let length = f64::from_bits(length);
            if node == to && made == route.len() {
                return length;
            }
            if length > least[place(node, made)] {
                continue;
            }
            for edge in self.graph.edges(node) {
                let ends = [edge.source(), edge.target()].map(|node| positions[node.index()]);
                let made_here = crossed[edge.id().index()]
                    .get_or_insert_with(|| self.crossings_of(edge.weight(), ends, &crossings));
                if !route[made..].starts_with(made_here) {
                    continue;
                }
                let (next, made) = (edge.target(), made + made_here.len());
                let onward = length + edge.weight().length();
                if onward < least[place(next, made)] {
                    least[place(next, made)] = onward;
                    queue.push(Reverse((onward.to_bits(), next, made)));
                }
            }
        }
        f64::INFINITY
    }

    /// Where the nodes are. All edges of a node begin or end in the same point, so that a gap's line has it on
    /// one side.
    fn positions(&self) -> Vec<Point> {
        let mut positions = vec![Point::origin(); self.graph.node_count()];
        for site in &self.sites {
            positions[site.node.index()] = site.straight.portal();
            positions[site.goal.index()] = site.straight.portal();
        }
        for (ring, stops) in self.rings.iter().enumerate() {
            let disc = &self.space.discs[ring / 2];
            stops.iter().for_each(|stop| positions[stop.node.index()] = disc.at(stop.angle));
        }
        positions
    }

    fn crossings_of(
        &self,
        way: &Way,
        [from, to]: [Point; 2],
        crossings: impl Fn(Point, Point) -> Vec<Crossing>,
    ) -> Vec<Crossing> {
        let Way::Arc { disc, from_angle, sweep, .. } = *way else { return crossings(from, to) };
        let chords = (sweep.abs() / CHORD_RAD).ceil().max(1.0) as usize;
        let inner =
            (1..chords).map(|i| self.space.discs[disc].at(from_angle + sweep * i as f64 / chords as f64));
        let mut at = from;
        let mut made = Vec::new();
        for next in inner.chain([to]) {
            made.extend(crossings(at, next));
            at = next;
        }
        made
    }
}

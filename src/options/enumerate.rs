//! Regions and passages in; the cheapest sequences of openings from the start to the target, which enter no region twice, out.

use super::{Crossing, OptionSet, START, TARGET, before, beyond, site};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Partial sequences looked at before the search gives up and says that it is cut.
const MOST_LOOKED_AT: usize = 200_000;

/// What the search found.
pub(super) struct Found {
    pub options: Vec<Vec<Crossing>>,
    /// Whether there are more.
    pub is_cut: bool,
}

/// A sequence under way, ordered by a lower bound of the cost of whatever it leads to.
struct Partial {
    bound: f64,
    /// Length walked, m, and chance of having passed unharmed.
    length: f64,
    safe: f64,
    crossings: Vec<Crossing>,
    arrived: bool,
}

/// The `limit` cheapest options by D_o + c_r S_o, cheapest first: best-first search, bounded from below by the shortest way on from each
/// passage (regions entered twice allowed).
pub(super) fn cheapest(set: &OptionSet, limit: usize, risk_weight: f64) -> Found {
    let onward = shortest_onward(set);
    let mut queue = BinaryHeap::new();
    queue.push(Partial { bound: 0.0, length: 0.0, safe: 1.0, crossings: Vec::new(), arrived: false });
    let mut found = Found { options: Vec::new(), is_cut: false };
    for _ in 0..MOST_LOOKED_AT {
        let Some(partial) = queue.pop() else { return found };
        if partial.arrived {
            if found.options.len() == limit {
                found.is_cut = true;
                return found;
            }
            found.options.push(partial.crossings);
            continue;
        }
        let leave = partial.crossings.last().map_or(START, |&c| beyond(c));
        let here = set.roadmap.component(leave);
        let to_target = set.stages.between(leave, TARGET).length();
        if to_target.is_finite() {
            let length = partial.length + to_target;
            queue.push(Partial {
                bound: length + risk_weight * (1.0 - partial.safe),
                length,
                safe: partial.safe,
                crossings: partial.crossings.clone(),
                arrived: true,
            });
        }
        let entered = |region: usize| {
            region == here || partial.crossings.iter().any(|&c| set.region_before(c) == region)
        };
        for (opening, passage) in set.passages.iter().enumerate() {
            for into in [0, 1] {
                let crossing = Crossing { opening, into };
                if set.region_before(crossing) != here || entered(set.region_after(crossing)) {
                    continue;
                }
                let length = partial.length + set.stages.between(leave, before(crossing)).length();
                let safe = partial.safe * (1.0 - passage.risk);
                let bound = length + onward[beyond(crossing)] + risk_weight * (1.0 - safe);
                if bound.is_finite() {
                    let crossings = partial.crossings.iter().copied().chain([crossing]).collect();
                    queue.push(Partial { bound, length, safe, crossings, arrived: false });
                }
            }
        }
    }
    found.is_cut = true;
    found
}

/// The shortest way (m) through any passages to the target, from the start and from the gap of every crossing, by the site beyond it.
fn shortest_onward(set: &OptionSet) -> Vec<f64> {
    let n = site(set.passages.len(), 0);
    let mut graph = petgraph::graph::DiGraph::new();
    let nodes: Vec<_> = (0..n).map(|_| graph.add_node(())).collect();
    for from in (0..n).filter(|&from| from != TARGET) {
        for to in (0..n).filter(|&to| to != START) {
            let length = set.stages.between(from, to).length();
            if length.is_finite() {
                // from the target's side, so that one search finds all; through a gap to its other side
                let gap = if to == TARGET { TARGET } else { to ^ 1 };
                graph.add_edge(nodes[gap], nodes[from], length);
            }
        }
    }
    let mut onward = vec![f64::INFINITY; n];
    for (node, length) in petgraph::algo::dijkstra(&graph, nodes[TARGET], None, |e| *e.weight()) {
        onward[node.index()] = length;
    }
    onward
}

impl Ord for Partial {
    /// The heap's greatest is the cheapest; equal costs go to the shorter sequence, then to lower openings.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |p: &Self| p.crossings.iter().map(|c| (c.opening, c.into)).collect::<Vec<_>>();
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| other.crossings.len().cmp(&self.crossings.len()))
            .then_with(|| key(other).cmp(&key(self)))
            .then_with(|| self.arrived.cmp(&other.arrived))
    }
}

impl PartialOrd for Partial {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Partial {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Partial {}

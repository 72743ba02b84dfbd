//! Enumeration of options: the cheapest sequences of openings from the start to the target that enter no
//! region twice.

use super::passage::{Crossing, Passage};
use super::roadmap::Roadmap;
use super::sites::{START, TARGET, before, beyond, site};
use super::stage::Stages;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The number of partial sequences after which the search stops and reports that it is cut.
const MOST_EXPANDED: usize = 200_000;

/// What is searched: places, the passages between them, and the paths from one to the next.
#[derive(Clone, Copy)]
pub(super) struct Network<'a> {
    pub roadmap: &'a Roadmap,
    pub passages: &'a [Passage],
    pub stages: &'a Stages,
}

/// The result of the search.
pub(super) struct Found {
    pub options: Vec<Vec<Crossing>>,
    /// Whether more options exist.
    pub is_cut: bool,
}

/// A partial sequence, ordered by a lower bound of the cost of its completions.
struct Partial {
    bound: f64,
    /// Length walked, m, and probability of safe passage so far.
    length: f64,
    safe: f64,
    crossings: Vec<Crossing>,
    arrived: bool,
}

/// Margin (m) subtracted from lower bounds, so that rounding does not lift them above the costs that they
/// bound.
const BOUND_ROUNDING_M: f64 = 1e-9;

/// The `limit` cheapest options by D_o + c_r S_o, cheapest first. The search is best-first over regions from
/// which the target can still be reached. Its lower bounds are the shortest and the safest path onward from
/// each passage, with regions entered twice allowed. The search stops after [`MOST_EXPANDED`] partial
/// sequences. If it has found no option by then, it takes the path of its bounds.
pub(super) fn cheapest(set: Network, limit: usize, risk_weight: f64) -> Found {
    let search = Search::new(set, risk_weight);
    let mut queue = BinaryHeap::new();
    queue.push(Partial { bound: 0.0, length: 0.0, safe: 1.0, crossings: Vec::new(), arrived: false });
    let mut found = Found { options: Vec::new(), is_cut: false };
    let mut looked_at = 0;
    while let Some(partial) = queue.pop() {
        looked_at += 1;
        let gives_up = looked_at > MOST_EXPANDED;
        if found.options.len() == limit && partial.arrived || gives_up && !found.options.is_empty() {
            found.is_cut = true;
            break;
        }
        if partial.arrived {
            found.options.push(partial.crossings);
            continue;
        }
        if gives_up {
            queue.clear();
        }
        queue.extend(search.onward(&partial));
    }
    found
}

/// The search's view of regions and passages.
struct Search<'a> {
    set: Network<'a>,
    risk_weight: f64,
    /// The region of every site, numbered from 0.
    regions: Vec<usize>,
    /// The crossings that lead from each region into another one.
    out: Vec<Vec<Crossing>>,
    /// From every site to the target through any passages: length of the shortest path, m, and largest
    /// probability of safe passage.
    shortest: Vec<f64>,
    safest: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(set: Network<'a>, risk_weight: f64) -> Self {
        let sites = 2 + 2 * set.passages.len();
        let components: Vec<usize> = (0..sites).map(|s| set.roadmap.component(s)).collect();
        let mut known = components.clone();
        known.sort_unstable();
        known.dedup();
        let regions: Vec<usize> = components.iter().map(|c| known.partition_point(|k| k < c)).collect();
        let mut out = vec![Vec::new(); known.len()];
        for opening in 0..set.passages.len() {
            for into in [0, 1] {
                let [before, after] = [1 - into, into].map(|side| regions[site(opening, side)]);
                if before != after {
                    out[before].push(Crossing { opening, into });
                }
            }
        }
        let length = |from: usize, to: usize| set.stages.between(from, to).length();
        // the inverse of the probability of safe passage
        let danger = |from: usize, to: usize| match to {
            _ if regions[from] != regions[to] => f64::INFINITY,
            TARGET => 1.0,
            _ => 1.0 / (1.0 - set.passages[(to - 2) / 2].risk),
        };
        let shortest = least_onward(sites, 0.0, length, |a, b| a + b);
        let safest = least_onward(sites, 1.0, danger, |a, b| a * b).into_iter().map(f64::recip).collect();
        Self { set, risk_weight, regions, out, shortest, safest }
    }

    /// The extensions of a sequence by one crossing or by the target.
    fn onward(&self, partial: &Partial) -> Vec<Partial> {
        let set = self.set;
        let leave = partial.crossings.last().map_or(START, |&c| beyond(c));
        let to_target = set.stages.between(leave, TARGET).length();
        if to_target.is_finite() {
            let length = partial.length + to_target;
            let bound = length + self.risk_weight * (1.0 - partial.safe);
            let crossings = partial.crossings.clone();
            return vec![Partial { bound, length, safe: partial.safe, crossings, arrived: true }];
        }
        let can_reach_target = self.can_reach_target(partial, self.regions[leave]);
        let extended = |crossing: &Crossing| {
            let exit = beyond(*crossing);
            let length = partial.length + set.stages.between(leave, before(*crossing)).length();
            let safe = partial.safe * (1.0 - set.passages[crossing.opening].risk);
            let bound = length + self.shortest[exit] + self.risk_weight * (1.0 - safe * self.safest[exit]);
            let crossings = partial.crossings.iter().copied().chain([*crossing]).collect();
            Partial { bound: bound - BOUND_ROUNDING_M, length, safe, crossings, arrived: false }
        };
        self.out[self.regions[leave]]
            .iter()
            .filter(|crossing| can_reach_target[self.after(**crossing)])
            .map(extended)
            .filter(|next| next.bound.is_finite())
            .collect()
    }

    /// The region that a crossing leads into.
    fn after(&self, crossing: Crossing) -> usize {
        self.regions[beyond(crossing)]
    }

    /// For every region, whether the target can be reached from it through regions that the sequence has not
    /// entered. `here` is the last region entered.
    fn can_reach_target(&self, partial: &Partial, here: usize) -> Vec<bool> {
        let target = self.regions[TARGET];
        let mut closed = vec![false; self.out.len()];
        for region in partial.crossings.iter().map(|c| self.after(c.back())).chain([here]) {
            closed[region] = true;
        }
        let mut can_reach_target = vec![false; self.out.len()];
        can_reach_target[target] = true;
        let mut queue = vec![target];
        while let Some(region) = queue.pop() {
            for &crossing in &self.out[region] {
                let next = self.after(crossing);
                if !closed[next] && !can_reach_target[next] {
                    can_reach_target[next] = true;
                    queue.push(next);
                }
            }
        }
        can_reach_target
    }
}

/// The least cost of a path to the target from the start and from the gap of every crossing, indexed by the
/// site beyond it. Any passages may be used and regions entered twice. Dijkstra's algorithm over all pairs:
/// `cost` is the cost from such a place to another site, `join` combines the costs of consecutive paths, and
/// `none` is the cost of an empty path.
fn least_onward(
    sites: usize,
    none: f64,
    cost: impl Fn(usize, usize) -> f64,
    join: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; sites];
    let mut is_done = vec![false; sites];
    least[TARGET] = none;
    let nearest = |least: &[f64], is_done: &[bool]| {
        (0..sites).filter(|&s| !is_done[s]).min_by(|&a, &b| least[a].total_cmp(&least[b]))
    };
    while let Some(place) = nearest(&least, &is_done).filter(|&s| least[s].is_finite()) {
        is_done[place] = true;
        // a gap is entered from its other side
        let to = if place == TARGET { TARGET } else { place ^ 1 };
        for from in (0..sites).filter(|&from| place != START && from != TARGET) {
            least[from] = least[from].min(join(cost(from, to), least[place]));
        }
    }
    least
}

impl Ord for Partial {
    /// The heap's greatest element is the cheapest. Equal costs go to the shorter sequence, then to lower
    /// openings.
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

//! Enumeration of options: the cheapest sequences of openings from the start to the target that enter no
//! region twice.

use super::passage::{Crossing, Passage};
use super::regions::on_routes;
use super::roadmap::Roadmap;
use super::sites::{MAX_LANES, START, Sites, TARGET};
use super::stage::Stages;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::rc::Rc;

/// The number of partial sequences after which the search stops and reports that it is cut.
const MAX_EXPANDED: usize = 200_000;

/// The largest number of places from which shortest paths to exits are searched: less than a minute of work.
const MAX_SEARCHED: u64 = 400_000_000;

/// The result of the search.
#[derive(Default)]
pub(super) struct FoundOptions {
    pub options: Vec<Vec<Crossing>>,
    /// Whether more options exist, or may exist.
    pub is_cut: bool,
    /// Whether the search stopped after [`MAX_EXPANDED`] partial sequences.
    pub is_search_cut: bool,
}

/// A partial sequence, ordered by a lower bound of the cost of its completions.
struct Partial {
    bound: f64,
    /// Length of the shortest path so far, m, to every lane of the last crossing; without one, the first is 0.
    lengths: [f64; MAX_LANES],
    /// Probability of safe passage so far.
    safe: f64,
    last: Option<Rc<Step>>,
    arrived: bool,
}

/// The last crossing of a sequence.
struct Step {
    crossing: Crossing,
    /// The crossing before it.
    before: Option<Rc<Step>>,
    /// The number of crossings up to this one.
    count: usize,
}

/// Margin (m) subtracted from lower bounds, so that rounding does not lift them above the costs that they
/// bound.
const BOUND_ROUNDING_M: f64 = 1e-9;

/// The `limit` cheapest options by D_o + c_r S_o, cheapest first. The search is best-first over regions from
/// which the target can still be reached. Its lower bounds are the shortest and the safest path onward from
/// each passage, with regions entered twice allowed. The search stops after [`MAX_EXPANDED`] partial
/// sequences. If it has found no option by then, it takes the path of its bounds. The paths that it may use
/// are added to `stages`.
///
/// # Errors
/// The error that there are too many paths between openings to be searched.
pub(super) fn cheapest(
    roadmap: &mut Roadmap,
    (passages, sites): (&[Passage], &Sites),
    stages: &mut Stages,
    limit: usize,
    risk_weight: f64,
) -> Result<FoundOptions, String> {
    if stages.between(roadmap, START, TARGET).length().is_finite() {
        return Ok(FoundOptions { options: vec![Vec::new()], ..FoundOptions::default() });
    }
    let layout = RoadmapLayout::new(roadmap, sites, passages.len());
    layout.tabulate(roadmap, stages)?;
    let search = Search::new(&layout, roadmap, passages, stages, risk_weight);
    let mut queue = BinaryHeap::new();
    queue.push(Partial { bound: 0.0, lengths: [0.0; MAX_LANES], safe: 1.0, last: None, arrived: false });
    let mut found = FoundOptions::default();
    let mut looked_at = 0;
    while let Some(partial) = queue.pop() {
        looked_at += 1;
        let gives_up = looked_at > MAX_EXPANDED;
        if found.options.len() == limit && partial.arrived || gives_up && !found.options.is_empty() {
            found.is_cut = true;
            found.is_search_cut = found.options.len() < limit;
            break;
        }
        if partial.arrived {
            found.options.push(partial.crossings());
            continue;
        }
        if gives_up {
            found.is_search_cut = true;
            queue.clear();
        }
        queue.extend(search.onward(&partial));
    }
    found.is_cut |= found.is_search_cut;
    Ok(found)
}

/// The regions that an option may enter, and the crossings between them.
struct RoadmapLayout<'a> {
    sites: &'a Sites,
    /// The region of every site, numbered from 0.
    regions: Vec<usize>,
    /// The crossings from each region that an option may make.
    out: Vec<Vec<Crossing>>,
    /// The sites in each region from which an option may continue.
    entries: Vec<Vec<usize>>,
}

impl<'a> RoadmapLayout<'a> {
    fn new(roadmap: &Roadmap, sites: &'a Sites, openings: usize) -> Self {
        let components: Vec<usize> = (0..sites.count()).map(|s| roadmap.component(s)).collect();
        let mut known = components.clone();
        known.sort_unstable();
        known.dedup();
        let regions: Vec<usize> = components.iter().map(|c| known.partition_point(|k| k < c)).collect();
        let sides = |opening: usize| [0, 1].map(|into| regions[sites.beyond(Crossing { opening, into }, 0)]);
        let mut neighbors = vec![Vec::new(); known.len()];
        for [a, b] in (0..openings).map(sides) {
            neighbors[a].push(b);
            neighbors[b].push(a);
        }
        let [start, target] = [regions[START], regions[TARGET]];
        let is_on_route = on_routes(&neighbors, start, target);
        let mut out = vec![Vec::new(); known.len()];
        let mut entries = vec![Vec::new(); known.len()];
        entries[start].push(START);
        for opening in 0..openings {
            for into in [0, 1] {
                let crossing = Crossing { opening, into };
                let (from, to) = (regions[sites.before(crossing, 0)], regions[sites.beyond(crossing, 0)]);
                let is_useful = from != to && from != target && to != start;
                if is_useful && is_on_route[from] && is_on_route[to] {
                    out[from].push(crossing);
                    entries[to].extend((0..sites.lanes(opening)).map(|lane| sites.beyond(crossing, lane)));
                }
            }
        }
        Self { sites, regions, out, entries }
    }

    /// Adds the paths within every region that an option may take to `stages`.
    fn tabulate(&self, roadmap: &mut Roadmap, stages: &mut Stages) -> Result<(), String> {
        let to_target = (&self.entries[self.regions[TARGET]], vec![TARGET]);
        let legs = self.out.iter().zip(&self.entries).flat_map(|(out, entries)| {
            let mut exits: Vec<Vec<usize>> = out.iter().map(|c| self.sites.all_before(*c)).collect();
            exits.sort_unstable();
            exits.into_iter().map(move |exit| (entries, exit))
        });
        let legs: Vec<_> = legs.chain([to_target]).filter(|(entries, _)| !entries.is_empty()).collect();
        let found: u64 = legs.iter().flat_map(|(_, to)| to).map(|to| roadmap.places_around(*to)).sum();
        if found > MAX_SEARCHED {
            return Err(format!(
                "paths to the openings start at {found} places; the limit is {MAX_SEARCHED}"
            ));
        }
        for (entries, to) in legs {
            stages.tabulate(roadmap, entries, &to);
            to.into_iter().for_each(|to| roadmap.forget_paths_to(to));
        }
        Ok(())
    }
}

/// The search's view of regions and passages.
struct Search<'a> {
    layout: &'a RoadmapLayout<'a>,
    roadmap: &'a Roadmap,
    passages: &'a [Passage],
    stages: &'a Stages,
    risk_weight: f64,
    /// From every site to the target through any passages: length of the shortest path, m, and largest
    /// probability of safe passage.
    shortest: Vec<f64>,
    safest: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(
        layout: &'a RoadmapLayout<'a>,
        roadmap: &'a Roadmap,
        passages: &'a [Passage],
        stages: &'a Stages,
        risk_weight: f64,
    ) -> Self {
        let length = |from: usize, to: usize| stages.between(roadmap, from, to).length();
        // the inverse of the probability of safe passage
        let danger = |_: usize, to: usize| match to {
            TARGET => 1.0,
            _ => 1.0 / (1.0 - passages[layout.sites.opening(to)].risk),
        };
        let shortest = least_onward(layout, 0.0, length, |a, b| a + b);
        let safest = least_onward(layout, 1.0, danger, |a, b| a * b).into_iter().map(f64::recip).collect();
        Self { layout, roadmap, passages, stages, risk_weight, shortest, safest }
    }

    fn length(&self, from: usize, to: usize) -> f64 {
        self.stages.between(self.roadmap, from, to).length()
    }

    /// The length (m) of the shortest path to a site that continues a sequence.
    fn length_to(&self, partial: &Partial, to: usize) -> f64 {
        let Some(step) = &partial.last else { return partial.lengths[0] + self.length(START, to) };
        let sites = self.layout.sites;
        let through =
            |lane: usize| partial.lengths[lane] + self.length(sites.beyond(step.crossing, lane), to);
        (0..sites.lanes(step.crossing.opening)).map(through).fold(f64::INFINITY, f64::min)
    }

    /// The extensions of a sequence by one crossing or by the target.
    fn onward(&self, partial: &Partial) -> Vec<Partial> {
        let sites = self.layout.sites;
        let leave = partial.last.as_ref().map_or(START, |step| sites.beyond(step.crossing, 0));
        let here = self.layout.regions[leave];
        if here == self.layout.regions[TARGET] {
            let length = self.length_to(partial, TARGET);
            let bound = length + self.risk_weight * (1.0 - partial.safe);
            let (lengths, last) = ([length; MAX_LANES], partial.last.clone());
            let arrived = Partial { bound, lengths, safe: partial.safe, last, arrived: true };
            return if length.is_finite() { vec![arrived] } else { Vec::new() };
        }
        let can_reach_target = self.can_reach_target(partial, here);
        let extended = |crossing: &Crossing| {
            let mut lengths = [f64::INFINITY; MAX_LANES];
            let mut shortest = f64::INFINITY;
            for (lane, length) in lengths.iter_mut().enumerate().take(sites.lanes(crossing.opening)) {
                *length = self.length_to(partial, sites.before(*crossing, lane));
                shortest = shortest.min(*length + self.shortest[sites.beyond(*crossing, lane)]);
            }
            let safe = partial.safe * (1.0 - self.passages[crossing.opening].risk);
            let safest = self.safest[sites.beyond(*crossing, 0)];
            let bound = shortest + self.risk_weight * (1.0 - safe * safest);
            let last = Some(Rc::new(Step {
                crossing: *crossing,
                before: partial.last.clone(),
                count: partial.count() + 1,
            }));
            Partial { bound: bound - BOUND_ROUNDING_M, lengths, safe, last, arrived: false }
        };
        self.layout.out[here]
            .iter()
            .filter(|crossing| can_reach_target[self.after(**crossing)])
            .map(extended)
            .filter(|next| next.bound.is_finite())
            .collect()
    }

    /// The region that a crossing leads into.
    fn after(&self, crossing: Crossing) -> usize {
        self.layout.regions[self.layout.sites.beyond(crossing, 0)]
    }

    /// For every region, whether the target can be reached from it through regions that the sequence has not
    /// entered. `here` is the last region entered.
    fn can_reach_target(&self, partial: &Partial, here: usize) -> Vec<bool> {
        let target = self.layout.regions[TARGET];
        let mut closed = vec![false; self.layout.out.len()];
        closed[here] = true;
        partial.steps().for_each(|step| closed[self.after(step.crossing.back())] = true);
        let mut can_reach_target = vec![false; self.layout.out.len()];
        can_reach_target[target] = true;
        let mut queue = vec![target];
        while let Some(region) = queue.pop() {
            for &entry in &self.layout.entries[region] {
                // a gap is entered from its other side
                let next = self.layout.regions[entry ^ 1];
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
/// site beyond it. Regions may be entered twice. Dijkstra's algorithm: `cost` is the cost from such a place to
/// another site, `join` combines the costs of consecutive paths, and `none` is the cost of an empty path.
fn least_onward(
    layout: &RoadmapLayout,
    none: f64,
    cost: impl Fn(usize, usize) -> f64,
    join: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; layout.regions.len()];
    let mut is_done = vec![false; layout.regions.len()];
    least[TARGET] = none;
    // the order of floats that are not negative is that of their bits
    let mut queue = BinaryHeap::from([Reverse((none.to_bits(), TARGET))]);
    while let Some(Reverse((_, place))) = queue.pop() {
        if std::mem::replace(&mut is_done[place], true) || place == START {
            continue;
        }
        // a gap is entered from its other side
        let to = if place == TARGET { TARGET } else { place ^ 1 };
        for &from in &layout.entries[layout.regions[to]] {
            let onward = join(cost(from, to), least[place]);
            if onward < least[from] {
                least[from] = onward;
                queue.push(Reverse((onward.to_bits(), from)));
            }
        }
    }
    least
}

impl Partial {
    /// Its crossings, the last one first.
    fn steps(&self) -> impl Iterator<Item = &Step> {
        std::iter::successors(self.last.as_deref(), |step| step.before.as_deref())
    }

    fn count(&self) -> usize {
        self.last.as_ref().map_or(0, |step| step.count)
    }

    fn crossings(&self) -> Vec<Crossing> {
        let mut crossings: Vec<Crossing> = self.steps().map(|step| step.crossing).collect();
        crossings.reverse();
        crossings
    }
}

impl Ord for Partial {
    /// The heap's greatest element is the cheapest. Equal costs go to the shorter sequence, then to lower
    /// openings.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |p: &Self| p.crossings().iter().map(|c| (c.opening, c.into)).collect::<Vec<_>>();
        other
            .bound
            .total_cmp(&self.bound)
            .then_with(|| other.count().cmp(&self.count()))
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

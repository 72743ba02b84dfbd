//! The path options of a [`World`], each with the length D_o and the risk S_o of its remaining path from the
//! team's position.
//!
//! The openings cut free space into regions. An option is a sequence of openings, crossed straight through
//! their middles (between pillars: see [`Passing`]) and connected by shortest collision-free paths. A tick
//! costs one short query per option: only the first leg depends on the team's position, the rest is
//! tabulated.

mod alignment;
mod build;
mod enumerate;
mod passage;
mod path_option;
mod progress;
mod regions;
mod roadmap;
mod sites;
mod stage;
mod trajectory;

pub use alignment::ALIGNMENT_M;
pub use passage::Crossing;
pub use path_option::PathOption;
pub use progress::Progress;
pub use trajectory::{nominal_trajectory, turned};

use crate::error::{Error, Place};
use crate::geometry::{Path, Point};
use crate::world::{ListedOption, World};
use arrayvec::ArrayVec;
use build::{passages, refused, space, straights, unreachable};
use passage::{Exit, Passage};
use path_option::{After, Afters};
use progress::Rest;
use roadmap::{Leg, Roadmap, Straight};
use serde::{Deserialize, Serialize};
use sites::{MAX_LANES, START, Sites, TARGET};
use stage::Stages;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The largest number of corners and cylinders of a world in which [`OptionSet::shortest_lengths`] searches.
const MAX_CORNERS_OF_SHORTEST: usize = 400;

/// The number of sites whose paths from the team's position are kept within a step.
const MAX_KNOWN_LEGS: usize = 16;

/// Where a path goes through a gap between pillars. Elsewhere there is one way through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passing {
    /// On the shortest path, whose length is D_o: as near to a pillar as a point may pass.
    Shortest,
    /// Through the middle: a long object cuts the corner round a pillar and needs the room.
    ///
    /// DEVIATION (eq. 1): the team walks farther than D_o says, by at most a quarter between random pillars.
    Middle,
}

/// The options of a world, ready to be evaluated from any position.
#[derive(Clone, Debug)]
pub struct OptionSet {
    roadmap: Roadmap,
    passages: Vec<Passage>,
    sites: Sites,
    stages: Stages,
    options: Vec<PathOption>,
    /// Whether more options exist than were enumerated, or may exist: see [`OptionSet::is_search_cut`].
    pub is_cut: bool,
    /// Whether the search was cut before it had found the cheapest options. Those that it found can be walked,
    /// but others may be cheaper.
    pub is_search_cut: bool,
    start: Point,
    target: Point,
    /// Tells it from others; that of a copy is the same.
    pub(crate) identity: Arc<()>,
}

/// The remainder of an option from the team's position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remaining {
    /// D_o, m. Infinite where there is no path.
    pub length: f64,
    /// S_o = 1 - prod (1 - S_xi) over the openings ahead (Sec. III-A).
    pub risk: f64,
    /// The next waypoint.
    pub next: Waypoint,
}

/// The next opening on an option, or the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Waypoint {
    /// An opening, crossed in one direction.
    Opening(Crossing),
    /// The target.
    Target,
}

/// The paths from one point to sites. Several options often lead to the same site next.
struct LegsFrom {
    point: Point,
    known: ArrayVec<(usize, Leg), MAX_KNOWN_LEGS>,
}

impl LegsFrom {
    fn new(point: Point) -> Self {
        Self { point, known: ArrayVec::new() }
    }

    /// The path to a site.
    fn to(&mut self, roadmap: &Roadmap, site: usize) -> Leg {
        if let Some((_, leg)) = self.known.iter().find(|(known, _)| *known == site) {
            return *leg;
        }
        let leg = roadmap.leg(self.point, site);
        // beyond the capacity, paths are found again
        if !self.known.is_full() {
            self.known.push((site, leg));
        }
        leg
    }
}

impl OptionSet {
    /// The options that the world lists; if it lists none, the cheapest by D_o + c_r S_o (eq. 1) up to the
    /// world's limit, with `risk_weight` c_r (m).
    ///
    /// # Errors
    /// The target cannot be reached, a listed option cannot be walked, or the world is too large to be
    /// searched. All are of [`ErrorKind::World`](crate::ErrorKind::World).
    pub fn new(world: &World, risk_weight: f64) -> Result<Self, Error> {
        let (space, closed) = space(world, &world.openings);
        let passages = passages(world, &space);
        let sites = Sites::new(&passages);
        let straights = straights([world.start, world.target], &passages);
        let too_open = |work: String| {
            let obstacles = world.obstacles.len();
            refused(
                Place::file(&world.file),
                format_args!(
                    "too many obstacles in an open world ({obstacles}): {work}; use fewer obstacles, or fewer corners (a cylinder has none)"
                ),
            )
        };
        let roadmap = Roadmap::new(space, &straights, &closed).map_err(too_open)?;
        let mut set = Self {
            roadmap,
            passages,
            sites,
            stages: Stages::default(),
            options: Vec::new(),
            is_cut: false,
            is_search_cut: false,
            start: world.start,
            target: world.target,
            identity: Arc::default(),
        };
        if world.listed_options.is_empty() {
            let Self { roadmap, passages, sites, stages, .. } = &mut set;
            let found =
                enumerate::cheapest(roadmap, (passages, sites), stages, world.option_limit, risk_weight)
                    .map_err(too_open)?;
            set.is_cut = found.is_cut;
            set.is_search_cut = found.is_search_cut;
            set.tabulate(found.options.iter().flatten().map(|crossing| crossing.opening));
            set.options = found
                .options
                .into_iter()
                .enumerate()
                .map(|(i, crossings)| set.option((i + 1).to_string(), crossings))
                .collect();
            if set.options.is_empty() {
                return Err(unreachable(world));
            }
        } else {
            set.tabulate(world.listed_options.iter().flat_map(|listed| listed.openings.iter().copied()));
            set.options = world
                .listed_options
                .iter()
                .map(|listed| {
                    let crossings = set.directed(world, listed)?;
                    Ok(set.option(listed.name.clone(), crossings))
                })
                .collect::<Result<_, Error>>()?;
        }
        Ok(set)
    }

    /// Tabulates the paths between these openings, the start and the target.
    fn tabulate(&mut self, openings: impl Iterator<Item = usize>) {
        let openings: BTreeSet<usize> = openings.collect();
        let mut from: Vec<usize> = openings.iter().flat_map(|&opening| self.sites.of(opening)).collect();
        from.push(START);
        let crossings = openings.iter().flat_map(|&opening| [1, 0].map(|into| Crossing { opening, into }));
        let to: Vec<Vec<usize>> = crossings.map(|crossing| self.sites.all_before(crossing)).collect();
        to.iter().chain([&vec![TARGET]]).for_each(|to| self.stages.tabulate(&self.roadmap, &from, to));
    }

    /// The options, in file order or cheapest first. Never empty.
    pub fn options(&self) -> &[PathOption] {
        &self.options
    }

    /// Whether an option goes through an opening (an index into the world's).
    pub fn uses(&self, opening: usize) -> bool {
        self.options.iter().flat_map(|o| &o.crossings).any(|c| c.opening == opening)
    }

    /// Whether both sides of an opening (an index into the world's) are the same region. A path then leads
    /// around the opening through no other one. Enumerated options enter no region twice, so none uses this
    /// opening.
    pub fn leads_nowhere_new(&self, opening: usize) -> bool {
        let crossing = Crossing { opening, into: 0 };
        self.region_before(crossing) == self.region_after(crossing)
    }

    /// Position of the target.
    pub fn target(&self) -> Point {
        self.target
    }

    /// Whether a straight step from one point to another goes through an opening.
    pub fn goes_through_opening(&self, from: Point, to: Point) -> bool {
        self.roadmap.crosses_barrier(from, to)
    }

    /// The crossing that a straight step from one point to another makes; of several, that of the first
    /// opening along the step.
    pub fn crossing(&self, from: Point, to: Point) -> Option<Crossing> {
        self.crossings(from, to).next()
    }

    /// The crossings that a straight step from one point to another makes, in order along the step.
    pub fn crossings(&self, from: Point, to: Point) -> impl Iterator<Item = Crossing> + '_ {
        progress::crossings(&self.passages, from, to)
    }

    /// The team at the start, with every option ahead of it.
    pub fn begin(&self) -> Progress {
        Progress::new(self.start, self.options.len())
    }

    /// For every option, the length (m) of the shortest path from the start through the same openings, wherever
    /// it passes them and without straight parts: [`Remaining::length`] at the start is never shorter. `None`
    /// where the world, which must be the one of these options, has too many corners to search.
    pub fn shortest_lengths(&self, world: &World) -> Option<Vec<f64>> {
        let (space, closed) = space(world, &[]);
        if space.corners() > MAX_CORNERS_OF_SHORTEST {
            return None;
        }
        let ends = [self.start, self.target].map(Straight::from);
        let roadmap = Roadmap::new(space, &ends, &closed).ok()?;
        let crossings = |from: Point, to: Point| match self.goes_through_opening(from, to) {
            true => self.crossings(from, to).collect(),
            false => Vec::new(),
        };
        let length =
            |option: &PathOption| roadmap.length_through([START, TARGET], &option.crossings, crossings);
        Some(self.options.iter().map(length).collect())
    }

    /// Whether a progress fits these options. One read from a file may not.
    pub fn knows(&self, progress: &Progress) -> bool {
        progress.is_among(&self.passages, &self.options)
    }

    /// Moves the team in a straight step to `to` and records the openings that it crosses.
    pub fn advance(&self, progress: &mut Progress, to: Point) {
        let exit = |crossing, rest: &Rest, option: &PathOption| self.after_gap(crossing, rest, option).exit;
        progress.advance(to, &self.passages, &self.options, |c| self.region_after(c), exit);
    }

    /// D_o, S_o and the next waypoint of an option (an index) from the team's position.
    ///
    /// An opening is behind the team once the team has left its straight part, which does not depend on the
    /// option. Until then the opening's risk counts, and an option that follows the straight part farther
    /// continues along it.
    pub fn remaining(&self, progress: &Progress, option: usize) -> Remaining {
        self.remaining_by(progress, option, &mut LegsFrom::new(self.off_gaps(progress.position)))
    }

    /// [`OptionSet::remaining`] of every option, in order.
    pub fn all_remaining<'a>(&'a self, progress: &'a Progress) -> impl Iterator<Item = Remaining> + 'a {
        let mut legs = LegsFrom::new(self.off_gaps(progress.position));
        (0..self.options.len()).map(move |option| self.remaining_by(progress, option, &mut legs))
    }

    /// [`OptionSet::remaining`] with the legs from the team's position off the gaps.
    fn remaining_by(&self, progress: &Progress, option: usize, legs: &mut LegsFrom) -> Remaining {
        let (next, rest, risk) =
            (self.next(progress, option), progress.rest(option), self.risk(progress, option));
        let way = &self.options[option];
        let length = match progress.inside.zip(self.exit(progress, option)) {
            None => self.beyond(rest, way, |site| legs.to(&self.roadmap, site)).length,
            Some((crossing, Exit::Axis(end))) => {
                (end - progress.position).norm() + self.after_gap(crossing, rest, way).length
            }
            Some((_, Exit::OffAxis(end))) => {
                (end - progress.position).norm() + self.beyond_point(end, rest, way).length
            }
        };
        Remaining { length, risk, next }
    }

    /// The next waypoint of an option from the team's position. It depends only on the remaining path, not on
    /// the openings that the option lists behind the team. Between a gap and the end of its straight part, it
    /// is the opening being crossed, or the same opening crossed back.
    pub fn next(&self, progress: &Progress, option: usize) -> Waypoint {
        let ahead = progress.rest(option).ahead(&self.options[option]).next();
        match progress.inside {
            Some(crossing) if ahead != Some(crossing.back()) => Waypoint::Opening(crossing),
            _ => ahead.map_or(Waypoint::Target, Waypoint::Opening),
        }
    }

    /// Whether two options have the same remaining way from the team's position.
    pub fn lead_the_same_way(&self, progress: &Progress, first: usize, second: usize) -> bool {
        let ahead = |option: usize| progress.rest(option).ahead(&self.options[option]);
        ahead(first).eq(ahead(second))
    }

    /// The remaining path of an option from the team's position. Its length is [`Remaining::length`]. `None`
    /// where there is no path.
    pub fn path(&self, progress: &Progress, option: usize) -> Option<Path> {
        self.path_passing(progress, option, Passing::Shortest)
    }

    /// The remaining path of an option from the team's position; `passing` says where it goes through gaps
    /// between pillars. `None` where there is no path.
    pub fn path_passing(&self, progress: &Progress, option: usize, passing: Passing) -> Option<Path> {
        let mut path = Path::default();
        self.write_path(progress, option, passing, &mut path).then_some(path)
    }

    /// [`OptionSet::path_passing`] written into an existing path, without allocation once that has enough
    /// capacity. Returns false, with the path cut short, where there is no path.
    pub fn write_path(&self, progress: &Progress, option: usize, passing: Passing, path: &mut Path) -> bool {
        path.clear();
        let chosen = |after: After| match passing {
            Passing::Shortest => after.lane,
            Passing::Middle => 0,
        };
        let (rest, way) = (progress.rest(option), &self.options[option]);
        let mut at = progress.position;
        let mut lane = match progress.inside.zip(self.exit(progress, option)) {
            None => {
                at = self.off_gaps(at);
                chosen(self.beyond_point(at, rest, way))
            }
            Some((crossing, exit)) => {
                let (Exit::Axis(end) | Exit::OffAxis(end)) = exit;
                path.line(at, end);
                at = end;
                match exit {
                    Exit::Axis(_) => chosen(self.after_gap(crossing, rest, way)),
                    Exit::OffAxis(_) => chosen(self.beyond_point(end, rest, way)),
                }
            }
        };
        for (i, crossing) in rest.ahead(way).enumerate() {
            let site = self.sites.before(crossing, lane);
            let Some(joined) = self.roadmap.extend(path, at, site) else { return false };
            let (passage, after) = (&self.passages[crossing.opening], self.afters(rest, way, i)[lane]);
            let middle = passage.middle(lane);
            at = passage.at(lane, crossing.into, after.exit);
            path.line(joined, middle);
            path.line(middle, at);
            lane = chosen(after);
        }
        self.roadmap.extend(path, at, TARGET).is_some()
    }

    /// The point where an option leaves the straight part that the team is in; `None` where it has.
    fn exit(&self, progress: &Progress, option: usize) -> Option<Exit> {
        let crossing = progress.inside?;
        let rest = progress.rest(option);
        if rest.has_left {
            return None;
        }
        let reach = self.after_gap(crossing, rest, &self.options[option]).exit;
        self.passages[crossing.opening].exit(progress.position, crossing.into, reach)
    }

    /// `p` off the lines of all gaps.
    fn off_gaps(&self, p: Point) -> Point {
        self.passages.iter().fold(p, |p, passage| passage.off_gap(p))
    }

    /// The remainder of an option from a point that is in no straight part beyond a gap; the whole length is
    /// [`After::length`].
    fn beyond_point(&self, p: Point, rest: &Rest, way: &PathOption) -> After {
        self.beyond(rest, way, |site| self.roadmap.leg(p, site))
    }

    /// [`OptionSet::beyond_point`] with the paths from that point to sites.
    fn beyond(&self, rest: &Rest, way: &PathOption, mut leg: impl FnMut(usize) -> Leg) -> After {
        let Some(next) = rest.ahead(way).next() else {
            return After { exit: 0.0, length: leg(TARGET).length, lane: 0 };
        };
        let afters = self.afters(rest, way, 0);
        let through = |lane: usize| {
            let (leg, after) = (leg(self.sites.before(next, lane)), afters[lane]);
            After { exit: 0.0, length: leg.length + (leg.depth + after.exit) + after.length, lane }
        };
        let lanes = (0..self.sites.lanes(next.opening)).map(through);
        lanes.min_by(|a, b| a.length.total_cmp(&b.length)).unwrap_or(After::NONE)
    }

    /// The remainder of an option from the gap of a straight part that the team is in. Such gaps have one lane.
    fn after_gap(&self, crossing: Crossing, rest: &Rest, way: &PathOption) -> After {
        let next = rest.ahead(way).next().map(|next| (next, self.afters(rest, way, 0)));
        self.stages.after(&self.roadmap, &self.sites, self.sites.beyond(crossing, 0), next)
    }

    /// The remainders from the gap of the crossing with this index among those ahead, which must exist.
    fn afters(&self, rest: &Rest, way: &PathOption, index: usize) -> Afters {
        let Some(back) = rest.back.len().checked_sub(index) else {
            return way.after[rest.place + index - rest.back.len()];
        };
        let mut next = way.crossings.get(rest.place).copied().zip(way.after.get(rest.place).copied());
        for &crossing in &rest.back[..back] {
            next = Some((crossing, self.stages.afters(&self.roadmap, &self.sites, crossing, next)));
        }
        next.map_or([After::NONE; MAX_LANES], |(_, afters)| afters)
    }

    /// S_o over the openings that are not behind the team.
    fn risk(&self, progress: &Progress, option: usize) -> f64 {
        let rest = progress.rest(option);
        let ahead = self.options[option].risk_left[rest.place];
        let crossed = rest.back.iter().chain(&progress.inside);
        crossed.fold(ahead, |risk, &crossing| self.risk_with(risk, crossing))
    }

    fn risk_with(&self, risk: f64, crossing: Crossing) -> f64 {
        1.0 - (1.0 - risk) * (1.0 - self.passages[crossing.opening].risk)
    }

    fn region_before(&self, crossing: Crossing) -> usize {
        self.region_after(crossing.back())
    }

    fn region_after(&self, crossing: Crossing) -> usize {
        self.roadmap.component(self.sites.beyond(crossing, 0))
    }

    fn option(&self, name: String, crossings: Vec<Crossing>) -> PathOption {
        let start = self.roadmap.component(START);
        let regions = [start].into_iter().chain(crossings.iter().map(|&c| self.region_after(c))).collect();
        let n = crossings.len();
        let mut after = vec![[After::NONE; MAX_LANES]; n];
        let mut risk_left = vec![0.0; n + 1];
        for i in (0..n).rev() {
            let next = crossings.get(i + 1).map(|&next| (next, after[i + 1]));
            after[i] = self.stages.afters(&self.roadmap, &self.sites, crossings[i], next);
            risk_left[i] = self.risk_with(risk_left[i + 1], crossings[i]);
        }
        PathOption { name, crossings, regions, after, risk_left }
    }

    /// The direction of every crossing of a listed option: of the walkable directions, those that give the
    /// shortest path.
    fn directed(&self, world: &World, listed: &ListedOption) -> Result<Vec<Crossing>, Error> {
        // for either direction of the last crossing: length so far and the crossings that lead there
        let mut ways: Vec<(f64, Vec<Crossing>)> = vec![(0.0, Vec::new())];
        // the direction does not depend on the lane
        let leave = |way: &[Crossing]| way.last().map_or(START, |&c| self.sites.beyond(c, 0));
        let not_walkable = |i: usize, to: String| {
            let item = format!("option `{}`", listed.name);
            let from = match i.checked_sub(1) {
                None => "the start".to_owned(),
                Some(before) => format!("opening `{}`", world.openings[listed.openings[before]].name),
            };
            let clearance = world.robot_width / 2.0;
            refused(
                Place { file: world.file.clone(), line: Some(listed.line), item },
                format_args!(
                    "no path leads from {from} to {to} with {clearance} m clear on either side and through no other opening"
                ),
            )
        };
        let shortest = |ways: Vec<(f64, Vec<Crossing>)>| {
            ways.into_iter().filter(|w| w.0.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))
        };
        for (i, &opening) in listed.openings.iter().enumerate() {
            let onward = |into: usize| {
                let crossing = Crossing { opening, into };
                shortest(
                    ways.clone()
                        .into_iter()
                        .map(|(length, mut way)| {
                            let before = self.sites.before(crossing, 0);
                            let stage = self.stages.between(&self.roadmap, leave(&way), before);
                            way.push(crossing);
                            (length + stage.length(), way)
                        })
                        .collect(),
                )
            };
            let next: Vec<_> = [onward(0), onward(1)].into_iter().flatten().collect();
            if next.is_empty() {
                return Err(not_walkable(i, format!("opening `{}`", world.openings[opening].name)));
            }
            ways = next;
        }
        let arrived = ways
            .into_iter()
            .map(|(length, way)| {
                (length + self.stages.between(&self.roadmap, leave(&way), TARGET).length(), way)
            })
            .collect();
        shortest(arrived)
            .map(|(_, way)| way)
            .ok_or_else(|| not_walkable(listed.openings.len(), "the target".to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::BUILT_IN_WORLDS;

    #[test]
    fn property_all_options_at_once_are_each_option_to_the_bit() {
        for built_in in BUILT_IN_WORLDS {
            let world = World::parse(built_in.name, built_in.text).unwrap();
            let set = OptionSet::new(&world, 10.0).unwrap();
            for walked in 0..set.options().len() {
                let mut progress = set.begin();
                let path = set.path(&progress, walked).unwrap();
                for step in 0..200 {
                    let point = path.point_at(f64::from(step) / 199.0 * path.length()).unwrap();
                    set.advance(&mut progress, point);
                    let each: Vec<Remaining> =
                        (0..set.options().len()).map(|option| set.remaining(&progress, option)).collect();
                    let all: Vec<Remaining> = set.all_remaining(&progress).collect();
                    assert_eq!(all, each, "{} {walked} {step}", built_in.name);
                }
            }
        }
    }
}

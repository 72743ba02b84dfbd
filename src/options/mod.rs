//! A [`World`] in; its path options out, each with the length D_o and risk S_o of what is left of it from where the team is.
//!
//! Free space is cut along the openings into regions; an option is a sequence of openings, walked straight through their middles, with shortest
//! collision-free paths between. A tick costs one short query per option: only the first leg depends on where the team is, the rest is
//! tabulated.

mod enumerate;
mod error;
mod passage;
mod progress;
mod roadmap;
mod trajectory;

pub use error::{Blockage, OptionError};
pub use passage::Crossing;
pub use progress::Progress;
pub use trajectory::{nominal_trajectory, turned};

use crate::geometry::{Path, Point};
use crate::world::{ListedOption, World};
use passage::Passage;
use progress::Rest;
use roadmap::{Roadmap, Space};
use serde::{Deserialize, Serialize};

/// How far the team walks straight before and after an opening, m: human, object and robot in tandem are about 2.5 m long and must be
/// straight when they enter.
pub const ALIGNMENT: f64 = 1.0;

/// The sites of the roadmap: the start, the target, then both ends of every passage.
const START: usize = 0;
const TARGET: usize = 1;

fn portal_site(opening: usize, side: usize) -> usize {
    2 + 2 * opening + side
}

/// The options of a world, and everything needed to evaluate them from anywhere.
#[derive(Clone, Debug)]
pub struct OptionSet {
    roadmap: Roadmap,
    passages: Vec<Passage>,
    options: Vec<PathOption>,
    /// Whether more options exist than were enumerated.
    pub is_cut: bool,
    start: Point,
    target: Point,
}

/// One way from the start to the target: openings in the order of travel.
#[derive(Clone, Debug)]
pub struct PathOption {
    /// Name, unique in its world.
    pub name: String,
    /// The openings in the order of travel, with the direction of each.
    pub crossings: Vec<Crossing>,
    /// The region before each crossing, and the last one.
    regions: Vec<usize>,
    /// Length from the end of each passage to the target, m.
    after: Vec<f64>,
    /// S_o over the crossings from each place on; 0 after the last.
    risk_left: Vec<f64>,
}

/// What is left of an option from where the team is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remaining {
    /// D_o, m. Infinite where there is no way.
    pub length: f64,
    /// S_o = 1 - prod (1 - S_xi) over the openings ahead (Sec. III-A).
    pub risk: f64,
    /// What the team walks toward next.
    pub next: Waypoint,
}

/// The next thing on an option's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Waypoint {
    /// An opening, walked in one direction.
    Opening(Crossing),
    /// The target.
    Target,
}

impl OptionSet {
    /// The options that the world lists, or else the cheapest by D_o + c_r S_o (eq. 1) up to the world's limit, with `risk_weight` c_r (m).
    ///
    /// # Errors
    /// [`OptionError`]: the target cannot be reached, or a listed option cannot be walked.
    pub fn new(world: &World, risk_weight: f64) -> Result<Self, OptionError> {
        let clearance = world.robot_width / 2.0;
        let closed = world.exactly_closed_gaps();
        let barriers = world.openings.iter().map(|o| o.ends).chain(closed).collect();
        let space = Space::new(world.obstacles.iter().map(|o| o.footprint.clone()), barriers, clearance);
        let passages = passages(world, &space);
        let portals = passages.iter().flat_map(|p| [p.portal(0), p.portal(1)]);
        let sites: Vec<Point> = [world.start, world.target].into_iter().chain(portals).collect();
        let roadmap = Roadmap::new(space, &sites);
        let mut set = Self {
            roadmap,
            passages,
            options: Vec::new(),
            is_cut: false,
            start: world.start,
            target: world.target,
        };
        if world.listed_options.is_empty() {
            let found = enumerate::cheapest(&set, world.option_limit, risk_weight);
            set.is_cut = found.is_cut;
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
            set.options = world
                .listed_options
                .iter()
                .map(|listed| {
                    let crossings = set.directed(world, listed)?;
                    Ok(set.option(listed.name.clone(), crossings))
                })
                .collect::<Result<_, _>>()?;
        }
        Ok(set)
    }

    /// The options, in file order or cheapest first. Never empty.
    pub fn options(&self) -> &[PathOption] {
        &self.options
    }

    /// Whether an option goes through an opening (an index into the world's).
    pub fn uses(&self, opening: usize) -> bool {
        self.options.iter().flat_map(|o| &o.crossings).any(|c| c.opening == opening)
    }

    /// Whether the two sides of an opening (an index into the world's) are one region: there is a way around it through no other opening, so
    /// that enumerated options, which enter no region twice, do not go through it.
    pub fn leads_nowhere_new(&self, opening: usize) -> bool {
        let crossing = Crossing { opening, into: 0 };
        self.region_before(crossing) == self.region_after(crossing)
    }

    /// Where the target lies.
    pub fn target(&self) -> Point {
        self.target
    }

    /// Whether a straight step from one point to another goes through an opening.
    pub fn goes_through_opening(&self, from: Point, to: Point) -> bool {
        self.roadmap.crosses_barrier(from, to)
    }

    /// The crossing that a straight step from one point to another makes; of several, that of the first opening.
    pub fn crossing(&self, from: Point, to: Point) -> Option<Crossing> {
        let crossed =
            |(opening, p): (usize, &Passage)| p.crossed(from, to).map(|(_, into)| Crossing { opening, into });
        self.passages.iter().enumerate().find_map(crossed)
    }

    /// The team at the start, with every option ahead of it.
    pub fn begin(&self) -> Progress {
        Progress::new(self.start, self.options.len())
    }

    /// Whether this is the progress of a team on these options: one that was read from a file may not be.
    pub fn knows(&self, progress: &Progress) -> bool {
        progress.is_among(&self.passages, &self.options)
    }

    /// Moves the team in a straight step to `to`, and keeps book of the openings that it goes through.
    pub fn advance(&self, progress: &mut Progress, to: Point) {
        progress.advance(to, &self.passages, &self.options, |c| self.region_after(c));
    }

    /// D_o, S_o and the next waypoint of an option (as an index) from where the team is.
    ///
    /// An opening is behind the team once the team is out of its straight part; until then the way goes on to the end of that part, at the
    /// opening's risk.
    pub fn remaining(&self, progress: &Progress, option: usize) -> Remaining {
        let next = self.next(progress, option);
        let position = progress.position;
        if let Some(crossing) = progress.inside {
            let rest = &progress.rests_outside[option];
            let exit = self.passages[crossing.opening].portal(crossing.into);
            let onward = self.length_after(crossing, rest, option);
            let risk = self.risk_with(self.risk(rest, option), crossing);
            return Remaining { length: (exit - position).norm() + onward, risk, next };
        }
        let rest = &progress.rests[option];
        let length = match next {
            Waypoint::Target => self.roadmap.distance(position, TARGET),
            Waypoint::Opening(crossing) => self.through(progress, crossing) + self.beyond(rest, option),
        };
        Remaining { length, risk: self.risk(rest, option), next }
    }

    /// What an option leads to next from where the team is. It depends on what is ahead only, not on the openings that the option lists behind
    /// the team: between a gap and the end of its straight part that is the opening under way, or the way back through it.
    pub fn next(&self, progress: &Progress, option: usize) -> Waypoint {
        let rests = if progress.inside.is_some() { &progress.rests_outside } else { &progress.rests };
        let ahead = rests[option].ahead(&self.options[option]).next();
        match progress.inside {
            Some(crossing) if ahead != Some(crossing.back()) => Waypoint::Opening(crossing),
            _ => ahead.map_or(Waypoint::Target, Waypoint::Opening),
        }
    }

    /// The path that is left of an option from where the team is; its length is [`Remaining::length`]. `None` where there is no way.
    pub fn path(&self, progress: &Progress, option: usize) -> Option<Path> {
        let mut path = Path::default();
        self.write_path(progress, option, &mut path).then_some(path)
    }

    /// [`OptionSet::path`] into a path that is there already, without allocating once it is long enough. False, with the path cut short, where
    /// there is no way.
    pub fn write_path(&self, progress: &Progress, option: usize, path: &mut Path) -> bool {
        path.clear();
        let mut at = progress.position;
        let mut rests = &progress.rests;
        if let Some(crossing) = progress.inside {
            let exit = self.passages[crossing.opening].portal(crossing.into);
            path.line(at, exit);
            at = exit;
            rests = &progress.rests_outside;
        }
        for crossing in rests[option].ahead(&self.options[option]) {
            let passage = &self.passages[crossing.opening];
            if at == progress.position && progress.aligned.contains(&crossing) {
                let foot = passage.foot(at, 1 - crossing.into);
                path.line(at, foot);
                at = foot;
            } else if !self.lead(path, &mut at, portal_site(crossing.opening, 1 - crossing.into)) {
                return false;
            }
            path.line(at, passage.center);
            path.line(passage.center, passage.portal(crossing.into));
            at = passage.portal(crossing.into);
        }
        self.lead(path, &mut at, TARGET)
    }

    fn lead(&self, path: &mut Path, at: &mut Point, site: usize) -> bool {
        let found = self.roadmap.extend(path, *at, site);
        *at = self.roadmap.point(site);
        found
    }

    /// Length from where the team is to the end of the passage of `next`.
    fn through(&self, progress: &Progress, next: Crossing) -> f64 {
        let (passage, position) = (&self.passages[next.opening], progress.position);
        if progress.aligned.contains(&next) {
            let foot = passage.foot(position, 1 - next.into);
            (foot - position).norm() + (passage.center - foot).norm() + passage.reach[next.into]
        } else {
            self.roadmap.distance(position, portal_site(next.opening, 1 - next.into)) + self.straight(next)
        }
    }

    /// Length from the end of a passage to the target.
    fn length_after(&self, crossing: Crossing, rest: &Rest, option: usize) -> f64 {
        let next = rest.ahead(&self.options[option]).next();
        self.after(crossing, next.map(|next| (next, self.beyond(rest, option))))
    }

    /// Length from the end of the first passage ahead to the target. Summed from the target's end, so that options that are one way from here on
    /// have equal bits, however they came there.
    fn beyond(&self, rest: &Rest, option: usize) -> f64 {
        let option = &self.options[option];
        let onward = option.crossings.get(rest.place).map(|&next| (next, option.after[rest.place]));
        let whole =
            rest.back.iter().fold(onward, |onward, &crossing| Some((crossing, self.after(crossing, onward))));
        whole.map_or(0.0, |(_, length)| length)
    }

    /// Length from the end of a passage to the target, by the next passage, if there is one, and the length from its end.
    fn after(&self, crossing: Crossing, onward: Option<(Crossing, f64)>) -> f64 {
        match onward {
            Some((next, after)) => self.leg(crossing, next) + self.straight(next) + after,
            None => self.roadmap.between(portal_site(crossing.opening, crossing.into), TARGET),
        }
    }

    fn risk(&self, rest: &Rest, option: usize) -> f64 {
        let ahead = self.options[option].risk_left[rest.place];
        rest.back.iter().fold(ahead, |risk, &crossing| self.risk_with(risk, crossing))
    }

    fn risk_with(&self, risk: f64, crossing: Crossing) -> f64 {
        1.0 - (1.0 - risk) * (1.0 - self.passages[crossing.opening].risk)
    }

    /// Length between two passages: from the end of one to the beginning of the next.
    fn leg(&self, from: Crossing, to: Crossing) -> f64 {
        self.roadmap.between(portal_site(from.opening, from.into), portal_site(to.opening, 1 - to.into))
    }

    fn straight(&self, crossing: Crossing) -> f64 {
        let reach = self.passages[crossing.opening].reach;
        reach[0] + reach[1]
    }

    fn region_before(&self, crossing: Crossing) -> usize {
        self.region_after(crossing.back())
    }

    fn region_after(&self, crossing: Crossing) -> usize {
        self.roadmap.component(portal_site(crossing.opening, crossing.into))
    }

    fn option(&self, name: String, crossings: Vec<Crossing>) -> PathOption {
        let start = self.roadmap.component(START);
        let regions = [start].into_iter().chain(crossings.iter().map(|&c| self.region_after(c))).collect();
        let n = crossings.len();
        let mut after = vec![0.0; n];
        let mut risk_left = vec![0.0; n + 1];
        for i in (0..n).rev() {
            after[i] = self.after(crossings[i], crossings.get(i + 1).map(|&next| (next, after[i + 1])));
            risk_left[i] = self.risk_with(risk_left[i + 1], crossings[i]);
        }
        PathOption { name, crossings, regions, after, risk_left }
    }

    /// The direction of every crossing of a listed option: of the directions that can be walked, those that make it shortest.
    fn directed(&self, world: &World, listed: &ListedOption) -> Result<Vec<Crossing>, OptionError> {
        // for either direction of the last crossing: length so far and the crossings that lead there
        let mut ways: Vec<(f64, Vec<Crossing>)> = vec![(0.0, Vec::new())];
        let leave = |way: &[Crossing]| way.last().map_or(START, |c| portal_site(c.opening, c.into));
        let not_walkable = |i: usize, to: String| OptionError::NotWalkable {
            file: world.file.clone(),
            line: listed.line,
            option: listed.name.clone(),
            from: match i.checked_sub(1) {
                None => "the start".to_owned(),
                Some(before) => format!("opening `{}`", world.openings[listed.openings[before]].name),
            },
            to,
            clearance: world.robot_width / 2.0,
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
                            let leg = self.roadmap.between(leave(&way), portal_site(opening, 1 - into));
                            way.push(crossing);
                            (length + leg + self.straight(crossing), way)
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
            .map(|(length, way)| (length + self.roadmap.between(leave(&way), TARGET), way))
            .collect();
        shortest(arrived)
            .map(|(_, way)| way)
            .ok_or_else(|| not_walkable(listed.openings.len(), "the target".to_owned()))
    }
}

fn passages(world: &World, space: &Space) -> Vec<Passage> {
    world
        .openings
        .iter()
        .enumerate()
        .map(|(i, opening)| {
            let others: Vec<[Point; 2]> =
                world.openings.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, o)| o.ends).collect();
            Passage::new(opening, &others, space, world.robot_width, ALIGNMENT)
        })
        .collect()
}

fn unreachable(world: &World) -> OptionError {
    let reason = match world.impassable_gaps().into_iter().next() {
        None => Blockage::Walled,
        Some(gap) => Blockage::Gap {
            first: world.obstacles[gap.between[0]].name.clone(),
            second: world.obstacles[gap.between[1]].name.clone(),
            width: gap.width,
            robot_width: world.robot_width,
        },
    };
    OptionError::Unreachable {
        file: world.file.clone(),
        sx: world.start.x,
        sy: world.start.y,
        tx: world.target.x,
        ty: world.target.y,
        reason,
    }
}

//! The paths from every gap to every next one, and how far they follow the straight part beyond the first.
//!
//! The straight parts of two consecutive openings may overlap. A path that followed both would overshoot the
//! second and double back. Instead it leaves the first as far out as the largest turn there allows
//! ([`MAX_BACKWARD`]), and joins the second likewise.

use super::passage::Crossing;
use super::path_option::{After, Afters};
use super::roadmap::{MAX_BACKWARD, Roadmap};
use super::sites::{MAX_LANES, START, Sites, TARGET};

/// Number of bisections in the search for where a path may leave a straight part.
const HALVINGS: u32 = 48;
/// Straight parts face each other if the cosine of the angle between their directions is below this.
const FACING_COSINE: f64 = -0.5;
/// Straight parts whose connection is shorter than this (m) cross each other.
const CROSSING_LENGTH_M: f64 = 1e-6;

/// The path from one gap to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    /// Length along the first axis, from the gap to where the path leaves it, m.
    exit: f64,
    /// Length between the two axes, m; infinite where there is no path.
    between: f64,
    /// Length along the second axis, from where the path joins it to the gap, m.
    entry: f64,
}

impl Stage {
    const NONE: Self = Self { exit: 0.0, between: f64::INFINITY, entry: 0.0 };

    /// From gap to gap, m.
    pub fn length(&self) -> f64 {
        self.exit + self.between + self.entry
    }
}

/// Paths between sites, tabulated for those that options use. A path from a straight part begins at its gap.
#[derive(Clone, Debug, Default)]
pub(super) struct Stages {
    /// From every site: the sites that paths lead to, ascending, and these paths.
    rows: Vec<Vec<(usize, Stage)>>,
}

impl Stages {
    /// Adds the paths from each of `from` to all sites of `to` to the table: the lanes of one crossing. They
    /// leave a straight part at the same point, so that a team that has left it for one lane has left it for
    /// all.
    pub fn tabulate(&mut self, roadmap: &Roadmap, from: &[usize], to: &[usize]) {
        for &from in from {
            if self.rows.len() <= from {
                self.rows.resize(from + 1, Vec::new());
            }
            let row = &mut self.rows[from];
            let is_known = |to: &usize| row.binary_search_by_key(to, |(to, _)| *to).is_ok();
            if to.iter().all(is_known) {
                continue;
            }
            let stages: Vec<Stage> = to.iter().map(|&to| stage(roadmap, from, to)).collect();
            let exits = stages.iter().filter(|stage| stage.between.is_finite()).map(|stage| stage.exit);
            let common = exits.fold(f64::INFINITY, f64::min);
            for (&to, mut stage) in to.iter().zip(stages) {
                if stage.between.is_finite() && stage.exit > common {
                    let leg = roadmap.leg(roadmap.straight(from).at(common), to);
                    stage = Stage { exit: common, between: leg.length, entry: leg.depth };
                }
                if let Err(place) = row.binary_search_by_key(&to, |(to, _)| *to) {
                    row.insert(place, (to, stage));
                }
            }
        }
    }

    /// The path from one site to another.
    pub fn between(&self, roadmap: &Roadmap, from: usize, to: usize) -> Stage {
        let row = self.rows.get(from).map_or(&[][..], Vec::as_slice);
        match row.binary_search_by_key(&to, |(to, _)| *to) {
            Ok(place) => row[place].1,
            Err(_) => stage(roadmap, from, to),
        }
    }

    /// The remainder of an option from the gap at `from` on. `next` is the next crossing with the remainders
    /// from its gap on; `None` if the target comes next. Of the next gap's lanes it takes the shortest way.
    pub fn after(
        &self,
        roadmap: &Roadmap,
        sites: &Sites,
        from: usize,
        next: Option<(Crossing, Afters)>,
    ) -> After {
        let Some((crossing, afters)) = next else {
            let stage = self.between(roadmap, from, TARGET);
            return After { exit: stage.exit, length: stage.between, lane: 0 };
        };
        let through = |lane: usize| {
            let stage = self.between(roadmap, from, sites.before(crossing, lane));
            let after = afters[lane];
            let length = stage.between + (stage.entry + after.exit) + after.length;
            After { exit: stage.exit, length, lane }
        };
        let total = |after: &After| after.exit + after.length;
        let lanes = (0..sites.lanes(crossing.opening)).map(through);
        lanes.min_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or(After::NONE)
    }

    /// [`Stages::after`] from every lane of a crossing.
    pub fn afters(
        &self,
        roadmap: &Roadmap,
        sites: &Sites,
        crossing: Crossing,
        next: Option<(Crossing, Afters)>,
    ) -> Afters {
        let mut afters = [After::NONE; MAX_LANES];
        for (lane, after) in afters.iter_mut().enumerate().take(sites.lanes(crossing.opening)) {
            *after = self.after(roadmap, sites, sites.beyond(crossing, lane), next);
        }
        afters
    }
}

fn stage(roadmap: &Roadmap, from: usize, to: usize) -> Stage {
    if from == TARGET || to == START {
        return Stage::NONE;
    }
    let [first, second] = [from, to].map(|site| roadmap.straight(site));
    let leg = roadmap.between(from, to);
    if leg.length.is_infinite() {
        return Stage::NONE;
    }
    let whole = Stage { exit: first.reach, between: leg.length, entry: leg.depth };
    // a path back through the same opening turns round at the end of its straight part
    if from == to || from == START {
        return whole;
    }
    let turn = |exit: f64| roadmap.departure(first.at(exit), to).map(|along| first.outward.dot(&along));
    let is_forward = |exit: f64| turn(exit).is_none_or(|cos| cos >= -MAX_BACKWARD);
    let facing = first.outward.dot(&second.outward) < FACING_COSINE;
    let apart = first.depth(second.center);
    let is_shortened = leg.depth < second.reach;
    let most = if facing && is_shortened && apart > 0.0 {
        // overlapping parts get half of the distance, or what the other leaves of it
        first.reach.min((apart / 2.0).max(apart - second.reach))
    } else {
        first.reach
    };
    if most == first.reach && is_forward(most) {
        return whole;
    }
    let mut exit = most;
    if !is_forward(exit) {
        let (mut near, mut far) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = (near + far) / 2.0;
            *(if is_forward(middle) { &mut near } else { &mut far }) = middle;
        }
        exit = near;
    }
    let mut leg = roadmap.leg(first.at(exit), to);
    if leg.length < CROSSING_LENGTH_M && -first.outward.dot(&second.outward) < -MAX_BACKWARD {
        // where the two cross at so sharp an angle, the path cuts the corner and turns partly on either side
        exit -= exit.min(leg.depth) / 2.0;
        leg = roadmap.leg(first.at(exit), to);
    }
    Stage { exit, between: leg.length, entry: leg.depth }
}

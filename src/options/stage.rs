//! The path from every gap to every next one, and how far it follows the straight part beyond the first.
//!
//! The straight parts of two consecutive openings may pass each other. A path would overshoot the second and double back. It leaves the
//! first as far out as it can without turning by more than it may there ([`MOST_BACKWARD`]), and joins the second likewise.

use super::roadmap::{MOST_BACKWARD, Roadmap, Straight};
use super::{After, Crossing, START, TARGET, before};

/// Halvings in the search for where a path may leave a straight part.
const HALVINGS: u32 = 48;
/// Straight parts whose directions differ from opposite ones by less than acos of this face each other.
const FACING: f64 = -0.5;
/// Ways shorter than this (m) between two straight parts: they cross.
const CROSSING: f64 = 1e-6;

/// The way from one gap to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    /// Along the axis of the first to where it leaves it, m.
    exit: f64,
    /// Between the two axes, m; infinite where there is no way.
    between: f64,
    /// Along the axis of the second, from where it joins it to its gap, m.
    entry: f64,
}

impl Stage {
    const NONE: Self = Self { exit: 0.0, between: f64::INFINITY, entry: 0.0 };

    /// From gap to gap, m.
    pub fn length(&self) -> f64 {
        self.exit + self.between + self.entry
    }
}

/// The way from every site to every other; from a straight part it begins at the gap.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    stages: Vec<Stage>,
    sites: usize,
}

impl Stages {
    /// The stages between sites of this roadmap.
    pub fn new(sites: &[Straight], roadmap: &Roadmap) -> Self {
        let n = sites.len();
        let stage = |i: usize| stage(sites, roadmap, i / n, i % n);
        Self { stages: (0..n * n).map(stage).collect(), sites: n }
    }

    /// The way from one site to another.
    pub fn between(&self, from: usize, to: usize) -> Stage {
        self.stages[from * self.sites + to]
    }

    /// How far (m) beyond a gap the way to the next crossing, or to the target, leaves the axis.
    pub fn exit(&self, from: usize, next: Option<Crossing>) -> f64 {
        self.between(from, next.map_or(TARGET, before)).exit
    }

    /// What is left from the gap at `from` on, where the next crossing and what is left from its gap on are `next`, or the target is.
    pub fn after(&self, from: usize, next: Option<(Crossing, After)>) -> After {
        match next {
            None => {
                let stage = self.between(from, TARGET);
                After { exit: stage.exit, length: stage.between }
            }
            Some((crossing, after)) => {
                let stage = self.between(from, before(crossing));
                After { exit: stage.exit, length: stage.between + (stage.entry + after.exit) + after.length }
            }
        }
    }
}

fn stage(sites: &[Straight], roadmap: &Roadmap, from: usize, to: usize) -> Stage {
    let (first, second) = (&sites[from], &sites[to]);
    let leg = roadmap.between(from, to);
    if leg.length.is_infinite() || from == TARGET || to == START {
        return Stage::NONE;
    }
    let whole = Stage { exit: first.reach, between: leg.length, entry: leg.depth };
    // whoever goes back through the same opening turns round at the end of its straight part
    if from == to || from == START {
        return whole;
    }
    let turn = |exit: f64| roadmap.departure(first.at(exit), to).map(|along| first.outward.dot(&along));
    let is_forward = |exit: f64| turn(exit).is_none_or(|cos| cos >= -MOST_BACKWARD);
    let facing = first.outward.dot(&second.outward) < FACING;
    let apart = first.depth(second.center);
    let is_shortened = leg.depth < second.reach;
    let most = if facing && is_shortened && apart > 0.0 {
        // parts that pass each other get half of the way, or what the other leaves of it
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
    if leg.length < CROSSING && -first.outward.dot(&second.outward) < -MOST_BACKWARD {
        // where the two cross at so sharp an angle, the path cuts the corner, and turns by a part of it on either side
        exit -= exit.min(leg.depth) / 2.0;
        leg = roadmap.leg(first.at(exit), to);
    }
    Stage { exit, between: leg.length, entry: leg.depth }
}

//! The density of the belief relative to the prior, as a step function over the plane of (alpha, gamma).
//!
//! At every gamma the density is constant between borders. It is kept as its jumps: each segment of a border
//! has the value below it and the step to the value above it. The product with another such function follows
//! from pairs of segments: a step of one is multiplied by the value of the other at its place. Every pair is
//! compared once, so rounding at a crossing changes the two products consistently.

use super::line::Line;
use crate::preference::rule::Rule;
use crate::preference::strips::{Domain, Outline};
use serde::{Deserialize, Serialize};

/// Steps below this are dropped; the density has mean 1. A thousand of them change a probability by 1e-8 at
/// most, and by 1e-6 after the belief has turned against a change rate of 1e-3.
const LEAST_STEP: f64 = 1e-11;

/// The most steps that are kept; beyond it the least ones are dropped.
const MOST_STEPS: usize = 2048;

/// Parts of segments shorter than this in gamma are dropped.
const SHORTEST: f64 = 2e-11;

/// A part of a border, with the density's values on both sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Segment {
    pub line: u32,
    pub from: f64,
    pub to: f64,
    /// The density just below the border.
    pub below: f64,
    /// The density just above it, minus that below it.
    pub step: f64,
}

/// The density, and the memory to update it.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    /// The first line is the least alpha, over the whole range of gamma.
    pub lines: Vec<Line>,
    /// Segments of the first line fill the range of gamma and come first, in order.
    pub segments: Vec<Segment>,
    pieces: Vec<Piece>,
    next: Vec<Segment>,
    events: Vec<(f64, f64)>,
    crossings: Vec<(u32, f64, f64)>,
    places: Vec<u32>,
}

/// A border of the function that the density is multiplied by.
#[derive(Debug, Clone, Copy)]
struct Piece {
    line: Line,
    from: f64,
    to: f64,
    below: f64,
    step: f64,
    /// Whether it is the least alpha, below which there is nothing.
    is_base: bool,
}

impl Plane {
    /// The prior: a density of 1.
    pub fn new(rule: &Rule, domain: &Domain) -> Self {
        let [from, to] = [domain.gamma.lower(), domain.gamma.upper()];
        let mut plane = Self {
            lines: Vec::with_capacity(MOST_STEPS),
            segments: Vec::with_capacity(MOST_STEPS),
            pieces: Vec::with_capacity(64),
            next: Vec::with_capacity(2 * MOST_STEPS),
            events: Vec::with_capacity(256),
            crossings: Vec::with_capacity(4 * MOST_STEPS),
            places: Vec::with_capacity(MOST_STEPS),
        };
        plane.lines.push(Line::constant(rule, [from, to], domain.alpha.lower(), domain));
        plane.segments.push(Segment { line: 0, from, to, below: 0.0, step: 1.0 });
        plane
    }

    /// Mixes the density with the prior: `rate` times 1, plus the rest times the density.
    pub fn mix(&mut self, rate: f64) {
        for segment in &mut self.segments {
            segment.step *= 1.0 - rate;
            if segment.line == 0 {
                segment.step += rate;
            } else {
                segment.below = (1.0 - rate) * segment.below + rate;
            }
        }
    }

    /// Multiplies the density by a factor for every region of `outline`, and divides it by its integral, which
    /// is returned. `None`, and no change, if the integral is not a positive number.
    pub fn multiply(
        &mut self,
        outline: &Outline,
        factors: &[f64],
        rule: &Rule,
        domain: &Domain,
    ) -> Option<f64> {
        self.set_pieces(outline, factors, rule);
        self.next.clear();
        self.crossings.clear();
        for segment in &self.segments {
            let line = &self.lines[segment.line as usize];
            self.events.clear();
            for (index, piece) in self.pieces.iter().enumerate() {
                let (from, to) = (piece.from.max(segment.from), piece.to.min(segment.to));
                if from >= to {
                    continue;
                }
                for (from, to, is_below) in line.sides(&piece.line, from, to).parts() {
                    if is_below {
                        self.events.extend([(from, piece.step), (to, -piece.step)]);
                    } else if !piece.is_base {
                        let index = index as u32;
                        self.crossings.extend([(index, from, segment.step), (index, to, -segment.step)]);
                    }
                }
            }
            self.events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let whole = (segment.from, segment.to);
            sweep(whole, self.events.iter().copied(), |from, to, factor| {
                let (below, step) = (segment.below * factor, segment.step * factor);
                push(&mut self.next, Segment { line: segment.line, from, to, below, step });
            });
        }
        self.crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut rest = self.crossings.as_slice();
        for (index, piece) in self.pieces.iter().enumerate().filter(|(_, piece)| !piece.is_base) {
            rest = &rest[rest.partition_point(|event| (event.0 as usize) < index)..];
            let own = &rest[..rest.partition_point(|event| event.0 as usize == index)];
            let line = self.lines.len() as u32;
            self.lines.push(piece.line);
            sweep((piece.from, piece.to), own.iter().map(|event| (event.1, event.2)), |from, to, density| {
                let (below, step) = (density * piece.below, density * piece.step);
                push(&mut self.next, Segment { line, from, to, below, step });
            });
        }
        let total: f64 = self.next.iter().map(|segment| self.lines.above(segment, domain)).sum();
        let is_possible = total > 1e-250 && total.is_finite();
        if is_possible {
            std::mem::swap(&mut self.segments, &mut self.next);
            for segment in &mut self.segments {
                segment.below /= total;
                segment.step /= total;
            }
            self.drop_least();
        }
        self.drop_unused_lines();
        is_possible.then_some(total)
    }

    /// The borders of the regions whose factors differ, and the least alpha.
    fn set_pieces(&mut self, outline: &Outline, factors: &[f64], rule: &Rule) {
        let base = self.lines[0];
        self.pieces.clear();
        for extent in outline.extents.iter().filter(|extent| extent.range == 0) {
            let [from, to] = extent.gamma;
            let step = factors[extent.options[0]];
            self.pieces.push(Piece { line: base, from, to, below: 0.0, step, is_base: true });
        }
        for border in &outline.borders {
            let [below, above] = border.options.map(|option| factors[option]);
            if below != above {
                let [from, to] = border.gamma;
                let line = Line::of(border, rule);
                self.pieces.push(Piece { line, from, to, below, step: above - below, is_base: false });
            }
        }
    }

    fn drop_least(&mut self) {
        let mut least = LEAST_STEP;
        self.segments.retain(|segment| segment.line == 0 || segment.step.abs() > least);
        while self.segments.len() > MOST_STEPS && least < 1e-6 {
            least *= 10.0;
            self.segments.retain(|segment| segment.line == 0 || segment.step.abs() > least);
        }
    }

    fn drop_unused_lines(&mut self) {
        self.places.clear();
        self.places.resize(self.lines.len(), u32::MAX);
        self.places[0] = 0;
        for segment in &self.segments {
            self.places[segment.line as usize] = 0;
        }
        let mut kept = 0;
        for line in 0..self.lines.len() {
            if self.places[line] != u32::MAX {
                self.lines[kept] = self.lines[line];
                self.places[line] = kept as u32;
                kept += 1;
            }
        }
        self.lines.truncate(kept);
        for segment in &mut self.segments {
            segment.line = self.places[segment.line as usize];
        }
    }

    /// Probability between two gammas and below a line. `line_mass` is the prior's between two gammas.
    pub fn mass_below(&self, line: &Line, line_mass: impl Fn(f64, f64) -> f64, [from, to]: [f64; 2]) -> f64 {
        let mut mass = 0.0;
        for segment in &self.segments {
            let own = &self.lines[segment.line as usize];
            let (from, to) = (from.max(segment.from), to.min(segment.to));
            if from >= to {
                continue;
            }
            for (from, to, is_below) in own.sides(line, from, to).parts() {
                if !is_below {
                    mass += segment.step * (line_mass(from, to) - own.mass(from, to));
                }
            }
        }
        mass
    }

    /// Probability between two gammas.
    pub fn mass_between(&self, from: f64, to: f64, domain: &Domain) -> f64 {
        let part = |segment: &Segment| {
            let (from, to) = (from.max(segment.from), to.min(segment.to));
            if from < to { self.lines.above(&Segment { from, to, ..*segment }, domain) } else { 0.0 }
        };
        self.segments.iter().map(part).sum()
    }

    /// The density at a point of the plane.
    pub fn density(&self, alpha: f64, gamma: f64) -> f64 {
        let is_below = |segment: &&Segment| {
            let is_last = segment.to == self.last_gamma();
            let has = segment.from <= gamma && (gamma < segment.to || is_last && gamma == segment.to);
            has && self.lines[segment.line as usize].alpha(gamma) <= alpha
        };
        self.segments.iter().filter(is_below).map(|segment| segment.step).sum::<f64>().max(0.0)
    }

    /// The density at one gamma: every alpha at which it steps, ascending, and the step. The first alpha is
    /// the least one.
    pub fn steps_at(&self, gamma: f64) -> Vec<(f64, f64)> {
        let last = self.last_gamma();
        let has = |s: &&Segment| s.from <= gamma && (gamma < s.to || s.to == last && gamma == last);
        let step = |s: &Segment| (self.lines[s.line as usize].alpha(gamma), s.step);
        let mut steps: Vec<(f64, f64)> = self.segments.iter().filter(has).map(step).collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        steps
    }

    fn last_gamma(&self) -> f64 {
        self.segments.iter().map(|segment| segment.to).fold(0.0, f64::max)
    }

    /// The prior's probability of all places with `function(density) = 1`, weighted: the integral of a function
    /// of the density over the prior.
    pub fn integral_of(&self, domain: &Domain, function: impl Fn(f64) -> f64) -> f64 {
        let of = |segment: &Segment| {
            let above = function((segment.below + segment.step).max(0.0));
            // below the least alpha there is nothing
            let below = if segment.line == 0 { 0.0 } else { function(segment.below.max(0.0)) };
            self.lines.above(&Segment { step: above - below, ..*segment }, domain)
        };
        self.segments.iter().map(of).sum()
    }
}

trait Above {
    /// The integral of a segment's step over the prior above it.
    fn above(&self, segment: &Segment, domain: &Domain) -> f64;
}

impl Above for Vec<Line> {
    fn above(&self, segment: &Segment, domain: &Domain) -> f64 {
        let Segment { line, from, to, step, .. } = *segment;
        let strip = domain.gamma.cdf(to) - domain.gamma.cdf(from);
        step * (strip - self[line as usize].mass(from, to))
    }
}

/// Calls `part` for every part of a range on which the sum of the events up to it is constant.
fn sweep(
    (from, to): (f64, f64),
    events: impl Iterator<Item = (f64, f64)>,
    mut part: impl FnMut(f64, f64, f64),
) {
    let (mut start, mut value) = (from, 0.0);
    for (at, change) in events {
        if at > start + SHORTEST {
            part(start, at.min(to), value);
            start = at;
        }
        value += change;
    }
    if to > start + SHORTEST {
        part(start, to, value);
    }
}

/// Adds a segment, or makes the last one longer if nothing changes between them.
fn push(segments: &mut Vec<Segment>, segment: Segment) {
    if segment.step == 0.0 && segment.line != 0 {
        return;
    }
    let is_near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs().max(b.abs());
    match segments.last_mut() {
        Some(last)
            if last.line == segment.line
                && last.to == segment.from
                && is_near(last.step, segment.step)
                && is_near(last.below, segment.below) =>
        {
            last.to = segment.to;
        }
        _ => segments.push(segment),
    }
}

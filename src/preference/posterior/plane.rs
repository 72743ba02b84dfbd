//! The density of the belief relative to the prior, as a step function over the plane of (alpha, gamma).
//!
//! At every gamma the density is constant between borders. It is kept as its jumps: each segment of a border
//! has the value below it and the step to the value above it. The product with another such function follows
//! from pairs of segments: a step of one is multiplied by the value of the other at its place. Every pair is
//! compared once, so rounding at a crossing changes the two products consistently.

use super::line::{GammaLine, Sides};
use crate::preference::rule::Rule;
use crate::preference::strips::{Domain, Outline};
use serde::{Deserialize, Serialize};

/// Steps that change no probability by more than this are dropped, and steps along a line that differ by no
/// more are joined. Together, dropping and joining change a probability by about 1e-9, and by 1e-6 after the
/// belief has turned against a change rate of 1e-3.
const MIN_MASS: f64 = 1e-12;

/// The largest change of the density at a place by dropping or joining.
const MIN_STEP: f64 = 1e-9;

/// Densities that differ by less than this part of them belong to one place, seen from its borders.
pub(super) const SAME: f64 = 1e-6;

/// The most steps that are kept; beyond it the least ones are dropped.
const MAX_STEPS: usize = 2048;

/// Parts of segments shorter than this in gamma are dropped.
const MIN_PIECE: f64 = 2e-11;

/// A part of a border, with the density's values on both sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Segment {
    /// Index of the border's line.
    pub line: u32,
    /// Its least gamma.
    pub from: f64,
    /// Its largest gamma.
    pub to: f64,
    /// The density just below the border.
    pub below: f64,
    /// The density just above it, minus that below it.
    pub step: f64,
    /// The prior's probability of its range of gamma above the border.
    #[serde(skip)]
    pub above: f64,
    /// The prior's probability of its range of gamma below the border.
    #[serde(skip)]
    pub under: f64,
}

impl Segment {
    /// The part of this segment between two gammas.
    fn part(&self, from: f64, to: f64, line: &GammaLine, domain: &Domain) -> Self {
        if (from, to) == (self.from, self.to) {
            *self
        } else {
            Self { from, to, ..*self }.weighed(line, domain)
        }
    }

    /// The probability of its range of gamma.
    fn gammas(&self) -> f64 {
        self.above + self.under
    }

    /// One segment in place of this one and the next on the line, if that changes no probability by more than
    /// `least`.
    fn joined(&self, next: &Self, least: f64, line: &GammaLine, domain: &Domain) -> Option<Self> {
        let change = (self.step - next.step).abs() + (self.below - next.below).abs();
        let [first, second] = [self.gammas(), next.gammas()];
        let is_near =
            self.line == next.line && self.to == next.from && is_least(change, first.min(second), least);
        let share = second / (first + second);
        let mean = |a: f64, b: f64| a + share * (b - a);
        let (step, below) = (mean(self.step, next.step), mean(self.below, next.below));
        is_near.then(|| Self { step, below, ..self.part(self.from, next.to, line, domain) })
    }

    /// The segment with its probabilities.
    pub fn weighed(self, line: &GammaLine, domain: &Domain) -> Self {
        let under = line.mass(self.from, self.to);
        Self { above: domain.gamma.cdf(self.to) - domain.gamma.cdf(self.from) - under, under, ..self }
    }
}

/// The density, and the memory to update it.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    /// The first line is the least alpha, over the whole range of gamma.
    pub lines: Vec<GammaLine>,
    /// Segments of the first line fill the range of gamma and come first, in order.
    pub segments: Vec<Segment>,
    pieces: Vec<Piece>,
    /// The segments of a product while it is formed.
    next: Vec<Segment>,
    /// Along one line: gamma, and the change there of the factor on the line.
    events: Vec<(f64, f64)>,
    /// Along the pieces: index of the piece, gamma, and the change there of the density on the piece.
    crossings: Vec<(u32, f64, f64)>,
    /// The new index of every line while unused ones are dropped.
    places: Vec<u32>,
}

/// A border of the function that the density is multiplied by.
#[derive(Debug, Clone, Copy)]
struct Piece {
    line: GammaLine,
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
            lines: Vec::with_capacity(MAX_STEPS),
            segments: Vec::with_capacity(MAX_STEPS),
            pieces: Vec::with_capacity(64),
            next: Vec::with_capacity(2 * MAX_STEPS),
            events: Vec::with_capacity(256),
            crossings: Vec::with_capacity(4 * MAX_STEPS),
            places: Vec::with_capacity(MAX_STEPS),
        };
        plane.lines.push(GammaLine::constant(rule, [from, to], domain.alpha.lower(), domain));
        let whole = Segment { line: 0, from, to, below: 0.0, step: 1.0, above: 0.0, under: 0.0 };
        plane.segments.push(whole.weighed(&plane.lines[0], domain));
        plane
    }

    /// The segments of every line.
    pub fn by_line(&self) -> impl Iterator<Item = &[Segment]> {
        self.segments.chunk_by(|a, b| a.line == b.line)
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
        self.multiply_segments(factors, domain);
        self.add_borders(domain);
        let total: f64 = self.next.iter().map(|segment| segment.step * segment.above).sum();
        let is_possible = total > 1e-250 && total.is_finite();
        if is_possible {
            std::mem::swap(&mut self.segments, &mut self.next);
            for segment in &mut self.segments {
                segment.below /= total;
                segment.step /= total;
            }
            self.drop_least(domain);
        }
        self.drop_unused_lines();
        is_possible.then_some(total)
    }

    /// Puts the segments, each times the factor on its line, into `next`, and the changes of the density along
    /// the pieces into `crossings`.
    fn multiply_segments(&mut self, factors: &[f64], domain: &Domain) {
        self.crossings.clear();
        for run in self.segments.chunk_by(|a, b| a.line == b.line) {
            let line = &self.lines[run[0].line as usize];
            self.events.clear();
            for (index, piece) in self.pieces.iter().enumerate() {
                for (from, to, is_below) in overlap(run, line, &piece.line, [piece.from, piece.to]).parts() {
                    if is_below {
                        self.events.extend([(from, piece.step), (to, -piece.step)]);
                    } else if !piece.is_base {
                        let mut last = (from, 0.0);
                        for (segment, from, to) in clipped(run, from, to) {
                            if last.0 == from {
                                self.crossings.push((index as u32, from, segment.step - last.1));
                            } else {
                                self.crossings.push((index as u32, last.0, -last.1));
                                self.crossings.push((index as u32, from, segment.step));
                            }
                            last = (to, segment.step);
                        }
                        self.crossings.push((index as u32, last.0, -last.1));
                    }
                }
            }
            self.events.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let (mut events, mut sum) = (self.events.iter().peekable(), 0.0);
            for segment in run {
                let mut start = segment.from;
                let mut add = |from, to, sum: f64| {
                    // the sum of steps is the factor of a region, but for rounding
                    let near = |a: &f64, b: &f64| (a - sum).abs().total_cmp(&(b - sum).abs());
                    let factor = factors.iter().copied().min_by(near).unwrap_or(sum);
                    let (below, step) = (segment.below * factor, segment.step * factor);
                    let part = Segment { below, step, ..segment.part(from, to, line, domain) };
                    self.next.push(part);
                };
                while let Some((at, change)) = events.next_if(|(at, _)| *at < segment.to - MIN_PIECE) {
                    if *at > start + MIN_PIECE {
                        add(start, *at, sum);
                        start = *at;
                    }
                    sum += change;
                }
                add(start, segment.to, sum);
            }
        }
    }

    /// Puts the segments of the pieces, each times the density along it, into `next`.
    fn add_borders(&mut self, domain: &Domain) {
        self.crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut rest = self.crossings.as_slice();
        for (index, piece) in self.pieces.iter().enumerate().filter(|(_, piece)| !piece.is_base) {
            rest = &rest[rest.partition_point(|event| (event.0 as usize) < index)..];
            let own = &rest[..rest.partition_point(|event| event.0 as usize == index)];
            let line = self.lines.len() as u32;
            self.lines.push(piece.line);
            sweep((piece.from, piece.to), own.iter().map(|event| (event.1, event.2)), |from, to, density| {
                let (below, step) = (density * piece.below, density * piece.step);
                let part = Segment { line, from, to, below, step, above: 0.0, under: 0.0 };
                self.next.push(part.weighed(&piece.line, domain));
            });
        }
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
                let line = GammaLine::of(border, rule);
                self.pieces.push(Piece { line, from, to, below, step: above - below, is_base: false });
            }
        }
    }

    /// Drops and joins the least steps, of at most [`MIN_MASS`], or more where too many are left.
    fn drop_least(&mut self, domain: &Domain) {
        let mut least = MIN_MASS;
        loop {
            let mut kept = 0_usize;
            for index in 0..self.segments.len() {
                let segment = self.segments[index];
                if segment.line != 0 && is_least(segment.step.abs(), segment.gammas(), least) {
                    continue;
                }
                let line = &self.lines[segment.line as usize];
                let before = kept.checked_sub(1).map(|last| self.segments[last]);
                match before.and_then(|before| before.joined(&segment, least, line, domain)) {
                    Some(joined) => self.segments[kept - 1] = joined,
                    None => {
                        self.segments[kept] = segment;
                        kept += 1;
                    }
                }
            }
            self.segments.truncate(kept);
            if self.segments.len() <= MAX_STEPS || least > 1e-8 {
                return;
            }
            least *= 10.0;
        }
    }

    /// Drops lines without segments, except the first one.
    fn drop_unused_lines(&mut self) {
        self.places.clear();
        self.places.resize(self.lines.len(), u32::MAX);
        self.places[0] = 0;
        for segment in &self.segments {
            self.places[segment.line as usize] = 0;
        }
        let mut kept = 0_usize;
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

    /// Probability between two gammas and below a line. `line_mass` is the prior's up to a gamma.
    pub fn mass_below(&self, line: &GammaLine, line_mass: impl Fn(f64) -> f64, range: [f64; 2]) -> f64 {
        let mut mass = 0.0;
        for run in self.by_line() {
            let own = &self.lines[run[0].line as usize];
            for (from, to, is_below) in overlap(run, own, line, range).parts() {
                if is_below {
                    continue;
                }
                let mut last = (from, line_mass(from));
                for (segment, from, to) in clipped(run, from, to) {
                    let is_whole = (from, to) == (segment.from, segment.to);
                    let under = if is_whole { segment.under } else { own.mass(from, to) };
                    let start = if last.0 == from { last.1 } else { line_mass(from) };
                    last = (to, line_mass(to));
                    mass += segment.step * (last.1 - start - under);
                }
            }
        }
        mass
    }

    /// Probability between two gammas.
    pub fn mass_between(&self, from: f64, to: f64, domain: &Domain) -> f64 {
        let part = |segment: &Segment| {
            let (from, to) = (from.max(segment.from), to.min(segment.to));
            let line = &self.lines[segment.line as usize];
            if from < to { segment.step * segment.part(from, to, line, domain).above } else { 0.0 }
        };
        self.segments.iter().map(part).sum()
    }

    /// The density at a point of the plane.
    pub fn density(&self, alpha: f64, gamma: f64) -> f64 {
        let is_below = |s: &&Segment| self.lines[s.line as usize].alpha(gamma) <= alpha;
        self.segments_at(gamma).filter(is_below).map(|segment| segment.step).sum::<f64>().max(0.0)
    }

    /// The density at one gamma: every alpha at which it steps, ascending, and the step. The first alpha is
    /// the least one.
    pub fn steps_at(&self, gamma: f64) -> Vec<(f64, f64)> {
        let step = |s: &Segment| (self.lines[s.line as usize].alpha(gamma), s.step);
        let mut steps: Vec<(f64, f64)> = self.segments_at(gamma).map(step).collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        steps
    }

    /// The segments with this gamma. The last gamma belongs to those that end there.
    fn segments_at(&self, gamma: f64) -> impl Iterator<Item = &Segment> {
        let last = self.segments.iter().map(|segment| segment.to).fold(0.0, f64::max);
        self.segments
            .iter()
            .filter(move |s| s.from <= gamma && (gamma < s.to || s.to == last && gamma == last))
    }

    /// The prior's probability of all places with `function(density) = 1`, weighted: the integral of a function
    /// of the density over the prior.
    pub fn integral_of(&self, function: impl Fn(f64) -> f64) -> f64 {
        let of = |segment: &Segment| {
            let above = function((segment.below + segment.step).max(0.0));
            // below the least alpha there is nothing
            let below = if segment.line == 0 { 0.0 } else { function(segment.below.max(0.0)) };
            (above - below) * segment.above
        };
        self.segments.iter().map(of).sum()
    }
}

/// Whether a change of the density on so much of gamma changes no probability by more than `least`.
fn is_least(change: f64, gammas: f64, least: f64) -> bool {
    change * gammas <= least && change <= MIN_STEP / MIN_MASS * least
}

/// Where the segments of a line lie below another line, and where above it, in a range of gamma.
fn overlap(run: &[Segment], own: &GammaLine, other: &GammaLine, [from, to]: [f64; 2]) -> Sides {
    let (from, to) = (from.max(run[0].from), to.min(run[run.len() - 1].to));
    if from < to { own.sides(other, from, to) } else { Sides::none() }
}

/// The segments of a line within a range of gamma, with the part of each.
fn clipped(run: &[Segment], from: f64, to: f64) -> impl Iterator<Item = (&Segment, f64, f64)> {
    run.iter().map(move |s| (s, from.max(s.from), to.min(s.to))).filter(|(_, from, to)| from < to)
}

/// Calls `part` for every part of a range on which the sum of the events up to it is constant.
fn sweep(
    (from, to): (f64, f64),
    events: impl Iterator<Item = (f64, f64)>,
    mut part: impl FnMut(f64, f64, f64),
) {
    let (mut start, mut value) = (from, 0.0);
    for (at, change) in events {
        if at > start + MIN_PIECE {
            part(start, at.min(to), value);
            start = at;
        }
        value += change;
    }
    if to > start + MIN_PIECE {
        part(start, to, value);
    }
}

//! A border in the plane of (alpha, gamma) as polynomials of gamma, and on which side of another it lies.

use crate::preference::rule::{NODES, Rule, Samples};
use crate::preference::strips::{Border, Domain};
use serde::{Deserialize, Serialize};

/// Borders nearer than this in alpha count as one; the newer one is then the one below.
const TIE: f64 = 1e-12;

/// Equally spaced points at which two borders are compared before a crossing is searched for.
const POINTS: usize = 6;

/// A crossing is found where the borders are nearer than this in alpha. From there to the crossing, what is
/// between them counts on the wrong side: an area of the order of the square of this.
const NEAR: f64 = 1e-9;

/// The most crossings of two borders that are told apart.
const MAX_CROSSINGS: usize = 2 * POINTS;

/// alpha as a polynomial of gamma on an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct GammaLine {
    middle: f64,
    half: f64,
    alpha: Samples,
    /// The integral of the mark (probability up to alpha, times the density of gamma).
    integral: [f64; NODES + 1],
    /// Bounds of alpha.
    low: f64,
    high: f64,
}

/// On which parts of a range of gamma one border lies below another.
pub(super) struct Sides {
    /// The ends of the parts: the range's own ends, and the crossings between them.
    ends: [f64; MAX_CROSSINGS + 2],
    parts: usize,
    first_is_below: bool,
}

impl Sides {
    fn same(from: f64, to: f64, is_below: bool) -> Self {
        let mut ends = [0.0; MAX_CROSSINGS + 2];
        (ends[0], ends[1]) = (from, to);
        Self { ends, parts: 1, first_is_below: is_below }
    }

    /// No part.
    pub fn none() -> Self {
        Self { ends: [0.0; MAX_CROSSINGS + 2], parts: 0, first_is_below: false }
    }

    /// From, to, and whether the newer border is below.
    pub fn parts(&self) -> impl Iterator<Item = (f64, f64, bool)> {
        let is_below = |part: usize| self.first_is_below == part.is_multiple_of(2);
        (0..self.parts).map(move |part| (self.ends[part], self.ends[part + 1], is_below(part)))
    }
}

impl GammaLine {
    pub fn of(border: &Border, rule: &Rule) -> Self {
        Self::through(rule, border.gamma, &border.alphas, &border.marks)
    }

    /// The line of one alpha at every gamma of a range.
    pub fn constant(rule: &Rule, [from, to]: [f64; 2], alpha: f64, domain: &Domain) -> Self {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mass = domain.alpha.cdf(alpha);
        let marks = rule.nodes.map(|node| mass * domain.gamma.density(middle + half * node));
        let mut line = Self::through(rule, [from, to], &[alpha; NODES], &marks);
        (line.low, line.high) = (alpha, alpha);
        line.alpha = [0.0; NODES];
        line.alpha[0] = alpha;
        line
    }

    fn through(rule: &Rule, [from, to]: [f64; 2], alphas: &Samples, marks: &Samples) -> Self {
        let half = 0.5 * (to - from);
        let mark = rule.polynomial(marks);
        let mut integral = [0.0; NODES + 1];
        for (power, coefficient) in mark.iter().enumerate() {
            integral[power + 1] = half * coefficient / (power + 1) as f64;
        }
        let mut line = Self {
            middle: 0.5 * (from + to),
            half,
            alpha: rule.polynomial(alphas),
            integral,
            low: 0.0,
            high: 0.0,
        };
        let ends = [line.alpha(from), line.alpha(to)];
        let all = || alphas.iter().chain(&ends).copied();
        (line.low, line.high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        // between the nodes the line may come further: a parabola by 2.3 % of its range
        let margin = 0.05 * (line.high - line.low) + TIE;
        (line.low, line.high) = (line.low - margin, line.high + margin);
        line
    }

    /// The same alphas as of a line of one alpha, on another range.
    pub fn between(&self, from: f64, to: f64) -> Self {
        Self { middle: 0.5 * (from + to), half: 0.5 * (to - from), ..*self }
    }

    /// Whether the line lies in a panel of gamma. No line but the least alpha lies in several.
    pub fn is_in(&self, panel: &[f64]) -> bool {
        panel[0] < self.middle && self.middle < panel[1]
    }

    /// gamma at the nodes.
    pub fn gammas(&self, rule: &Rule) -> Samples {
        rule.nodes.map(|node| self.middle + self.half * node)
    }

    /// alpha at the nodes.
    pub fn alphas(&self, rule: &Rule) -> Samples {
        horners(&self.alpha, &rule.nodes)
    }

    /// Weights of the nodes for the integral over gamma of a function times a step function, which is given by
    /// its parts: from, to and value.
    pub fn weights(&self, parts: impl Iterator<Item = (f64, f64, f64)>, rule: &Rule) -> Samples {
        // the integrals of the powers of x, times power + 1
        let mut sums = [0.0; NODES];
        let mut add = |gamma: f64, value: f64| {
            let x = (gamma - self.middle) / self.half;
            let mut at = value;
            for sum in &mut sums {
                at *= x;
                *sum += at;
            }
        };
        let mut last = (self.middle, 0.0);
        for (from, to, value) in parts {
            match last.0 == from {
                true => add(from, last.1 - value),
                false => {
                    add(last.0, last.1);
                    add(from, -value);
                }
            }
            last = (to, value);
        }
        add(last.0, last.1);
        let mut weights = [0.0; NODES];
        for (power, sum) in sums.iter().enumerate() {
            let integral = self.half * sum / (power + 1) as f64;
            for (weight, coefficient) in weights.iter_mut().zip(&rule.powers[power]) {
                *weight += coefficient * integral;
            }
        }
        weights
    }

    pub fn alpha(&self, gamma: f64) -> f64 {
        horner(&self.alpha, (gamma - self.middle) / self.half)
    }

    /// The integral over gamma of the probability up to alpha, times the density of gamma.
    pub fn mass(&self, from: f64, to: f64) -> f64 {
        let [from, to] = horners(&self.integral, &[from, to].map(|gamma| (gamma - self.middle) / self.half));
        to - from
    }

    /// The same from the line's middle on.
    pub fn mass_to(&self, gamma: f64) -> f64 {
        horner(&self.integral, (gamma - self.middle) / self.half)
    }

    /// Where between `from` and `to` the line `newer` is below this one, or on it.
    pub fn sides(&self, newer: &Self, from: f64, to: f64) -> Sides {
        if newer.high <= self.low {
            return Sides::same(from, to, true);
        }
        if newer.low > self.high + TIE {
            return Sides::same(from, to, false);
        }
        let excess = |gamma: f64| newer.alpha(gamma) - self.alpha(gamma) - TIE;
        let spacing = (to - from) / (POINTS - 1) as f64;
        let at = |point: usize| if point + 1 == POINTS { to } else { from + spacing * point as f64 };
        let gammas: [f64; POINTS] = std::array::from_fn(at);
        let alphas =
            |line: &Self| horners(&line.alpha, &gammas.map(|gamma| (gamma - line.middle) / line.half));
        let (mine, others) = (alphas(self), alphas(newer));
        let values: [f64; POINTS] = std::array::from_fn(|point| others[point] - mine[point] - TIE);
        let mut sides = Sides::same(from, to, values[0] <= 0.0);
        for point in 1..POINTS {
            let (left, right) = ((at(point - 1), values[point - 1]), (at(point), values[point]));
            if (left.1 <= 0.0) != (right.1 <= 0.0) {
                sides.cut(crossing(&excess, left, right));
            } else if let Some(gamma) = dip(&values, point).map(|part| at(point - 1) + spacing * part) {
                let between = (gamma, excess(gamma));
                if (between.1 <= 0.0) != (left.1 <= 0.0) {
                    sides.cut(crossing(&excess, left, between));
                    sides.cut(crossing(&excess, between, right));
                }
            }
        }
        sides
    }
}

impl Sides {
    /// Adds a crossing, the last so far.
    fn cut(&mut self, gamma: f64) {
        self.ends[self.parts + 1] = self.ends[self.parts];
        self.ends[self.parts] = gamma;
        self.parts += 1;
    }
}

/// The part of the way from the point before to `point` at which values of one sign come nearest to 0, by the
/// parabola through three points; `None` if they do not come near.
fn dip(values: &[f64; POINTS], point: usize) -> Option<f64> {
    let sign = if values[point] > 0.0 { 1.0 } else { -1.0 };
    let value = |i: usize| sign * values[i];
    let from = |first: usize| {
        let (a, b, c) = (value(first), value(first + 1), value(first + 2));
        let (slope, curvature) = (0.5 * (c - a), a - 2.0 * b + c);
        let lowest = -slope / curvature;
        let part = first as f64 + 1.0 + lowest - (point - 1) as f64;
        let bottom = b - 0.5 * slope * slope / curvature;
        // twice the parabola's curvature still has to reach 0
        let is_near = curvature > 0.0 && part > 0.0 && part < 1.0 && bottom <= 0.5 * curvature;
        is_near.then_some(part)
    };
    let before = if point >= 2 { from(point - 2) } else { None };
    before.or_else(|| if point + 1 < POINTS { from(point - 1) } else { None })
}

/// Where a function changes its sign, by the Illinois method.
fn crossing(function: &impl Fn(f64) -> f64, left: (f64, f64), right: (f64, f64)) -> f64 {
    let (mut a, mut b) = (left, right);
    let mut kept = 0;
    for _ in 0..60 {
        let at = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
        let at = if at > a.0 && at < b.0 { at } else { 0.5 * (a.0 + b.0) };
        let value = function(at);
        if value.abs() < NEAR || b.0 - a.0 < 1e-13 {
            return at;
        }
        if (value <= 0.0) == (a.1 <= 0.0) {
            a = (at, value);
            if kept == 1 {
                b.1 *= 0.5;
            }
            kept = 1;
        } else {
            b = (at, value);
            if kept == 2 {
                a.1 *= 0.5;
            }
            kept = 2;
        }
    }
    0.5 * (a.0 + b.0)
}

/// A polynomial at several places at once.
fn horners<const N: usize>(coefficients: &[f64], x: &[f64; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for coefficient in coefficients.iter().rev() {
        for (sum, x) in sums.iter_mut().zip(x) {
            *sum = *sum * x + coefficient;
        }
    }
    sums
}

fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::Marginal;

    #[test]
    fn closed_form_a_dip_between_two_points_is_seen() {
        let rule = Rule::new();
        let uniform = |low, high| Marginal::uniform(low, high).unwrap();
        let (alpha, gamma) = (uniform(0.5, 0.9), uniform(0.5, 1.5));
        let domain = Domain { alpha, alpha_panels: vec![0.5, 0.9], gamma, gamma_panels: vec![0.5, 1.5] };
        let level = GammaLine::constant(&rule, [0.5, 1.5], 0.7, &domain);
        // the points lie at 0.9 and 1.1
        for [from, to] in [[0.95, 1.05], [0.91, 0.93], [0.999, 1.001]] {
            let alphas = rule.nodes.map(|x| 0.7 + (1.0 + 0.5 * x - from) * (1.0 + 0.5 * x - to));
            let line = GammaLine::through(&rule, [0.5, 1.5], &alphas, &alphas);
            let sides = level.sides(&line, 0.5, 1.5);
            let found: Vec<_> = sides.parts().collect();
            let wanted = [(0.5, from, false), (from, to, true), (to, 1.5, false)];
            assert_eq!(found.len(), 3, "{found:?}");
            for (found, wanted) in found.iter().zip(wanted) {
                let is_near = (found.0 - wanted.0).abs() < 1e-6 && (found.1 - wanted.1).abs() < 1e-6;
                assert!(is_near && found.2 == wanted.2, "{found:?} {wanted:?}");
            }
        }
    }
}

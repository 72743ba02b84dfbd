//! Means over the belief: expected costs, mean, covariance, intervals and regions.

use super::independent::Independent;
use super::line::Line;
use super::plane::{Plane, Segment};
use crate::math;
use crate::preference::rule::{Rule, gauss_legendre};
use crate::preference::strips::Domain;
use crate::preference::{Marginal, Perception, Prospect, SampleSet};
use std::num::NonZeroUsize;

/// Nodes per panel; a mean of a polynomial of a smaller degree is exact.
const POINTS: usize = 14;

/// Nodes on a short segment: exact where the border is straight and the prior uniform.
const FEW: usize = 8;

/// Segments shorter than this part of a panel, in alpha and in gamma, are short. Borders are nearly straight
/// there.
const SHORT: f64 = 0.1;

/// A belief about one human in figures.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// Mean of alpha and gamma.
    pub mean: [f64; 2],
    /// Variance of alpha, covariance, variance of gamma.
    pub covariance: [f64; 3],
    /// The central 95 % interval of alpha.
    pub alpha: [f64; 2],
    /// The central 95 % interval of gamma.
    pub gamma: [f64; 2],
    /// The density, relative to the prior's, above which the region of highest density with 95 % lies.
    pub region_density: f64,
    /// The share of the prior that this region has, 0 to 1.
    pub region_share: f64,
    /// Relative entropy to the prior, nats: 0 where nothing was learned. The differential entropy of the
    /// density is the prior's minus this.
    pub information: f64,
}

/// The marginals as nodes and weights, and the mean of alpha times gamma.
#[derive(Debug, Clone, Default)]
pub(super) struct Moments {
    alpha: Vec<(f64, f64)>,
    gamma: Vec<(f64, f64)>,
    product: f64,
    nodes: Vec<(f64, f64)>,
    few: Vec<(f64, f64)>,
}

impl Moments {
    /// Computes the marginals of a density.
    pub fn fill(&mut self, plane: &Plane, domain: &Domain, rule: &Rule) {
        if self.nodes.is_empty() {
            [self.nodes, self.few] =
                [POINTS, FEW].map(|n| gauss_legendre(NonZeroUsize::new(n).unwrap_or(NonZeroUsize::MIN)));
        }
        self.product = 0.0;
        self.alpha.clear();
        self.gamma.clear();
        let whole = [domain.gamma.lower(), domain.gamma.upper()];
        for panel in domain.alpha_panels.windows(2) {
            let top = Line::constant(rule, whole, panel[1], domain);
            let bottom = Line::constant(rule, whole, panel[0], domain);
            let mut means = [0.0; POINTS];
            for segment in &plane.segments {
                let line = &plane.lines[segment.line as usize];
                // where the line is within the panel, and where it is below it
                for (from, to, top_is_below) in line.sides(&top, segment.from, segment.to).parts() {
                    if top_is_below {
                        continue;
                    }
                    for (from, to, _) in line.sides(&bottom, from, to).parts() {
                        let part = Segment { from, to, ..*segment };
                        self.product += self.add_alpha(&part, line, panel, domain, &mut means);
                    }
                }
            }
            let [low, high] = [panel[0], panel[1]];
            to_weights(&self.nodes, &means, low, high, &mut self.alpha);
        }
        for panel in domain.gamma_panels.windows(2) {
            let mut means = [0.0; POINTS];
            for segment in &plane.segments {
                let (from, to) = (segment.from.max(panel[0]), segment.to.min(panel[1]));
                if from < to {
                    let line = &plane.lines[segment.line as usize];
                    self.add_gamma(&Segment { from, to, ..*segment }, line, panel, domain, &mut means);
                }
            }
            to_weights(&self.nodes, &means, panel[0], panel[1], &mut self.gamma);
        }
    }

    /// Adds a segment's part of the means of Legendre's polynomials of alpha over a panel. Returns its part of
    /// the mean of alpha times gamma.
    fn add_alpha(
        &self,
        segment: &Segment,
        line: &Line,
        panel: &[f64],
        domain: &Domain,
        means: &mut [f64; POINTS],
    ) -> f64 {
        let (half, middle) = halves(segment.from, segment.to);
        let (panel_half, panel_middle) = halves(panel[0], panel[1]);
        let mut product = 0.0;
        let range = domain.gamma.upper() - domain.gamma.lower();
        for (node, weight) in self.rule(segment, line, range, panel_half) {
            let gamma = middle + half * node;
            let weight = segment.step * half * weight * domain.gamma.density(gamma);
            let from = ((line.alpha(gamma) - panel_middle) / panel_half).clamp(-1.0, 1.0);
            let tails = self.tails(from, panel_half, panel_middle, &domain.alpha);
            for (mean, tail) in means.iter_mut().zip(tails) {
                *mean += weight * tail;
            }
            product += weight * gamma * (panel_middle * tails[0] + panel_half * tails[1]);
        }
        product
    }

    /// The rule for a segment. `gammas` is what counts as a whole range of gamma, `alphas` half a range of
    /// alpha.
    fn rule(&self, segment: &Segment, line: &Line, gammas: f64, alphas: f64) -> &[(f64, f64)] {
        let rise = (line.alpha(segment.to) - line.alpha(segment.from)).abs();
        let is_short = segment.to - segment.from < SHORT * gammas && rise < 2.0 * SHORT * alphas;
        if is_short { &self.few } else { &self.nodes }
    }

    /// Integrals of Legendre's polynomials times the density of alpha, from a place in `[-1, 1]` to 1.
    fn tails(&self, from: f64, half: f64, middle: f64, alpha: &Marginal) -> [f64; POINTS] {
        let mut tails = [0.0; POINTS];
        if alpha.normal_shape().is_some() {
            let (part, centre) = halves(from, 1.0);
            for (node, weight) in &self.nodes {
                let t = centre + part * node;
                let weight = part * weight * half * alpha.density(middle + half * t);
                legendre(t, |degree, value, _| tails[degree] += weight * value);
            }
            return tails;
        }
        let density = half / (alpha.upper() - alpha.lower());
        let mut before = [0.0; 2];
        legendre(from, |degree, value, next| {
            // the integral of P_j is (P_(j+1) - P_(j-1)) / (2 j + 1)
            let earlier = if degree == 0 { 1.0 } else { before[1] };
            tails[degree] = match degree {
                0 => density * (1.0 - from),
                _ => density * (earlier - next) * PER_DEGREE[degree],
            };
            before = [before[1], value];
        });
        tails
    }

    fn add_gamma(
        &self,
        segment: &Segment,
        line: &Line,
        panel: &[f64],
        domain: &Domain,
        means: &mut [f64; POINTS],
    ) {
        let (half, middle) = halves(segment.from, segment.to);
        let (panel_half, panel_middle) = halves(panel[0], panel[1]);
        let range = domain.alpha.upper() - domain.alpha.lower();
        for (node, weight) in self.rule(segment, line, 2.0 * panel_half, 0.5 * range) {
            let gamma = middle + half * node;
            let above = 1.0 - domain.alpha.cdf(line.alpha(gamma));
            let weight = segment.step * half * weight * domain.gamma.density(gamma) * above;
            legendre((gamma - panel_middle) / panel_half, |degree, value, _| means[degree] += weight * value);
        }
    }

    /// Mean of alpha and gamma.
    pub fn mean(&self) -> [f64; 2] {
        [&self.alpha, &self.gamma].map(|nodes| mean(nodes, |x| x))
    }

    /// Expected subjective cost of an option.
    pub fn expected_cost(&self, prospect: Prospect, risk_weight: f64) -> f64 {
        let Prospect { length, risk } = prospect.clamped();
        let perceived_length = match length == 0.0 || length == f64::INFINITY {
            true => length,
            false => {
                let log_length = math::ln(length);
                mean(&self.alpha, |alpha| math::exp(alpha * log_length))
            }
        };
        let log_surprise = math::ln(-math::ln(risk));
        perceived_length
            + risk_weight * mean(&self.gamma, |gamma| math::exp(-math::exp(gamma * log_surprise)))
    }
}

fn halves(from: f64, to: f64) -> (f64, f64) {
    (0.5 * (to - from), 0.5 * (from + to))
}

fn mean(nodes: &[(f64, f64)], function: impl Fn(f64) -> f64) -> f64 {
    nodes.iter().map(|&(value, weight)| weight * function(value)).sum()
}

/// (2 k + 1) / (k + 1) and k / (k + 1) for k = degree + 1.
const RECURRENCE: [[f64; 2]; POINTS] = {
    let mut table = [[0.0; 2]; POINTS];
    let mut degree = 0;
    while degree < POINTS {
        let k = (degree + 1) as f64;
        table[degree] = [(2.0 * k + 1.0) / (k + 1.0), k / (k + 1.0)];
        degree += 1;
    }
    table
};

/// 1 / (2 degree + 1).
const PER_DEGREE: [f64; POINTS] = {
    let mut table = [0.0; POINTS];
    let mut degree = 0;
    while degree < POINTS {
        table[degree] = 1.0 / (2 * degree + 1) as f64;
        degree += 1;
    }
    table
};

/// Calls `each` with the degree, P_degree(x) and P_(degree + 1)(x).
fn legendre(x: f64, mut each: impl FnMut(usize, f64, f64)) {
    let (mut value, mut next) = (1.0, x);
    for (degree, [ahead, back]) in RECURRENCE.into_iter().enumerate() {
        each(degree, value, next);
        (value, next) = (next, ahead * x * next - back * value);
    }
}

/// Adds nodes on a panel whose weights give these means of Legendre's polynomials.
fn to_weights(rule: &[(f64, f64)], means: &[f64; POINTS], low: f64, high: f64, nodes: &mut Vec<(f64, f64)>) {
    let (half, middle) = halves(low, high);
    nodes.extend(rule.iter().map(|(node, weight)| {
        let mut sum = 0.0;
        legendre(*node, |degree, value, _| sum += (degree as f64 + 0.5) * value * means[degree]);
        (middle + half * node, weight * sum)
    }));
}

/// The share of a distribution on each side of a 95 % interval.
const TAIL: f64 = 0.025;

impl Independent {
    pub fn marginals(&self, alpha: f64, gamma: f64) -> [f64; 2] {
        let [low, high] = [self.domain.gamma.lower(), self.domain.gamma.upper()];
        let alpha = alpha.clamp(self.domain.alpha.lower(), self.domain.alpha.upper());
        let line = Line::constant(&self.rule, [low, high], alpha, &self.domain);
        let (share, gammas) = (self.domain.alpha.cdf(alpha), &self.domain.gamma);
        let line_mass = |from, to| share * (gammas.cdf(to) - gammas.cdf(from));
        let below = self.plane.mass_below(&line, line_mass, [low, high]);
        [below, self.plane.mass_between(low, gamma.clamp(low, high), &self.domain)]
    }

    pub fn estimate(&self, moments: &Moments) -> Estimate {
        let of = |nodes: &[(f64, f64)]| {
            let first = mean(nodes, |x| x);
            (first, mean(nodes, |x| (x - first) * (x - first)))
        };
        let ((alpha, alpha_var), (gamma, gamma_var)) = (of(&moments.alpha), of(&moments.gamma));
        let [alphas, gammas] =
            [&self.domain.alpha, &self.domain.gamma].map(|marginal| [marginal.lower(), marginal.upper()]);
        let quantile = |[low, high]: [f64; 2], which: usize, share: f64| {
            let (mut below, mut above) = (low, high);
            for _ in 0..40 {
                let middle = 0.5 * (below + above);
                let found = self.marginals(middle, middle)[which];
                if found < share { below = middle } else { above = middle }
            }
            0.5 * (below + above)
        };
        let interval = |range, which| [TAIL, 1.0 - TAIL].map(|share| quantile(range, which, share));
        let (region_density, region_share) = self.region(1.0 - 2.0 * TAIL);
        let information =
            self.plane.integral_of(&self.domain, |w| if w > 0.0 { w * math::ln(w) } else { 0.0 }).max(0.0);
        Estimate {
            mean: [alpha, gamma],
            covariance: [alpha_var, moments.product - alpha * gamma, gamma_var],
            alpha: interval(alphas, 0),
            gamma: interval(gammas, 1),
            region_density,
            region_share,
            information,
        }
    }

    /// The least density of the region of highest density with this probability, and the region's prior
    /// probability.
    fn region(&self, probability: f64) -> (f64, f64) {
        let values = self.plane.segments.iter().flat_map(|s| [s.below, s.below + s.step]);
        let mut values: Vec<f64> = values.filter(|value| *value > 0.0).collect();
        values.sort_unstable_by(f64::total_cmp);
        let near = |least: f64| least * (1.0 - 1e-9);
        let mass =
            |least: f64| self.plane.integral_of(&self.domain, |w| if w >= near(least) { w } else { 0.0 });
        let enough = values.partition_point(|least| mass(*least) >= probability);
        let least = values.get(enough.saturating_sub(1)).copied().unwrap_or(0.0);
        let share = self.plane.integral_of(&self.domain, |w| if w >= near(least) { 1.0 } else { 0.0 });
        (least, share.clamp(0.0, 1.0))
    }
}

/// The figures of weighted samples.
pub(super) fn of_samples(set: &SampleSet, weights: &[f64]) -> Estimate {
    let pairs = || set.samples().iter().map(|sample| sample.perception).zip(weights.iter().copied());
    let mean =
        |value: &dyn Fn(Perception) -> f64| -> f64 { pairs().map(|(p, weight)| weight * value(p)).sum() };
    let (alpha, gamma) = (mean(&|p| p.alpha), mean(&|p| p.gamma));
    let interval = |value: &dyn Fn(Perception) -> f64| {
        let mut values: Vec<_> = pairs().map(|(p, weight)| (value(p), weight)).collect();
        values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        [TAIL, 1.0 - TAIL].map(|share| {
            let mut left = share;
            let found = values.iter().find(|(_, weight)| {
                left -= weight;
                left <= 0.0
            });
            found.or(values.last()).map_or(0.0, |(value, _)| *value)
        })
    };
    let mut ratios: Vec<(f64, f64, f64)> =
        set.samples().iter().zip(weights).map(|(s, w)| (w / s.weight, *w, s.weight)).collect();
    ratios.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let (mut mass, mut share, mut least) = (0.0, 0.0, 0.0);
    for (ratio, weight, prior) in &ratios {
        if mass >= 1.0 - 2.0 * TAIL {
            break;
        }
        (mass, share, least) = (mass + weight, share + prior, *ratio);
    }
    let relative =
        |(ratio, weight, _): &(f64, f64, f64)| if *weight > 0.0 { weight * math::ln(*ratio) } else { 0.0 };
    Estimate {
        mean: [alpha, gamma],
        covariance: [
            mean(&|p| (p.alpha - alpha) * (p.alpha - alpha)),
            mean(&|p| (p.alpha - alpha) * (p.gamma - gamma)),
            mean(&|p| (p.gamma - gamma) * (p.gamma - gamma)),
        ],
        alpha: interval(&|p| p.alpha),
        gamma: interval(&|p| p.gamma),
        region_density: least,
        region_share: share,
        information: ratios.iter().map(relative).sum::<f64>().max(0.0),
    }
}

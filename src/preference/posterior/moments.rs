//! Means over the belief: expected costs, mean, covariance, intervals and regions.

use super::independent::Independent;
use super::line::GammaLine;
use super::plane::{Plane, SAME, Segment};
use crate::math;
use crate::preference::rule::{NODES, Rule, Samples, gauss_legendre, powers};
use crate::preference::strips::Domain;
use crate::preference::{Marginal, Perception, Prospect, SampleSet};
use std::num::NonZeroUsize;

/// Nodes per panel; a mean of a polynomial of a smaller degree is exact.
const POINTS: usize = 12;

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
#[derive(Debug, Clone)]
pub(super) struct Moments {
    alpha: Vec<(f64, f64)>,
    gamma: Vec<(f64, f64)>,
    product: f64,
    rule: PanelRule,
    alpha_sums: Vec<Sums>,
    gamma_sums: Vec<Sums>,
}

/// Gauss-Legendre nodes and weights, and the coefficients of every node's Lagrange polynomial, by power.
#[derive(Debug, Clone)]
struct PanelRule {
    nodes: [(f64, f64); POINTS],
    powers: [[f64; POINTS]; POINTS],
}

/// Sums of the powers of a place in a panel, by degree, for every node of a line.
type Sums = [Samples; POINTS + 1];

impl Default for Moments {
    fn default() -> Self {
        let found = gauss_legendre(NonZeroUsize::new(POINTS).unwrap_or(NonZeroUsize::MIN));
        let nodes: [(f64, f64); POINTS] = std::array::from_fn(|i| found[i]);
        let rule = PanelRule { nodes, powers: powers(&nodes.map(|(node, _)| node)) };
        let (alpha, gamma, alpha_sums, gamma_sums) = Default::default();
        Self { alpha, gamma, product: 0.0, rule, alpha_sums, gamma_sums }
    }
}

impl Moments {
    /// Computes the marginals of a density.
    ///
    /// Where the density steps along a line, the step counts for all alphas above the line. The integral over
    /// gamma of what that adds is taken over the nodes of the line.
    pub fn fill(&mut self, plane: &Plane, domain: &Domain, rule: &Rule) {
        self.product = 0.0;
        for (sums, panels) in
            [(&mut self.alpha_sums, &domain.alpha_panels), (&mut self.gamma_sums, &domain.gamma_panels)]
        {
            sums.clear();
            sums.resize(panels.len() - 1, Sums::default());
        }
        for segments in plane.by_line() {
            let line = &plane.lines[segments[0].line as usize];
            for (index, panel) in domain.gamma_panels.windows(2).enumerate() {
                if segments[0].line == 0 {
                    let clipped = |s: &Segment| (s.from.max(panel[0]), s.to.min(panel[1]), s.step);
                    let level = line.between(panel[0], panel[1]);
                    let parts = segments.iter().map(clipped).filter(|(from, to, _)| from < to);
                    self.add(&level, &level.weights(parts, rule), index, domain, rule);
                } else if line.is_in(panel) {
                    let parts = segments.iter().map(|s| (s.from, s.to, s.step));
                    self.add(line, &line.weights(parts, rule), index, domain, rule);
                }
            }
        }
        self.alpha.clear();
        self.gamma.clear();
        for (panel, sums) in domain.alpha_panels.windows(2).zip(&self.alpha_sums) {
            let mut means = sums.map(|nodes| nodes.iter().sum::<f64>());
            if let Some(density) = density_if_uniform(&domain.alpha, panel) {
                // the sums are of the ends: the integral of t^j from t to 1 is (1 - t^(j+1)) / (j + 1)
                means = std::array::from_fn(|j| match means.get(j + 1) {
                    Some(end) => density * (means[0] - end) / (j + 1) as f64,
                    None => 0.0,
                });
            }
            self.rule.add_nodes(&means, panel, &mut self.alpha);
        }
        for (panel, sums) in domain.gamma_panels.windows(2).zip(&self.gamma_sums) {
            let means = sums.map(|nodes| nodes.iter().sum::<f64>());
            self.rule.add_nodes(&means, panel, &mut self.gamma);
        }
    }

    /// Adds what the steps along a line amount to. It lies in one panel of gamma and in one of alpha.
    fn add(&mut self, line: &GammaLine, weights: &Samples, gamma_panel: usize, domain: &Domain, rule: &Rule) {
        let (gammas, alphas) = (line.gammas(rule), line.alphas(rule));
        let each = |value: &dyn Fn(usize) -> f64| -> Samples { std::array::from_fn(value) };
        let weights = each(&|q| weights[q] * domain.gamma.density(gammas[q]));
        let above = each(&|q| weights[q] * (1.0 - domain.alpha.cdf(alphas[q])));
        let (half, middle) = halves(&domain.gamma_panels[gamma_panel..]);
        add_powers(&mut self.gamma_sums[gamma_panel], &above, &gammas.map(|gamma| (gamma - middle) / half));
        for (sums, panel) in self.alpha_sums.iter_mut().zip(domain.alpha_panels.windows(2)) {
            let (half, middle) = halves(panel);
            let from = alphas.map(|alpha| ((alpha - middle) / half).clamp(-1.0, 1.0));
            if from == [1.0; NODES] {
                continue;
            }
            let mut mean = [0.0; NODES];
            if let Some(density) = density_if_uniform(&domain.alpha, panel) {
                add_powers(sums, &weights, &from);
                mean = from.map(|t| density * (1.0 - t) * (middle + 0.5 * half * (1.0 + t)));
            } else {
                for (node, weight) in &self.rule.nodes {
                    let at = from.map(|from| 0.5 * (from + 1.0) + 0.5 * (1.0 - from) * node);
                    let alphas = at.map(|t| middle + half * t);
                    let part =
                        each(&|q| 0.5 * (1.0 - from[q]) * weight * half * domain.alpha.density(alphas[q]));
                    add_powers(sums, &each(&|q| weights[q] * part[q]), &at);
                    mean = each(&|q| mean[q] + part[q] * alphas[q]);
                }
            }
            self.product += (0..NODES).map(|q| weights[q] * gammas[q] * mean[q]).sum::<f64>();
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

/// Half of a panel's width, and its middle.
fn halves(panel: &[f64]) -> (f64, f64) {
    (0.5 * (panel[1] - panel[0]), 0.5 * (panel[0] + panel[1]))
}

/// The density of a uniform prior for a panel of length 2.
fn density_if_uniform(prior: &Marginal, panel: &[f64]) -> Option<f64> {
    prior.normal_shape().is_none().then(|| halves(panel).0 / (prior.upper() - prior.lower()))
}

fn add_powers(sums: &mut Sums, weights: &Samples, x: &Samples) {
    let mut at = *weights;
    for sum in sums {
        for q in 0..NODES {
            sum[q] += at[q];
            at[q] *= x[q];
        }
    }
}

impl PanelRule {
    /// Adds nodes on a panel whose weights give these means of the powers.
    fn add_nodes(&self, means: &[f64; POINTS + 1], panel: &[f64], nodes: &mut Vec<(f64, f64)>) {
        let (half, middle) = halves(panel);
        nodes.extend(self.nodes.iter().enumerate().map(|(i, (node, _))| {
            let weight = self.powers.iter().zip(means).map(|(of_node, mean)| of_node[i] * mean).sum();
            (middle + half * node, weight)
        }));
    }
}

fn mean(nodes: &[(f64, f64)], function: impl Fn(f64) -> f64) -> f64 {
    nodes.iter().map(|&(value, weight)| weight * function(value)).sum()
}

/// The share of a distribution on each side of a 95 % interval.
const TAIL: f64 = 0.025;

impl Independent {
    /// The probability of an alpha (0) or a gamma (1) up to a value.
    pub fn marginal(&self, which: usize, value: f64) -> f64 {
        let [low, high] = [self.domain.gamma.lower(), self.domain.gamma.upper()];
        if which == 1 {
            return self.plane.mass_between(low, value.clamp(low, high), &self.domain);
        }
        let alpha = value.clamp(self.domain.alpha.lower(), self.domain.alpha.upper());
        let line = GammaLine::constant(&self.rule, [low, high], alpha, &self.domain);
        let (share, gammas) = (self.domain.alpha.cdf(alpha), &self.domain.gamma);
        self.plane.mass_below(&line, |gamma| share * gammas.cdf(gamma), [low, high])
    }

    /// The alpha (0) or gamma (1) up to which there is this probability.
    pub fn quantile(&self, which: usize, probability: f64) -> f64 {
        let range = if which == 0 { &self.domain.alpha } else { &self.domain.gamma };
        let (mut below, mut above) = (range.lower(), range.upper());
        for _ in 0..40 {
            let middle = 0.5 * (below + above);
            if self.marginal(which, middle) < probability { below = middle } else { above = middle }
        }
        0.5 * (below + above)
    }

    pub fn estimate(&self, moments: &Moments) -> Estimate {
        let of = |nodes: &[(f64, f64)]| {
            let first = mean(nodes, |x| x);
            (first, mean(nodes, |x| (x - first) * (x - first)))
        };
        let ((alpha, alpha_var), (gamma, gamma_var)) = (of(&moments.alpha), of(&moments.gamma));
        let interval = |which| [TAIL, 1.0 - TAIL].map(|share| self.quantile(which, share));
        let (region_density, region_share) = self.region(1.0 - 2.0 * TAIL);
        let information = self.plane.integral_of(|w| if w > 0.0 { w * math::ln(w) } else { 0.0 }).max(0.0);
        Estimate {
            mean: [alpha, gamma],
            covariance: [alpha_var, moments.product - alpha * gamma, gamma_var],
            alpha: interval(0),
            gamma: interval(1),
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
        let near = |least: f64| least * (1.0 - SAME);
        let mass = |least: f64| self.plane.integral_of(|w| if w >= near(least) { w } else { 0.0 });
        let enough = values.partition_point(|least| mass(*least) >= probability);
        let least = values.get(enough.saturating_sub(1)).copied().unwrap_or(0.0);
        let share = self.plane.integral_of(|w| if w >= near(least) { 1.0 } else { 0.0 });
        (least, share.clamp(0.0, 1.0))
    }
}

/// The alpha (0) or gamma (1) of weighted samples up to which there is this probability.
pub(super) fn sample_quantile(set: &SampleSet, weights: &[f64], which: usize, probability: f64) -> f64 {
    let value = |perception: Perception| [perception.alpha, perception.gamma][which];
    let mut values: Vec<(f64, f64)> =
        set.samples().iter().map(|sample| value(sample.perception)).zip(weights.iter().copied()).collect();
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut left = probability;
    let found = values.iter().find(|(_, weight)| {
        left -= weight;
        left <= 0.0
    });
    found.or(values.last()).map_or(0.0, |(value, _)| *value)
}

/// The figures of weighted samples.
pub(super) fn of_samples(set: &SampleSet, weights: &[f64]) -> Estimate {
    let pairs = || set.samples().iter().map(|sample| sample.perception).zip(weights.iter().copied());
    let mean =
        |value: &dyn Fn(Perception) -> f64| -> f64 { pairs().map(|(p, weight)| weight * value(p)).sum() };
    let (alpha, gamma) = (mean(&|p| p.alpha), mean(&|p| p.gamma));
    let interval = |which| [TAIL, 1.0 - TAIL].map(|share| sample_quantile(set, weights, which, share));
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
        alpha: interval(0),
        gamma: interval(1),
        region_density: least,
        region_share: share,
        information: ratios.iter().map(relative).sum::<f64>().max(0.0),
    }
}

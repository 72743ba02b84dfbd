//! Means of the perceived length and the perceived risk over a marginal: the two terms of the expected
//! subjective cost.

use crate::math;
use std::num::NonZeroUsize;

use super::Marginal;
use super::rule::gauss_legendre;

/// Nodes per panel of a marginal's range. They integrate Stevens' and Prelec's functions to rounding on the
/// paper's ranges.
const POINTS: usize = 14;

/// A marginal as weighted nodes: the mean of a smooth function is a sum over them.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    nodes: Vec<(f64, f64)>,
}

impl Nodes {
    /// Nodes of a marginal; the weights sum to 1.
    pub fn new(marginal: &Marginal) -> Self {
        let rule = gauss_legendre(NonZeroUsize::new(POINTS).unwrap_or(NonZeroUsize::MIN));
        let mut nodes = Vec::new();
        for panel in marginal.panels().windows(2) {
            let (half, middle) = (0.5 * (panel[1] - panel[0]), 0.5 * (panel[0] + panel[1]));
            nodes.extend(rule.iter().map(|(node, weight)| {
                let value = middle + half * node;
                (value, half * weight * marginal.density(value))
            }));
        }
        let sum: f64 = nodes.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut nodes {
            *weight /= sum;
        }
        Self { nodes }
    }

    /// Mean of `function` over the marginal.
    pub fn mean(&self, function: impl Fn(f64) -> f64) -> f64 {
        self.nodes.iter().map(|&(value, weight)| weight * function(value)).sum()
    }

    /// Mean of Prelec's function of `risk`.
    pub fn perceived_risk(&self, risk: f64) -> f64 {
        let log_surprise = math::ln(-math::ln(risk));
        self.mean(|gamma| math::exp(-math::exp(gamma * log_surprise)))
    }

    /// Mean of Stevens' function of `length`.
    pub fn perceived_length(&self, length: f64) -> f64 {
        let log_length = math::ln(length);
        self.mean(|alpha| math::exp(alpha * log_length))
    }
}

/// Mean of `D^alpha` for `alpha` uniform on `[lower, upper]`: `(D^upper - D^lower) / (ln D (upper - lower))`.
pub(super) fn uniform_perceived_length(length: f64, lower: f64, upper: f64) -> f64 {
    if length == 0.0 || length == f64::INFINITY {
        return length;
    }
    let log_length = math::ln(length);
    let exponent = log_length * (upper - lower);
    // (exp(x) - 1) / x, whose limit at 0 is 1: near D = 1 the closed form is 0 / 0.
    let growth = if exponent == 0.0 { 1.0 } else { math::exp_m1(exponent) / exponent };
    math::exp(lower * log_length) * growth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over a marginal by the midpoint rule, extrapolated once. The sum is compensated, because
    /// rounding would dominate the result.
    fn slow_mean(marginal: &Marginal, function: impl Fn(f64) -> f64) -> f64 {
        let range = marginal.upper() - marginal.lower();
        let midpoint = |points: u32| -> f64 {
            let at = |k: u32| marginal.lower() + range * (f64::from(k) + 0.5) / f64::from(points);
            let (mut sum, mut lost) = (0.0, 0.0);
            for k in 0..points {
                let term = function(at(k)) * marginal.density(at(k)) * range / f64::from(points) - lost;
                let next = sum + term;
                lost = (next - sum) - term;
                sum = next;
            }
            sum
        };
        (4.0 * midpoint(40_000) - midpoint(20_000)) / 3.0
    }

    #[test]
    fn closed_form_uniform_lengths() {
        let alpha = Marginal::uniform(0.55, 0.95).unwrap();
        for length in [0.0, 1e-12, 0.3, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 18.0649, 1e4] {
            let found = uniform_perceived_length(length, 0.55, 0.95);
            let wanted = slow_mean(&alpha, |alpha| math::pow(length, alpha));
            assert!((found - wanted).abs() < 1e-12 * (1.0 + wanted), "{length}: {found} and {wanted}");
        }
        assert_eq!(uniform_perceived_length(1.0, 0.55, 0.95), 1.0);
    }

    #[test]
    fn closed_form_normal_lengths() {
        // exp(mean L + std^2 L^2 / 2) times the ratio of the shifted and the plain probability between the
        // bounds.
        let (mean, std, lower, upper) = (0.75, 0.1, 0.55, 0.95);
        let mass = |shift: f64| {
            let cdf = |x: f64| 0.5 * math::erfc(-(x - mean - shift) / std / std::f64::consts::SQRT_2);
            cdf(upper) - cdf(lower)
        };
        let nodes = Nodes::new(&Marginal::truncated_normal(mean, std, lower, upper).unwrap());
        for length in [0.01f64, 0.5, 1.0, 3.0, 18.0, 400.0] {
            let log = math::ln(length);
            let wanted =
                math::exp(mean * log + 0.5 * math::squared(std * log)) * mass(std * std * log) / mass(0.0);
            let found = nodes.perceived_length(length);
            assert!((found - wanted).abs() < 1e-12 * (1.0 + wanted), "{length}: {found} and {wanted}");
        }
        assert_eq!(nodes.perceived_length(0.0), 0.0);
    }

    #[test]
    fn closed_form_risks() {
        let ranges = [
            Marginal::uniform(0.5, 1.1).unwrap(),
            Marginal::uniform(0.05, 5.0).unwrap(),
            Marginal::truncated_normal(0.8, 0.02, 0.5, 1.1).unwrap(),
        ];
        for (gamma, tolerance) in ranges.iter().zip([1e-12, 1e-9, 1e-12]) {
            let nodes = Nodes::new(gamma);
            for risk in [0.0, 1e-12, 0.001, 0.05, 0.3679, 0.5, 0.9, 0.999, 1.0 - 1e-12, 1.0] {
                let found = nodes.perceived_risk(risk);
                let wanted = slow_mean(gamma, |gamma| super::super::perceived_risk(risk, gamma));
                assert!((found - wanted).abs() < tolerance, "{gamma} {risk}: {found} and {wanted}");
            }
        }
    }
}

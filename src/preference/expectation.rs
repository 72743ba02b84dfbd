//! Means of the perceived length and the perceived risk over a marginal: the two halves of the expected subjective cost.

use std::num::NonZeroUsize;

use super::Marginal;
use super::rule::gauss_legendre;

/// Nodes per panel of a marginal's range: Stevens' and Prelec's functions are then integrated to rounding on the paper's ranges.
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
        let log_surprise = (-risk.ln()).ln();
        self.mean(|gamma| (-(gamma * log_surprise).exp()).exp())
    }

    /// Mean of Stevens' function of `length`.
    pub fn perceived_length(&self, length: f64) -> f64 {
        let log_length = length.ln();
        self.mean(|alpha| (alpha * log_length).exp())
    }
}

/// Mean of `D^alpha` for `alpha` uniform on `[lower, upper]`: `(D^upper - D^lower) / (ln D (upper - lower))`.
pub(super) fn uniform_perceived_length(length: f64, lower: f64, upper: f64) -> f64 {
    if length == 0.0 {
        return 0.0;
    }
    let log_length = length.ln();
    let exponent = log_length * (upper - lower);
    // (exp(x) - 1) / x, whose limit at 0 is 1: near D = 1 the closed form is 0 / 0.
    let growth = if exponent == 0.0 { 1.0 } else { exponent.exp_m1() / exponent };
    (lower * log_length).exp() * growth
}

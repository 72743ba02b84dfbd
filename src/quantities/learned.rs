//! The quantities of the robot's belief about the human.

use super::{Fields, PLAIN, Quantity, QuantityKind, Value, fields, headings, quantities};
use crate::learning::Learner;
use crate::preference::{Estimate, Perception};
use QuantityKind::Numbers;

/// The number of values of alpha, and of gamma, in the grid of densities.
const GRID: u32 = 32;

/// The robot's belief about the human. Missing without `--belief learn`.
pub const LEARNED: &[Quantity] = quantities! {
    "human", QuantityKind::Record(|| headings(HUMAN)), "the belief over this human's alpha, gamma and eta", |v| v.episode.learner().map(human);
};

pub(super) struct Human<'a> {
    learner: &'a Learner,
    estimate: Estimate,
}

type OfHuman = Quantity<fn(&Human) -> Value>;

#[rustfmt::skip]
pub(super) const HUMAN: &[OfHuman] = quantities! {
    "alpha_mean", PLAIN, "mean of alpha", |h| h.estimate.mean[0];
    "gamma_mean", PLAIN, "mean of gamma", |h| h.estimate.mean[1];
    "alpha_variance", PLAIN, "variance of alpha", |h| h.estimate.covariance[0];
    "alpha_gamma_covariance", PLAIN, "covariance of alpha and gamma", |h| h.estimate.covariance[1];
    "gamma_variance", PLAIN, "variance of gamma", |h| h.estimate.covariance[2];
    "alpha_interval", Numbers, "central 95 % interval of alpha", |h| h.estimate.alpha.to_vec();
    "gamma_interval", Numbers, "central 95 % interval of gamma", |h| h.estimate.gamma.to_vec();
    "information_nats", QuantityKind::Number("nats"), "relative entropy to the prior: 0 where nothing was learned", |h| h.estimate.information;
    "region_share", PLAIN, "share of the prior in the region of highest density with 95 % of the belief, 0 to 1", |h| h.estimate.region_share;
    "region_density", PLAIN, "the least density of that region, relative to the prior's", |h| h.estimate.region_density;
    "alpha_range", Numbers, "the prior's least and largest alpha", |h| h.learner.perception().prior().ranges()[0].to_vec();
    "gamma_range", Numbers, "the prior's least and largest gamma", |h| h.learner.perception().prior().ranges()[1].to_vec();
    "density", Numbers, "density, relative to the prior's, at the middles of 32 by 32 cells of these ranges: all gammas of the first alpha, then of the next", |h| densities(h.learner);
    "eta_mean", PLAIN, "mean of eta", |h| h.learner.tolerance().moments()[0];
    "eta_variance", PLAIN, "variance of eta", |h| h.learner.tolerance().moments()[1];
    "eta_interval", Numbers, "central 95 % interval of eta", |h| h.learner.tolerance().interval(0.95).to_vec();
};

fn human(learner: &Learner) -> Fields {
    let estimate = learner.perception().clone().estimate();
    fields(HUMAN, &Human { learner, estimate })
}

fn densities(learner: &Learner) -> Vec<f64> {
    let [alphas, gammas] = learner.perception().prior().ranges();
    let middle = |[low, high]: [f64; 2], i| low + (high - low) * (f64::from(i) + 0.5) / f64::from(GRID);
    let cells = (0..GRID).flat_map(|i| (0..GRID).map(move |j| (i, j)));
    cells
        .map(|(i, j)| learner.density(Perception { alpha: middle(alphas, i), gamma: middle(gammas, j) }))
        .collect()
}

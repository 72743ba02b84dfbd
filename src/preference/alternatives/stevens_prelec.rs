//! The paper's perception, as one of several.

use super::{RiskParameter, RiskPerception};
use crate::preference::{Belief, Perception, Prospect, subjective_cost};

/// The paper's perception by Stevens and Prelec, eq. (2), of the people of a belief. A
/// [`Predictor`](crate::preference::Predictor) has the same probabilities, to 1e-9.
#[derive(Clone, Debug)]
pub struct StevensPrelec {
    belief: Belief,
    parameters: [RiskParameter; 2],
}

impl StevensPrelec {
    /// The people of this belief.
    pub fn new(belief: Belief) -> Self {
        let [alpha, gamma] = belief.ranges().map(|[low, high]| ([low, high], 0.5 * (low + high)));
        let parameters = [("alpha", alpha), ("gamma", gamma)];
        let parameters = parameters.map(|(name, (range, example))| RiskParameter { name, range, example });
        Self { belief, parameters }
    }
}

impl RiskPerception for StevensPrelec {
    fn name(&self) -> &'static str {
        "stevens-prelec"
    }

    fn parameters(&self) -> &[RiskParameter] {
        &self.parameters
    }

    fn perceived_cost(&self, prospect: Prospect, risk_weight: f64, parameters: &[f64]) -> f64 {
        subjective_cost(prospect, risk_weight, Perception { alpha: parameters[0], gamma: parameters[1] })
    }

    /// Samples lie one after the other, each as wide as its weight.
    fn at(&self, quantiles: &[f64]) -> Vec<f64> {
        match &self.belief {
            Belief::Independent { alpha, gamma } => {
                [alpha, gamma].into_iter().zip(quantiles).map(|(marginal, u)| marginal.quantile(*u)).collect()
            }
            Belief::Samples(set) => {
                let Perception { alpha, gamma } = set.at(quantiles[0]);
                vec![alpha, gamma]
            }
        }
    }

    fn breaks(&self, _: &[Prospect], _: f64) -> Option<Vec<f64>> {
        let Belief::Samples(set) = &self.belief else { return None };
        let sum = set.samples().iter().scan(0.0, |sum, sample| {
            *sum += sample.weight;
            Some(*sum)
        });
        Some(sum.collect())
    }
}

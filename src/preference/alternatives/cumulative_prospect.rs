//! Cumulative prospect theory.

use super::{RiskParameter, RiskPerception};
use crate::math;
use crate::preference::Prospect;

/// The value of a loss in cumulative prospect theory (A. Tversky and D. Kahneman, J. Risk and Uncertainty 5,
/// 1992): w(S) (D + c_r)^b + (1 - w(S)) D^b, with w(S) = S^d / (S^d + (1 - S)^d)^(1/d). The exponent b is
/// uniform from 0.5 to 1, the weighting d from 0.28, below which w does not rise everywhere, to 1, where w(S)
/// = S. Tversky and Kahneman found medians of 0.88 and 0.69. Their aversion to losses has no effect: all
/// outcomes are losses.
pub const CUMULATIVE_PROSPECT: CumulativeProspect = CumulativeProspect;

/// The type of [`CUMULATIVE_PROSPECT`].
#[derive(Clone, Copy, Debug)]
pub struct CumulativeProspect;

const PARAMETERS: [RiskParameter; 2] = [
    RiskParameter { name: "exponent", range: [0.5, 1.0], example: 0.88 },
    RiskParameter { name: "weighting", range: [0.28, 1.0], example: 0.69 },
];

/// w(S).
fn weight(risk: f64, weighting: f64) -> f64 {
    let [hit, miss] = [risk, 1.0 - risk].map(|p| math::pow(p, weighting));
    hit / math::pow(hit + miss, 1.0 / weighting)
}

impl RiskPerception for CumulativeProspect {
    fn name(&self) -> &'static str {
        "cumulative-prospect"
    }

    fn parameters(&self) -> &[RiskParameter] {
        &PARAMETERS
    }

    fn perceived_cost(
        &self,
        Prospect { length, risk }: Prospect,
        risk_weight: f64,
        parameters: &[f64],
    ) -> f64 {
        let w = weight(risk, parameters[1]);
        let [collision, none] = [length + risk_weight, length].map(|loss| math::pow(loss, parameters[0]));
        w * collision + (1.0 - w) * none
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_weights_of_tversky_and_kahneman() {
        assert_eq!([0.0, 1.0].map(|risk| weight(risk, 0.69)), [0.0, 1.0]);
        assert!((weight(0.3, 1.0) - 0.3).abs() < 1e-15);
        // small risks count more, large ones less; 1/2 has 2^-d / (2^(1-d))^(1/d)
        assert!(weight(0.05, 0.69) > 0.05 && weight(0.9, 0.69) < 0.9);
        let half = math::pow(2.0, -0.69) / math::pow(2.0, (1.0 - 0.69) / 0.69);
        assert!((weight(0.5, 0.69) - half).abs() < 1e-15);
        // rising everywhere at the least weighting
        let values: Vec<f64> = (0..=1000).map(|i| weight(f64::from(i) / 1000.0, 0.28)).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

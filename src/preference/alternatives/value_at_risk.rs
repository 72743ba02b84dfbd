//! Conditional value at risk: people who look at the worst outcomes only.

use super::{RiskParameter, RiskPerception};
use crate::preference::Prospect;

/// The mean cost of the worst outcomes of probability t (R. T. Rockafellar and S. Uryasev 2000):
/// D + c_r min(1, S / t). At t = 1 it is the expected cost; the smaller t, the more cautious the person. t is
/// uniform from 0 to 1, all that there is.
pub const CONDITIONAL_VALUE_AT_RISK: ConditionalValueAtRisk = ConditionalValueAtRisk;

/// The type of [`CONDITIONAL_VALUE_AT_RISK`].
#[derive(Clone, Copy, Debug)]
pub struct ConditionalValueAtRisk;

/// t, from 0 to 1: a quantile is its value.
const TAIL: RiskParameter = RiskParameter { name: "tail", range: [0.0, 1.0], example: 0.5 };

impl RiskPerception for ConditionalValueAtRisk {
    fn name(&self) -> &'static str {
        "cvar"
    }

    fn parameters(&self) -> &[RiskParameter] {
        &[TAIL]
    }

    fn perceived_cost(&self, Prospect { length, risk }: Prospect, risk_weight: f64, tail: &[f64]) -> f64 {
        // no risk is none, also to somebody who looks at nothing but the worst
        length + if risk > 0.0 { risk_weight * (risk / tail[0]).min(1.0) } else { 0.0 }
    }

    /// Costs are D + c_r S v with v = 1 / t up to v = 1 / S, and D + c_r beyond.
    fn breaks(&self, prospects: &[Prospect], risk_weight: f64) -> Option<Vec<f64>> {
        let prospects: Vec<Prospect> = prospects.iter().map(|prospect| prospect.clamped()).collect();
        let mut breaks: Vec<f64> = prospects.iter().map(|prospect| prospect.risk).collect();
        for a in &prospects {
            for b in &prospects {
                let difference = b.length - a.length;
                // where both rise, and where a rises and b has risen
                breaks.push(risk_weight * (a.risk - b.risk) / difference);
                breaks.push(risk_weight * a.risk / (difference + risk_weight));
            }
        }
        Some(breaks)
    }
}

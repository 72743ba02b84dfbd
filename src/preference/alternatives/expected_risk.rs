//! Expected risk: people who distort nothing.

use super::{RiskParameter, RiskPerception};
use crate::preference::{Prospect, objective_cost};

/// Everybody prefers the option of least expected cost D + c_r S, eq. (1).
pub const EXPECTED_RISK: ExpectedRisk = ExpectedRisk;

/// The type of [`EXPECTED_RISK`].
#[derive(Clone, Copy, Debug)]
pub struct ExpectedRisk;

impl RiskPerception for ExpectedRisk {
    fn name(&self) -> &'static str {
        "expected-risk"
    }

    fn parameters(&self) -> &[RiskParameter] {
        &[]
    }

    fn perceived_cost(&self, prospect: Prospect, risk_weight: f64, _: &[f64]) -> f64 {
        objective_cost(prospect, risk_weight)
    }

    fn breaks(&self, _: &[Prospect], _: f64) -> Option<Vec<f64>> {
        Some(Vec::new())
    }
}

//! Smooth rates over the physics steps of a control period.

use crate::robot::{InputVector, without_last};
use serde::{Deserialize, Serialize};

/// Share of a period during which rates change.
const TRANSITION_SHARE: f64 = 0.25;

/// A smooth transition of rates from one period to the next, because every jump of a rate jolts the object.
/// At the end of the period, every joint is where it would be if its rate had jumped, as far as the limits
/// allow.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Ramp {
    #[serde(with = "without_last")]
    from: InputVector,
    #[serde(with = "without_last")]
    to: InputVector,
    /// Number of physics steps of the transition, and how many of them are over.
    steps: f64,
    over: f64,
}

impl Ramp {
    /// A ramp at rest.
    pub fn new() -> Self {
        Self { from: InputVector::zeros(), to: InputVector::zeros(), steps: 1.0, over: 1.0 }
    }

    /// Begins a period of `steps` physics steps with these mean rates, clamped to the limits.
    pub fn begin(&mut self, mean: &InputVector, limits: &InputVector, steps: u64) {
        let whole = steps as f64;
        self.from = self.rates();
        self.steps = (TRANSITION_SHARE * whole).round().max(1.0);
        self.over = 0.0;
        // the sum of what a smooth unit transition lacks, at the ends of its steps
        let missing = (self.steps - 1.0) / 2.0;
        let to = (mean * whole - self.from * missing) / (whole - missing);
        self.to = to.zip_map(limits, |rate, limit| rate.clamp(-limit, limit));
    }

    /// Begins a physics step and returns the rates at its end.
    pub fn next(&mut self) -> InputVector {
        self.over = (self.over + 1.0).min(self.steps);
        self.rates()
    }

    fn rates(&self) -> InputVector {
        let x = self.over / self.steps;
        self.from + (self.to - self.from) * (x * x * (3.0 - 2.0 * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    const STEPS: u64 = 48;

    #[test]
    fn closed_form_a_period_ends_where_constant_rates_would() {
        let limits = InputVector::repeat(10.0);
        let mut ramp = Ramp::new();
        for period in 0..20 {
            let mean = InputVector::from_fn(|i, _| math::sin((period * (i + 1)) as f64));
            ramp.begin(&mean, &limits, STEPS);
            let sum: InputVector = (0..STEPS).map(|_| ramp.next()).sum();
            assert!((sum / STEPS as f64 - mean).norm() < 1e-12, "period {period}");
        }
    }

    #[test]
    fn rates_do_not_jump_and_keep_their_limits() {
        let limits = InputVector::repeat(1.2);
        // the steepest part of a smooth change from one limit to the other; 2.4 would be a jump
        let steepest = 1.5 / (TRANSITION_SHARE * STEPS as f64) * 2.4;
        let mut ramp = Ramp::new();
        let mut before = ramp.rates();
        for period in 0..20 {
            let mean = InputVector::repeat(if period % 2 == 0 { 1.0 } else { -1.0 });
            ramp.begin(&mean, &limits, STEPS);
            for _ in 0..STEPS {
                let rates = ramp.next();
                assert!((rates - before).amax() <= steepest && rates.amax() <= 1.2, "{rates}");
                before = rates;
            }
        }
    }

    #[test]
    fn a_period_of_one_step_has_its_rates_at_once() {
        let mut ramp = Ramp::new();
        ramp.begin(&InputVector::repeat(0.5), &InputVector::repeat(1.0), 1);
        assert_eq!(ramp.next(), InputVector::repeat(0.5));
    }
}

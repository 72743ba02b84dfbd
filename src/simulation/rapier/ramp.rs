//! Smooth rates over the physics steps of a control period.

use crate::robot::InputVector;
use serde::{Deserialize, Serialize};

/// Share of a period in which rates change.
const SHARE: f64 = 0.25;

/// How rates go over from one period's to the next's: smoothly, for every jump of a rate is a jolt of the object; and such that by the end of
/// the period all is where it would be had they jumped, as far as the limits allow.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Ramp {
    from: InputVector,
    to: InputVector,
    /// Physics steps that the change takes, and how many of them are over.
    steps: f64,
    over: f64,
}

impl Ramp {
    /// At rest.
    pub fn new() -> Self {
        Self { from: InputVector::zeros(), to: InputVector::zeros(), steps: 1.0, over: 1.0 }
    }

    /// A period of so many physics steps begins, whose mean rates are to be these, none beyond its limit.
    pub fn begin(&mut self, mean: &InputVector, limits: &InputVector, steps: u64) {
        let whole = steps as f64;
        self.from = self.rates();
        self.steps = (SHARE * whole).round().max(1.0);
        self.over = 0.0;
        // the sum of what is missing of a smooth change by one, at the ends of its steps
        let missing = (self.steps - 1.0) / 2.0;
        let to = (mean * whole - self.from * missing) / (whole - missing);
        self.to = to.zip_map(limits, |rate, limit| rate.clamp(-limit, limit));
    }

    /// A physics step begins: the rates at its end.
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
        let steepest = 1.5 / (SHARE * STEPS as f64) * 2.4;
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

//! The noise of a force: its part above a frequency, whatever the physics step.

use crate::math;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The corner frequency, Hz: above the gait (0.9 and 1.8), the planning steps (5) and the hand's hold (4).
pub(super) const NOISE_FREQUENCY: f64 = 10.0;

/// A Butterworth high-pass filter of second order, by the bilinear transform that is exact at its corner.
///
/// Gain at frequency f, in steps of dt seconds: w^2 / sqrt(1 + w^4), where w = tan(pi f dt) / tan(pi fc dt):
/// f / fc in the limit of short steps. Constants and ramps are removed.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct HighPass {
    /// The two state vectors of the transposed direct form; `None` before the first value.
    state: Option<[Vector3<f64>; 2]>,
}

/// Coefficients of the filter for one length of step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    feed: f64,
    back: [f64; 2],
}

impl Coefficients {
    /// The coefficients for steps of `dt` seconds, shorter than half a period of the corner.
    pub fn new(dt: f64) -> Self {
        let angle = PI * NOISE_FREQUENCY * dt;
        let corner = math::sin(angle) / math::cos(angle);
        let square = corner * corner;
        let over = 1.0 / (1.0 + 2.0 * FRAC_1_SQRT_2 * corner + square);
        let damped = (1.0 - 2.0 * FRAC_1_SQRT_2 * corner + square) * over;
        Self { feed: over, back: [2.0 * (square - 1.0) * over, damped] }
    }
}

impl HighPass {
    /// The part of the next value above the corner frequency. The first value counts as having been there
    /// always.
    pub fn next(&mut self, value: &Vector3<f64>, of: &Coefficients) -> Vector3<f64> {
        let Coefficients { feed, back } = *of;
        let fed = value * feed;
        let [first, second] = self.state.unwrap_or([-fed, fed]);
        let out = fed + first;
        self.state = Some([second - fed * 2.0 - out * back[0], fed - out * back[1]]);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain of a sine of `frequency` (Hz) at `rate` (Hz), by the last second of four.
    fn gain(frequency: f64, rate: f64) -> f64 {
        let (mut filter, of) = (HighPass::default(), Coefficients::new(1.0 / rate));
        let (mut into, mut out) = (0.0, 0.0);
        for step in 0..(4.0 * rate) as u32 {
            let value = Vector3::new(0.0, math::sin(2.0 * PI * frequency * f64::from(step) / rate), 7.0);
            let passed = filter.next(&value, &of);
            if f64::from(step) >= 3.0 * rate {
                into += value.y * value.y;
                out += passed.norm_squared();
            }
        }
        f64::sqrt(out / into)
    }

    #[test]
    fn closed_form_a_sine_passes_with_the_gain_of_its_frequency() {
        for rate in [60.0, 100.0, 240.0, 960.0] {
            let tan = |f: f64| math::sin(PI * f / rate) / math::cos(PI * f / rate);
            for frequency in [1.0, 2.0, 5.0, 10.0, 20.0] {
                let w = math::squared(tan(frequency) / tan(NOISE_FREQUENCY));
                let expected = w / f64::sqrt(1.0 + w * w);
                let found = gain(frequency, rate);
                assert!((found - expected).abs() < 1e-6, "{frequency} Hz at {rate} Hz: {found}, {expected}");
            }
        }
    }

    #[test]
    fn the_gain_hardly_depends_on_the_step() {
        for frequency in [1.0, 5.0, 10.0, 20.0] {
            let [coarse, fine] = [100.0, 960.0].map(|rate| gain(frequency, rate));
            // at 100 Hz the bilinear transform takes 0.011 at 5 Hz
            assert!((coarse - fine).abs() < 0.012, "{frequency} Hz: {coarse} and {fine}");
        }
    }
}

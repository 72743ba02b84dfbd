//! Intervals of a positive number that scatters in; the log-normal distribution that makes them likeliest, and what its median may be, out.

use super::minimum::{SCANNED, least, refined, scanned};
use crate::math;
use serde::Serialize;

/// A log-normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogNormal {
    /// exp of the mean of the logarithm.
    pub median: f64,
    /// Standard deviation of the logarithm.
    pub log_std: f64,
}

/// Standard deviations of the logarithm that are tried.
const SPREADS: [f64; 2] = [0.005, 3.0];
/// Medians that are tried.
const MEDIANS: [f64; 2] = [1e-3, 1e6];
/// A 95 % interval ends where the log-likelihood is this much below its best (half of chi-squared's quantile for one degree of freedom).
const DROP: f64 = 1.920_729;

/// What all intervals have in common, if anything.
pub(super) fn intersection(intervals: &[[f64; 2]]) -> Option<[f64; 2]> {
    let lower = intervals.iter().map(|i| i[0]).fold(0.0, f64::max);
    let upper = intervals.iter().map(|i| i[1]).fold(f64::INFINITY, f64::min);
    (lower < upper).then_some([lower, upper])
}

impl LogNormal {
    /// The likeliest distribution of numbers of which each lies in its interval (the upper end may be infinite: censored), and the 95 % profile
    /// likelihood interval of its median.
    ///
    /// Where all intervals have something in common, the likeliest has no spread, and its median may lie anywhere there: it is put into the
    /// middle. `None` if no interval has an upper end.
    pub fn fit(intervals: &[[f64; 2]]) -> Option<(Self, [f64; 2])> {
        if intervals.iter().all(|i| i[1].is_infinite()) {
            return None;
        }
        if let Some([lower, upper]) = intersection(intervals) {
            return Some((Self { median: (lower + upper) / 2.0, log_std: 0.0 }, [lower, upper]));
        }
        let spreads = scanned(SPREADS);
        let spreads: Vec<f64> = spreads.into_iter().step_by(SCANNED / 60).collect();
        // the least loss over spreads, for a median
        let best_spread = |median: f64| {
            let losses: Vec<f64> = spreads.iter().map(|s| loss(intervals, math::ln(median), *s)).collect();
            let spread = refined(&spreads, least(&losses), |s| loss(intervals, math::ln(median), s));
            (spread, loss(intervals, math::ln(median), spread))
        };
        let medians = scanned(MEDIANS);
        let losses: Vec<f64> = medians.iter().map(|m| best_spread(*m).1).collect();
        let best = least(&losses);
        let median = refined(&medians, best, |m| best_spread(m).1);
        let (log_std, lowest) = best_spread(median);
        let is_in = |m: f64| best_spread(m).1 <= lowest + DROP;
        let end = |outward: &mut dyn Iterator<Item = usize>| {
            let mut inside = median;
            for i in outward {
                if is_in(medians[i]) {
                    inside = medians[i];
                    continue;
                }
                let mut outside = medians[i];
                for _ in 0..30 {
                    let middle = (inside * outside).sqrt();
                    if is_in(middle) { inside = middle } else { outside = middle }
                }
                return inside;
            }
            inside
        };
        let low = end(&mut (0..medians.len()).rev().filter(|&i| medians[i] < median));
        let high = end(&mut (0..medians.len()).filter(|&i| medians[i] > median));
        Some((Self { median, log_std }, [low, high]))
    }
}

/// Negative log-likelihood that every interval holds its number.
fn loss(intervals: &[[f64; 2]], log_median: f64, log_std: f64) -> f64 {
    let z = |end: f64| (math::ln(end) - log_median) / log_std;
    intervals.iter().map(|i| -ln_between(z(i[0]), z(i[1]))).sum()
}

/// ln of the probability that a standard normal number lies between `a` and `b`; either may be infinite.
fn ln_between(a: f64, b: f64) -> f64 {
    // in the upper tail, where small probabilities are exact
    let (a, b) = if a + b < 0.0 { (-b, -a) } else { (a, b) };
    if a <= 0.0 {
        return math::ln((1.0 - above(-a) - above(b)).max(f64::MIN_POSITIVE));
    }
    let beyond = if b.is_infinite() { 0.0 } else { math::exp(ln_above(b) - ln_above(a)) };
    // two ends that rounding makes equal still hold something
    ln_above(a) + math::ln((1.0 - beyond).max(f64::EPSILON))
}

/// Probability that a standard normal number is above `x`.
fn above(x: f64) -> f64 {
    0.5 * math::erfc(x / std::f64::consts::SQRT_2)
}

/// Its logarithm, for positive `x`.
fn ln_above(x: f64) -> f64 {
    match x < 30.0 {
        true => math::ln(above(x)),
        // the first terms of the asymptotic series
        false => -x * x / 2.0 - math::ln(x * std::f64::consts::TAU.sqrt()) - 1.0 / (x * x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(value: f64) -> [f64; 2] {
        [value * 0.999, value * 1.001]
    }

    #[test]
    fn closed_form_narrow_intervals_give_mean_and_deviation_of_the_logarithms() {
        let values = [4.0f64, 8.0, 10.0, 14.0];
        let intervals: Vec<[f64; 2]> = values.iter().map(|v| around(*v)).collect();
        let (found, interval) = LogNormal::fit(&intervals).unwrap();
        let logs = values.map(math::ln);
        let mean = logs.iter().sum::<f64>() / 4.0;
        let std = (logs.iter().map(|l| math::squared(l - mean)).sum::<f64>() / 4.0).sqrt();
        assert!((math::ln(found.median) - mean).abs() < 1e-3, "{found:?}");
        assert!((found.log_std - std).abs() < 1e-3, "{found:?}");
        // the profile likelihood of a normal mean: n / 2 ln(1 + d^2 / s^2) = DROP
        let half = std * (math::exp(2.0 * DROP / 4.0) - 1.0).sqrt();
        assert!((math::ln(interval[0]) - (mean - half)).abs() < 3e-3, "{interval:?}");
        assert!((math::ln(interval[1]) - (mean + half)).abs() < 3e-3, "{interval:?}");
    }

    #[test]
    fn closed_form_a_censored_number_raises_the_median() {
        let two = [around(4.0), around(8.0)];
        let three = [around(4.0), around(8.0), [8.0, f64::INFINITY]];
        let median = |intervals: &[[f64; 2]]| LogNormal::fit(intervals).unwrap().0.median;
        assert!(median(&three) > 1.1 * median(&two));
        assert_eq!(LogNormal::fit(&three[2..]), None);
    }

    #[test]
    fn closed_form_intervals_that_agree_have_no_spread() {
        let (found, interval) = LogNormal::fit(&[[3.0, 6.0], [5.0, f64::INFINITY], [4.0, 7.0]]).unwrap();
        assert_eq!((found.median, found.log_std, interval), (5.5, 0.0, [5.0, 6.0]));
    }

    #[test]
    fn closed_form_tails_join() {
        assert!((ln_above(30.0 - 1e-12) - ln_above(30.0)).abs() < 1e-5);
        assert!((math::exp(ln_between(-1.0, 1.0)) - 0.682_689_492).abs() < 1e-9);
        assert!((ln_between(-40.0, -39.0) - ln_between(39.0, 40.0)).abs() < 1e-12);
    }
}

//! Statistics of samples: means, intervals, and paired comparisons of the same humans under two conditions.
//!
//! A sample has one value for each human. Where all humans of a cell make the same choices, their values are
//! equal or differ only by gait noise. There is then a single outcome, however often it was repeated, and no
//! interval or test is given.

use crate::parallel::{OnDone, in_parallel};
use cocarry::math;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The relative difference below which values are equal up to rounding.
const RELATIVE_ROUNDING: f64 = 1e-9;

/// Mean and sample standard deviation (n - 1); NaN where there are too few values.
pub fn mean_and_std(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| math::squared(v - mean)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

/// The quantiles of values, interpolated between neighbours; `None` without values.
pub fn quantiles<const N: usize>(mut values: Vec<f64>, shares: [f64; N]) -> Option<[f64; N]> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(shares.map(|share| {
        let at = share * last as f64;
        let (below, part) = (at.floor() as usize, at.fract());
        values[below] + part * (values[(below + 1).min(last)] - values[below])
    }))
}

/// The 95 % percentile-bootstrap intervals of the means of several columns, whose rows are people: every
/// resample takes the same people for all columns. Values that are missing are left out of a column's mean.
/// `None` for a column with fewer than two values, or whose values are equal up to rounding: its resamples do
/// not vary.
pub fn bootstrapped(
    rows: &[Vec<Option<f64>>],
    resamples: usize,
    seed: u64,
    on_done: OnDone,
) -> Vec<Option<[f64; 2]>> {
    let columns = rows.first().map_or(0, Vec::len);
    let means = in_parallel(resamples, on_done, |resample| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(resample as u64);
        let mut sums = vec![(0.0, 0.0); columns];
        for _ in rows {
            let row = &rows[rng.random_range(0..rows.len())];
            for (sum, value) in sums.iter_mut().zip(row).filter_map(|(sum, value)| Some((sum, (*value)?))) {
                *sum = (sum.0 + value, sum.1 + 1.0);
            }
        }
        sums.iter().map(|(sum, count)| sum / count).collect::<Vec<f64>>()
    });
    let interval = |column: usize| {
        let mut moments = Moments::default();
        rows.iter().filter_map(|row| row[column]).for_each(|value| moments.add(value, value.abs()));
        moments.estimate(true)?.interval?;
        // a resample may have nobody with a value
        let means = means.iter().map(|means| means[column]).filter(|mean| mean.is_finite());
        quantiles(means.collect(), [0.025, 0.975])
    };
    (0..columns).map(interval).collect()
}

/// The 95 % interval of a probability from as many successes of `of` independent trials, by Wilson's score.
pub fn wilson(successes: usize, of: usize) -> [f64; 2] {
    const Z: f64 = 1.959_963_984_540_054;
    let (n, p) = (of as f64, successes as f64 / of as f64);
    let square = Z * Z / n;
    let half = Z * (p * (1.0 - p) / n + square / (4.0 * n)).sqrt();
    let end = |end: f64| (p + square / 2.0 + end) / (1.0 + square);
    // exact where rounding would leave a rest
    [if successes == 0 { 0.0 } else { end(-half) }, if successes == of { 1.0 } else { end(half) }]
}

/// Count, mean, sum of squared deviations and largest magnitude of the values so far (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    n: u64,
    mean: f64,
    squares: f64,
    size: f64,
}

impl Moments {
    /// Adds a value. `size` is the magnitude of the numbers that it was calculated from: the value itself, or
    /// the operands of a difference.
    pub fn add(&mut self, value: f64, size: f64) {
        self.n += 1;
        let before = value - self.mean;
        self.mean += before / self.n as f64;
        self.squares += before * (value - self.mean);
        self.size = self.size.max(size);
    }

    /// Number of values.
    pub fn count(&self) -> u64 {
        self.n
    }

    fn std(&self) -> Option<f64> {
        (self.n > 1).then(|| (self.squares / (self.n - 1) as f64).sqrt())
    }

    /// Mean, deviation and interval; `None` without values. `is_sample` says whether the values come from
    /// humans who make different choices, not from noise alone. There is no interval if `is_sample` is false
    /// or the values differ by rounding only.
    pub fn estimate(&self, is_sample: bool) -> Option<Estimate> {
        let Self { n, mean, size, .. } = *self;
        let std = self.std();
        let varies = std.is_some_and(|std| is_sample && std > RELATIVE_ROUNDING * size);
        let interval = std.filter(|_| varies).map(|std| {
            let half = students_quantile((n - 1) as f64) * std / (n as f64).sqrt();
            [mean - half, mean + half]
        });
        (n > 0).then_some(Estimate { n, mean, std, interval })
    }
}

/// The moments over units (humans, participants) of each one's mean: a unit counts once, with the mean of its
/// values.
#[derive(Clone, Copy, Debug, Default)]
pub struct UnitMoments {
    moments: Moments,
    /// Sum, largest magnitude and number of the present unit's values.
    present: (f64, f64, u32),
    below: u64,
}

impl UnitMoments {
    /// Adds a value of the present unit. `size` as for [`Moments::add`].
    pub fn add(&mut self, value: f64, size: f64) {
        let (sum, largest, count) = self.present;
        self.present = (sum + value, largest.max(size), count + 1);
    }

    /// Adds a difference of the present unit: first minus second.
    pub fn add_pair(&mut self, first: f64, second: f64) {
        self.add(first - second, first.abs().max(second.abs()));
    }

    /// Ends the present unit. One without values does not count.
    pub fn end_unit(&mut self) {
        let (sum, largest, count) = std::mem::take(&mut self.present);
        if count > 0 {
            let mean = sum / f64::from(count);
            self.moments.add(mean, largest);
            self.below += u64::from(mean < 0.0);
        }
    }

    /// The moments of the units that have ended.
    pub fn moments(&self) -> &Moments {
        &self.moments
    }

    /// The share of the units that have ended whose mean is below 0.
    pub fn share_below(&self) -> f64 {
        self.below as f64 / self.moments.count() as f64
    }

    /// The moments of values in the order of their units.
    pub fn of<U: PartialEq>(values: impl IntoIterator<Item = (U, f64, f64)>) -> Self {
        let mut all = Self::default();
        let mut present = None;
        for (unit, value, size) in values {
            if present.as_ref() != Some(&unit) {
                all.end_unit();
                present = Some(unit);
            }
            all.add(value, size);
        }
        all.end_unit();
        all
    }
}

/// A mean and its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Number of values.
    pub n: u64,
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation; `None` for a single value.
    pub std: Option<f64>,
    /// 95 % confidence interval of the mean (Student's t); `None` for a single value and where the values do
    /// not vary between humans.
    pub interval: Option<[f64; 2]>,
}

/// A paired comparison of the same humans under two conditions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Paired {
    /// The differences, one value for each human.
    #[serde(flatten)]
    pub difference: Estimate,
    /// Mean difference over its standard deviation (Cohen's d_z); `None` where the differences do not vary
    /// between humans.
    pub effect_size: Option<f64>,
    /// Two-sided p-value of the paired t-test that the mean is 0; `None` where the differences do not vary
    /// between humans.
    pub p_value: Option<f64>,
    /// The p-value corrected by Holm's method for all comparisons of the table.
    pub p_holm: Option<f64>,
}

impl Paired {
    /// The uncorrected comparison of these differences; `None` without values. `is_sample` as for
    /// [`Moments::estimate`].
    pub fn of(moments: &Moments, is_sample: bool) -> Option<Self> {
        let difference = moments.estimate(is_sample)?;
        let Estimate { n, mean, std, interval } = difference;
        let effect_size = interval.and(std).map(|std| mean / std);
        let p_value = effect_size.map(|effect| two_sided(effect * (n as f64).sqrt(), (n - 1) as f64));
        Some(Self { difference, effect_size, p_value, p_holm: None })
    }

    /// The comparison of two lists of values of the same humans: first minus second.
    pub fn of_lists(first: &[f64], second: &[f64], is_sample: bool) -> Option<Self> {
        let mut moments = Moments::default();
        first.iter().zip(second).for_each(|(a, b)| moments.add(a - b, a.abs().max(b.abs())));
        Self::of(&moments, is_sample)
    }
}

/// Corrects the p-values of a table's comparisons by Holm's method (1979). It bounds the probability of any
/// false rejection in the table by the level of the test.
pub fn correct<'a>(comparisons: impl Iterator<Item = &'a mut Paired>) {
    let mut tested: Vec<(f64, &mut Paired)> = comparisons.filter_map(|c| Some((c.p_value?, c))).collect();
    tested.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut left, mut largest) = (tested.len(), 0.0_f64);
    for (p, comparison) in tested {
        largest = largest.max((p * left as f64).min(1.0));
        comparison.p_holm = Some(largest);
        left -= 1;
    }
}

/// Probability that Student's t with `freedom` degrees of freedom lies farther from 0 than `t`.
fn two_sided(t: f64, freedom: f64) -> f64 {
    let whole = freedom + t * t;
    incomplete_beta(freedom / 2.0, 0.5, freedom / whole, t * t / whole)
}

/// The 97.5 % quantile of Student's t.
fn students_quantile(freedom: f64) -> f64 {
    let (mut below, mut above) = (0.0, 2.0);
    while two_sided(above, freedom) > 0.05 {
        (below, above) = (above, 2.0 * above);
    }
    loop {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            return middle;
        }
        match two_sided(middle, freedom) > 0.05 {
            true => below = middle,
            false => above = middle,
        }
    }
}

/// The regularised incomplete beta function I_x(a, b), by its continued fraction (Lentz's method). `rest` is
/// 1 - x to full precision. No crate is used because they call the system's functions, whose last bits differ
/// between machines.
fn incomplete_beta(a: f64, b: f64, x: f64, rest: f64) -> f64 {
    if x <= 0.0 || rest <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, rest, x);
    }
    let scale = math::ln_gamma(a + b) - math::ln_gamma(a) - math::ln_gamma(b);
    let front = math::exp(scale + a * math::ln(x) + b * math::ln(rest)) / a;
    let nonzero = |value: f64| if value.abs() < 1e-300 { 1e-300 } else { value };
    let (mut c, mut d) = (1.0, 1.0 / nonzero(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    // it converges within about ten times the root of the larger parameter
    for k in 1..1_000_000 {
        let k = f64::from(k);
        let even = k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k));
        let odd = -(a + k) * (a + b + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0));
        let before = fraction;
        for numerator in [even, odd] {
            d = 1.0 / nonzero(1.0 + numerator * d);
            c = nonzero(1.0 + numerator / c);
            fraction *= c * d;
        }
        if (fraction - before).abs() <= 1e-15 * fraction.abs() {
            break;
        }
    }
    front * fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    fn paired(p_value: Option<f64>) -> Paired {
        let difference = Estimate { n: 20, mean: 1.0, std: Some(1.0), interval: None };
        Paired { difference, effect_size: None, p_value, p_holm: None }
    }

    #[test]
    fn golden_a_paired_test_agrees_with_tables() {
        // differences 1, 2, 3, 4, 5: t = 3 / (1.5811 / sqrt 5) = 4.2426 with 4 degrees of freedom
        let p_value = |a: &[f64], b: &[f64]| Paired::of_lists(a, b, true).and_then(|paired| paired.p_value);
        let p = p_value(&[2.0, 4.0, 6.0, 8.0, 10.0], &[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert!((p - 0.013_236).abs() < 1e-6, "{p}");
        assert_eq!(p_value(&[1.0], &[0.0]), None);
    }

    /// Compares the distribution with an independent crate's.
    #[test]
    fn students_distribution_is_that_of_statrs() {
        for freedom in [1.0, 2.0, 3.0, 19.0, 99.0, 1e4, 1e6] {
            let theirs = StudentsT::new(0.0, 1.0, freedom).unwrap();
            for t in [0.0, 1e-6, 0.3, 1.0, 1.96, 5.0, 20.0, 100.0] {
                let (found, wanted) = (two_sided(t, freedom), 2.0 * theirs.sf(t));
                // near t = 0, statrs loses t in 1 - x
                let closest = if t < 1e-3 && t > 0.0 { 1e-6 } else { 1e-9 };
                assert!(
                    (found - wanted).abs() <= closest * wanted + 1e-300,
                    "{freedom} {t}: {found} {wanted}"
                );
            }
            // statrs is wrong in the fourth digit there; use z + (z^3 + z) / (4 n) with the normal quantile z
            let wanted = if freedom > 1e5 { 1.959_966_357 } else { theirs.inverse_cdf(0.975) };
            let found = students_quantile(freedom);
            assert!((found - wanted).abs() < 1e-7 * wanted, "{freedom}: {found} {wanted}");
        }
    }

    #[test]
    fn what_does_not_vary_between_humans_is_not_tested() {
        let same = Paired::of_lists(&[3.0, 3.0, 3.0], &[1.0, 1.0, 1.0], true).unwrap();
        let rounding = Paired::of_lists(&[3.0 + 1e-13, 3.0, 3.0], &[1.0; 3], true).unwrap();
        let noise = Paired::of_lists(&[3.0, 3.1, 2.9], &[1.0; 3], false).unwrap();
        for c in [same, rounding, noise] {
            assert_eq!(
                (c.difference.n, c.difference.interval, c.effect_size, c.p_value),
                (3, None, None, None)
            );
            assert!((c.difference.mean - 2.0).abs() < 1e-9);
        }
        let humans = Paired::of_lists(&[3.0, 3.1, 2.9], &[1.0; 3], true).unwrap();
        assert!((humans.effect_size.unwrap() - 20.0).abs() < 1e-9);
        assert!(humans.p_value.unwrap() < 0.01 && humans.difference.interval.is_some());
    }

    #[test]
    fn golden_holms_correction() {
        // Holm (1979): 0.01 * 4, 0.02 * 3, 0.03 * 2 raised to the one before, 0.04
        let mut all = [Some(0.03), None, Some(0.01), Some(0.04), Some(0.02)].map(paired);
        correct(all.iter_mut());
        let found = all.map(|c| c.p_holm.map(|p| (p * 1e6).round() / 1e6));
        assert_eq!(found, [Some(0.06), None, Some(0.04), Some(0.06), Some(0.06)]);
    }

    #[test]
    fn a_bootstrap_interval_is_about_that_of_the_normal_and_none_where_nothing_varies() {
        let rows: Vec<Vec<Option<f64>>> = (0..200)
            .map(|i| vec![Some(f64::from(i * 37 % 200)), Some(3.0), (i == 0).then_some(1.0)])
            .collect();
        let found = bootstrapped(&rows, 2000, 1, &|| ());
        let [low, high] = found[0].unwrap();
        let half = 1.96 * mean_and_std(&(0..200).map(f64::from).collect::<Vec<_>>()).1 / 200f64.sqrt();
        assert!((low - (99.5 - half)).abs() < 0.5 && (high - (99.5 + half)).abs() < 0.5, "{low} {high}");
        assert_eq!(found[1..], [None, None]);
        assert_eq!(bootstrapped(&[], 10, 1, &|| ()), []);
    }

    #[test]
    fn golden_wilsons_interval() {
        // Wilson (1927) with z = 1.96, as in tables: 8 of 10
        let [low, high] = wilson(8, 10);
        assert!((low - 0.490_162).abs() < 1e-5 && (high - 0.943_318).abs() < 1e-5, "{low} {high}");
        assert_eq!([wilson(0, 10)[0], wilson(10, 10)[1]], [0.0, 1.0]);
    }

    #[test]
    fn closed_form_mean_and_sample_deviation() {
        let (mean, std) = mean_and_std(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!(mean, 5.0);
        assert!((std - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn closed_form_moments_are_those_of_all_values_at_once() {
        let values: Vec<f64> = (0..100).map(|i| 1e6 + f64::from(i * i % 37)).collect();
        let mut moments = Moments::default();
        values.iter().for_each(|v| moments.add(*v, *v));
        let (mean, std) = mean_and_std(&values);
        assert!((moments.mean - mean).abs() < 1e-9 && (moments.std().unwrap() - std).abs() < 1e-9);
    }

    #[test]
    fn golden_the_interval_is_students() {
        // 1 to 5: mean 3, std 1.5811, t(0.975, 4) = 2.7764
        let mut moments = Moments::default();
        (1..=5).map(f64::from).for_each(|v| moments.add(v, v));
        let [lower, upper] = moments.estimate(true).unwrap().interval.unwrap();
        assert!((lower - 1.03676).abs() < 1e-4 && (upper - 4.96324).abs() < 1e-4, "{lower} {upper}");
    }
}

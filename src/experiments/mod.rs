//! One file per claim or table: what the paper says, our run, side by side. Episodes run in parallel; results are ordered by index, so
//! that every figure is the same for any number of threads.

pub mod contacts;
pub mod cycles;
pub mod cycles_physical;
pub mod fit;
pub mod h1;
pub mod h2;
pub mod h2_physical;
pub mod h3;
pub mod paper;
pub mod regress;
pub mod report;
pub mod sweep;
pub mod table;

use crate::math;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Called once for every unit of work that is done, from any thread.
pub type OnDone<'a> = &'a (dyn Fn() + Sync);

/// `work(0..n)` on all threads of the current pool, results in order.
fn in_parallel<T: Send>(n: usize, on_done: OnDone, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    (0..n)
        .into_par_iter()
        .map(|i| {
            let result = work(i);
            on_done();
            result
        })
        .collect()
}

/// Mean and sample standard deviation (n - 1); NaN where there are too few values.
pub fn mean_and_std(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| math::squared(v - mean)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

/// Two-sided p-value of the paired t-test that `a - b` has mean 0: `None` for fewer than two pairs, 1 if all pairs are equal.
pub fn paired_p_value(a: &[f64], b: &[f64]) -> Option<f64> {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let (mean, std) = mean_and_std(&differences);
    p_value_of_mean(mean, std, differences.len() as f64)
}

/// Two-sided p-value of the t-test that `n` values with this mean and sample standard deviation have mean 0: `None` for fewer than two, 1 if
/// all are 0.
fn p_value_of_mean(mean: f64, std: f64, n: f64) -> Option<f64> {
    let distribution = StudentsT::new(0.0, 1.0, n - 1.0).ok()?;
    match (mean == 0.0, std == 0.0) {
        (true, true) => Some(1.0),
        (false, true) => Some(0.0),
        _ => Some(2.0 * distribution.sf((mean / (std / n.sqrt())).abs())),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn golden_a_paired_test_agrees_with_tables() {
        // differences 1, 2, 3, 4, 5: t = 3 / (1.5811 / sqrt 5) = 4.2426 with 4 degrees of freedom
        let p = super::paired_p_value(&[2.0, 4.0, 6.0, 8.0, 10.0], &[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert!((p - 0.013_236).abs() < 1e-6, "{p}");
        assert_eq!(super::paired_p_value(&[1.0, 1.0], &[1.0, 1.0]), Some(1.0));
        assert_eq!(super::paired_p_value(&[1.0], &[0.0]), None);
    }

    #[test]
    fn closed_form_mean_and_sample_deviation() {
        let (mean, std) = super::mean_and_std(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!(mean, 5.0);
        assert!((std - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
    }
}

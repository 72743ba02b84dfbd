//! One file per claim or table: what the paper says, our run, side by side. Episodes run in parallel; results are ordered by index, so
//! that every figure is the same for any number of threads.

pub mod cycles;
pub mod h1;
pub mod h2;
pub mod paper;

use rayon::prelude::*;

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
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

#[cfg(test)]
mod tests {
    #[test]
    fn closed_form_mean_and_sample_deviation() {
        let (mean, std) = super::mean_and_std(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!(mean, 5.0);
        assert!((std - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
    }
}

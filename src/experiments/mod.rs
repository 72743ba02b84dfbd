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
pub mod statistics;
pub mod sweep;
pub mod table;

use crate::episode::Summary;
use rayon::prelude::*;

/// Called once for every unit of work that is done, from any thread.
pub type OnDone<'a> = &'a (dyn Fn() + Sync);

/// The way that an episode went, to tell humans who make the same choices: first and last option, and how often it changed.
type Way = [u64; 3];

fn way(summary: &Summary) -> Way {
    [summary.first_option as u64, summary.last_option as u64, summary.changes.into()]
}

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

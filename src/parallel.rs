//! Work on all threads of the current pool, with results ordered by index: the same for any number of threads.

use rayon::prelude::*;

/// Called once for every unit of work that is done, from any thread.
pub type OnDone<'a> = &'a (dyn Fn() + Sync);

/// `work(0..n)` on all threads of the current pool, results in order.
pub(crate) fn in_parallel<T: Send>(n: usize, on_done: OnDone, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    (0..n)
        .into_par_iter()
        .map(|i| {
            let result = work(i);
            on_done();
            result
        })
        .collect()
}

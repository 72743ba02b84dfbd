//! Parallel work on the threads of the current pool. Results are ordered by index, so they do not depend on
//! the number of threads.

use rayon::prelude::*;

/// A callback that runs once for every finished unit of work, on any thread.
pub type OnDone<'a> = &'a (dyn Fn() + Sync);

/// The results of `work(0..n)` in index order, computed on all threads of the current pool.
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

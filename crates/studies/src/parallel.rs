//! Parallel work on the threads of the current pool. Results are ordered by index, so they do not depend on
//! the number of threads.

use rayon::prelude::*;
use std::sync::Mutex;

/// A callback that runs once for every finished unit of work, on any thread.
pub type OnDone<'a> = &'a (dyn Fn() + Sync);

/// The results of `work(0..n)` in index order, computed on all threads of the current pool.
pub fn in_parallel<T: Send>(n: usize, on_done: OnDone, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let results: Vec<_> = (0..n).map(|_| Mutex::new(None)).collect();
    for_each(n, &|i| {
        let result = work(i);
        *results[i].lock().expect("no other thread has it") = Some(result);
        on_done();
    });
    let result = |done: Mutex<Option<T>>| done.into_inner().ok().flatten();
    results.into_iter().map(|done| result(done).expect("all work is done")).collect()
}

/// Compiled once: rayon's code is long.
fn for_each(n: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..n).into_par_iter().for_each(work);
}

//! Parallel work whose results are delivered in order, within a bounded window.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The shared state of the threads.
struct OrderedState<T, W, E> {
    /// The next number to work on.
    next: u64,
    /// The next number to write.
    due: u64,
    /// Results that wait for earlier ones.
    waiting: BTreeMap<u64, T>,
    write: W,
    failed: Option<E>,
    is_over: bool,
}

struct Shared<T, W, E> {
    /// How far results may be ahead of the first missing one.
    window: u64,
    state: Mutex<OrderedState<T, W, E>>,
    changed: Condvar,
}

/// Runs `work` for every number on all threads of the current pool. `write` receives the results in order, on
/// any thread, one or more at a time, one call at a time. At most `window` results wait.
///
/// # Errors
/// The first error of `write`. It ends the work.
pub(super) fn in_order<T: Send, E: Send, W: FnMut(Vec<T>) -> Result<(), E> + Send>(
    numbers: Range<u64>,
    window: u64,
    work: impl Fn(u64) -> T + Sync,
    write: W,
) -> Result<(), E> {
    let state = OrderedState {
        next: numbers.start,
        due: numbers.start,
        waiting: BTreeMap::new(),
        write,
        failed: None,
        is_over: false,
    };
    let shared = Shared { window, state: Mutex::new(state), changed: Condvar::new() };
    rayon::broadcast(|_| {
        let _end = EndOnPanic(&shared);
        while let Some(number) = shared.take(numbers.end) {
            shared.give(number, work(number));
        }
    });
    let state = shared.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    state.failed.map_or(Ok(()), Err)
}

impl<T, W, E> Shared<T, W, E> {
    fn lock(&self) -> MutexGuard<'_, OrderedState<T, W, E>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next number to work on. Waits until the window reaches it.
    fn take(&self, end: u64) -> Option<u64> {
        let mut state = self.lock();
        while !state.is_over && state.next < end && state.next >= state.due + self.window {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let number = state.next;
        state.next += 1;
        (!state.is_over && number < end).then_some(number)
    }
}

impl<T, E, W: FnMut(Vec<T>) -> Result<(), E>> Shared<T, W, E> {
    /// Stores a result, and writes the results that are next in order.
    fn give(&self, number: u64, result: T) {
        let mut state = self.lock();
        let OrderedState { due, waiting, write, failed, is_over, .. } = &mut *state;
        waiting.insert(number, result);
        let mut results = Vec::new();
        while let Some(result) = waiting.remove(due) {
            results.push(result);
            *due += 1;
        }
        if !results.is_empty() && !*is_over {
            if let Err(error) = write(results) {
                *failed = Some(error);
                *is_over = true;
            }
            self.changed.notify_all();
        }
    }
}

/// Ends the work if a thread panics: the other threads would otherwise wait for its result for ever.
struct EndOnPanic<'a, T, W, E>(&'a Shared<T, W, E>);

impl<T, W, E> Drop for EndOnPanic<'_, T, W, E> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().is_over = true;
            self.0.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const WINDOW: u64 = 1024;

    fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
    }

    #[test]
    fn results_are_written_in_order_for_any_slow_thread() {
        for threads in [1, 4] {
            let mut written = Vec::new();
            let slow = |n: u64| {
                if n.is_multiple_of(97) {
                    std::thread::sleep(Duration::from_millis(5));
                }
                n
            };
            let write = |results: Vec<u64>| {
                written.extend(results);
                Ok::<(), ()>(())
            };
            on_threads(threads, || in_order(5..4000, WINDOW, slow, write)).unwrap();
            assert!(written.iter().copied().eq(5..4000), "{threads} threads");
        }
    }

    #[test]
    fn no_thread_runs_further_ahead_than_the_window() {
        let (furthest, first_is_done) = (Mutex::new(0), Mutex::new(false));
        let work = |n: u64| {
            if n == 0 {
                std::thread::sleep(Duration::from_millis(300));
                *first_is_done.lock().unwrap() = true;
            } else if !*first_is_done.lock().unwrap() {
                let mut furthest = furthest.lock().unwrap();
                *furthest = n.max(*furthest);
            }
        };
        on_threads(3, || in_order(0..20_000, WINDOW, work, |_| Ok::<(), ()>(()))).unwrap();
        assert_eq!(*furthest.lock().unwrap(), WINDOW - 1);
    }

    #[test]
    fn an_error_ends_the_work() {
        let mut written = 0;
        let write = |results: Vec<u64>| {
            written += results.len();
            if written >= 10 { Err("full") } else { Ok(()) }
        };
        let error = on_threads(2, || in_order(0..u64::MAX, WINDOW, |n| n, write)).unwrap_err();
        assert_eq!(error, "full");
    }

    #[test]
    fn a_panic_does_not_leave_the_others_waiting() {
        let work = |n: u64| {
            assert!(n != 7, "on purpose");
        };
        let ended = std::panic::catch_unwind(|| {
            on_threads(2, || in_order(0..100_000, WINDOW, work, |_| Ok::<(), ()>(())))
        });
        assert!(ended.is_err());
    }
}

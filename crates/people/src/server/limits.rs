//! What bounds a server: how often something may happen, how much it prints, how much it holds.

use std::collections::VecDeque;
use std::fmt::Display;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The interval in which events are counted.
const INTERVAL: Duration = Duration::from_secs(60);
/// The largest number of lines that a server prints in an interval.
const MAX_LINES: usize = 30;
/// The largest number of bytes of bodies that a server holds at once.
const MAX_BODIES: usize = 128 << 20;

/// At most so many events in a minute.
pub(super) struct Rate {
    most: usize,
    times: Mutex<VecDeque<Instant>>,
}

impl Rate {
    pub fn new(most: usize) -> Self {
        Self { most, times: Mutex::new(VecDeque::new()) }
    }

    fn recent(&self, now: Instant) -> MutexGuard<'_, VecDeque<Instant>> {
        let mut times = locked(&self.times);
        while times.front().is_some_and(|first| now.duration_since(*first) > INTERVAL) {
            times.pop_front();
        }
        times
    }

    /// Whether there were as many as there may be in the minute before `now`.
    pub fn is_full(&self, now: Instant) -> bool {
        self.recent(now).len() >= self.most
    }

    /// Counts an event, unless there were as many as there may be; whether it was counted.
    pub fn take(&self, now: Instant) -> bool {
        let mut times = self.recent(now);
        let has_room = times.len() < self.most;
        if has_room {
            times.push_back(now);
        }
        has_room
    }
}

/// What a server prints of requests that it refuses: so many lines in a minute, and the number of the others.
pub(super) struct Log {
    rate: Rate,
    unsaid: AtomicU64,
}

impl Log {
    pub fn new() -> Self {
        Self { rate: Rate::new(MAX_LINES), unsaid: AtomicU64::new(0) }
    }

    pub fn line(&self, line: impl Display) {
        if self.rate.take(Instant::now()) {
            self.say_unsaid();
            eprintln!("{line}");
        } else {
            self.unsaid.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Says how many lines were not printed.
    pub fn say_unsaid(&self) {
        let unsaid = self.unsaid.swap(0, Ordering::Relaxed);
        if unsaid > 0 {
            eprintln!("refused: {unsaid} more, of which no line is printed");
        }
    }
}

/// The bytes of bodies that a server holds.
#[derive(Default)]
pub(super) struct Held(AtomicUsize);

/// The bytes of a body, for as long as they are held.
pub(super) struct Hold<'a>(&'a Held, usize);

impl Held {
    pub fn hold(&self) -> Hold<'_> {
        Hold(self, 0)
    }
}

impl Hold<'_> {
    /// Whether there is room for more bytes, which are then held.
    pub fn add(&mut self, bytes: usize) -> bool {
        let before = self.0.0.fetch_add(bytes, Ordering::Relaxed);
        self.1 += bytes;
        before + bytes <= MAX_BODIES
    }
}

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        self.0.0.fetch_sub(self.1, Ordering::Relaxed);
    }
}

pub(super) fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_has_room_again_after_a_minute() {
        let (rate, now) = (Rate::new(2), Instant::now());
        let at = |seconds| now + Duration::from_secs(seconds);
        assert!(rate.take(at(0)) && rate.take(at(30)) && !rate.take(at(59)) && rate.is_full(at(60)));
        assert!(!rate.is_full(at(61)) && rate.take(at(61)) && !rate.take(at(90)) && rate.take(at(91)));
    }

    #[test]
    fn bodies_are_held_until_they_are_dropped() {
        let held = Held::default();
        let mut first = held.hold();
        assert!(first.add(MAX_BODIES));
        assert!(!held.hold().add(1));
        drop(first);
        assert!(held.hold().add(1));
    }
}

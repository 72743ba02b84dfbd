//! Ctrl-C, SIGTERM and SIGHUP as a request to stop the run.

use super::output::Failure;
use anyhow::anyhow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The interval between two looks at the flag.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A flag that these signals set.
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Catches the signals: the first one stops the episode, so that its files are finished. A second one ends
    /// the program.
    pub fn caught() -> Result<Self, Failure> {
        let interrupt = Self(Arc::default());
        let flag = Arc::clone(&interrupt.0);
        let stop = move || {
            // a second signal does not wait for the files
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        ctrlc::set_handler(stop)
            .map_err(|error| Failure::Output(anyhow!(error).context("Ctrl-C cannot be caught")))?;
        Ok(interrupt)
    }

    /// The flag itself, for work that looks at it.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Waits for such a signal.
    pub fn wait(&self) {
        while !self.is_set() {
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Whether there was such a signal.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

//! Ctrl-C as a request to stop the run.

use super::output::Failure;
use anyhow::anyhow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that Ctrl-C sets.
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Catches Ctrl-C if `is_to_be_finished`: it then stops the episode, so that its files are finished. A
    /// second Ctrl-C ends the program.
    pub fn caught_if(is_to_be_finished: bool) -> Result<Self, Failure> {
        let interrupt = Self(Arc::default());
        if is_to_be_finished {
            let flag = Arc::clone(&interrupt.0);
            let stop = move || {
                // a second Ctrl-C does not wait for the files
                if flag.swap(true, Ordering::Relaxed) {
                    std::process::exit(130);
                }
            };
            ctrlc::set_handler(stop)
                .map_err(|error| Failure::Output(anyhow!(error).context("Ctrl-C cannot be caught")))?;
        }
        Ok(interrupt)
    }

    /// Whether Ctrl-C was pressed.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

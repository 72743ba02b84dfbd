//! Whether the user has asked a run to stop.

use super::output::Failure;
use anyhow::anyhow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user wants the run to stop.
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on Ctrl-C stops the episode, not the program, if there is something to finish.
    pub fn caught_if(is_to_be_finished: bool) -> Result<Self, Failure> {
        let interrupt = Self(Arc::default());
        if is_to_be_finished {
            let flag = Arc::clone(&interrupt.0);
            let stop = move || {
                // one who asks twice does not want to wait
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

//! The arguments that several claims share.

use super::super::output::{Failure, Progress};
use anyhow::Context;
use clap::Args;
use cocarry_studies::parallel::OnDone;

/// The arguments of commands that run many episodes.
#[derive(Args, Debug)]
pub(in super::super) struct Common {
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Number of threads [default: all cores]; the figures do not depend on it
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
}

impl Common {
    /// Runs the work on the number of threads given.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        let threads = self.threads.map_or(0, |n| n as usize);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(pool.context("threads").map_err(Failure::Output)?.install(work))
    }

    /// Runs work of so many `units` on the number of threads given. A bar named `what` shows how many are done.
    pub fn with_progress<T: Send>(
        &self,
        units: usize,
        what: &str,
        work: impl FnOnce(OnDone) -> T + Send,
    ) -> Result<T, Failure> {
        let bar = Progress::new(units, what);
        let done = self.on_threads(|| work(&|| bar.step()))?;
        bar.finish();
        Ok(done)
    }
}

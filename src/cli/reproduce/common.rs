//! What several claims take as arguments.

use super::super::output::Failure;
use anyhow::Context;
use clap::Args;

/// What commands that run many episodes take.
#[derive(Args, Debug)]
pub(in super::super) struct Common {
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Threads to use [default: all cores]; the figures do not depend on it
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
}

impl Common {
    /// Runs the work on as many threads as asked for.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        let threads = self.threads.map_or(0, |n| n as usize);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(pool.context("threads").map_err(Failure::Output)?.install(work))
    }
}

//! The audit of results: a sample of the episodes, run again and compared.

use super::{ClusterError, Job};
use crate::parallel::OnDone;
use crate::study::{Difference as RowDifference, Shard, Study, different};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BTreeSet;

/// An episode whose results differ when it is run again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The episode, and the values that differ.
    pub row: RowDifference,
    /// The shard that had it.
    pub shard: u64,
    /// The machine that ran it, as noted by the shard.
    pub node: String,
}

/// A sample of the episodes of gathered results.
#[derive(Debug)]
pub struct Sample<'a> {
    job: &'a Job,
    study: Study,
    episodes: BTreeSet<u64>,
}

/// Draws a sample of the episodes of a job: of every shard a `share` (0 to 1), at least one episode. The same
/// `seed` gives the same sample.
///
/// # Errors
/// [`ClusterError`], where the study has changed.
pub fn sample(job: &Job, share: f64, seed: u64) -> Result<Sample<'_>, ClusterError> {
    let study = job.study()?;
    let episodes = draw(&study, job.description().shards, share, seed);
    Ok(Sample { job, study, episodes })
}

impl Sample<'_> {
    /// The number of episodes.
    pub fn episodes(&self) -> usize {
        self.episodes.len()
    }

    /// Runs the episodes again, on all threads of the current pool, and compares the bytes of their rows with
    /// the gathered results. Returns those that differ.
    ///
    /// # Errors
    /// [`ClusterError`], where the results cannot be read, or are of another study or arithmetic.
    pub fn compare(&self, on_done: OnDone) -> Result<Vec<Difference>, ClusterError> {
        let rows = different(&self.study, self.job.results(), &self.episodes, on_done)?;
        let with_node = |row: RowDifference| {
            let (shard, node) = self.job.node_of(row.episode).unwrap_or((0, "unknown".to_owned()));
            Difference { row, shard, node }
        };
        Ok(rows.into_iter().map(with_node).collect())
    }
}

/// The episodes to run again, in order.
fn draw(study: &Study, shards: u64, share: f64, seed: u64) -> BTreeSet<u64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut sample = BTreeSet::new();
    for number in 1..=shards {
        let episodes = Shard { number, of: shards }.episodes(study.episodes());
        let size = episodes.end - episodes.start;
        let wanted = ((share * size as f64).ceil() as u64).clamp(size.min(1), size);
        if wanted == size {
            sample.extend(episodes);
            continue;
        }
        let wanted = sample.len() as u64 + wanted;
        while (sample.len() as u64) < wanted {
            sample.insert(rng.random_range(episodes.clone()));
        }
    }
    sample
}

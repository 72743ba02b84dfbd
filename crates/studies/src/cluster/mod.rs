//! A study on a cluster: its shards as tasks of the cluster's own scheduler, and the results that come back,
//! checked.
//!
//! A [`Job`] is a folder next to the results, which all tasks and commands share through the file system: its
//! description, the script of a task, the shards' results and the scheduler's logs. A task needs only
//! [`Job::run_shard`]. [`slurm`] submits tasks and asks after them. [`sample`] runs a sample of the episodes
//! again.

mod audit;
mod error;
mod job;
pub mod slurm;
mod status;

pub use audit::{Difference, Sample, sample};
pub use error::ClusterError;
pub use job::{Array, Description, Job, Progress, with_methods};
pub use status::{ShardState, states};

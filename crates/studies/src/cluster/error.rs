//! Errors of a study on a cluster.

use crate::study::SweepError;
use cocarry_output::output_file::OutputError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a command for a cluster was refused, or failed.
#[derive(Debug, Error)]
pub enum ClusterError {
    /// The study, or a file of its results.
    #[error(transparent)]
    Study(#[from] SweepError),
    /// A file of the job cannot be read, or is not what its name says.
    #[error(transparent)]
    File(#[from] cocarry::Error),
    /// A file of the job cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A folder of the job cannot be created or removed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder, or the file in it.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no job for these results.
    #[error(
        "{}: there is no such job; `cocarry cluster slurm STUDY -o {}` creates it",
        folder.display(), results.display()
    )]
    NoJob {
        /// The results asked for.
        results: PathBuf,
        /// The folder that their job would have.
        folder: PathBuf,
    },
    /// There is a job for these results already.
    #[error(
        "{}: there is a job for these results already; see `cocarry cluster status`, or start again with --overwrite",
        folder.display()
    )]
    Exists {
        /// The job's folder.
        folder: PathBuf,
    },
    /// Tasks of the job are in the queue.
    #[error(
        "{}: {tasks} tasks of this job wait or run; cancel them first, with: scancel {ids}",
        folder.display()
    )]
    InQueue {
        /// The job's folder.
        folder: PathBuf,
        /// The number of tasks.
        tasks: usize,
        /// The arrays' identifiers, separated by spaces.
        ids: String,
    },
    /// A number of shards that the job cannot have, or a shard that it does not have.
    #[error("shard {number}: the job in {} has shards 1 to {shards}", folder.display())]
    NoShard {
        /// The shard asked for.
        number: u64,
        /// The job's folder.
        folder: PathBuf,
        /// The number of shards.
        shards: u64,
    },
    /// Another version of the program made the job.
    #[error(
        "{}: version {made} of cocarry made this job, and this is version {this}; use one version for all tasks",
        folder.display()
    )]
    OtherVersion {
        /// The job's folder.
        folder: PathBuf,
        /// The version that made it.
        made: String,
        /// This version.
        this: String,
    },
    /// The study has changed.
    #[error(
        "{}: the study, a world or a robot has changed since the job was made (its digest was {made} and is {now}); \
         undo the change, or start again with --overwrite",
        study.display()
    )]
    Changed {
        /// The study file.
        study: PathBuf,
        /// The digest when the job was made.
        made: String,
        /// The digest now.
        now: String,
    },
    /// This machine's arithmetic has other last bits.
    #[error(
        "{node}: the arithmetic of this machine has other last bits (stamp {found}) than that of the machine that made \
         the job (stamp {made}); leave such nodes out, for example with: --sbatch \"--exclude={node}\""
    )]
    OtherArithmetic {
        /// This machine.
        node: String,
        /// Its stamp.
        found: String,
        /// The job's stamp.
        made: String,
    },
    /// An option of `sbatch` that the job sets itself.
    #[error("--sbatch: `{option}` is set by cocarry; it must be another option of sbatch")]
    OwnOption {
        /// The option.
        option: String,
    },
    /// The scheduler's program cannot be started.
    #[error(
        "{program}: cannot be started ({source}); run this where Slurm's commands are, or use --no-submit and submit the \
         script yourself"
    )]
    NoScheduler {
        /// The program, such as `sbatch`.
        program: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The scheduler refused.
    #[error("{command}: {said}")]
    Scheduler {
        /// The command.
        command: String,
        /// What it said.
        said: String,
    },
}

impl ClusterError {
    /// Whether an output could not be written, as opposed to an input that is wrong.
    pub fn is_about_writing(&self) -> bool {
        match self {
            Self::Study(error) => error.is_about_writing(),
            Self::Output(error) => !error.is_refusal(),
            Self::Folder { .. } => true,
            _ => false,
        }
    }
}

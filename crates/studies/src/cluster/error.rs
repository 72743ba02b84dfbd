//! Errors of a study on a cluster.

use crate::study::SweepError;
use cocarry::error::{Error, Place};
use cocarry::suggestion::shell_word;
use cocarry_output::output_file::OutputError;
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a command for a cluster was refused, or failed.
#[derive(Debug, thiserror::Error)]
pub enum ClusterError {
    /// The study, or a file of its results.
    #[error(transparent)]
    Study(#[from] SweepError),
    /// A job, a file of it, an argument or the scheduler.
    #[error(transparent)]
    Refused(#[from] Error),
    /// A file of the job cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A folder of the job cannot be created or removed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder, or the file in it.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

/// The sentences.
impl ClusterError {
    fn at(path: &Path, sentence: fmt::Arguments) -> Self {
        Self::Refused(Error::at(Place::file(path.display().to_string()), sentence))
    }

    /// Results without a job; `folder` is where it would be.
    pub(super) fn no_job(results: PathBuf, folder: PathBuf) -> Self {
        let results = shell_word(&results.display().to_string());
        Self::at(
            &folder,
            format_args!("there is no such job; `cocarry cluster slurm STUDY -o {results}` creates it"),
        )
    }

    /// Results with a job already.
    pub(super) fn exists(folder: PathBuf) -> Self {
        let sentence = format_args!(
            "there is a job for these results already; see `cocarry cluster status`, or start again with --overwrite"
        );
        Self::at(&folder, sentence)
    }

    /// A job whose tasks are in the queue; `ids` are the identifiers of its arrays.
    pub fn in_queue(folder: PathBuf, tasks: usize, ids: String) -> Self {
        let sentence =
            format_args!("{tasks} tasks of this job wait or run; cancel them first, with: scancel {ids}");
        Self::at(&folder, sentence)
    }

    /// A shard that the job does not have.
    pub(super) fn no_shard(number: u64, folder: PathBuf, shards: u64) -> Self {
        let folder = folder.display();
        Self::Refused(Error::new(format!("shard {number}: the job in {folder} has shards 1 to {shards}")))
    }

    /// A job that another version of the program made.
    pub(super) fn other_version(folder: PathBuf, made: String, this: String) -> Self {
        let sentence = format_args!(
            "version {made} of cocarry made this job, and this is version {this}; use one version for all tasks"
        );
        Self::at(&folder, sentence)
    }

    /// A study that has changed since its job was made, by its digests.
    pub(super) fn changed(study: PathBuf, made: String, now: String) -> Self {
        let sentence = format_args!(
            "the study, a world or a robot has changed since the job was made (its digest was {made} and is {now}); undo the change, or start again with --overwrite"
        );
        Self::at(&study, sentence)
    }

    /// A machine whose arithmetic has other last bits, by their stamps.
    pub(super) fn other_arithmetic(node: String, found: String, made: String) -> Self {
        Self::Refused(Error::new(format!(
            "{node}: the arithmetic of this machine has other last bits (stamp {found}) than that of the machine that made the job (stamp {made}); leave such nodes out, for example with: --sbatch \"--exclude={node}\""
        )))
    }

    /// An option of `sbatch` that the job sets itself.
    pub(super) fn set_by_cocarry(option: String) -> Self {
        let sentence = format!("--sbatch: `{option}` is set by cocarry; it must be another option of sbatch");
        Self::Refused(Error::new(sentence))
    }

    /// A program of the scheduler, such as `sbatch`, that cannot be started.
    pub(super) fn no_scheduler(program: &str, source: std::io::Error) -> Self {
        Self::Refused(Error::new(format!(
            "{program}: cannot be started ({source}); run this where Slurm's commands are, or use --no-submit and submit the script yourself"
        )))
    }

    /// A command that the scheduler refused.
    pub(super) fn scheduler(command: String, said: String) -> Self {
        Self::Refused(Error::new(format!("{command}: {said}")))
    }

    /// Whether an output could not be written, as opposed to an input that is wrong.
    pub fn is_about_writing(&self) -> bool {
        match self {
            Self::Study(error) => error.is_about_writing(),
            Self::Output(error) => !error.is_refusal(),
            Self::Folder { .. } => true,
            Self::Refused(_) => false,
        }
    }
}

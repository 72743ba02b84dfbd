//! What can be wrong with a file of runs, each case with its file, line, run and key.

use super::FORMAT;
use crate::located::FileError;
use thiserror::Error;

/// Why a baseline was refused.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// The file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] FileError),
    /// There are no runs.
    #[error("{file}: no runs; write each as a table [[run]], with the keys of `cocarry run`'s arguments")]
    NoRuns {
        /// The file.
        file: String,
    },
    /// A key that does not belong.
    #[error("{file}:{line}: {place}: unknown key `{key}`; expected {expected}")]
    Key {
        /// The file.
        file: String,
        /// Line of the key.
        line: usize,
        /// The table that it stands in.
        place: String,
        /// The key.
        key: String,
        /// The keys allowed.
        expected: String,
    },
    /// A value that does not belong.
    #[error("{file}:{line}: {place}: {key} = {value}; it must be {expected}")]
    Value {
        /// The file.
        file: String,
        /// Line of the value.
        line: usize,
        /// The table that it stands in.
        place: String,
        /// The key.
        key: String,
        /// The value found.
        value: String,
        /// The values allowed.
        expected: String,
    },
    /// Two runs of one name.
    #[error("{file}:{line}: run `{name}` is there twice; tell them apart by `name`")]
    Duplicate {
        /// The file.
        file: String,
        /// Line of the second run.
        line: usize,
        /// The name.
        name: String,
    },
    /// A run of which nothing has been recorded.
    #[error("{file}:{line}: run `{name}` has no figures yet; record them: cocarry regress record {file}")]
    NotRecorded {
        /// The file.
        file: String,
        /// Line of the run.
        line: usize,
        /// Its name.
        name: String,
    },
    /// Figures of an earlier format.
    #[error(
        "{file}: its figures are of format {found}, which did not have all that format {FORMAT} compares (since 2: the openings walked; since 3: all figures, under the names of `cocarry run --json`); record them anew: cocarry regress record {file}"
    )]
    Older {
        /// The file.
        file: String,
        /// Its format.
        found: i64,
    },
}

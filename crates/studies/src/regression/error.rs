//! Errors of baseline files, each with its file, line, run and key.

use super::FORMAT;
use thiserror::Error;

/// Why a baseline was refused.
#[derive(Debug, Error)]
pub enum BaselineError {
    /// The file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] cocarry::Error),
    /// The file has no runs.
    #[error("{file}: no runs; write each as a table [[run]], with the keys of `cocarry run`'s arguments")]
    NoRuns {
        /// The file.
        file: String,
    },
    /// A key is unknown.
    #[error("{file}:{line}: {place}: unknown key `{key}`; expected one of: {expected}")]
    Key {
        /// The file.
        file: String,
        /// Line of the key.
        line: usize,
        /// The table with the key.
        place: String,
        /// The key.
        key: String,
        /// The keys allowed.
        expected: String,
    },
    /// A value is not allowed.
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
    /// Two runs have the same name.
    #[error("{file}:{line}: duplicate run `{name}`; give each run its own `name`")]
    Duplicate {
        /// The file.
        file: String,
        /// Line of the second run.
        line: usize,
        /// The name.
        name: String,
    },
    /// A run has no recorded figures.
    #[error("{file}:{line}: run `{name}` has no figures yet; record them: cocarry regress record {file}")]
    NotRecorded {
        /// The file.
        file: String,
        /// Line of the run.
        line: usize,
        /// Its name.
        name: String,
    },
    /// The figures have an earlier format.
    #[error(
        "{file}: its figures have format {found}, which lacks some of format {FORMAT} (2 added the openings walked; 3 has all figures, with the keys of `cocarry run --json`); record them again: cocarry regress record {file}"
    )]
    Older {
        /// The file.
        file: String,
        /// Its format.
        found: i64,
    },
}

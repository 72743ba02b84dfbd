//! What can go wrong with recordings, each case with the file, the place and what would be right.

use crate::output_file::OutputError;
use crate::scenario::ScenarioError;
use thiserror::Error;

/// A recording that cannot be written.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be made, or not get its name.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What the run is made of cannot be written down.
    #[error("{file}: would not say what it is made of")]
    Scenario {
        /// The file.
        file: String,
        /// Why.
        source: ScenarioError,
    },
    /// Writing went wrong.
    #[error("{file}: cannot be written on; what was written until then can be read by `cocarry recover`")]
    Write {
        /// The file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
}

impl RecordingError {
    /// The same error about a file of which nothing is left.
    pub(super) fn begun(self) -> Self {
        match self {
            Self::Write { file, source } => OutputError::Write { file: file.into(), source }.into(),
            other => other,
        }
    }
}

/// A recording that cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The system cannot read it.
    #[error("{file}: cannot be read")]
    Read {
        /// The file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// It does not begin as MCAP files do.
    #[error("{file}: is no MCAP file: it must begin with the bytes 89 4d 43 41 50 30 0d 0a")]
    NotMcap {
        /// The file.
        file: String,
    },
    /// It ends too early.
    #[error("{file}: is cut at byte {offset}, in {what}; `cocarry recover` saves what is there")]
    Cut {
        /// The file.
        file: String,
        /// Where it ends.
        offset: u64,
        /// In what.
        what: &'static str,
    },
    /// A record or chunk longer than any that is written.
    #[error("{file}: {what} at byte {offset} would be {length} bytes long; at most {limit} are read")]
    TooLong {
        /// The file.
        file: String,
        /// Where it begins.
        offset: u64,
        /// What is too long.
        what: &'static str,
        /// How long it says that it is.
        length: u64,
        /// How long it may be.
        limit: u64,
    },
    /// Something in it is not as it should be.
    #[error("{file}: {what} at byte {offset}: {why}")]
    Damaged {
        /// The file.
        file: String,
        /// Where the record begins.
        offset: u64,
        /// What is damaged.
        what: &'static str,
        /// What is wrong and what would be right.
        why: String,
    },
    /// What it says that it was made of is no scenario.
    #[error("{file}: its attachment scenario.toml")]
    Scenario {
        /// The file.
        file: String,
        /// Why.
        source: ScenarioError,
    },
    /// It lacks something that is asked for.
    #[error("{file}: {what}")]
    Lacks {
        /// The file.
        file: String,
        /// What it lacks, and what it has.
        what: String,
    },
}

impl ReadError {
    /// What is wrong and where, without the file's name.
    pub(super) fn place(&self) -> String {
        let file = match self {
            Self::Read { file, .. }
            | Self::NotMcap { file }
            | Self::Cut { file, .. }
            | Self::TooLong { file, .. }
            | Self::Damaged { file, .. }
            | Self::Scenario { file, .. }
            | Self::Lacks { file, .. } => file,
        };
        self.to_string().replacen(&format!("{file}: "), "", 1)
    }

    /// Whether reading may go on behind what is wrong: the rest of the file is framed.
    pub fn is_local(&self) -> bool {
        matches!(self, Self::Damaged { .. })
    }
}

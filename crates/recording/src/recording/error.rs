//! Errors of recordings, each with the file, the place and the expected value.

use cocarry_output::output_file::OutputError;
use thiserror::Error;

/// The error of a recording that cannot be written.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be created or renamed.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scenario cannot be written into the recording.
    #[error("{file}: the scenario cannot be written")]
    Scenario {
        /// The file.
        file: String,
        /// The reason.
        source: cocarry::Error,
    },
    /// Writing failed.
    #[error("{file}: cannot be written on; `cocarry recover` saves what was written before")]
    Write {
        /// The file.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
}

impl RecordingError {
    /// The same error, for a file that was removed.
    pub(super) fn begun(self) -> Self {
        match self {
            Self::Write { file, source } => OutputError::write(file.as_ref(), source).into(),
            other => other,
        }
    }
}

/// The error of a recording that cannot be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The system cannot read the file.
    #[error("{file}: cannot be read")]
    Read {
        /// The file.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file does not begin like an MCAP file.
    #[error("{file}: is not an MCAP file: it must begin with the bytes 89 4d 43 41 50 30 0d 0a")]
    NotMcap {
        /// The file.
        file: String,
    },
    /// The file ends too early.
    #[error("{file}: is cut at byte {offset}, in {what}; `cocarry recover` saves the complete messages")]
    Cut {
        /// The file.
        file: String,
        /// The offset of its end.
        offset: u64,
        /// The part that is incomplete.
        what: String,
    },
    /// A record or chunk is longer than the limit.
    #[error("{file}: {what} at byte {offset} would be {length} bytes long; at most {limit} are read")]
    TooLong {
        /// The file.
        file: String,
        /// The offset of its beginning.
        offset: u64,
        /// The part that is too long.
        what: &'static str,
        /// Its length according to the file, bytes.
        length: u64,
        /// The limit, bytes.
        limit: u64,
    },
    /// A record is damaged.
    #[error("{file}: {what} at byte {offset}: {why}")]
    Damaged {
        /// The file.
        file: String,
        /// The offset of the record.
        offset: u64,
        /// The damaged record.
        what: &'static str,
        /// The fault, and the expected value.
        why: String,
    },
    /// Its attachment scenario.toml is not a valid scenario.
    #[error("{file}: its attachment scenario.toml")]
    Scenario {
        /// The file.
        file: String,
        /// Why.
        source: cocarry::Error,
    },
    /// The recording lacks a requested part.
    #[error("{file}: {what}")]
    Lacks {
        /// The file.
        file: String,
        /// The part that is missing, and those that exist.
        what: String,
    },
}

impl ReadError {
    /// The fault and its place, without the file's name.
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

    /// Whether reading may continue after the fault, since the rest of the file is framed.
    pub fn is_local(&self) -> bool {
        matches!(self, Self::Damaged { .. })
    }
}

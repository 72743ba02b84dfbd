//! Why the store does not do what is asked.

use std::path::PathBuf;

/// Why the store does not do what is asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The request is refused; the store is as before.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The file cannot be read or written.
    #[error("{file}: cannot be read or written")]
    Database {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: rusqlite::Error,
    },
    /// The file is not one of this program, or cannot be used.
    #[error("{file}: {sentence}")]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong, and what would be right.
        sentence: String,
    },
}

/// A request that is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// A key, a digest, a number or a name has not the form that it must have.
    #[error("{0}")]
    Form(&'static str),
    /// No session has this key.
    #[error("this session is not known, or was removed")]
    Unknown,
    /// The body is not the one of the digest.
    #[error("the body does not have this digest: it was damaged on its way")]
    Damaged,
    /// Another chunk has this key.
    #[error("another chunk with this number is stored already")]
    OtherChunk,
    /// The session has ended.
    #[error("the session is finished; nothing can be added")]
    Finished,
    /// The session is too large.
    #[error("a session has at most 32 MiB and 20000 chunks")]
    TooMuch,
    /// As many participants as the study has have begun.
    #[error("the study has all its participants")]
    Full,
    /// The person has begun before, with another key.
    #[error("you have begun this study already, in another browser or window; go on there")]
    BegunBefore,
    /// The person has begun before, with another version of the study.
    #[error("the study has changed since you began it; please tell those who run it")]
    Changed,
    /// What the session has is not what the digest says.
    #[error("not everything has arrived")]
    NotWhole,
}

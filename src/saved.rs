//! The saved state of one part of an episode in a snapshot: bytes that only the part itself can read.

use crate::cbor;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The saved state of a human, a robot policy or a team, as CBOR. Empty for parts without memory.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Saved(#[serde(with = "serde_bytes")] Vec<u8>);

impl From<RestoreError> for crate::error::Error {
    fn from(error: RestoreError) -> Self {
        Self::new(error.to_string())
    }
}

/// A saved state that does not belong to the part that should restore it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the state belongs to another episode: its {part} does not match")]
pub struct RestoreError {
    /// The part whose state does not match.
    pub part: &'static str,
}

impl Saved {
    /// The bytes of a state. Empty for a type that cannot be written as CBOR; [`Saved::read`] then refuses
    /// it.
    pub fn of<T: Serialize>(state: &T) -> Self {
        cbor::to_vec(state).map_or_else(|_| Self::default(), Self)
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// A saved state of these bytes, which [`Saved::read`] checks.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        Self(bytes.to_vec())
    }

    /// The state read back. The error calls it `part`.
    pub fn read<T: DeserializeOwned>(&self, part: &'static str) -> Result<T, RestoreError> {
        cbor::from_slice(&self.0).map_err(|_| RestoreError { part })
    }

    /// A check that nothing was saved, for parts without memory.
    pub fn is_empty(&self, part: &'static str) -> Result<(), RestoreError> {
        if self.0.is_empty() { Ok(()) } else { Err(RestoreError { part }) }
    }
}

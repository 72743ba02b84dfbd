//! What parts of an episode carry through snapshots: bytes that only the part itself understands.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The saved state of a human, a robot policy or a team, as CBOR. Empty for parts without a memory.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Saved(#[serde(with = "serde_bytes")] Vec<u8>);

/// A saved state that does not belong to the part that is to take it over.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the state is one of another episode: its {part} does not belong here")]
pub struct NotRestored {
    /// What does not belong.
    pub part: &'static str,
}

impl Saved {
    /// The bytes of a state; empty for a type that cannot be written as CBOR, which [`Saved::read`] then refuses.
    pub fn of<T: Serialize>(state: &T) -> Self {
        let mut bytes = Vec::new();
        match ciborium::into_writer(state, &mut bytes) {
            Ok(()) => Self(bytes),
            Err(_) => Self::default(),
        }
    }

    /// The state again; `part` is what the error calls it.
    ///
    /// # Errors
    /// [`NotRestored`] if the bytes are not those of such a state.
    pub fn read<T: DeserializeOwned>(&self, part: &'static str) -> Result<T, NotRestored> {
        ciborium::from_reader(self.0.as_slice()).map_err(|_| NotRestored { part })
    }

    /// Nothing was saved, as by parts without a memory.
    ///
    /// # Errors
    /// [`NotRestored`] if something was.
    pub fn is_empty(&self, part: &'static str) -> Result<(), NotRestored> {
        if self.0.is_empty() { Ok(()) } else { Err(NotRestored { part }) }
    }
}

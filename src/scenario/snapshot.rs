//! Snapshots: a running episode as one file, which resumes in another process with the same bits.
//!
//! A snapshot file is `cocarry snapshot`, the version of the format (4 bytes), the version of the program
//! (its length, 1 byte, and its text), the length of the contents (8 bytes), the contents (CBOR), and the
//! CRC-32 of all that (4 bytes). Numbers are little-endian. The checksum detects truncated and damaged files.
//! It does not protect against intent: of a file written by hand with a correct checksum, everything is
//! checked but the state within the physics engine. If that is not consistent, the engine may panic in a later
//! step; the program catches it.

use super::{PreparedScenario, Scenario, ScenarioError};
use crate::arithmetic;
use crate::episode::{Episode, State};
use crate::located;
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;
use thiserror::Error;

const MAGIC: &[u8] = b"cocarry snapshot";
/// The version of the format. Raise it whenever the contents change.
const FORMAT: u32 = 8;
/// The largest file that is read, bytes. A snapshot has about 100 kB.
const LARGEST: u64 = 1 << 28;

/// The state of an episode, with its scenario.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// The scenario of the episode.
    pub scenario: Scenario,
    /// The state of the episode.
    pub state: State,
    /// The [stamp](arithmetic::stamp) of the arithmetic that computed the state. With another arithmetic, the
    /// episode resumes with other last bits.
    pub arithmetic: String,
    /// The version of the program that wrote it. Another version may not resume bit-identically.
    #[serde(skip)]
    pub written_by: String,
}

/// Why a snapshot was refused.
#[derive(Debug, Error)]
pub enum SnapshotError {
    /// The file cannot be read.
    #[error("{file}: cannot be read")]
    Read {
        /// The file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a snapshot.
    #[error("{file}: not a snapshot")]
    Foreign {
        /// The file.
        file: String,
    },
    /// The snapshot was written in another format.
    #[error(
        "{file}: a snapshot of format {found}, written by cocarry {written_by}; this program reads format {FORMAT}"
    )]
    Format {
        /// The file.
        file: String,
        /// Its format.
        found: u32,
        /// The version of the program that wrote it.
        written_by: String,
    },
    /// The file is shorter or longer than a complete snapshot.
    #[error("{file}: a damaged snapshot: it has {found} bytes; expected {expected}")]
    Length {
        /// The file.
        file: String,
        /// Bytes found.
        found: u64,
        /// Bytes expected, at least.
        expected: u64,
    },
    /// The file is too large to be a snapshot.
    #[error("{file}: larger than {LARGEST} bytes: not a snapshot")]
    TooLarge {
        /// The file.
        file: String,
    },
    /// The checksum does not match the contents.
    #[error("{file}: a damaged snapshot: its checksum does not match its contents")]
    Checksum {
        /// The file.
        file: String,
    },
    /// The checksum matches, but the contents are not those of a snapshot.
    #[error("{file}: not a valid snapshot, written by cocarry {written_by}")]
    Contents {
        /// The file.
        file: String,
        /// The version of the program that wrote it.
        written_by: String,
        /// The reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The snapshot cannot be encoded.
    #[error("the snapshot cannot be encoded")]
    Unwritable(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl PreparedScenario {
    /// A snapshot of an episode of this prepared scenario.
    pub fn snapshot(&self, episode: &Episode) -> Snapshot {
        let written_by = env!("CARGO_PKG_VERSION").to_owned();
        let arithmetic = arithmetic::stamp().to_owned();
        Snapshot { scenario: self.scenario().clone(), state: episode.state(), arithmetic, written_by }
    }

    /// The episode in the saved `state`. It continues with the same bits.
    ///
    /// # Errors
    /// [`ScenarioError::State`]: the state does not belong to this scenario.
    pub fn resume(&self, state: State) -> Result<Episode<'_>, ScenarioError> {
        Ok(self.episode()?.resume(state)?)
    }
}

impl Snapshot {
    /// The version of the format that is written and read.
    pub const FORMAT: u32 = FORMAT;

    /// The snapshot as a file's contents.
    ///
    /// # Errors
    /// [`SnapshotError::Unwritable`], never for an episode that runs.
    pub fn bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        let unwritable = |e: ciborium::ser::Error<_>| SnapshotError::Unwritable(Box::new(e));
        let mut contents = Vec::new();
        ciborium::into_writer(self, &mut contents).map_err(unwritable)?;
        let version = env!("CARGO_PKG_VERSION").as_bytes();
        let length = contents.len() as u64;
        let mut bytes =
            [MAGIC, &FORMAT.to_le_bytes(), &[version.len() as u8], version, &length.to_le_bytes()].concat();
        bytes.append(&mut contents);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        Ok(bytes)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`SnapshotError`], which names the file and what is wrong with it.
    pub fn load(path: &Path) -> Result<Self, SnapshotError> {
        let file = path.display().to_string();
        let mut bytes = Vec::new();
        let read = located::open(path).and_then(|f| f.take(LARGEST + 1).read_to_end(&mut bytes));
        match read {
            Err(source) => Err(SnapshotError::Read { file, source }),
            Ok(_) if bytes.len() as u64 > LARGEST => Err(SnapshotError::TooLarge { file }),
            Ok(_) => Self::parse(&file, &bytes),
        }
    }

    /// Reads a file's contents. Errors call it `file`.
    ///
    /// # Errors
    /// As [`Snapshot::load`].
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, SnapshotError> {
        let mut fields = Fields { file, all: bytes, at: 0 };
        if !bytes.starts_with(&MAGIC[..MAGIC.len().min(bytes.len())]) || bytes.is_empty() {
            return Err(SnapshotError::Foreign { file: file.to_owned() });
        }
        fields.take(MAGIC.len())?;
        let found = u32::from_le_bytes(fields.array()?);
        let [length] = fields.array()?;
        let written_by = String::from_utf8_lossy(fields.take(length.into())?).escape_debug().to_string();
        if found != FORMAT {
            return Err(SnapshotError::Format { file: file.to_owned(), found, written_by });
        }
        let length = u64::from_le_bytes(fields.array()?);
        let expected = (fields.at as u64).saturating_add(length).saturating_add(4);
        if expected != bytes.len() as u64 {
            let found = bytes.len() as u64;
            return Err(SnapshotError::Length { file: file.to_owned(), found, expected });
        }
        let mut contents = fields.take(length as usize)?;
        if crc32fast::hash(&bytes[..fields.at]) != u32::from_le_bytes(fields.array()?) {
            return Err(SnapshotError::Checksum { file: file.to_owned() });
        }
        match ciborium::from_reader::<Self, _>(&mut contents) {
            Ok(snapshot) => Ok(Self { written_by, ..snapshot }),
            Err(e) => {
                let (file, source) = (file.to_owned(), Box::new(e));
                Err(SnapshotError::Contents { file, written_by, source })
            }
        }
    }
}

/// A reader of a file's contents from the front.
struct Fields<'a> {
    file: &'a str,
    all: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], SnapshotError> {
        let end = self.at.saturating_add(length);
        let taken = self.all.get(self.at..end).ok_or_else(|| SnapshotError::Length {
            file: self.file.to_owned(),
            found: self.all.len() as u64,
            expected: end as u64,
        })?;
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], SnapshotError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }
}

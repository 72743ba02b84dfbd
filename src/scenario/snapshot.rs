//! Snapshots: a running episode as one file, which resumes in another process with the same bits.
//!
//! A snapshot file is `cocarry snapshot`, the version of the format (4 bytes), the version of the program
//! (its length, 1 byte, and its text), the length of the contents (8 bytes), the contents (CBOR), and the
//! CRC-32 of all that (4 bytes). Numbers are little-endian. The checksum detects truncated and damaged files.
//! It does not protect against intent: of a file written by hand with a correct checksum, everything is
//! checked but the state within the physics engine. If that is not consistent, the engine may panic in a later
//! step; the program catches it.

use super::{PreparedScenario, Scenario};
use crate::arithmetic;
use crate::bounds;
use crate::cbor;
use crate::episode::{Episode, EpisodeState};
use crate::error::{Error, Place};
use crate::located;
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

const MAGIC: &[u8] = b"cocarry snapshot";
/// The version of the format. Raise it whenever the contents change.
const FORMAT: u32 = 10;
/// The largest file that is read, bytes. A snapshot has up to about 130 kB.
const MAX_BYTES: u64 = bounds::SNAPSHOT.bytes();

/// The state of an episode, with its scenario.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    /// The scenario of the episode.
    pub scenario: Scenario,
    /// The state of the episode.
    pub state: EpisodeState,
    /// The [stamp](arithmetic::stamp) of the arithmetic that computed the state. With another arithmetic, the
    /// episode resumes with other last bits.
    pub arithmetic: String,
    /// The version of the program that wrote it. Another version may not resume bit-identically.
    #[serde(skip)]
    pub written_by: String,
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
    /// The state does not belong to this scenario.
    pub fn resume(&self, state: EpisodeState) -> Result<Episode<'_>, Error> {
        Ok(self.episode()?.resume(state)?)
    }
}

impl Snapshot {
    /// The version of the format that is written and read.
    pub const FORMAT: u32 = FORMAT;

    /// The snapshot as a file's contents.
    ///
    /// # Errors
    /// The snapshot cannot be encoded: never for an episode that runs.
    pub fn bytes(&self) -> Result<Vec<u8>, Error> {
        let mut contents = cbor::to_vec(self)
            .map_err(|error| Error::new("the snapshot cannot be encoded").because(error))?;
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
    /// The file and what is wrong with it.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let file = path.display().to_string();
        let mut bytes = Vec::new();
        let read = located::open(path).and_then(|f| f.take(MAX_BYTES + 1).read_to_end(&mut bytes));
        match read {
            Err(error) => Err(located::unreadable(file, error)),
            Ok(_) if bytes.len() as u64 > MAX_BYTES => Err(Error::at(
                Place::file(file),
                format_args!("larger than {MAX_BYTES} bytes: not a snapshot"),
            )),
            Ok(_) => Self::parse(&file, &bytes),
        }
    }

    /// Reads a file's contents. Errors call it `file`.
    ///
    /// # Errors
    /// As [`Snapshot::load`].
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, Error> {
        let refused = |why: String| Error::at(Place::file(file), why);
        let mut fields = Fields { file, all: bytes, at: 0 };
        if !bytes.starts_with(&MAGIC[..MAGIC.len().min(bytes.len())]) || bytes.is_empty() {
            return Err(refused("not a snapshot".to_owned()));
        }
        fields.take(MAGIC.len())?;
        let found = u32::from_le_bytes(fields.array()?);
        let [length] = fields.array()?;
        let written_by = String::from_utf8_lossy(fields.take(length.into())?).escape_debug().to_string();
        if found != FORMAT {
            return Err(refused(format!(
                "a snapshot of format {found}, written by cocarry {written_by}; this program reads format {FORMAT}"
            )));
        }
        let length = u64::from_le_bytes(fields.array()?);
        let expected = (fields.at as u64).saturating_add(length).saturating_add(4);
        if expected != bytes.len() as u64 {
            return Err(fields.wrong_length(expected));
        }
        let contents = fields.take(length as usize)?;
        if crc32fast::hash(&bytes[..fields.at]) != u32::from_le_bytes(fields.array()?) {
            return Err(refused("a damaged snapshot: its checksum does not match its contents".to_owned()));
        }
        match cbor::from_slice::<Self>(contents) {
            Ok(snapshot) => Ok(Self { written_by, ..snapshot }),
            Err(fault) => {
                let error = refused(format!("not a valid snapshot, written by cocarry {written_by}"));
                Err(error.because(fault))
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
    fn wrong_length(&self, expected: u64) -> Error {
        let found = self.all.len();
        let sentence = format_args!("a damaged snapshot: it has {found} bytes; expected {expected}");
        Error::at(Place::file(self.file), sentence)
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], Error> {
        let end = self.at.saturating_add(length);
        let taken = self.all.get(self.at..end).ok_or_else(|| self.wrong_length(end as u64))?;
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }
}

//! The store of what participants answer: one SQLite file beside the study.
//!
//! A chunk that was acknowledged is on the disk: the journal is a write-ahead log, and every transaction is
//! synced (`synchronous = FULL`). A chunk has a key, (session, trial, number): the same one again changes
//! nothing, and another one with its key is refused. No network address is stored.

mod error;
mod forget;
mod progress;
#[cfg(test)]
mod tests;
mod write;

pub use error::{Refusal, StoreError};
pub use forget::Forgotten;
pub(crate) use progress::Progress;
pub(crate) use write::{Fault, Writing};

use crate::digest::sha256;
use rusqlite::{Connection, OptionalExtension, TransactionBehavior};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The longest chunk, bytes.
pub const MAX_CHUNK_BYTES: usize = 1 << 20;
/// The largest number of bytes of a session.
pub(crate) const MAX_SESSION_BYTES: i64 = 32 << 20;
/// The largest number of chunks of a session.
const MAX_CHUNKS: i64 = 20_000;
/// The largest number of a trial, and of a chunk in it.
const MAX_NUMBER: u32 = 1_000_000;
/// How long another process may hold the file.
const PATIENCE: Duration = Duration::from_secs(10);
/// The number of hexadecimal digits of a pseudonym, and of a code.
const PSEUDONYM_DIGITS: usize = 12;
const CODE_DIGITS: usize = 8;

/// Times in UTC, for `strftime`.
const TIME: &str = "'%Y-%m-%dT%H:%M:%SZ'";

/// The changes of the tables, from an empty file on. The version of a file is the number of those that it has
/// had.
const MIGRATIONS: [&str; 2] = [
    "
    CREATE TABLE study (one INTEGER PRIMARY KEY CHECK (one = 1), secret BLOB NOT NULL) STRICT;
    -- place: the participant's number from 0, which gives the order of the worlds; times: seconds since 1970
    CREATE TABLE sessions (
        participant TEXT PRIMARY KEY, key_sha256 TEXT NOT NULL UNIQUE, place INTEGER NOT NULL UNIQUE,
        study_sha256 TEXT NOT NULL, begun INTEGER NOT NULL, finished INTEGER, digest TEXT
    ) STRICT;
    -- what a recruiting platform knows somebody by: never joined with answers but by the pseudonym
    CREATE TABLE platform_ids (
        participant TEXT NOT NULL REFERENCES sessions (participant) ON DELETE CASCADE,
        name TEXT NOT NULL, value TEXT NOT NULL, PRIMARY KEY (participant, name)
    ) STRICT;
    CREATE TABLE chunks (
        participant TEXT NOT NULL REFERENCES sessions (participant) ON DELETE CASCADE,
        trial INTEGER NOT NULL, number INTEGER NOT NULL, sha256 TEXT NOT NULL, received INTEGER NOT NULL,
        body TEXT NOT NULL, UNIQUE (participant, trial, number)
    ) STRICT;
",
    "
    -- the number of a session's chunks and their bytes, which bound it
    ALTER TABLE sessions ADD COLUMN chunks INTEGER NOT NULL DEFAULT 0;
    ALTER TABLE sessions ADD COLUMN bytes INTEGER NOT NULL DEFAULT 0;
    UPDATE sessions SET (chunks, bytes) = (SELECT count(*), coalesce(sum(octet_length(body)), 0)
        FROM chunks WHERE chunks.participant = sessions.participant);
",
];

/// A request for a session.
#[derive(Clone, Debug)]
pub struct Begin<'a> {
    /// The participant's secret: 64 hexadecimal digits. The same one again gives the same session.
    pub key: &'a str,
    /// Parameters of the page's address, the first of which identifies a person.
    pub platform_ids: &'a [(String, String)],
    /// SHA-256 of what the participant sees.
    pub study: &'a str,
    /// The largest number of participants.
    pub participants: u64,
    /// Now, seconds since 1970.
    pub now: i64,
}

/// A session that has begun.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Session {
    /// The participant's pseudonym.
    pub participant: String,
    /// The participant's number, from 0.
    pub place: u64,
}

/// A part of what a session records.
#[derive(Clone, Copy, Debug)]
pub struct Chunk<'a> {
    /// The number of the trial.
    pub trial: u32,
    /// The number of the chunk in the trial.
    pub number: u32,
    /// The SHA-256 of the body.
    pub sha256: &'a str,
    /// JSON: an array of objects.
    pub body: &'a str,
}

/// What became of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Put {
    /// It is stored now.
    Stored,
    /// It was stored before.
    Known,
}

/// A session with everything that it recorded.
#[derive(Clone, Debug)]
pub struct StoredSession {
    /// The pseudonym.
    pub participant: String,
    /// The number, from 0.
    pub place: u64,
    /// SHA-256 of what the participant saw.
    pub study: String,
    /// When it began and when it was finished: UTC, as in `2026-11-26T20:05:00Z`.
    pub begun: String,
    /// See `begun`.
    pub finished: Option<String>,
    /// The records of each trial, in the order in which they were made.
    pub records: Vec<(u32, Vec<Map<String, Value>>)>,
}

/// The store of a study.
pub struct Store {
    file: PathBuf,
    connection: Connection,
    secret: Vec<u8>,
}

impl Store {
    /// Opens the store in this file, or makes one.
    ///
    /// # Errors
    /// The file cannot be read or written, or is not a store.
    pub fn open(file: &Path) -> Result<Self, StoreError> {
        let failed = |source| StoreError::Database { file: file.to_owned(), source };
        let connection = Connection::open(file).map_err(failed)?;
        let set_up = || -> rusqlite::Result<()> {
            connection.busy_timeout(PATIENCE)?;
            connection.pragma_update(None, "journal_mode", "WAL")?;
            connection.pragma_update(None, "synchronous", "FULL")?;
            connection.pragma_update(None, "foreign_keys", true)?;
            connection.pragma_update(None, "secure_delete", true)?;
            connection.pragma_update(None, "trusted_schema", false)
        };
        set_up().map_err(failed)?;
        let mut store = Self { file: file.to_owned(), connection, secret: Vec::new() };
        store.migrate()?;
        Ok(store)
    }

    /// Opens the store in a file that exists.
    ///
    /// # Errors
    /// As [`Store::open`], also if there is no such file.
    pub fn open_existing(file: &Path) -> Result<Self, StoreError> {
        match file.is_file() {
            true => Self::open(file),
            false => Err(StoreError::File {
                file: file.to_owned(),
                sentence: "nobody has answered yet".to_owned(),
            }),
        }
    }

    fn migrate(&mut self) -> Result<(), StoreError> {
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let transaction = begun.map_err(failed)?;
        let version: i64 =
            transaction.pragma_query_value(None, "user_version", |row| row.get(0)).map_err(failed)?;
        let Some(missing) = usize::try_from(version).ok().and_then(|had| MIGRATIONS.get(had..)) else {
            let sentence = format!(
                "has version {version} of the tables, this program has {}; use a newer program",
                MIGRATIONS.len()
            );
            return Err(StoreError::File { file, sentence });
        };
        let change = || -> rusqlite::Result<()> {
            for migration in missing {
                transaction.execute_batch(migration)?;
            }
            transaction.pragma_update(None, "user_version", MIGRATIONS.len() as i64)
        };
        change().map_err(failed)?;
        if version == 0 {
            let mut secret = [0; 32];
            getrandom::fill(&mut secret).map_err(|error| StoreError::File {
                file: file.clone(),
                sentence: format!("the system has no random numbers for its secret: {error}"),
            })?;
            let stored = transaction.execute("INSERT INTO study VALUES (1, ?1)", [secret.as_slice()]);
            stored.map_err(failed)?;
        }
        let secret = transaction.query_row("SELECT secret FROM study", [], |row| row.get(0));
        self.secret = secret.map_err(failed)?;
        transaction.commit().map_err(failed)
    }

    /// All sessions with what they recorded, by number.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn sessions(&self) -> Result<Vec<StoredSession>, StoreError> {
        self.read_sessions("1").map_err(|source| self.failed(source))
    }

    /// As [`Store::sessions`], without the chunks in which no trial ends: what `collect` reads, in less memory.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn ends_of_trials(&self) -> Result<Vec<StoredSession>, StoreError> {
        self.read_sessions("instr(body, '\"done\"')").map_err(|source| self.failed(source))
    }

    /// The sessions with those of their chunks for which an expression of SQL is true.
    fn read_sessions(&self, wanted: &str) -> rusqlite::Result<Vec<StoredSession>> {
        let mut statement = self.connection.prepare(&format!(
            "SELECT participant, place, study_sha256, strftime({TIME}, begun, 'unixepoch'), \
             strftime({TIME}, finished, 'unixepoch') FROM sessions ORDER BY place"
        ))?;
        let sessions = statement.query_map([], |row| {
            Ok(StoredSession {
                participant: row.get(0)?,
                place: unsigned(row.get(1)?),
                study: row.get(2)?,
                begun: row.get::<_, Option<String>>(3)?.unwrap_or_default(),
                finished: row.get(4)?,
                records: Vec::new(),
            })
        })?;
        let mut sessions = sessions.collect::<rusqlite::Result<Vec<_>>>()?;
        let mut statement = self.connection.prepare(&format!(
            "SELECT trial, body FROM chunks WHERE participant = ?1 AND {wanted} ORDER BY trial, number"
        ))?;
        for session in &mut sessions {
            let chunks = statement.query_map([&session.participant], |row| {
                Ok((row.get::<_, u32>(0)?, row.get::<_, String>(1)?))
            })?;
            for chunk in chunks {
                let (trial, body) = chunk?;
                // checked when it was put
                let records: Vec<Map<String, Value>> = serde_json::from_str(&body).unwrap_or_default();
                match session.records.last_mut().filter(|(last, _)| *last == trial) {
                    Some((_, known)) => known.extend(records),
                    None => session.records.push((trial, records)),
                }
            }
        }
        Ok(sessions)
    }

    /// The faults that SQLite finds in the file; none in a sound one.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn faults(&self) -> Result<Vec<String>, StoreError> {
        let read = || -> rusqlite::Result<Vec<String>> {
            let mut statement = self.connection.prepare("PRAGMA integrity_check")?;
            let found = statement
                .query_map([], |row| row.get::<_, String>(0))?
                .collect::<rusqlite::Result<Vec<_>>>()?;
            Ok(found.into_iter().filter(|line| line != "ok").collect())
        };
        read().map_err(|source| self.failed(source))
    }

    /// The number of chunks that have arrived.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn chunk_count(&self) -> Result<u64, StoreError> {
        let counted = self.connection.query_row("SELECT count(*) FROM chunks", [], |row| row.get(0));
        counted.map(unsigned).map_err(|source| self.failed(source))
    }

    /// The numbers of participants who have begun, and who have finished.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn counts(&self) -> Result<[u64; 2], StoreError> {
        let counted =
            self.connection.query_row("SELECT count(*), count(finished) FROM sessions", [], |row| {
                Ok([unsigned(row.get(0)?), unsigned(row.get(1)?)])
            });
        counted.map_err(|source| self.failed(source))
    }

    fn failed(&self, source: rusqlite::Error) -> StoreError {
        StoreError::Database { file: self.file.clone(), source }
    }
}

/// The participant of a key, and whether the session is finished.
fn session(connection: &Connection, key: &str) -> rusqlite::Result<Option<(String, bool)>> {
    connection
        .query_row(
            "SELECT participant, finished IS NOT NULL FROM sessions WHERE key_sha256 = ?1",
            [sha256(key.as_bytes())],
            |row| Ok((row.get(0)?, row.get(1)?)),
        )
        .optional()
}

fn listed(connection: &Connection, participant: &str) -> rusqlite::Result<Vec<(u32, u32, String)>> {
    let mut statement = connection
        .prepare("SELECT trial, number, sha256 FROM chunks WHERE participant = ?1 ORDER BY trial, number")?;
    statement.query_map([participant], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?.collect()
}

/// The digest of a whole session.
pub(crate) fn whole_digest(chunks: &[(u32, u32, String)]) -> String {
    let lines: String =
        chunks.iter().map(|(trial, number, sha256)| format!("{trial} {number} {sha256}\n")).collect();
    sha256(lines.as_bytes())
}

/// A count of the database.
fn unsigned(count: i64) -> u64 {
    u64::try_from(count).unwrap_or(0)
}

//! The store of what participants answer: one SQLite file beside the study.
//!
//! A chunk that was acknowledged is on the disk: the journal is a write-ahead log, and every transaction is synced
//! (`synchronous = FULL`). A chunk has a key, (session, trial, number): the same one again changes nothing, and another
//! one with its key is refused. No network address is stored.

use crate::digest::{is_digest, keyed, sha256};
use crate::study::is_word;
use rusqlite::{Connection, OptionalExtension, TransactionBehavior, params};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The longest chunk, bytes.
pub const MAX_CHUNK_BYTES: usize = 1 << 20;
/// The largest number of bytes of a session.
const MAX_SESSION_BYTES: i64 = 32 << 20;
/// The largest number of chunks of a session.
const MAX_CHUNKS: i64 = 20_000;
/// The largest number of a trial, and of a chunk in it.
const MAX_NUMBER: u32 = 1_000_000;
/// How long another process may hold the file.
const PATIENCE: Duration = Duration::from_secs(10);
/// The number of hexadecimal digits of a pseudonym, and of a code.
const PSEUDONYM_DIGITS: usize = 12;
const CODE_DIGITS: usize = 8;

/// The changes of the tables, from an empty file on. The version of a file is the number of those that it has had.
const MIGRATIONS: [&str; 1] = ["
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
"];

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
    /// What the session has is not what the digest says.
    #[error("not everything has arrived")]
    NotWhole,
}

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

/// What was removed of a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Forgotten {
    /// The pseudonym.
    pub participant: String,
    /// The number of chunks.
    pub chunks: u64,
    /// The number of identities of a platform.
    pub platform_ids: u64,
    /// The number of bytes that were searched for what identified the person, and do not have it.
    pub searched_bytes: u64,
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

    /// Begins a session, or finds the one that has begun with this key: in a transaction, so that no two participants get
    /// one number.
    ///
    /// # Errors
    /// [`Refusal::Form`], [`Refusal::Full`], [`Refusal::BegunBefore`].
    pub fn begin(&mut self, begin: &Begin) -> Result<Session, StoreError> {
        if !is_digest(begin.key) {
            return Err(Refusal::Form("the key must be 64 hexadecimal digits").into());
        }
        let is_plain = |(name, value): &(String, String)| is_word(name) && is_word(value);
        if begin.platform_ids.len() > 24 || !begin.platform_ids.iter().all(is_plain) {
            return Err(
                Refusal::Form("names and values of a platform must be letters, digits, - and _").into()
            );
        }
        let key_sha256 = sha256(begin.key.as_bytes());
        let identity = match begin.platform_ids.first() {
            Some((name, value)) => format!("platform {name} {value}"),
            None => format!("session {key_sha256}"),
        };
        let pseudonym = format!("p{}", &keyed(&self.secret, &identity)[..PSEUDONYM_DIGITS]);
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let transaction = begun.map_err(failed)?;
        let known = transaction
            .query_row(
                "SELECT participant, place FROM sessions WHERE key_sha256 = ?1",
                [&key_sha256],
                |row| Ok(Session { participant: row.get(0)?, place: unsigned(row.get(1)?) }),
            )
            .optional()
            .map_err(failed)?;
        if let Some(known) = known {
            return Ok(known);
        }
        let counts = transaction
            .query_row(
                "SELECT count(*), coalesce(max(place) + 1, 0), total(participant = ?1) FROM sessions",
                [&pseudonym],
                |row| Ok((unsigned(row.get(0)?), row.get::<_, i64>(1)?, row.get::<_, f64>(2)? > 0.0)),
            )
            .map_err(failed)?;
        match counts {
            (_, _, true) => return Err(Refusal::BegunBefore.into()),
            (count, ..) if count >= begin.participants => return Err(Refusal::Full.into()),
            _ => {}
        }
        let place = counts.1;
        let insert = || -> rusqlite::Result<()> {
            transaction.execute(
                "INSERT INTO sessions (participant, key_sha256, place, study_sha256, begun) VALUES (?1, ?2, ?3, ?4, ?5)",
                params![pseudonym, key_sha256, place, begin.study, begin.now],
            )?;
            for (name, value) in begin.platform_ids {
                transaction.execute(
                    "INSERT OR IGNORE INTO platform_ids (participant, name, value) VALUES (?1, ?2, ?3)",
                    params![pseudonym, name, value],
                )?;
            }
            Ok(())
        };
        insert().map_err(failed)?;
        transaction.commit().map_err(failed)?;
        Ok(Session { participant: pseudonym, place: unsigned(place) })
    }

    /// Stores a chunk of the session with this key. When it returns, the chunk is on the disk.
    ///
    /// # Errors
    /// A [`Refusal`].
    pub fn put(&mut self, key: &str, chunk: &Chunk, now: i64) -> Result<Put, StoreError> {
        if chunk.trial > MAX_NUMBER || chunk.number > MAX_NUMBER || !is_digest(chunk.sha256) {
            return Err(
                Refusal::Form("a chunk needs numbers up to 1000000 and the SHA-256 of its body").into()
            );
        }
        if chunk.body.len() > MAX_CHUNK_BYTES {
            return Err(Refusal::TooMuch.into());
        }
        if sha256(chunk.body.as_bytes()) != chunk.sha256 {
            return Err(Refusal::Damaged.into());
        }
        if serde_json::from_str::<Vec<Map<String, Value>>>(chunk.body).is_err() {
            return Err(Refusal::Form("the body must be a JSON array of objects").into());
        }
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let transaction = begun.map_err(failed)?;
        let Some((participant, is_finished)) = session(&transaction, key).map_err(failed)? else {
            return Err(Refusal::Unknown.into());
        };
        let known: Option<String> = transaction
            .query_row(
                "SELECT sha256 FROM chunks WHERE participant = ?1 AND trial = ?2 AND number = ?3",
                params![participant, chunk.trial, chunk.number],
                |row| row.get(0),
            )
            .optional()
            .map_err(failed)?;
        match known {
            Some(known) if known == chunk.sha256 => return Ok(Put::Known),
            Some(_) => return Err(Refusal::OtherChunk.into()),
            None if is_finished => return Err(Refusal::Finished.into()),
            None => {}
        }
        let (count, bytes): (i64, i64) = transaction
            .query_row(
                "SELECT count(*), coalesce(sum(length(CAST(body AS BLOB))), 0) FROM chunks WHERE participant = ?1",
                [&participant],
                |row| Ok((row.get(0)?, row.get(1)?)),
            )
            .map_err(failed)?;
        if count >= MAX_CHUNKS || bytes + chunk.body.len() as i64 > MAX_SESSION_BYTES {
            return Err(Refusal::TooMuch.into());
        }
        transaction
            .execute(
                "INSERT INTO chunks (participant, trial, number, sha256, received, body) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                params![participant, chunk.trial, chunk.number, chunk.sha256, now, chunk.body],
            )
            .map_err(failed)?;
        transaction.commit().map_err(failed)?;
        Ok(Put::Stored)
    }

    /// The chunks that the session with this key has: trial, number, SHA-256, in this order.
    ///
    /// # Errors
    /// [`Refusal::Unknown`].
    pub fn chunks(&self, key: &str) -> Result<Vec<(u32, u32, String)>, StoreError> {
        let failed = |source| self.failed(source);
        let (participant, _) = session(&self.connection, key).map_err(failed)?.ok_or(Refusal::Unknown)?;
        listed(&self.connection, &participant).map_err(failed)
    }

    /// Ends the session with this key, if it has all that the digest says: the SHA-256 of a line `TRIAL NUMBER SHA256` for
    /// every chunk, in the order of the numbers. Returns the participant's code, `code` if it is given.
    ///
    /// # Errors
    /// [`Refusal::Unknown`], [`Refusal::NotWhole`].
    pub fn finish(
        &mut self,
        key: &str,
        digest: &str,
        code: Option<&str>,
        now: i64,
    ) -> Result<String, StoreError> {
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let transaction = begun.map_err(failed)?;
        let (participant, is_finished) =
            session(&transaction, key).map_err(failed)?.ok_or(Refusal::Unknown)?;
        let chunks = listed(&transaction, &participant).map_err(failed)?;
        if chunks.is_empty() || whole_digest(&chunks) != digest {
            return Err(Refusal::NotWhole.into());
        }
        if !is_finished {
            transaction
                .execute(
                    "UPDATE sessions SET finished = ?2, digest = ?3 WHERE participant = ?1",
                    params![participant, now, digest],
                )
                .map_err(failed)?;
            transaction.commit().map_err(failed)?;
        }
        let own = || keyed(&self.secret, &format!("code {participant}"))[..CODE_DIGITS].to_uppercase();
        Ok(code.map_or_else(own, str::to_owned))
    }

    /// All sessions with what they recorded, by number.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn sessions(&self) -> Result<Vec<StoredSession>, StoreError> {
        self.read_sessions().map_err(|source| self.failed(source))
    }

    fn read_sessions(&self) -> rusqlite::Result<Vec<StoredSession>> {
        const TIME: &str = "'%Y-%m-%dT%H:%M:%SZ'";
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
        let mut statement = self
            .connection
            .prepare("SELECT trial, body FROM chunks WHERE participant = ?1 ORDER BY trial, number")?;
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

    /// The pseudonyms that `id` stands for: itself, or those of this identity of a platform.
    fn participants_of(&self, id: &str) -> rusqlite::Result<Vec<String>> {
        let mut statement = self.connection.prepare(
            "SELECT participant FROM sessions WHERE participant = ?1
             UNION SELECT participant FROM platform_ids WHERE value = ?1 ORDER BY participant",
        )?;
        statement.query_map([id], |row| row.get(0))?.collect()
    }

    /// Removes a person, given by pseudonym or by an identity of a platform, with all that they answered. Afterwards the
    /// files of the store are searched for what identified the person.
    ///
    /// # Errors
    /// Nobody or more than one is known by this name; the file cannot be written, or still has a trace.
    pub fn forget(&mut self, id: &str) -> Result<Forgotten, StoreError> {
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let refused = |sentence: String| StoreError::File { file: file.clone(), sentence };
        let participants = self.participants_of(id).map_err(failed)?;
        let participant = match participants.as_slice() {
            [one] => one.clone(),
            [] => {
                return Err(refused(format!(
                    "nobody is known as `{id}`; give the number of a participant, or the identity of a platform"
                )));
            }
            many => {
                let sentence = format!(
                    "`{id}` stands for {} people; give the number of one: {}",
                    many.len(),
                    many.join(", ")
                );
                return Err(refused(sentence));
            }
        };
        let traces = self.traces(&participant).map_err(failed)?;
        let begun = self.connection.transaction_with_behavior(TransactionBehavior::Immediate);
        let transaction = begun.map_err(failed)?;
        let remove = |table: &str| {
            transaction.execute(&format!("DELETE FROM {table} WHERE participant = ?1"), [&participant])
        };
        let chunks = remove("chunks").map_err(failed)?;
        let platform_ids = remove("platform_ids").map_err(failed)?;
        remove("sessions").map_err(failed)?;
        transaction.commit().map_err(failed)?;
        // no old page stays, neither in the file nor in its log
        let sweep = "PRAGMA wal_checkpoint(TRUNCATE); VACUUM; PRAGMA wal_checkpoint(TRUNCATE);";
        self.connection.execute_batch(sweep).map_err(failed)?;
        let searched_bytes = self.search(&traces)?;
        Ok(Forgotten {
            participant,
            chunks: chunks as u64,
            platform_ids: platform_ids as u64,
            searched_bytes,
        })
    }

    /// What identifies a person in the files: pseudonym, digest of the key, identities of a platform.
    fn traces(&self, participant: &str) -> rusqlite::Result<Vec<String>> {
        let of_key = "SELECT key_sha256 FROM sessions WHERE participant = ?1";
        let key: String = self.connection.query_row(of_key, [participant], |row| row.get(0))?;
        // identities that several people share, such as the platform's name of the study, identify nobody
        let mut statement = self.connection.prepare(
            "SELECT value FROM platform_ids AS own WHERE participant = ?1 AND NOT EXISTS
             (SELECT 1 FROM platform_ids WHERE value = own.value AND participant <> ?1)",
        )?;
        let values = statement.query_map([participant], |row| row.get(0))?;
        let mut traces = values.collect::<rusqlite::Result<Vec<String>>>()?;
        traces.extend([participant.to_owned(), key]);
        Ok(traces)
    }

    /// The number of bytes of the store's files, none of which is of a trace.
    fn search(&self, traces: &[String]) -> Result<u64, StoreError> {
        let mut searched = 0;
        for extension in ["", "-wal"] {
            let mut file = self.file.clone().into_os_string();
            file.push(extension);
            let file = PathBuf::from(file);
            let bytes = match std::fs::read(&file) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => {
                    return Err(StoreError::File { file, sentence: format!("cannot be searched: {error}") });
                }
            };
            let has = |trace: &&String| bytes.windows(trace.len()).any(|part| part == trace.as_bytes());
            if traces.iter().find(has).is_some() {
                let sentence =
                    "the rows are removed, but the file still has a trace; stop the server and try again";
                return Err(StoreError::File { file, sentence: sentence.to_owned() });
            }
            searched += bytes.len() as u64;
        }
        Ok(searched)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn key(n: u8) -> String {
        sha256(&[n])
    }

    fn begin<'a>(key: &'a str, platform_ids: &'a [(String, String)]) -> Begin<'a> {
        Begin { key, platform_ids, study: "study", participants: 3, now: 1_795_723_500 }
    }

    fn refusal<T>(result: Result<T, StoreError>) -> Refusal {
        match result {
            Err(StoreError::Refused(refusal)) => refusal,
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("it is not refused"),
        }
    }

    fn put(store: &mut Store, key: &str, [trial, number]: [u32; 2], body: &str) -> Result<Put, StoreError> {
        store.put(key, &Chunk { trial, number, sha256: &sha256(body.as_bytes()), body }, 5)
    }

    #[test]
    fn a_session_begins_once_and_numbers_are_allotted_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
        let first = store.begin(&begin(&key(1), &[])).unwrap();
        assert_eq!(store.begin(&begin(&key(1), &[])).unwrap(), first);
        assert_eq!(first.place, 0);
        let anna = [("PID".to_owned(), "anna".to_owned())];
        let second = store.begin(&begin(&key(2), &anna)).unwrap();
        assert_eq!(second.place, 1);
        // the same person with another key
        assert_eq!(refusal(store.begin(&begin(&key(3), &anna))), Refusal::BegunBefore);
        assert_eq!(store.begin(&begin(&key(3), &[])).unwrap().place, 2);
        assert_eq!(refusal(store.begin(&begin(&key(4), &[]))), Refusal::Full);
        assert!(matches!(refusal(store.begin(&begin("short", &[]))), Refusal::Form(_)));
        let script = [("PID".to_owned(), "<script>".to_owned())];
        assert!(matches!(refusal(store.begin(&begin(&key(4), &script))), Refusal::Form(_)));
        assert_eq!(store.counts().unwrap(), [3, 0]);
    }

    #[test]
    fn a_chunk_is_stored_once_and_another_with_its_number_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
        store.begin(&begin(&key(1), &[])).unwrap();
        let body = r#"[{"kind":"done"}]"#;
        assert_eq!(put(&mut store, &key(1), [0, 0], body).unwrap(), Put::Stored);
        assert_eq!(put(&mut store, &key(1), [0, 0], body).unwrap(), Put::Known);
        assert_eq!(refusal(put(&mut store, &key(1), [0, 0], "[]")), Refusal::OtherChunk);
        assert_eq!(refusal(put(&mut store, &key(2), [0, 0], body)), Refusal::Unknown);
        assert!(matches!(refusal(put(&mut store, &key(1), [0, 1], "{}")), Refusal::Form(_)));
        let damaged = Chunk { trial: 0, number: 1, sha256: &sha256(b"other"), body };
        assert_eq!(refusal(store.put(&key(1), &damaged, 5)), Refusal::Damaged);
        let long = format!("[{}]", " ".repeat(MAX_CHUNK_BYTES));
        assert_eq!(refusal(put(&mut store, &key(1), [0, 1], &long)), Refusal::TooMuch);
        let chunks = store.chunks(&key(1)).unwrap();
        assert_eq!(chunks, [(0, 0, sha256(body.as_bytes()))]);
    }

    #[test]
    fn the_code_is_given_for_the_digest_of_everything_alone() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
        let key = key(1);
        store.begin(&begin(&key, &[])).unwrap();
        assert_eq!(refusal(store.finish(&key, &whole_digest(&[]), None, 6)), Refusal::NotWhole);
        put(&mut store, &key, [1, 0], "[]").unwrap();
        put(&mut store, &key, [0, 0], "[]").unwrap();
        let lines = format!("0 0 {0}\n1 0 {0}\n", sha256(b"[]"));
        let digest = sha256(lines.as_bytes());
        assert_eq!(refusal(store.finish(&key, &sha256(b"x"), None, 6)), Refusal::NotWhole);
        let code = store.finish(&key, &digest, None, 6).unwrap();
        assert_eq!(code.len(), 8);
        assert_eq!(store.finish(&key, &digest, None, 7).unwrap(), code);
        assert_eq!(store.finish(&key, &digest, Some("ALL"), 7).unwrap(), "ALL");
        assert_eq!(refusal(put(&mut store, &key, [2, 0], "[]")), Refusal::Finished);
        assert_eq!(put(&mut store, &key, [1, 0], "[]").unwrap(), Put::Known);
        let session = &store.sessions().unwrap()[0];
        assert_eq!(session.begun, "2026-11-26T20:05:00Z");
        assert_eq!(session.finished.as_deref(), Some("1970-01-01T00:00:06Z"));
    }

    #[test]
    fn nothing_of_a_forgotten_person_is_in_the_files_and_the_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.sqlite");
        let mut store = Store::open(&file).unwrap();
        let anna =
            [("PID".to_owned(), "annasidentity".to_owned()), ("STUDY".to_owned(), "shared".to_owned())];
        let ben = [("PID".to_owned(), "bensidentity".to_owned()), ("STUDY".to_owned(), "shared".to_owned())];
        let participant = store.begin(&begin(&key(1), &anna)).unwrap().participant;
        store.begin(&begin(&key(2), &ben)).unwrap();
        for n in 0..40 {
            put(&mut store, &key(1), [n, 0], r#"[{"secretword":1}]"#).unwrap();
            put(&mut store, &key(2), [n, 0], "[]").unwrap();
        }
        let bytes = || {
            let mut bytes = std::fs::read(&file).unwrap();
            bytes.extend(std::fs::read(folder.path().join("s.sqlite-wal")).unwrap_or_default());
            bytes
        };
        let has = |text: &str| bytes().windows(text.len()).any(|part| part == text.as_bytes());
        assert!(has("annasidentity") && has(&participant) && has("secretword"));
        assert!(store.forget("shared").unwrap_err().to_string().contains("stands for 2 people"));
        assert!(store.forget("clara").unwrap_err().to_string().contains("nobody is known as `clara`"));
        let forgotten = store.forget("annasidentity").unwrap();
        assert_eq!((forgotten.chunks, forgotten.platform_ids, &forgotten.participant), (40, 2, &participant));
        assert!(
            !has("annasidentity")
                && !has(&participant)
                && !has("secretword")
                && !has(&sha256(key(1).as_bytes()))
        );
        assert!(has("bensidentity") && store.faults().unwrap().is_empty());
        assert_eq!(store.chunks(&key(2)).unwrap().len(), 40);
        assert_eq!(refusal(store.chunks(&key(1))), Refusal::Unknown);
    }

    #[test]
    fn a_store_of_a_newer_program_and_a_file_of_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.sqlite");
        assert!(Store::open_existing(&file).is_err());
        Store::open(&file).unwrap().connection.pragma_update(None, "user_version", 9).unwrap();
        let Err(error) = Store::open(&file) else { panic!("it is opened") };
        assert!(error.to_string().contains("version 9"), "{error}");
        std::fs::write(
            folder.path().join("text.sqlite"),
            "not a database, but long enough to be one".repeat(100),
        )
        .unwrap();
        assert!(Store::open(&folder.path().join("text.sqlite")).is_err());
    }
}

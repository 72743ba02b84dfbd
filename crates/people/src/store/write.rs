//! What is written for participants: one request, or several of them in one transaction.

use super::{
    Begin, CODE_DIGITS, Chunk, MAX_CHUNK_BYTES, MAX_CHUNKS, MAX_NUMBER, MAX_SESSION_BYTES, PSEUDONYM_DIGITS,
    Put, Refusal, Session, Store, StoreError, listed, session, unsigned, whole_digest,
};
use crate::digest::{is_digest, keyed, sha256};
use crate::study::is_word;
use rusqlite::{Connection, OptionalExtension, TransactionBehavior, params};
use serde_json::{Map, Value};

/// Why a request is not written.
pub(crate) enum Fault {
    /// It is refused; nothing was written for it.
    Refused(Refusal),
    /// The file cannot be written.
    Database(rusqlite::Error),
}

impl From<Refusal> for Fault {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<rusqlite::Error> for Fault {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(error)
    }
}

/// A store within a transaction.
pub(crate) struct Writing<'a> {
    connection: &'a Connection,
    secret: &'a [u8],
}

impl Chunk<'_> {
    /// The check of all that does not need the store.
    ///
    /// # Errors
    /// [`Refusal::Form`], [`Refusal::TooMuch`], [`Refusal::Damaged`].
    pub fn check(&self) -> Result<(), Refusal> {
        if self.trial > MAX_NUMBER || self.number > MAX_NUMBER || !is_digest(self.sha256) {
            return Err(Refusal::Form("a chunk needs numbers up to 1000000 and the SHA-256 of its body"));
        }
        if self.body.len() > MAX_CHUNK_BYTES {
            return Err(Refusal::TooMuch);
        }
        if sha256(self.body.as_bytes()) != self.sha256 {
            return Err(Refusal::Damaged);
        }
        match serde_json::from_str::<Vec<Map<String, Value>>>(self.body) {
            Ok(_) => Ok(()),
            Err(_) => Err(Refusal::Form("the body must be a JSON array of objects")),
        }
    }
}

impl Writing<'_> {
    /// See [`Store::begin`].
    pub fn begin(&self, begin: &Begin) -> Result<Session, Fault> {
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
        let known = self
            .connection
            .query_row(
                "SELECT participant, place FROM sessions WHERE key_sha256 = ?1",
                [&key_sha256],
                |row| Ok(Session { participant: row.get(0)?, place: unsigned(row.get(1)?) }),
            )
            .optional()?;
        if let Some(known) = known {
            return Ok(known);
        }
        let identity = match begin.platform_ids.first() {
            Some((name, value)) => format!("platform {name} {value}"),
            None => format!("session {key_sha256}"),
        };
        let participant = format!("p{}", &keyed(self.secret, &identity)[..PSEUDONYM_DIGITS]);
        let of_person = "SELECT study_sha256 FROM sessions WHERE participant = ?1";
        let begun_with: Option<String> =
            self.connection.query_row(of_person, [&participant], |row| row.get(0)).optional()?;
        match begun_with {
            Some(study) if study == begin.study => Err(Refusal::BegunBefore.into()),
            Some(_) => Err(Refusal::Changed.into()),
            None => self.insert(begin, participant, &key_sha256),
        }
    }

    /// Adds a session, with the next number.
    fn insert(&self, begin: &Begin, participant: String, key_sha256: &str) -> Result<Session, Fault> {
        let (count, place) = self.connection.query_row(
            "SELECT count(*), coalesce(max(place) + 1, 0) FROM sessions",
            [],
            |row| Ok((unsigned(row.get(0)?), row.get::<_, i64>(1)?)),
        )?;
        if count >= begin.participants {
            return Err(Refusal::Full.into());
        }
        self.connection.execute(
            "INSERT INTO sessions (participant, key_sha256, place, study_sha256, begun) VALUES (?1, ?2, ?3, ?4, ?5)",
            params![participant, key_sha256, place, begin.study, begin.now],
        )?;
        for (name, value) in begin.platform_ids {
            self.connection.execute(
                "INSERT OR IGNORE INTO platform_ids (participant, name, value) VALUES (?1, ?2, ?3)",
                params![participant, name, value],
            )?;
        }
        Ok(Session { participant, place: unsigned(place) })
    }

    /// Stores a chunk that was checked.
    pub fn put(&self, key: &str, chunk: &Chunk, now: i64) -> Result<Put, Fault> {
        let of_key =
            "SELECT participant, finished IS NOT NULL, chunks, bytes FROM sessions WHERE key_sha256 = ?1";
        let found: Option<(String, bool, i64, i64)> = self
            .connection
            .query_row(of_key, [sha256(key.as_bytes())], |row| {
                Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?))
            })
            .optional()?;
        let (participant, is_finished, count, bytes) = found.ok_or(Refusal::Unknown)?;
        let known: Option<String> = self
            .connection
            .query_row(
                "SELECT sha256 FROM chunks WHERE participant = ?1 AND trial = ?2 AND number = ?3",
                params![participant, chunk.trial, chunk.number],
                |row| row.get(0),
            )
            .optional()?;
        match known {
            Some(known) if known == chunk.sha256 => return Ok(Put::Known),
            Some(_) => return Err(Refusal::OtherChunk.into()),
            None if is_finished => return Err(Refusal::Finished.into()),
            None => {}
        }
        let length = chunk.body.len() as i64;
        if count >= MAX_CHUNKS || bytes + length > MAX_SESSION_BYTES {
            return Err(Refusal::TooMuch.into());
        }
        self.connection.execute(
            "INSERT INTO chunks (participant, trial, number, sha256, received, body) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
            params![participant, chunk.trial, chunk.number, chunk.sha256, now, chunk.body],
        )?;
        self.connection.execute(
            "UPDATE sessions SET chunks = chunks + 1, bytes = bytes + ?2 WHERE participant = ?1",
            params![participant, length],
        )?;
        Ok(Put::Stored)
    }

    /// See [`Store::chunks`].
    pub fn chunks(&self, key: &str) -> Result<Vec<(u32, u32, String)>, Fault> {
        let (participant, _) = session(self.connection, key)?.ok_or(Refusal::Unknown)?;
        Ok(listed(self.connection, &participant)?)
    }

    /// See [`Store::finish`].
    pub fn finish(&self, key: &str, digest: &str, code: Option<&str>, now: i64) -> Result<String, Fault> {
        let (participant, is_finished) = session(self.connection, key)?.ok_or(Refusal::Unknown)?;
        let chunks = listed(self.connection, &participant)?;
        if chunks.is_empty() || whole_digest(&chunks) != digest {
            return Err(Refusal::NotWhole.into());
        }
        if !is_finished {
            let finish = "UPDATE sessions SET finished = ?2, digest = ?3 WHERE participant = ?1";
            self.connection.execute(finish, params![participant, now, digest])?;
        }
        let own = || keyed(self.secret, &format!("code {participant}"))[..CODE_DIGITS].to_uppercase();
        Ok(code.map_or_else(own, str::to_owned))
    }
}

impl Store {
    /// Begins a session, or finds the one that has begun with this key: in a transaction, so that no two
    /// participants get one number.
    ///
    /// # Errors
    /// [`Refusal::Form`], [`Refusal::Full`], [`Refusal::BegunBefore`], [`Refusal::Changed`].
    pub fn begin(&mut self, begin: &Begin) -> Result<Session, StoreError> {
        self.alone(|writing| writing.begin(begin))
    }

    /// Stores a chunk of the session with this key. When it returns, the chunk is on the disk.
    ///
    /// # Errors
    /// A [`Refusal`].
    pub fn put(&mut self, key: &str, chunk: &Chunk, now: i64) -> Result<Put, StoreError> {
        chunk.check()?;
        self.alone(|writing| writing.put(key, chunk, now))
    }

    /// The chunks that the session with this key has: trial, number, SHA-256, in this order.
    ///
    /// # Errors
    /// [`Refusal::Unknown`].
    pub fn chunks(&mut self, key: &str) -> Result<Vec<(u32, u32, String)>, StoreError> {
        self.alone(|writing| writing.chunks(key))
    }

    /// Ends the session with this key, if it has all that the digest says: the SHA-256 of a line `TRIAL
    /// NUMBER SHA256` for every chunk, in the order of the numbers. Returns the participant's code, `code` if
    /// it is given.
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
        self.alone(|writing| writing.finish(key, digest, code, now))
    }

    /// Does this in one transaction, which costs one synchronization of the disk: when it returns, all of it is
    /// on the disk, or nothing is.
    pub(crate) fn alone<T>(
        &mut self,
        work: impl FnOnce(&Writing) -> Result<T, Fault>,
    ) -> Result<T, StoreError> {
        let Self { file, connection, secret } = self;
        let write = || {
            let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
            let done = work(&Writing { connection: &transaction, secret })?;
            transaction.commit()?;
            Ok(done)
        };
        write().map_err(|fault| match fault {
            Fault::Refused(refusal) => refusal.into(),
            Fault::Database(source) => StoreError::Database { file: file.clone(), source },
        })
    }
}

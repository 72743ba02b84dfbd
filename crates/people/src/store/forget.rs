//! How a person is removed, with a proof.

use super::{Store, StoreError};
use rusqlite::TransactionBehavior;
use std::path::PathBuf;

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

/// The shortest identity that is searched for, bytes.
const MIN_SEARCHED: usize = 8;

impl Store {
    /// The pseudonyms that `id` stands for: itself, or those of this identity of a platform.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn participants_of(&self, id: &str) -> Result<Vec<String>, StoreError> {
        let read = || -> rusqlite::Result<Vec<String>> {
            let mut statement = self.connection.prepare(
                "SELECT participant FROM sessions WHERE participant = ?1
                 UNION SELECT participant FROM platform_ids WHERE value = ?1 ORDER BY participant",
            )?;
            statement.query_map([id], |row| row.get(0))?.collect()
        };
        read().map_err(|source| self.failed(source))
    }

    /// Removes a person, given by pseudonym or by an identity of a platform, with all that they answered.
    /// Afterwards the files of the store are searched for what identified the person.
    ///
    /// # Errors
    /// Nobody or more than one is known by this name; the file cannot be written, or still has a trace.
    pub fn forget(&mut self, id: &str) -> Result<Forgotten, StoreError> {
        let file = self.file.clone();
        let failed = |source| StoreError::Database { file: file.clone(), source };
        let refused = |sentence: String| StoreError::File { file: file.clone(), sentence };
        let participants = self.participants_of(id)?;
        let participant = match participants.as_slice() {
            [one] => one.clone(),
            [] => {
                return Err(refused(format!(
                    "nobody is known as `{id}`; give the number of a participant, or the id of a recruiting platform"
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
        // an identity that several people share, such as the platform's name of the study, identifies nobody,
        // and a shorter one is found by chance
        let mut statement = self.connection.prepare(
            "SELECT value FROM platform_ids AS own WHERE participant = ?1 AND NOT EXISTS
             (SELECT 1 FROM platform_ids WHERE value = own.value AND participant <> ?1)",
        )?;
        let values = statement.query_map([participant], |row| row.get(0))?;
        let mut traces = values.collect::<rusqlite::Result<Vec<String>>>()?;
        traces.retain(|value| value.len() >= MIN_SEARCHED);
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
            let has = |trace: &String| bytes.windows(trace.len()).any(|part| part == trace.as_bytes());
            if traces.iter().any(has) {
                let sentence =
                    "the rows are removed, but the file still has a trace; stop the server and try again";
                return Err(StoreError::File { file, sentence: sentence.to_owned() });
            }
            searched += bytes.len() as u64;
        }
        Ok(searched)
    }
}

//! How far the participants of a store are.

use super::{Store, StoreError, TIME, unsigned};

/// How far a participant is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Progress {
    /// The number, from 0.
    pub place: u64,
    /// SHA-256 of what the participant sees.
    pub study: String,
    /// Whether everything has arrived.
    pub is_finished: bool,
    /// The trial of which something arrived last, from 0; `None` before anything did.
    pub trial: Option<usize>,
    /// When something arrived last: seconds since 1970, and UTC.
    pub last: i64,
    /// See `last`.
    pub last_utc: String,
}

impl Store {
    /// How far every participant is, by number.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn progress(&self) -> Result<Vec<Progress>, StoreError> {
        let read = || {
            let mut statement = self.connection.prepare(&format!(
                "SELECT place, study_sha256, finished IS NOT NULL, trial, last, strftime({TIME}, last, 'unixepoch')
                 FROM (SELECT *, max(begun, ifnull(finished, 0), ifnull(received, 0)) AS last FROM sessions
                     LEFT JOIN (SELECT participant, max(trial) AS trial, max(received) AS received
                         FROM chunks GROUP BY participant) USING (participant))
                 ORDER BY place"
            ))?;
            let people = statement.query_map([], |row| {
                Ok(Progress {
                    place: unsigned(row.get(0)?),
                    study: row.get(1)?,
                    is_finished: row.get(2)?,
                    trial: row.get::<_, Option<u32>>(3)?.map(|trial| trial as usize),
                    last: row.get(4)?,
                    last_utc: row.get(5)?,
                })
            })?;
            people.collect::<rusqlite::Result<Vec<_>>>()
        };
        read().map_err(|source| self.failed(source))
    }
}

//! Episodes of a file of results, run again and compared.

use super::results::{Rows, check_values};
use super::{Study, SweepError, row};
use crate::parallel::{OnDone, in_parallel};
use std::collections::BTreeSet;
use std::path::Path;

/// The number of rows in memory.
const CHUNK: usize = 512;

/// A row that differs when its episode is run again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The episode.
    pub episode: u64,
    /// The columns that differ: name, value in the file, value now.
    pub values: Vec<[String; 3]>,
}

/// Runs these episodes again, on all threads of the current pool, and compares their rows with those of a file
/// of results. Returns those that differ, in order.
///
/// # Errors
/// [`SweepError`]: the file cannot be read, or has rows of another study, or lacks an episode.
pub fn different(
    study: &Study,
    path: &Path,
    episodes: &BTreeSet<u64>,
    on_done: OnDone,
) -> Result<Vec<Difference>, SweepError> {
    let mut rows = Rows::open(path)?;
    let mut left = episodes.iter().copied().peekable();
    let (mut found, mut chunk) = (Vec::new(), Vec::with_capacity(CHUNK));
    loop {
        let identity = rows.next()?;
        if let Some(identity) = &identity {
            super::partial::check_study(study, identity, &rows.file, rows.position())?;
            if left.next_if(|episode| *episode == identity.episode).is_some() {
                check_values(&rows.line, &rows.file, rows.position())?;
                chunk.push((identity.episode, std::mem::take(&mut rows.line)));
            }
        }
        if chunk.len() == CHUNK || identity.is_none() || left.peek().is_none() {
            let again = in_parallel(chunk.len(), on_done, |i| study.run(chunk[i].0));
            let pairs = chunk.drain(..).zip(again).filter(|((_, line), now)| line != now);
            found.extend(
                pairs.map(|((episode, line), now)| Difference { episode, values: differing(&line, &now) }),
            );
        }
        match (identity, left.peek()) {
            (_, None) => return Ok(found),
            (Some(_), _) => {}
            (None, Some(episode)) => {
                return Err(SweepError::row(
                    rows.position(),
                    rows.file,
                    "the end of the file".to_owned(),
                    format!("episode {episode}"),
                ));
            }
        }
    }
}

/// The columns in which two rows differ, without that of the checksum.
fn differing(line: &[u8], now: &[u8]) -> Vec<[String; 3]> {
    let fields = |line: &[u8]| -> Vec<String> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line);
        let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
        record.iter().map(str::to_owned).collect()
    };
    let columns = row::columns().into_iter().zip(fields(line)).zip(fields(now));
    columns
        .filter(|((name, was), now)| *name != "checksum" && was != now)
        .map(|((name, was), now)| [name.to_owned(), was, now])
        .collect()
}

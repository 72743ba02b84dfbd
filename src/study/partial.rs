//! Running sweeps, whose rows are in a partial file beside the results until the sweep is complete. The
//! partial file may end anywhere; the sweep resumes from it.
//!
//! The partial file is the beginning of the final one: rows are appended in order, each batch in one write. A
//! killed process leaves complete rows, and at worst one incomplete row, which is removed. Every row names
//! its study, so no other file is needed.

use super::ordered::in_order;
use super::results::{self, Identity};
use super::{Study, SweepError, row};
use crate::arithmetic;
use crate::located::FileError;
use crate::output_file::{OutputError, OutputFile};
use crate::parallel::OnDone;
use std::fs::File;
use std::io::{BufReader, Write};
use std::ops::Range;
use std::path::Path;

/// A shard of a study, for one of several computers: a contiguous range of its episodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 1.
    pub number: u64,
    /// The number of shards.
    pub of: u64,
}

impl Shard {
    /// The shard's episodes in a study with a number of episodes. The shards together have every episode
    /// once.
    pub fn episodes(self, all: u64) -> Range<u64> {
        let end = |number: u64| (u128::from(all) * u128::from(number) / u128::from(self.of.max(1))) as u64;
        end(self.number.saturating_sub(1))..end(self.number)
    }
}

/// A sweep that is ready to run or to resume.
#[derive(Debug)]
pub struct Sweep<'a> {
    study: &'a Study,
    file: OutputFile,
    episodes: Range<u64>,
    kept: u64,
}

impl<'a> Sweep<'a> {
    /// Opens the partial file of `path`, and keeps its rows. With `overwrite`, an existing file of results is
    /// replaced at the end, and rows of another study are dropped.
    ///
    /// # Errors
    /// [`SweepError`]: the results are there already, or rows of another study, or another process is writing
    /// them.
    pub fn open(
        study: &'a Study,
        path: &Path,
        shard: Option<Shard>,
        overwrite: bool,
    ) -> Result<Self, SweepError> {
        let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
        let (mut file, _) = OutputFile::resumable(path, overwrite)?;
        file.keep();
        let partial = file.partial().to_owned();
        let write = |source| OutputError::Write { file: partial.clone(), source };
        let (bytes, kept) = match rows_kept(study, file.as_file(), &partial.display().to_string(), &episodes)
        {
            Err(error @ (SweepError::File(_) | SweepError::Output(_))) => return Err(error),
            Err(_) if overwrite => (0, 0),
            other => other?,
        };
        file.cut(bytes).map_err(write)?;
        if bytes == 0 {
            file.write_all(&row::header()).and_then(|()| file.flush()).map_err(write)?;
        }
        Ok(Self { study, file, episodes, kept })
    }

    /// The number of episodes whose rows existed already.
    pub fn kept(&self) -> u64 {
        self.kept
    }

    /// The number of episodes of the sweep, or of its shard.
    pub fn episodes(&self) -> u64 {
        self.episodes.end - self.episodes.start
    }

    /// Runs the remaining episodes on all threads of the current pool, and renames the file.
    ///
    /// # Errors
    /// [`SweepError::Output`]; the rows written so far stay in the partial file.
    pub fn run(self, on_done: OnDone) -> Result<(), SweepError> {
        let Self { study, mut file, episodes, kept } = self;
        let left = episodes.start + kept..episodes.end;
        let append = |lines: &[u8], count: u64| {
            file.write_all(lines)?;
            file.flush()?;
            (0..count).for_each(|_| on_done());
            Ok(())
        };
        let done = in_order(left, |episode| study.run(episode), append);
        let partial = file.partial().to_owned();
        done.map_err(|source| OutputError::Write { file: partial, source })?;
        Ok(file.finish()?)
    }
}

/// The number of bytes of the file that can be kept, and the number of rows in them.
fn rows_kept(
    study: &Study,
    file: &File,
    name: &str,
    episodes: &Range<u64>,
) -> Result<(u64, u64), SweepError> {
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    let (mut bytes, mut kept) = (0, 0);
    loop {
        let read = results::read_line(&mut reader, &mut line);
        read.map_err(|source| FileError::Read { file: name.to_owned(), source })?;
        if line.last() != Some(&b'\n') {
            // the end of the file, or an incomplete row
            if bytes == 0 && !row::header().starts_with(&line) {
                results::check_header(&line, name)?;
            }
            return Ok((bytes, kept));
        }
        if bytes == 0 {
            results::check_header(&line, name)?;
        } else {
            let due = episodes.start + kept;
            check_row(study, &line, name, kept + 2, due, episodes.end)?;
            kept += 1;
        }
        bytes += line.len() as u64;
    }
}

/// The check that a row belongs to the next episode.
fn check_row(
    study: &Study,
    line: &[u8],
    file: &str,
    number: u64,
    due: u64,
    end: u64,
) -> Result<(), SweepError> {
    let found = Identity::of_line(line, file, number)?;
    check_study(study, &found, file, number)?;
    if found.episode != due || due >= end {
        let expected = if due < end { format!("episode {due}") } else { "the end of the file".to_owned() };
        let found = format!("episode {}", found.episode);
        return Err(SweepError::Line { file: file.to_owned(), line: number, found, expected });
    }
    results::check_values(line, file, number)
}

/// The check that a row is of this study and of this machine's arithmetic.
pub(super) fn check_study(
    study: &Study,
    found: &Identity,
    file: &str,
    number: u64,
) -> Result<(), SweepError> {
    if (found.study.as_str(), found.episodes) != (study.digest(), study.episodes()) {
        return Err(SweepError::OtherStudy {
            file: file.to_owned(),
            line: number,
            found: found.study.clone(),
            expected: study.digest().to_owned(),
        });
    }
    if found.arithmetic != arithmetic::stamp() {
        return Err(SweepError::OtherArithmetic {
            file: format!("{file}: line {number}"),
            found: found.arithmetic.clone(),
            other: "this program".to_owned(),
            expected: arithmetic::stamp().to_owned(),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_shards_have_every_episode_once() {
        for (all, of) in [(10, 4), (3, 8), (1, 1), (1_000_003, 7), (0, 3)] {
            let mut next = 0;
            for number in 1..=of {
                let range = Shard { number, of }.episodes(all);
                assert_eq!(range.start, next);
                next = range.end;
            }
            assert_eq!(next, all);
        }
    }
}

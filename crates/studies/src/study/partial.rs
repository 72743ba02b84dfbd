//! Running sweeps, whose rows are in a partial file next to the results until the sweep is complete. The
//! partial file may end anywhere; the sweep resumes from it.
//!
//! The partial file is the beginning of the final one: rows are appended in order, each batch in one write. A
//! killed process leaves complete rows, and at worst one incomplete row, which is removed. Every row names
//! its study, so no other file is needed.

use super::error::Position;
use super::ordered::in_order;
use super::partners::{BuiltIn, EpisodeMaker};
use super::results::{self, Identity};
use super::tables::{self, Ticks};
use super::{Study, SweepError, row};
use crate::parallel::OnDone;
use cocarry::arithmetic;
use cocarry::located;
use cocarry_output::output_file::{OutputError, OutputFile};
use std::borrow::Borrow;
use std::fs::File;
use std::io::{BufReader, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

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

/// How far rows may be ahead of the first missing one.
const WINDOW: u64 = 1024;
/// The same with ticks, which are larger.
const WINDOW_WITH_TICKS: u64 = 64;

/// Where a sweep writes.
#[derive(Clone, Copy, Debug)]
pub struct SweepOutputs<'a> {
    /// The file of results: Parquet if its name ends in `.parquet`, else CSV.
    pub rows: &'a Path,
    /// The folder of the ticks, if wanted.
    pub ticks: Option<&'a Path>,
    /// Whether existing outputs are replaced at the end, and rows and ticks of another study dropped.
    pub overwrite: bool,
}

/// A sweep of a study (`&Study`, `Arc<Study>`, ...) that is ready to run or to resume.
#[derive(Debug)]
pub struct Sweep<S> {
    study: S,
    path: PathBuf,
    file: OutputFile,
    ticks: Option<Ticks>,
    episodes: Range<u64>,
    kept: u64,
}

impl<S: Borrow<Study>> Sweep<S> {
    /// Opens the partial outputs, and keeps their rows and ticks.
    ///
    /// # Errors
    /// [`SweepError`]: the results are there already, or rows of another study, or another process is writing
    /// them; or the program has no Parquet.
    pub fn open(
        owner: S,
        shard: Option<Shard>,
        SweepOutputs { rows: path, ticks, overwrite }: SweepOutputs,
    ) -> Result<Self, SweepError> {
        let study = owner.borrow();
        if ticks == Some(path) {
            return Err(SweepError::same_name(path.display().to_string()));
        }
        results::check_name(path)?;
        let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
        if let Some(folder) = ticks {
            tables::check(&folder.display().to_string())?;
        }
        let (mut file, _) = OutputFile::resumable(path, overwrite)?;
        let ticks =
            ticks.map(|folder| Ticks::open(study, folder, episodes.clone(), overwrite)).transpose()?;
        file.keep();
        // rows count only with their ticks, whose files are complete
        let is_kept = |kept: u64| {
            ticks.as_ref().is_none_or(|t| kept <= t.covered() && t.begins_file(episodes.start + kept))
        };
        let partial = file.partial().to_owned();
        let write = |source| OutputError::write(&partial, source);
        let found = rows_kept(study, file.as_file(), &partial.display().to_string(), &episodes, is_kept);
        let (bytes, kept) = match found {
            Err(error @ (SweepError::File(_) | SweepError::Output(_))) => return Err(error),
            Err(_) if overwrite => (0, 0),
            other => other?,
        };
        file.cut(bytes).map_err(write)?;
        if bytes == 0 {
            file.write_all(&row::header()).and_then(|()| file.flush()).map_err(write)?;
        }
        Ok(Self { study: owner, path: path.to_owned(), file, ticks, episodes, kept })
    }

    /// The number of episodes whose rows existed already, with their ticks if wanted.
    pub fn kept(&self) -> u64 {
        self.kept
    }

    /// The number of episodes of the sweep, or of its shard.
    pub fn episodes(&self) -> u64 {
        self.episodes.end - self.episodes.start
    }

    /// Appends the rows of the next episodes, which ran elsewhere ([`Study::rows`]). Each is checked as those
    /// of an unfinished file are.
    ///
    /// # Errors
    /// [`SweepError`]: a row is not the next one, of another study or another arithmetic, or damaged; or it
    /// cannot be written. The rows before are kept.
    pub fn append(&mut self, rows: &[u8]) -> Result<(), SweepError> {
        let partial = self.file.partial().to_owned();
        let name = partial.display().to_string();
        let write = |source| OutputError::write(&partial, source);
        for line in rows.split_inclusive(|byte| *byte == b'\n') {
            let due = self.episodes.start + self.kept;
            check_row(self.study.borrow(), line, &name, self.kept + 2, due, self.episodes.end)?;
            self.file.write_all(line).map_err(write)?;
            self.kept += 1;
        }
        Ok(self.file.flush().map_err(write)?)
    }

    /// Runs the remaining episodes on all threads of the current pool, and gives the outputs their names.
    ///
    /// With `stop` it stops after the episodes that are running.
    ///
    /// # Errors
    /// [`SweepError::Output`] or [`SweepError::Stopped`]; the rows and ticks written so far stay in the
    /// partial outputs.
    pub fn run(self, on_done: OnDone, stop: &AtomicBool) -> Result<(), SweepError> {
        self.run_with(&BuiltIn, on_done, stop)
    }

    /// As [`Sweep::run`], for a study with custom partners. It also stops before an episode that was given up.
    ///
    /// # Errors
    /// As [`Sweep::run`].
    pub fn run_with(
        self,
        maker: &dyn EpisodeMaker,
        on_done: OnDone,
        stop: &AtomicBool,
    ) -> Result<(), SweepError> {
        let Self { study: owner, path, mut file, mut ticks, episodes, kept } = self;
        let study = owner.borrow();
        let left = episodes.start + kept..episodes.end;
        let mut append = |lines: &[Vec<u8>]| {
            let is_made = lines.iter().take_while(|line| !line.is_empty()).count();
            let written = file.write_all(&lines[..is_made].concat()).and_then(|()| file.flush());
            written.map_err(|source| OutputError::write(file.partial(), source))?;
            (0..is_made).for_each(|_| on_done());
            match stop.load(Ordering::Relaxed) || is_made < lines.len() {
                true => Err(SweepError::Stopped { file: file.partial().to_owned() }),
                false => Ok(()),
            }
        };
        match &mut ticks {
            None => in_order(left, WINDOW, |episode| study.row(episode, maker), |lines| append(&lines))?,
            Some(ticks) => {
                let (layout, mut due) = (ticks.layout(), left.start);
                in_order(
                    left,
                    WINDOW_WITH_TICKS,
                    |episode| layout.run(study, episode, maker),
                    |results| {
                        for (line, batch) in results {
                            // ticks first: rows without ticks would be dropped
                            if !line.is_empty() {
                                ticks.add(due, batch)?;
                            }
                            append(&[line])?;
                            due += 1;
                        }
                        Ok::<(), SweepError>(())
                    },
                )?;
            }
        }
        ticks.map_or(Ok(()), Ticks::finish)?;
        results::finish(file, &path, &study.origin())
    }
}

/// The lines of the results of a study, or of a shard of it, run on all threads of the current pool.
///
/// `stop` and `on_done` are as for [`Sweep::run`].
///
/// # Errors
/// [`SweepError::Stopped`], also where an episode was given up.
pub fn rows_with(
    study: &Study,
    shard: Option<Shard>,
    maker: &dyn EpisodeMaker,
    on_done: OnDone,
    stop: &AtomicBool,
) -> Result<Vec<Vec<u8>>, SweepError> {
    let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
    let mut rows = Vec::new();
    let append = |lines: Vec<Vec<u8>>| {
        let is_over = stop.load(Ordering::Relaxed) || lines.iter().any(Vec::is_empty);
        lines.iter().for_each(|_| on_done());
        rows.extend(lines);
        match is_over {
            true => Err(SweepError::Stopped { file: PathBuf::new() }),
            false => Ok(()),
        }
    };
    in_order(episodes, WINDOW, |episode| study.row(episode, maker), append)?;
    Ok(rows)
}

/// The number of rows in `path`, if these are all rows of the study, or of a shard of it, as CSV: a sweep
/// would write the same file.
pub fn complete_rows(study: &Study, shard: Option<Shard>, path: &Path) -> Option<u64> {
    // a sweep would not write a file of another name
    results::check_name(path).ok()?;
    let episodes = shard.map_or(0..study.episodes(), |shard| shard.episodes(study.episodes()));
    let file = located::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let (bytes, rows) = rows_kept(study, &file, &path.display().to_string(), &episodes, |_| true).ok()?;
    (bytes == length && rows == episodes.end - episodes.start).then_some(rows)
}

/// The number of bytes of the file that can be kept, and the number of rows in them, which `is_kept` allows.
fn rows_kept(
    study: &Study,
    file: &File,
    name: &str,
    episodes: &Range<u64>,
    is_kept: impl Fn(u64) -> bool,
) -> Result<(u64, u64), SweepError> {
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    let (mut bytes, mut rows) = (0, 0);
    let mut end = (0, 0);
    loop {
        let read = results::read_line(&mut reader, &mut line);
        read.map_err(|source| located::unreadable(name, source))?;
        if line.last() != Some(&b'\n') {
            // the end of the file, or an incomplete row
            if bytes == 0 && !row::header().starts_with(&line) {
                results::check_header(&line, name)?;
            }
            return Ok(end);
        }
        if bytes == 0 {
            results::check_header(&line, name)?;
        } else {
            let due = episodes.start + rows;
            check_row(study, &line, name, rows + 2, due, episodes.end)?;
            rows += 1;
        }
        bytes += line.len() as u64;
        if is_kept(rows) {
            end = (bytes, rows);
        }
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
    let found = Identity::of_line(line, file, Position::Line(number))?;
    check_study(study, &found, file, Position::Line(number))?;
    if found.episode != due || due >= end {
        let expected = if due < end { format!("episode {due}") } else { "the end of the file".to_owned() };
        let found = format!("episode {}", found.episode);
        return Err(SweepError::row(Position::Line(number), file.to_owned(), found, expected));
    }
    results::check_values(line, file, Position::Line(number))
}

/// The check that a row is of this study and of this machine's arithmetic.
pub(super) fn check_study(
    study: &Study,
    found: &Identity,
    file: &str,
    position: Position,
) -> Result<(), SweepError> {
    if (found.study.as_str(), found.episodes) != (study.digest(), study.episodes()) {
        return Err(SweepError::other_study(
            file.to_owned(),
            position,
            found.study.clone(),
            study.digest().to_owned(),
        ));
    }
    if found.arithmetic != arithmetic::stamp() {
        return Err(SweepError::other_arithmetic(
            format!("{file}: {position}"),
            found.arithmetic.clone(),
            "this program".to_owned(),
            arithmetic::stamp().to_owned(),
        ));
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

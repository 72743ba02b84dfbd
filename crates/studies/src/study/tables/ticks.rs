//! The ticks of a whole sweep: a folder of Parquet files, one for every hundred episodes of the study.
//!
//! A file has every planning step of its episodes in order, with the columns of `cocarry run --ticks`, the
//! number and the seed of the episode, and the inputs that vary. Its name has the first and the last of its
//! episodes, and its bytes depend on them only. The files are in `FOLDER.partial` until the sweep is
//! complete: each appears under its name when it is complete, and a sweep that was stopped resumes where rows
//! and files are both there.

use super::{ARITHMETIC, DIGEST, open, properties, system_error, unread, value_of};
use crate::columns::Columns;
use crate::study::{EpisodeMaker, Origin, Study, SweepError, row};
use arrow_array::RecordBatch;
use arrow_schema::{ArrowError, SchemaRef};
use cocarry::quantities::{Heading, TICK, Value, View};
use cocarry_output::output_file::{OutputError, OutputFile};
use parquet::arrow::ArrowWriter;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Episodes of a file.
const EPISODES: u64 = 100;
/// The file that marks a folder whose files are being written.
const LOCK: &str = ".lock";
/// The inputs that every file has; others if they vary.
const INPUTS: [&str; 3] = ["world", "plant", "method"];

/// The files of a sweep's ticks, which are being written.
#[derive(Debug)]
pub(in crate::study) struct Ticks {
    folder: PathBuf,
    partial: PathBuf,
    overwrite: bool,
    lock: File,
    origin: Origin,
    episodes: Range<u64>,
    covered: u64,
    layout: ChunkLayout,
    file: Option<ArrowWriter<OutputFile>>,
}

/// The columns of the ticks of a study.
#[derive(Clone, Debug)]
pub(in crate::study) struct ChunkLayout {
    schema: SchemaRef,
    /// The indices of the inputs that the files have.
    inputs: Vec<usize>,
}

/// The ticks of an episode.
pub(in crate::study) type Batch = Result<RecordBatch, ArrowError>;

impl ChunkLayout {
    fn of(study: &Study) -> Self {
        let names: Vec<&str> = row::input_columns().collect();
        let first = study.inputs(0);
        let mut varies: Vec<bool> = names.iter().map(|name| INPUTS.contains(name)).collect();
        for cell in 1..study.cells.len() {
            let differs = study.inputs(cell).into_iter().zip(&first).map(|(value, first)| value != *first);
            varies.iter_mut().zip(differs).for_each(|(varies, differs)| *varies |= differs);
        }
        let inputs: Vec<usize> = (0..names.len()).filter(|i| varies[*i]).collect();
        let all = row::headings();
        let heading = |name: &str| all.iter().find(|heading| heading.name == name).cloned();
        let names =
            ["episode", "seed"].into_iter().chain(inputs.iter().map(|i| names[*i])).chain(["alpha", "gamma"]);
        let headings: Vec<Heading> =
            names.filter_map(heading).chain(TICK.into_iter().flatten().map(Heading::from)).collect();
        Self { schema: Columns::new(&headings).schema().clone(), inputs }
    }

    /// Runs an episode: its line of results, which is empty if the episode is given up, and its ticks.
    pub fn run(&self, study: &Study, episode: u64, maker: &dyn EpisodeMaker) -> (Vec<u8>, Batch) {
        let columns = RefCell::new(Columns::of_schema(self.schema.clone()));
        let Some((cell, seed)) = study.place(episode) else {
            return (Vec::new(), columns.into_inner().batch());
        };
        let mut scenario = study.drawn(cell, seed);
        // as in `run --ticks`; the rows do not depend on it
        scenario.settings.predict_while_human_leads = true;
        let inputs = study.inputs(cell);
        let before = [episode.to_string(), seed.to_string()];
        let after = [scenario.human.alpha.to_string(), scenario.human.gamma.to_string()];
        let cells: Vec<&str> = before
            .iter()
            .chain(self.inputs.iter().map(|i| &inputs[*i]))
            .chain(&after)
            .map(String::as_str)
            .collect();
        let line = study.row_of(episode, cell, scenario, maker, &|prepared, episode| {
            let view = View::new(prepared, episode);
            let values: Vec<Value> =
                TICK.into_iter().flat_map(|table| view.read(table)).map(|(_, value)| value).collect();
            columns.borrow_mut().add(cells.iter().copied(), &values);
        });
        (line, columns.into_inner().batch())
    }
}

impl Ticks {
    /// Opens the folder's partial one, and keeps its files of this study. With `overwrite`, an existing folder
    /// of ticks is replaced at the end, and files of another study are removed.
    ///
    /// # Errors
    /// [`SweepError`]: the folder is there already, or something else is in it, or another process is writing
    /// it.
    pub fn open(
        study: &Study,
        folder: &Path,
        episodes: Range<u64>,
        overwrite: bool,
    ) -> Result<Self, SweepError> {
        let mut name = folder.as_os_str().to_owned();
        name.push(".partial");
        let partial = PathBuf::from(name);
        let write = |source| OutputError::write(&partial, source);
        if is_folder(folder)? {
            if !overwrite {
                return Err(OutputError::exists(folder).into());
            }
            // nothing but ticks is ever replaced
            files(folder)?;
        }
        if !is_folder(&partial)? {
            std::fs::create_dir(&partial).map_err(write)?;
        }
        let lock = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(partial.join(LOCK))
            .map_err(write)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(OutputError::busy(&partial).into()),
            Err(TryLockError::Error(source)) => return Err(write(source).into()),
        }
        let mut ticks = Self {
            folder: folder.to_owned(),
            overwrite,
            lock,
            origin: study.origin(),
            covered: 0,
            layout: ChunkLayout::of(study),
            file: None,
            episodes,
            partial,
        };
        ticks.covered = ticks.keep()?;
        Ok(ticks)
    }

    /// Checks the files that are there, and returns the number of episodes from the first on that they have.
    fn keep(&self) -> Result<u64, SweepError> {
        let mut found = files(&self.partial)?;
        let mut next = self.episodes.start;
        while next < self.episodes.end {
            let range = self.file_of(next);
            let Some(path) = found.remove(&name(&range)) else { break };
            if !self.keeps(&path)? {
                break;
            }
            next = range.end;
        }
        // those after a gap are written again
        for path in found.values() {
            if self.keeps(path)? {
                remove(path)?;
            }
        }
        Ok(next - self.episodes.start)
    }

    /// Whether a file is of this study. With `overwrite` others are removed, without they are errors.
    fn keeps(&self, path: &Path) -> Result<bool, SweepError> {
        match self.is_of_study(path) {
            Ok(true) => Ok(true),
            _ if self.overwrite => Ok(remove(path).map(|()| false)?),
            Ok(false) => Err(self.foreign(path)),
            Err(error) => Err(error),
        }
    }

    fn foreign(&self, path: &Path) -> SweepError {
        SweepError::ticks(
            self.partial.display().to_string(),
            format!("{}, which belongs to another study or arithmetic", file_name(path)),
            "remove it, choose another folder, or give --overwrite",
        )
    }

    fn is_of_study(&self, path: &Path) -> Result<bool, SweepError> {
        let name = path.display().to_string();
        let read = |source| cocarry::located::unreadable(&name, source);
        let file = File::open(path).map_err(read)?;
        let reader = open(file).map_err(|error| unread(&name, error))?;
        let pairs = reader.metadata().file_metadata().key_value_metadata();
        let expected = [(DIGEST, &self.origin.study), (ARITHMETIC, &self.origin.arithmetic)];
        Ok(expected.into_iter().all(|(key, value)| value_of(pairs, key) == Some(value)))
    }

    /// The number of episodes from the first on whose files are there.
    pub fn covered(&self) -> u64 {
        self.covered
    }

    /// Whether a file begins with this episode.
    pub fn begins_file(&self, episode: u64) -> bool {
        episode == self.episodes.end || self.file_of(episode).start == episode
    }

    /// The layout, which runs episodes.
    pub fn layout(&self) -> ChunkLayout {
        self.layout.clone()
    }

    /// The episodes of the file that has this one.
    fn file_of(&self, episode: u64) -> Range<u64> {
        let begin = episode - episode % EPISODES;
        begin.max(self.episodes.start)..(begin + EPISODES).min(self.episodes.end)
    }

    /// Adds the ticks of the next episode. Files are written in the order of their episodes.
    ///
    /// # Errors
    /// [`SweepError::Output`].
    pub fn add(&mut self, episode: u64, batch: Batch) -> Result<(), SweepError> {
        let range = self.file_of(episode);
        let path = self.partial.join(name(&range));
        let write = |error| OutputError::write(&path, system_error(error));
        let mut file = match self.file.take() {
            Some(file) => file,
            None => {
                let file = OutputFile::create(&path, true)?;
                let schema = self.layout.schema.clone();
                ArrowWriter::try_new(file, schema, Some(properties(&self.origin))).map_err(write)?
            }
        };
        file.write(&batch.map_err(|error| write(error.into()))?).map_err(write)?;
        match episode + 1 == range.end {
            true => file.into_inner().map_err(write)?.finish()?,
            false => self.file = Some(file),
        }
        Ok(())
    }

    /// Gives the folder its name.
    ///
    /// # Errors
    /// [`SweepError`], also if the name is taken meanwhile.
    pub fn finish(self) -> Result<(), SweepError> {
        let rename = |source| OutputError::rename(&self.partial, &self.folder, source);
        if is_folder(&self.folder)? {
            if !self.overwrite {
                return Err(OutputError::exists(&self.folder).into());
            }
            for path in files(&self.folder)?.values() {
                remove(path)?;
            }
            std::fs::remove_dir(&self.folder).map_err(rename)?;
        }
        std::fs::remove_file(self.partial.join(LOCK)).map_err(rename)?;
        std::fs::rename(&self.partial, &self.folder).map_err(rename)?;
        Ok(())
    }
}

impl Drop for Ticks {
    /// Removes the partial folder if it is still empty.
    fn drop(&mut self) {
        if files(&self.partial).is_ok_and(|files| files.is_empty()) {
            // if the removal fails, the first error is the one to report
            let _ = std::fs::remove_file(self.partial.join(LOCK));
            let _ = std::fs::remove_dir(&self.partial);
        }
        // as for an output file
        let _ = self.lock.unlock();
    }
}

/// The name of the file of these episodes. Names are in the order of the episodes.
fn name(episodes: &Range<u64>) -> String {
    format!("episodes-{:010}-{:010}.parquet", episodes.start, episodes.end.saturating_sub(1))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn remove(path: &Path) -> Result<(), OutputError> {
    std::fs::remove_file(path).map_err(|source| OutputError::write(path, source))
}

/// Whether there is a folder of that name; an error if the name is that of something else.
fn is_folder(path: &Path) -> Result<bool, OutputError> {
    match path.symlink_metadata() {
        Ok(found) if found.is_dir() => Ok(true),
        Ok(found) => {
            let kind = if found.is_symlink() { "symbolic link" } else { "file" };
            Err(OutputError::not_a_folder(path, kind))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(source) => Err(OutputError::write(path, source)),
    }
}

/// The files of ticks in a folder, by name. Unfinished ones are removed.
fn files(folder: &Path) -> Result<BTreeMap<String, PathBuf>, SweepError> {
    let read = |source: Error| OutputError::write(folder, source);
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(read)? {
        let path = entry.map_err(read)?.path();
        let name = file_name(&path);
        let is_file = path.symlink_metadata().is_ok_and(|found| found.is_file());
        let ends = |begin: &str, end: &str| name.starts_with(begin) && name.ends_with(end);
        if is_file && ends("episodes-", ".parquet") {
            found.insert(name, path);
        } else if is_file && ends(".cocarry-", ".tmp") {
            remove(&path)?;
        } else if name != LOCK {
            return Err(SweepError::ticks(folder.display().to_string(), name, "choose another folder"));
        }
    }
    Ok(found)
}

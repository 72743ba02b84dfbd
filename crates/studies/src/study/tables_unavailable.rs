//! The replacement of `tables` in a program without the feature `parquet`: it refuses Parquet files.

use super::origin::Origin;
use super::{EpisodeMaker, Study, SweepError};
use std::convert::Infallible;
use std::fs::File;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::path::Path;

/// The check that this program can write such files: it cannot.
pub(super) fn check(file: &str) -> Result<(), SweepError> {
    Err(SweepError::no_parquet(file.to_owned()))
}

pub(super) fn write(_: impl Read, _: impl Write + Send, _: &Origin) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// A reader that does not exist.
pub(super) struct RowReader(Infallible);

impl RowReader {
    /// The refusal.
    pub fn open(_: File, name: &str) -> Result<Self, SweepError> {
        check(name).and(Err(SweepError::no_parquet(name.to_owned())))
    }

    pub fn study_text(&self) -> Option<&str> {
        match self.0 {}
    }

    pub fn next(&mut self) -> Result<Vec<u8>, SweepError> {
        match self.0 {}
    }
}

/// Ticks that do not exist.
#[derive(Debug)]
pub(super) struct Ticks(Infallible);

impl Ticks {
    /// The refusal.
    pub fn open(_: &Study, folder: &Path, _: Range<u64>, _: bool) -> Result<Self, SweepError> {
        Err(SweepError::no_parquet(folder.display().to_string()))
    }

    pub fn begins_file(&self, _: u64) -> bool {
        match self.0 {}
    }

    pub fn covered(&self) -> u64 {
        match self.0 {}
    }

    pub fn layout(&self) -> ChunkLayout {
        match self.0 {}
    }

    pub fn add(&mut self, _: u64, _: Infallible) -> Result<(), SweepError> {
        match self.0 {}
    }

    pub fn finish(self) -> Result<(), SweepError> {
        match self.0 {}
    }
}

/// Columns that do not exist.
#[derive(Clone)]
pub(super) struct ChunkLayout(Infallible);

impl ChunkLayout {
    pub fn run(&self, _: &Study, _: u64, _: &dyn EpisodeMaker) -> (Vec<u8>, Infallible) {
        match self.0 {}
    }
}

//! Errors of study files and of the files of a sweep, each with its file, place and value.

use crate::fit::{NAME, bad_cell};
use cocarry::error::{Error, Place};
use cocarry::suggestion::{Expected, hint};
use cocarry_output::output_file::OutputError;
use std::fmt;
use std::path::PathBuf;

/// The error of the system or of another part.
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a sweep was refused, or stopped.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] Error),
    /// A value of a study, or a file or a row of results, is refused.
    #[error(transparent)]
    Refused(Error),
    /// A file cannot be written, or may not be.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The sweep was stopped.
    #[error("{} holds the rows so far; run the same command to resume", file.display())]
    Stopped {
        /// The partial file.
        file: PathBuf,
    },
}

/// The sentences.
impl SweepError {
    fn at(place: Place, sentence: fmt::Arguments) -> Self {
        Self::Refused(Error::at(place, sentence))
    }

    fn of_file(file: impl Into<String>, sentence: fmt::Arguments) -> Self {
        Self::at(Place::file(file), sentence)
    }

    /// A value that is not allowed for the key at `place`.
    pub(super) fn value(place: Place, value: String, expected: Expected) -> Self {
        let hint = expected.hint(value.trim_matches('"'));
        Self::Refused(Error::value(place, format_args!("{value}; it must be {expected}{hint}")))
    }

    /// A key that is not one of those known.
    pub(super) fn unknown_key(place: Place, known: Vec<String>) -> Self {
        let hint = hint(&place.item, known.iter().map(String::as_str));
        Self::at(place, format_args!("unknown key{hint}; expected one of: {}", known.join(", ")))
    }

    /// A required key that is missing.
    pub(super) fn missing(place: Place, key: &str, expected: impl fmt::Display) -> Self {
        Self::at(place, format_args!("{key} is missing; it must be {expected}"))
    }

    /// A value or a name that is there already.
    pub(super) fn duplicate(place: Place, value: String) -> Self {
        Self::at(place, format_args!("duplicate {value}"))
    }

    /// A key that applies to no plant of its run.
    pub(super) fn idle(place: Place, what: &str) -> Self {
        Self::at(place, format_args!("needs {what}, which no plant of this run has"))
    }

    /// A run that has an episode of an earlier one.
    pub(super) fn repeated(place: Place, seed: u64, inputs: String) -> Self {
        let sentence = format_args!(
            "seed {seed} of this combination is already covered by an earlier [[run]]: {inputs}"
        );
        Self::at(place, sentence)
    }

    /// A study with too many combinations.
    pub(super) fn too_many(place: Place, most: usize, what: &str) -> Self {
        Self::at(place, format_args!("more than {most} {what}; use more seeds and fewer values"))
    }

    /// A world or a robot, named at this place, that is not valid.
    pub(super) fn named(place: Place, source: impl Into<Cause>) -> Self {
        Self::Refused(Error::new(place.to_string()).because(source))
    }

    /// A combination that is not a valid scenario.
    pub(super) fn scenario(file: String, inputs: String, source: impl Into<Cause>) -> Self {
        Self::Refused(Error::new(format!("{file}: {inputs}")).because(source))
    }

    /// A row of another study.
    pub(super) fn other_study(file: String, position: Position, found: String, expected: String) -> Self {
        let sentence = format_args!(
            "{position} is of study {found}, this is study {expected}: a file, an option, the code of a custom partner or the program has changed; --overwrite starts again"
        );
        Self::of_file(file, sentence)
    }

    /// Rows that were calculated with another arithmetic than those of `other`.
    pub(super) fn other_arithmetic(file: String, found: String, other: String, expected: String) -> Self {
        let sentence = format_args!(
            "calculated with arithmetic {found}, {other} has {expected}: the last bits of their results may differ; run all rows on machines and a version with the same arithmetic (--overwrite starts again)"
        );
        Self::of_file(file, sentence)
    }

    /// A file with another column, counted from 1, than that of this version.
    pub(super) fn columns(file: String, column: usize, found: String, expected: String) -> Self {
        let sentence = format_args!(
            "not the results of a sweep of this version: column {column} is {found}; expected {expected}"
        );
        Self::of_file(file, sentence)
    }

    /// A row that is not the expected one.
    pub(super) fn row(position: Position, file: String, found: String, expected: String) -> Self {
        Self::of_file(file, format_args!("{position} is {found}; it must be {expected}"))
    }

    /// A row without a name that every row has.
    pub(super) fn missing_name(file: &str, position: Position, column: &str, cell: &str) -> Self {
        let place = match position {
            Position::Line(number) => Place::line(file, number, column),
            Position::Row(_) => Place::item(file, format!("{position}: {column}")),
        };
        Self::Refused(bad_cell(place, cell, NAME))
    }

    /// A Parquet file that cannot be read.
    #[cfg(feature = "parquet")]
    pub(super) fn parquet(file: String, source: Cause) -> Self {
        let error = Error::at(Place::file(file), "not a Parquet file that can be read");
        Self::Refused(error.because(source))
    }

    /// A file or folder that needs Parquet, in a program without it.
    #[cfg(not(feature = "parquet"))]
    pub(super) fn no_parquet(file: String) -> Self {
        let sentence = format_args!(
            "this program was built without the feature `parquet`; build it with `cargo install --path crates/program --features parquet`, use the Python package, or write CSV"
        );
        Self::of_file(file, sentence)
    }

    /// A folder for ticks with something else in it.
    #[cfg(feature = "parquet")]
    pub(super) fn ticks(folder: String, found: String, advice: &str) -> Self {
        Self::of_file(folder, format_args!("holds {found}; {advice}"))
    }

    /// A name of results whose extension is that of another format.
    pub(super) fn extension(file: String) -> Self {
        Self::of_file(
            file,
            format_args!("results are written as CSV or Parquet; expected the extension .csv or .parquet"),
        )
    }

    /// Ticks and rows with one name.
    pub(super) fn same_name(file: String) -> Self {
        Self::of_file(file, format_args!("duplicate output; choose different names for rows and ticks"))
    }

    /// A file without rows to merge, to summarise or to draw.
    pub(super) fn empty(file: String) -> Self {
        Self::of_file(file, format_args!("has no episodes"))
    }

    /// A shard of another study than the `first` one.
    pub(super) fn foreign(
        file: String,
        found: String,
        found_episodes: u64,
        first: String,
        expected: String,
        expected_episodes: u64,
    ) -> Self {
        let sentence = format_args!(
            "study {found} of {found_episodes} episodes; {first} is of study {expected} of {expected_episodes}"
        );
        Self::of_file(file, sentence)
    }

    /// An episode that another shard has, too.
    pub(super) fn overlap(file: String, episode: u64, other: String) -> Self {
        Self::of_file(file, format_args!("duplicate episode {episode}, which {other} has too"))
    }

    /// Episodes that are in no shard; `hint` names the missing shards.
    pub(super) fn gap(first: u64, last: u64, episodes: u64, hint: String) -> Self {
        let sentence = format!("episodes {first} to {last} of {episodes} are in none of the files{hint}");
        Self::Refused(Error::new(sentence))
    }

    /// A file of the benchmark's folder that is not as it ships.
    pub(super) fn not_the_benchmarks(file: String, name: &str) -> Self {
        let sentence = format_args!(
            "missing, or not as it is in {name}; `cocarry bench FOLDER` writes its files into a new folder"
        );
        Self::of_file(file, sentence)
    }

    /// A row that is not of the benchmark.
    pub(super) fn not_of_the_benchmark(file: String, position: Position, study: String, name: &str) -> Self {
        let sentence = format_args!(
            "{position} is of study {study}, which is none of {name} in this version of the program: sweep its small.toml or full.toml with other policies only, without --seeds"
        );
        Self::of_file(file, sentence)
    }

    /// Results that lack episodes.
    pub(super) fn incomplete(file: String, found: u64, episodes: u64, first: u64) -> Self {
        let sentence = format_args!(
            "{found} of {episodes} episodes; a score is of all. Number {first} is missing: run the same sweep again, which resumes, or give the files of all shards"
        );
        Self::of_file(file, sentence)
    }

    /// Whether the error is about writing, not about the input.
    pub fn is_about_writing(&self) -> bool {
        matches!(self, Self::Output(error) if !error.is_refusal())
    }
}

/// The place of a row in a file of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// A line of a CSV file, counted from 1. The first one has the names of the columns.
    Line(u64),
    /// A row of a Parquet file, counted from 1.
    Row(u64),
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Row(number) => write!(f, "row {number}"),
        }
    }
}

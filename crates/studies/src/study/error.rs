//! Errors of study files and of the files of a sweep, each with its file, place and value.

use cocarry::error::Place;
use cocarry::suggestion::{Expected, hint};
use cocarry_output::output_file::OutputError;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// Why a sweep was refused, or stopped.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] cocarry::Error),
    /// A file cannot be written, or may not be.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A value is not allowed for its key.
    #[error("{place} = {value}; it must be {expected}{}", expected.hint(value.trim_matches('"')))]
    Value {
        /// Where, and the key.
        place: Place,
        /// The value, as written.
        value: String,
        /// The values allowed.
        expected: Expected,
    },
    /// A key is unknown.
    #[error(
        "{place}: unknown key{}; expected one of: {}",
        hint(&place.item, known.iter().map(String::as_str)),
        known.join(", ")
    )]
    Key {
        /// Where, and the key.
        place: Place,
        /// The keys allowed.
        known: Vec<String>,
    },
    /// A required key is missing.
    #[error("{place}: {key} is missing; it must be {expected}")]
    Missing {
        /// Where.
        place: Place,
        /// The key.
        key: &'static str,
        /// The values allowed.
        expected: String,
    },
    /// A value or a name is duplicate.
    #[error("{place}: duplicate {value}")]
    Twice {
        /// The place of the second, with its key.
        place: Place,
        /// The value.
        value: String,
    },
    /// A key applies to no plant of its run.
    #[error("{place}: needs {what}, which no plant of this run has")]
    Idle {
        /// Where, and the key.
        place: Place,
        /// What the key needs.
        what: &'static str,
    },
    /// Two runs have an episode in common.
    #[error("{place}: seed {seed} of this combination is already covered by an earlier [[run]]: {inputs}")]
    Repeated {
        /// The place of the second run.
        place: Place,
        /// A seed of both runs.
        seed: u64,
        /// The combination.
        inputs: String,
    },
    /// A study has too many combinations of these values.
    #[error("{place}: more than {most} {what}; use more seeds and fewer values")]
    TooMany {
        /// The run.
        place: Place,
        /// The largest number allowed.
        most: usize,
        /// The combinations.
        what: &'static str,
    },
    /// A world that the study names is not valid.
    #[error("{place}")]
    World {
        /// Where it is named.
        place: Place,
        /// What is wrong with it.
        source: Box<cocarry::Error>,
    },
    /// A robot that the study names is not valid.
    #[error("{place}")]
    Robot {
        /// Where it is named.
        place: Place,
        /// What is wrong with it.
        source: Box<cocarry::Error>,
    },
    /// A combination is not a valid scenario.
    #[error("{file}: {inputs}")]
    Scenario {
        /// The study file.
        file: String,
        /// The combination.
        inputs: String,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The file has rows of another study.
    #[error(
        "{file}: {position} is of study {found}, this is study {expected}: a file, an option or the program has changed; --overwrite starts again"
    )]
    OtherStudy {
        /// The file.
        file: String,
        /// The place of the row.
        position: Position,
        /// The digest found.
        found: String,
        /// The digest of the study.
        expected: String,
    },
    /// Rows were calculated with another arithmetic.
    #[error(
        "{file}: calculated with arithmetic {found}, {other} has {expected}: the last bits of their results differ; run all rows on machines and a version with the same arithmetic (--overwrite starts again)"
    )]
    OtherArithmetic {
        /// The file, or the line in it.
        file: String,
        /// Its stamp.
        found: String,
        /// The file or program that it is compared with.
        other: String,
        /// Its stamp.
        expected: String,
    },
    /// The file is not from a sweep of this version.
    #[error(
        "{file}: not the results of a sweep of this version: column {column} is {found}; expected {expected}"
    )]
    Columns {
        /// The file.
        file: String,
        /// The first column that differs, counted from 1.
        column: usize,
        /// Its name there.
        found: String,
        /// Its name here.
        expected: String,
    },
    /// A row is not the expected one.
    #[error("{file}: {position} is {found}; it must be {expected}")]
    Row {
        /// The file.
        file: String,
        /// Its place in the file.
        position: Position,
        /// The row found.
        found: String,
        /// The row expected.
        expected: String,
    },
    /// A Parquet file cannot be read.
    #[error("{file}: not a Parquet file that can be read")]
    Parquet {
        /// The file.
        file: String,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The program was built without Parquet.
    #[error(
        "{file}: this program was built without the feature `parquet`; build it with `cargo install --path crates/program --features parquet`, use the Python package, or write CSV"
    )]
    NoParquet {
        /// The file or folder.
        file: String,
    },
    /// The folder for ticks has something else in it, or ticks of another study.
    #[error("{folder}: holds {found}; {advice}")]
    Ticks {
        /// The folder.
        folder: String,
        /// The file found in it.
        found: String,
        /// What to do.
        advice: &'static str,
    },
    /// The sweep was stopped.
    #[error("{} holds the rows so far; run the same command to resume", file.display())]
    Stopped {
        /// The partial file.
        file: PathBuf,
    },
    /// Ticks and rows have one name.
    #[error("{file}: duplicate output; choose different names for rows and ticks")]
    SameName {
        /// The name.
        file: String,
    },
    /// There are no rows to merge or to summarise.
    #[error("{file}: has no episodes")]
    Empty {
        /// The file, or the files.
        file: String,
    },
    /// A shard belongs to another study than the first shard.
    #[error(
        "{file}: study {found} of {found_episodes} episodes; {first} is of study {expected} of {expected_episodes}"
    )]
    Foreign {
        /// The file.
        file: String,
        /// Its digest.
        found: String,
        /// Its study's episodes.
        found_episodes: u64,
        /// The file that it is compared with.
        first: String,
        /// That one's digest.
        expected: String,
        /// That one's episodes.
        expected_episodes: u64,
    },
    /// Two shards have an episode in common.
    #[error("{file}: duplicate episode {episode}, which {other} has too")]
    Overlap {
        /// The file.
        file: String,
        /// The episode.
        episode: u64,
        /// The other file.
        other: String,
    },
    /// Some episodes are in no shard.
    #[error("episodes {first} to {last} of {episodes} are in none of the files{hint}")]
    Gap {
        /// The first missing.
        first: u64,
        /// The last missing.
        last: u64,
        /// All of the study.
        episodes: u64,
        /// The missing shards, where they can be determined.
        hint: String,
    },
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

impl SweepError {
    /// Whether the error is about writing, not about the input.
    pub fn is_about_writing(&self) -> bool {
        matches!(self, Self::Output(error) if !error.is_refusal())
    }
}

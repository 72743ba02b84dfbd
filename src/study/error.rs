//! What can be wrong with a study file or with the files of a sweep, each case with its file, place and value.

use crate::located::{FileError, Place};
use crate::output_file::OutputError;
use crate::robot::RobotError;
use crate::world::WorldError;
use thiserror::Error;

/// Why a sweep was refused, or stopped.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file cannot be read, or is not TOML.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file cannot be written, or may not be.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A value is not one that the key takes.
    #[error("{place} = {value}; it must be {expected}")]
    Value {
        /// Where, and the key.
        place: Place,
        /// The value, as written.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// A key that a study has not.
    #[error("{place}: there is no such key here; there are: {known}")]
    Key {
        /// Where, and the key.
        place: Place,
        /// The keys that exist.
        known: String,
    },
    /// A key that must be there is missing.
    #[error("{place}: {key} is missing; it must be {expected}")]
    Missing {
        /// Where.
        place: Place,
        /// The key.
        key: &'static str,
        /// What would be right.
        expected: String,
    },
    /// A value is listed twice, or a name given twice.
    #[error("{place} = {value} stands there twice")]
    Twice {
        /// Where the second stands, and the key.
        place: Place,
        /// The value.
        value: String,
    },
    /// A key says something of a plant that no episode is run on.
    #[error("{place} says something of {what}, but no plant of this run has one")]
    Idle {
        /// Where, and the key.
        place: Place,
        /// What it is about.
        what: &'static str,
    },
    /// Two runs have an episode in common.
    #[error("{place}: seed {seed} of the same combination is run before already: {inputs}")]
    Repeated {
        /// Where the second run stands.
        place: Place,
        /// A seed that both have.
        seed: u64,
        /// The combination.
        inputs: String,
    },
    /// More combinations than can be held.
    #[error("{place}: more than {most} combinations; use more seeds and fewer values")]
    TooMany {
        /// The run.
        place: Place,
        /// The most that there may be.
        most: usize,
    },
    /// A world that the study names is not valid.
    #[error("{place}")]
    World {
        /// Where it is named.
        place: Place,
        /// What is wrong with it.
        source: Box<WorldError>,
    },
    /// A robot that the study names is not valid.
    #[error("{place}")]
    Robot {
        /// Where it is named.
        place: Place,
        /// What is wrong with it.
        source: Box<RobotError>,
    },
    /// A combination that is no valid scenario.
    #[error("{file}: {inputs}")]
    Scenario {
        /// The study file.
        file: String,
        /// The combination.
        inputs: String,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Rows of another study are there.
    #[error(
        "{file}: line {line} is of study {found}, this is study {expected}: a file, an option or the program has changed; --overwrite begins anew"
    )]
    OtherStudy {
        /// The file.
        file: String,
        /// Line, counted from 1.
        line: u64,
        /// The digest found.
        found: String,
        /// The digest of the study.
        expected: String,
    },
    /// Rows were calculated with another arithmetic.
    #[error(
        "{file}: calculated with arithmetic {found}, {other} has {expected}: the last bits of results differ between the two; run all rows on machines and a version with the same arithmetic (--overwrite begins anew)"
    )]
    OtherArithmetic {
        /// The file, or the line in it.
        file: String,
        /// Its stamp.
        found: String,
        /// What it is compared with.
        other: String,
        /// The stamp of that.
        expected: String,
    },
    /// A file that no sweep of this version wrote.
    #[error(
        "{file}: not the results of a sweep by this version: its columns are others (column {column}: {found}; here {expected})"
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
    /// A line that does not belong where it stands.
    #[error("{file}: line {line} is {found}; it must be {expected}")]
    Line {
        /// The file.
        file: String,
        /// Line, counted from 1.
        line: u64,
        /// What stands there.
        found: String,
        /// What belongs there.
        expected: String,
    },
    /// There is nothing to merge or to sum up.
    #[error("{file}: no episodes in it")]
    Empty {
        /// The file, or the files.
        file: String,
    },
    /// A shard is of another study than the first.
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
    #[error("{file}: begins with episode {episode}, which {other} has too")]
    Overlap {
        /// The file.
        file: String,
        /// The episode.
        episode: u64,
        /// The other file.
        other: String,
    },
    /// Episodes that no shard has.
    #[error("episodes {first} to {last} of {episodes} are in none of the files{hint}")]
    Gap {
        /// The first missing.
        first: u64,
        /// The last missing.
        last: u64,
        /// All of the study.
        episodes: u64,
        /// Which shards these are, where that can be told.
        hint: String,
    },
}

impl SweepError {
    /// Whether it is about writing, not about what was given.
    pub fn is_about_writing(&self) -> bool {
        matches!(self, Self::Output(error) if !error.is_refusal())
    }
}

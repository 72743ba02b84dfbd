//! Errors in a file of answers or switches, each with its file, line, column and value.

use cocarry::learning::LearningError;
use cocarry::preference::PreferenceError;
use thiserror::Error;

/// The reason why nothing was fitted.
#[derive(Debug, Error)]
pub enum FitError {
    /// The episode of a participant cannot begin, or the file cannot be read.
    #[error(transparent)]
    File(#[from] cocarry::Error),
    /// A missing or duplicate column.
    #[error("{file}:{line}: {fault} column `{column}`; found `{found}`, expected {expected}")]
    Column {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The fault: `no`, or `more than one`.
        fault: &'static str,
        /// The column.
        column: &'static str,
        /// The columns found.
        found: String,
        /// The columns expected.
        expected: String,
    },
    /// A row has more or fewer fields than the header.
    #[error("{file}:{line}: {found} fields; the header has {expected}")]
    Fields {
        /// The file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Fields found.
        found: usize,
        /// Columns of the header.
        expected: usize,
    },
    /// A file without rows.
    #[error("{file}: no rows; expected the columns {expected} and a row for every answer")]
    NoRows {
        /// The file.
        file: String,
        /// The columns expected.
        expected: String,
    },
    /// An invalid value.
    #[error("{file}:{line}: {column} = {value:?}; it must be {expected}")]
    Cell {
        /// The file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Column of the value.
        column: &'static str,
        /// The value found.
        value: String,
        /// The values allowed.
        expected: String,
    },
    /// A duplicate answer.
    #[error("{file}:{line}: duplicate answer: {what} first answered in line {first}")]
    Duplicate {
        /// The file.
        file: String,
        /// Line of the second answer.
        line: u64,
        /// The question.
        what: String,
        /// Line of the first answer.
        first: u64,
    },
    /// An answer without a row for one of the options.
    #[error(
        "{file}:{line}: participant `{participant}` answers for {world}, but not for its option `{option}`; every option needs a row, 0 percent included"
    )]
    OptionMissing {
        /// The file.
        file: String,
        /// Line of the last row of the answer.
        line: u64,
        /// The participant.
        participant: String,
        /// The world.
        world: String,
        /// The option without a row.
        option: String,
    },
    /// A participant's percentages do not sum to 100.
    #[error(
        "{file}:{line}: percent of participant `{participant}` in {world} (lines {first} to {line}) sums to {sum}; it must be 100 (within 1); --normalise scales every sum to 100"
    )]
    Sum {
        /// The file.
        file: String,
        /// Line of the last row of the answer.
        line: u64,
        /// Line of its first row.
        first: u64,
        /// The participant.
        participant: String,
        /// The world.
        world: String,
        /// The sum, percent.
        sum: f64,
    },
    /// Held-out worlds without answers, or none left to fit.
    #[error("{file}: {reason}")]
    Worlds {
        /// The file.
        file: String,
        /// The fault of the held-out worlds.
        reason: String,
    },
    /// The model's choice probabilities are the same for every c_r.
    #[error(
        "{file}: the answers do not determine c_r: in every fitted world, P_o is the same for all c_r from {lower} to {upper} m"
    )]
    Flat {
        /// The file.
        file: String,
        /// Smallest c_r tried, m.
        lower: f64,
        /// Largest c_r tried, m.
        upper: f64,
    },
    /// A file of neither answers nor switches.
    #[error(
        "{file}: neither answers nor switches; found the columns {found}, expected participant, world, option and percent (answers), or participant, world, option or method, and step (switches)"
    )]
    Kind {
        /// The file.
        file: String,
        /// The columns found.
        found: String,
    },
    /// Answers that no alpha and gamma of the belief explain without lapses.
    #[error(
        "{file}: participant `{participant}`: no alpha and gamma of the belief agree with the answer in {world} and the others; without lapses, every answer must be 100 percent for the option that the model's human prefers: give a --lapse-rate above 0"
    )]
    Contradiction {
        /// The file.
        file: String,
        /// The participant.
        participant: String,
        /// The world.
        world: String,
    },
    /// A walk that no alpha and gamma of the belief explain without lapses.
    #[error(
        "{file}: participant `{participant}`: no alpha and gamma of the belief agree with this walk and the rest; give a --lapse-rate above 0"
    )]
    Walk {
        /// The recording.
        file: String,
        /// The participant.
        participant: String,
    },
    /// Switches that no eta explains without lapses.
    #[error(
        "{file}: participant `{participant}`: no eta agrees with all episodes; give a --lapse-rate above 0"
    )]
    Tolerances {
        /// The file.
        file: String,
        /// The participant.
        participant: String,
    },
    /// More episodes of a participant than the belief over eta holds.
    #[error("{file}: participant `{participant}`: {count} episodes with a robot that leads; at most {most}")]
    Episodes {
        /// The file.
        file: String,
        /// The participant.
        participant: String,
        /// Number of episodes.
        count: usize,
        /// The most.
        most: usize,
    },
    /// Mean answers that no population explains without lapses.
    #[error(
        "{file}: no population gives these mean answers without lapses: an option was chosen that no alpha and gamma of the belief prefers; give a --lapse-rate above 0"
    )]
    Population {
        /// The file.
        file: String,
    },
    /// A number of the belief or of the lapses is out of its range.
    #[error(transparent)]
    Learning(#[from] LearningError),
    /// The belief is not valid.
    #[error(transparent)]
    Preference(#[from] PreferenceError),
}

//! The kind of a file of participants, by its header.

use super::csv_text::{header, read_csv_text};
use super::table::no_rows;
use cocarry::Error;
use cocarry::error::Place;
use std::path::Path;

/// The kind of a file, by what participants did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// They said how likely they would choose each option.
    Answers,
    /// They asked the robot to switch at some step.
    Switches,
}

impl Kind {
    /// The kind of a CSV file: answers have a column `percent`, switches a column `step`.
    ///
    /// # Errors
    /// The file cannot be read, is empty, or has neither or both.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let file = path.display().to_string();
        let (text, delimiter) = read_csv_text(path)?;
        let Some(header) = header(&text) else {
            return Err(no_rows(&file, "participant, world, option, percent or step"));
        };
        let columns: Vec<&str> =
            header.split(char::from(delimiter)).map(|name| name.trim().trim_matches('"')).collect();
        match ["percent", "step"].map(|name| columns.contains(&name)) {
            [true, false] => Ok(Self::Answers),
            [false, true] => Ok(Self::Switches),
            _ => Err(Error::at(
                Place::file(file),
                format_args!(
                    "neither answers nor switches; found the columns {}, expected participant, world, option and percent (answers), or participant, world, option or method, and step (switches)",
                    columns.join(", ")
                ),
            )),
        }
    }
}

//! The kind of a file of participants, by its header.

use super::FitError;
use cocarry::located;
use std::path::Path;

/// What participants did.
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
    /// [`FitError`]: the file cannot be read, is empty, or has neither or both.
    pub fn of(path: &Path) -> Result<Self, FitError> {
        let file = path.display().to_string();
        let text = located::read(path)?;
        let is_header = |line: &&str| !line.is_empty() && !line.starts_with('#');
        let Some(header) = text.lines().map(str::trim).find(is_header) else {
            let expected = "participant, world, option, percent or step".to_owned();
            return Err(FitError::NoRows { file, expected });
        };
        let columns: Vec<&str> = header
            .trim_start_matches('\u{feff}')
            .split(',')
            .map(|name| name.trim().trim_matches('"'))
            .collect();
        match ["percent", "step"].map(|name| columns.contains(&name)) {
            [true, false] => Ok(Self::Answers),
            [false, true] => Ok(Self::Switches),
            _ => Err(FitError::Kind { file, found: columns.join(", ") }),
        }
    }
}

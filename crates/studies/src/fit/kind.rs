//! The kind of a file of participants, by its header.

use super::csv_text::{header, read_csv_text};
use super::table::no_rows;
use cocarry::Error;
use cocarry::error::Place;
use std::path::{Path, PathBuf};

/// The kind of a file, by what participants did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EvidenceKind {
    /// They said how likely they would choose each option.
    Answers,
    /// They asked the robot to switch at some step.
    Switches,
}

impl EvidenceKind {
    const ALL: [Self; 2] = [Self::Answers, Self::Switches];

    /// Its name in a folder of `cocarry new` or `cocarry study collect`.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Answers => "answers.csv",
            Self::Switches => "switches.csv",
        }
    }

    /// What its columns are, for errors.
    fn columns(self) -> &'static str {
        match self {
            Self::Answers => "participant, world, option and percent",
            Self::Switches => "participant, world, option or method, and step",
        }
    }

    /// The file of this kind in `path`, if that is a folder; otherwise `path` itself.
    ///
    /// # Errors
    /// The folder has no such file.
    pub fn within(self, path: &Path) -> Result<PathBuf, Error> {
        if !path.is_dir() {
            return Ok(path.to_owned());
        }
        let inside = path.join(self.file_name());
        if inside.is_file() {
            return Ok(inside);
        }
        let sentence = format_args!(
            "a folder without {}; expected that file in it, or a CSV file with the columns {}",
            self.file_name(),
            self.columns()
        );
        Err(Error::at(Place::file(path.display().to_string()), sentence))
    }

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

/// The files of participants in `path`, if that is a folder: its answers, its switches, or both; otherwise
/// `path` itself.
///
/// # Errors
/// The folder has neither.
pub fn participants_files(path: &Path) -> Result<Vec<PathBuf>, Error> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let files: Vec<PathBuf> = EvidenceKind::ALL
        .map(|kind| path.join(kind.file_name()))
        .into_iter()
        .filter(|file| file.is_file())
        .collect();
    match files.is_empty() {
        false => Ok(files),
        true => Err(Error::at(
            Place::file(path.display().to_string()),
            "a folder without answers.csv and switches.csv; expected one of these files in it",
        )),
    }
}

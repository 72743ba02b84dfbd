//! The errors of output files.

use cocarry::error::Place;
use std::fmt::Display;
use std::io::Error;
use std::path::Path;

/// The error of a file that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The name is refused, before the system is asked.
    #[error(transparent)]
    Refused(cocarry::Error),
    /// The system cannot write or rename the file.
    #[error(transparent)]
    Failed(cocarry::Error),
}

/// The sentences.
impl OutputError {
    fn refused(file: &Path, sentence: impl Display) -> Self {
        Self::Refused(cocarry::Error::at(Place::file(file.display().to_string()), sentence))
    }

    fn failed(file: &Path, sentence: impl Display, source: Error) -> Self {
        let place = Place::file(file.display().to_string());
        Self::Failed(cocarry::Error::at(place, sentence).because(source))
    }

    /// A file that exists.
    pub fn exists(file: &Path) -> Self {
        Self::refused(file, "exists already; choose another name, or give --overwrite")
    }

    /// An unfinished file that exists.
    pub(super) fn left_over(file: &Path) -> Self {
        let sentence = "exists already and is unfinished; recover or remove it, choose another name, or give --overwrite";
        Self::refused(file, sentence)
    }

    /// The name of something other than a file, such as a directory.
    pub(super) fn not_a_file(file: &Path, kind: &str) -> Self {
        Self::refused(file, format_args!("is a {kind}, which is never replaced; choose another name"))
    }

    /// The name of something other than a folder, such as a file.
    pub fn not_a_folder(file: &Path, kind: &str) -> Self {
        Self::refused(file, format_args!("is a {kind}, not a folder; choose another name"))
    }

    /// An input of the command.
    pub(super) fn input(file: &Path) -> Self {
        Self::refused(file, "is an input of this command, which is never replaced; choose another name")
    }

    /// A file that another process is writing.
    pub fn busy(file: &Path) -> Self {
        Self::refused(file, "another process is writing it")
    }

    /// A name that no file can have.
    pub(super) fn no_name(file: &Path, source: Error) -> Self {
        let place = Place::file(file.display().to_string());
        Self::Refused(cocarry::Error::at(place, "cannot be the name of a file").because(source))
    }

    /// A file that the system cannot write.
    pub fn write(file: &Path, source: Error) -> Self {
        Self::failed(file, "cannot be written", source)
    }

    /// A complete file that the system cannot rename.
    pub fn rename(partial: &Path, file: &Path, source: Error) -> Self {
        let sentence = format_args!("is complete, but cannot be renamed to {}", file.display());
        Self::failed(partial, sentence, source)
    }

    /// Whether the name was refused, before the system was asked.
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Refused(_))
    }
}

//! Input files, bounded in size, and the places in text files, for errors.

use crate::suggestion;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::ops::Range;
use std::path::Path;
use thiserror::Error;
use toml::Spanned;
use toml::de::DeTable;

/// The size of the largest text file that is read, bytes: answers, samples, URDFs.
const LARGEST: u64 = 16 << 20;
/// The same for a file of settings: studies, baselines, robots.
pub const LARGEST_SETTINGS: u64 = 1 << 20;
/// The same for a world.
pub const LARGEST_WORLD: u64 = 4 << 20;

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The name of the file, as given by the caller.
    pub file: String,
    /// The line, counted from 1; `None` where it is unknown, as in a URDF.
    pub line: Option<usize>,
    /// The item, such as ``obstacle `pillar` ``.
    pub item: String,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file, self.item),
            None => write!(f, "{}: {}", self.file, self.item),
        }
    }
}

/// A syntax error, with the key or value that was probably meant.
#[derive(Debug, Error)]
#[error("{}{hint}", error.to_string().trim_end())]
struct Hinted {
    error: toml::de::Error,
    hint: String,
}

/// The error of a file that cannot be read, or is not valid.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error("{file}: cannot be read")]
    Read {
        /// The file.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file has a syntax error.
    #[error("{file}: not a valid {kind}")]
    Syntax {
        /// The file.
        file: String,
        /// The kind of file expected.
        kind: &'static str,
        /// Line, column, and the text expected there.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// Opens an input file. Only regular files are inputs: a FIFO or a terminal would wait for its writer, and a
/// device may never end.
///
/// # Errors
/// The system's, or that the file is not a regular file.
pub fn open(path: &Path) -> Result<File, Error> {
    // before the file is opened, since opening a FIFO waits too
    let kind = std::fs::metadata(path)?.file_type();
    match kind.is_dir() {
        _ if kind.is_file() => File::open(path),
        true => Err(Error::new(ErrorKind::IsADirectory, "is a directory; expected a file")),
        false => Err(Error::new(ErrorKind::InvalidInput, "is a special file; expected a regular file")),
    }
}

/// Reads a text file of at most 16 MiB.
///
/// # Errors
/// [`FileError::Read`], also if it is larger, not a regular file, or not UTF-8.
pub fn read(path: &Path) -> Result<String, FileError> {
    read_at_most(LARGEST, path)
}

/// As [`read`], with another limit (bytes).
///
/// # Errors
/// As [`read`].
pub fn read_at_most(limit: u64, path: &Path) -> Result<String, FileError> {
    let text = |bytes| String::from_utf8(bytes).map_err(|error| Error::new(ErrorKind::InvalidData, error));
    let read = read_bytes(limit, path).and_then(text);
    read.map_err(|source| FileError::Read { file: path.display().to_string(), source: hinted(path, source) })
}

/// The error of a file, with the name of a file beside it if that is nearly the name asked for.
fn hinted(path: &Path, error: Error) -> Error {
    let hint =
        if error.kind() == ErrorKind::NotFound { suggestion::hint_of_files(path) } else { String::new() };
    if hint.is_empty() { error } else { Error::new(error.kind(), format!("{error}{hint}")) }
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// The system's, also if the file is larger or not a regular file.
pub fn read_bytes(limit: u64, path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(Error::other(format!("larger than {limit} bytes")));
    }
    Ok(bytes)
}

/// A file's name and text.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Its name in errors.
    pub file: &'a str,
    /// Its text.
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// The values of a TOML file. `kind` is the kind of file expected, such as `world file`.
    ///
    /// # Errors
    /// [`FileError::Syntax`], which names line and column.
    pub fn parse<T: DeserializeOwned>(self, kind: &'static str) -> Result<T, FileError> {
        toml::from_str(self.text).map_err(|error: toml::de::Error| {
            let hint = suggestion::hint_of_error(error.message());
            self.invalid(kind, Hinted { error, hint })
        })
    }

    /// The table of a TOML file, each key and value with its span.
    ///
    /// # Errors
    /// As [`Source::parse`].
    pub fn table(self, kind: &'static str) -> Result<Spanned<DeTable<'a>>, FileError> {
        DeTable::parse(self.text).map_err(|mut error| {
            error.set_input(Some(self.text));
            self.invalid(kind, error)
        })
    }

    /// The error that the file is not a valid `kind`.
    pub fn invalid(
        self,
        kind: &'static str,
        error: impl std::error::Error + Send + Sync + 'static,
    ) -> FileError {
        FileError::Syntax { file: self.file.to_owned(), kind, source: Box::new(error) }
    }

    /// The line of a byte, counted from 1.
    pub fn line(self, byte: usize) -> usize {
        let before = &self.text.as_bytes()[..byte.min(self.text.len())];
        1 + before.iter().filter(|byte| **byte == b'\n').count()
    }

    /// The place of `item`, which was read from `spanned`.
    pub fn place<T>(self, spanned: &Spanned<T>, item: impl Into<String>) -> Place {
        self.place_at(spanned.span(), item)
    }

    /// The place of `item`, which is at these bytes.
    pub fn place_at(self, span: Range<usize>, item: impl Into<String>) -> Place {
        Place { file: self.file.to_owned(), line: Some(self.line(span.start)), item: item.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_lines_are_counted_from_1() {
        let source = Source { file: "f", text: "a\nbü\n\nc" };
        assert_eq!([0, 1, 2, 4, 5, 6, 99].map(|byte| source.line(byte)), [1, 1, 2, 2, 2, 3, 4]);
        assert_eq!(source.place_at(2..3, "x").to_string(), "f:2: x");
    }

    #[test]
    fn a_file_that_is_too_large_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.toml");
        File::create(&path).unwrap().set_len(LARGEST + 1).unwrap();
        let FileError::Read { source, .. } = read(&path).unwrap_err() else { panic!("another error") };
        assert_eq!(source.to_string(), "larger than 16777216 bytes");
    }
}

//! Input files, bounded in size, and the places in text files, for errors.

use crate::bounds::FileBounds;
use crate::error::{Error, Place};
use crate::{known_names, suggestion};
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;

/// Opens an input file. Only regular files are inputs: a FIFO or a terminal would wait for its writer, and a
/// device may never end.
///
/// # Errors
/// The system's, or that the file is not a regular file.
pub fn open(path: &Path) -> Result<File, io::Error> {
    // before the file is opened, since opening a FIFO waits too
    let kind = std::fs::metadata(path)?.file_type();
    match kind.is_dir() {
        _ if kind.is_file() => File::open(path),
        true => Err(io::Error::new(ErrorKind::IsADirectory, "is a directory; expected a file")),
        false => Err(io::Error::new(ErrorKind::InvalidInput, "is a special file; expected a regular file")),
    }
}

/// Reads a text file of a kind.
///
/// # Errors
/// The system's, also if the file is longer than its kind may be, not a regular file, or not UTF-8.
pub fn read(kind: &FileBounds, path: &Path) -> Result<String, Error> {
    read_with(kind, path, utf_8)
}

/// As [`read`], with another encoding of the text.
///
/// # Errors
/// As [`read`], and those of `decoded`.
pub fn read_with(
    kind: &FileBounds,
    path: &Path,
    decoded: fn(Vec<u8>) -> Result<String, io::Error>,
) -> Result<String, Error> {
    let read = read_bytes(kind, path).and_then(decoded);
    read.map_err(|error| unreadable(path.display(), hinted(path, error)))
}

/// Reads a file of a kind, in whatever encoding.
///
/// # Errors
/// As [`read`], but for the encoding.
pub fn read_file(kind: &FileBounds, path: &Path) -> Result<Vec<u8>, Error> {
    read_bytes(kind, path).map_err(|error| unreadable(path.display(), hinted(path, error)))
}

fn utf_8(bytes: Vec<u8>) -> Result<String, io::Error> {
    String::from_utf8(bytes).map_err(|error| io::Error::new(ErrorKind::InvalidData, error))
}

/// What errors call standard input.
pub const STANDARD_INPUT: &str = "standard input";

/// As [`read`], from standard input to its end.
///
/// # Errors
/// As [`read`].
pub fn read_input(kind: &FileBounds) -> Result<String, Error> {
    bounded(kind, io::stdin().lock()).and_then(utf_8).map_err(|error| unreadable(STANDARD_INPUT, error))
}

/// The error of a file that the system cannot read.
pub fn unreadable(file: impl Display, error: io::Error) -> Error {
    Error::at(Place::file(file.to_string()), "cannot be read").because(error)
}

/// The error of a file, with the name of a file next to it if that is nearly the name asked for.
fn hinted(path: &Path, error: io::Error) -> io::Error {
    let hint =
        if error.kind() == ErrorKind::NotFound { suggestion::hint_of_files(path) } else { String::new() };
    if hint.is_empty() { error } else { io::Error::new(error.kind(), format!("{error}{hint}")) }
}

/// As [`read`], for a file that need not be text.
///
/// # Errors
/// The system's, also if the file is longer than its kind may be, or not a regular file.
pub fn read_bytes(kind: &FileBounds, path: &Path) -> Result<Vec<u8>, io::Error> {
    bounded(kind, open(path)?)
}

/// What a reader gives, up to the limit of its kind.
fn bounded(kind: &FileBounds, reader: impl Read) -> Result<Vec<u8>, io::Error> {
    let limit = kind.bytes();
    let mut bytes = Vec::new();
    reader.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::other(format!("larger than {limit} bytes")));
    }
    Ok(bytes)
}

/// The longest line of an error's text, characters.
const MAX_LINE: usize = 400;

/// An error of a reader of TOML, without the end of long lines: it shows a line of the file, of any length.
pub fn short_lines(error: &dyn Display) -> String {
    let text = error.to_string();
    let short = |line: &str| match line.char_indices().nth(MAX_LINE) {
        Some((end, _)) => format!("{}…", line[..end].trim_end()),
        None => line.to_owned(),
    };
    text.split('\n').map(short).collect::<Vec<_>>().join("\n")
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
    /// The line, the column and what was expected there.
    pub fn parse<T: DeserializeOwned>(self, kind: &str) -> Result<T, Error> {
        toml::from_str(self.text).map_err(|error: toml::de::Error| {
            let hint = known_names::hint::<T>(self.text);
            self.invalid(kind, format!("{}{hint}", short_lines(&error).trim_end()))
        })
    }

    /// The table of a TOML file, each key and value with its span.
    ///
    /// # Errors
    /// As [`Source::parse`].
    pub fn table(self, kind: &str) -> Result<Spanned<DeTable<'a>>, Error> {
        DeTable::parse(self.text).map_err(|mut error| {
            error.set_input(Some(self.text));
            self.invalid(kind, short_lines(&error))
        })
    }

    /// The error that the file is not a valid `kind`.
    pub fn invalid(self, kind: &str, cause: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
        Error::at(Place::file(self.file), format_args!("not a valid {kind}")).because(cause)
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
    use crate::bounds::URDF;
    use crate::error::words;

    #[test]
    fn closed_form_lines_are_counted_from_1() {
        let source = Source { file: "f", text: "a\nbü\n\nc" };
        assert_eq!([0, 1, 2, 4, 5, 6, 99].map(|byte| source.line(byte)), [1, 1, 2, 2, 2, 3, 4]);
        assert_eq!(source.place_at(2..3, "x").to_string(), "f:2: x");
    }

    #[test]
    fn an_error_shows_no_line_of_any_length() {
        for text in [format!("a = {}", "[".repeat(200_000)), format!("a = {} b", "1".repeat(200_000))] {
            let source = Source { file: "f", text: &text };
            let parsed = source.parse::<toml::Table>("file").unwrap_err();
            for error in [parsed, source.table("file").unwrap_err()] {
                let words = words(&error);
                assert!(words.contains("line 1, column") && words.contains("a = "), "{words}");
                assert!(words.len() < 3 * MAX_LINE && words.lines().count() > 3, "{}", words.len());
            }
        }
        let source = Source { file: "f", text: "a = 1 b" };
        let shown = words(&source.table("file").unwrap_err());
        assert!(shown.contains("1 | a = 1 b\n") && !shown.contains('…'), "{shown}");
    }

    #[test]
    fn a_file_that_is_too_large_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.toml");
        File::create(&path).unwrap().set_len(URDF.bytes() + 1).unwrap();
        let error = read(&URDF, &path).unwrap_err();
        let cause = std::error::Error::source(&error).expect("a cause");
        assert_eq!(cause.to_string(), "larger than 16777216 bytes");
    }
}

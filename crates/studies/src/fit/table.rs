//! A CSV file read by columns, each row with its line.

use super::FitError;
use cocarry::located::{self, Source};
use std::path::Path;

/// A column by name, and whether it is optional.
#[derive(Clone, Copy)]
pub(super) struct Column {
    pub name: &'static str,
    pub is_optional: bool,
}

impl Column {
    pub const fn needed(name: &'static str) -> Self {
        Self { name, is_optional: false }
    }

    pub const fn optional(name: &'static str) -> Self {
        Self { name, is_optional: true }
    }
}

/// The trimmed values of a row, in the order of the requested columns; empty where a column is missing.
pub(super) struct Line<const N: usize> {
    pub line: u64,
    pub values: [String; N],
}

/// The worlds that rows name, each with the first line that does.
pub(super) fn named_worlds<'r>(rows: impl Iterator<Item = (&'r str, u64)>) -> Vec<(String, u64)> {
    let mut worlds: Vec<(String, u64)> = Vec::new();
    for (name, line) in rows {
        if worlds.iter().all(|(world, _)| world != name) {
            worlds.push((name.to_owned(), line));
        }
    }
    worlds
}

/// The rows of a file. Other columns, empty lines and lines that begin with `#` are ignored.
///
/// # Errors
/// [`FitError`]: the file cannot be read, lacks a column, has no rows, or a row is longer or shorter than the
/// header.
pub(super) fn read<const N: usize>(path: &Path, columns: [Column; N]) -> Result<Vec<Line<N>>, FitError> {
    let file = path.display().to_string();
    let text = located::read(path)?;
    let names: Vec<&str> = columns.iter().map(|c| c.name).collect();
    let expected = names.join(", ");
    let not_csv = |error: csv::Error| Source { file: &file, text: &text }.invalid("CSV file", error);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut lines = Lines { text: text.as_bytes(), at: 0, line: 1 };
    let mut record = csv::StringRecord::new();
    if !reader.read_record(&mut record).map_err(not_csv)? {
        return Err(FitError::NoRows { file, expected });
    }
    let header_line = lines.up_to(reader.position().byte());
    let width = record.len();
    let mut places = [None; N];
    for (place, column) in places.iter_mut().zip(&columns) {
        let found: Vec<usize> = (0..width).filter(|&i| &record[i] == column.name).collect();
        let fault = match found.as_slice() {
            [] if !column.is_optional => "no",
            [] | [_] => "",
            _ => "more than one",
        };
        if !fault.is_empty() {
            let found = record.iter().collect::<Vec<_>>().join(", ");
            let (line, column) = (header_line, column.name);
            return Err(FitError::Column { file, line, fault, column, found, expected });
        }
        *place = found.first().copied();
    }
    let mut rows = Vec::new();
    while reader.read_record(&mut record).map_err(not_csv)? {
        let line = lines.up_to(reader.position().byte());
        if record.len() != width {
            return Err(FitError::Fields { file, line, found: record.len(), expected: width });
        }
        let values = places.map(|place| place.map_or(String::new(), |i| record[i].to_owned()));
        rows.push(Line { line, values });
    }
    if rows.is_empty() { Err(FitError::NoRows { file, expected }) } else { Ok(rows) }
}

/// A line counter, since the reader gives the position of a record only up to the comments before it.
struct Lines<'a> {
    text: &'a [u8],
    at: usize,
    line: u64,
}

impl Lines<'_> {
    /// The last line of the record that ends at `byte`.
    fn up_to(&mut self, byte: u64) -> u64 {
        let end = (byte as usize).min(self.text.len());
        let ended = self.text[self.at..end].iter().rposition(|b| !b"\r\n".contains(b));
        let last = ended.map_or(self.at, |i| self.at + i + 1);
        self.line += self.text[self.at..last].iter().filter(|&&b| b == b'\n').count() as u64;
        self.at = last;
        self.line
    }
}

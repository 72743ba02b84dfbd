//! A CSV file read by columns, each row with its line.

use super::csv_text::read_csv_text;
use cocarry::Error;
use cocarry::error::Place;
use cocarry::located::Source;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use unicode_normalization::UnicodeNormalization;

/// A column by name, and whether it is optional.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// Whether a file may lack it.
    pub is_optional: bool,
}

impl Column {
    /// A column that a file must have.
    pub const fn needed(name: &'static str) -> Self {
        Self { name, is_optional: false }
    }

    /// A column whose values are empty where a file lacks it.
    pub const fn optional(name: &'static str) -> Self {
        Self { name, is_optional: true }
    }
}

/// What a cell with a name must be.
pub(crate) const NAME: &str = "a name; pandas and R read NA, null and None as missing, unless told otherwise (keep_default_na=False, na.strings)";

/// The largest number of participants of a file, of its worlds, and of both multiplied: memory and time are
/// taken for each.
const MAX_PARTICIPANTS: usize = 20_000;
const MAX_WORLDS: usize = 1000;
const MAX_ASKED: usize = 200_000;

/// The check of the numbers of participants and worlds that rows name.
///
/// # Errors
/// There are too many.
pub(super) fn check_counts<'r>(
    file: &str,
    rows: impl Iterator<Item = (&'r str, &'r str)> + Clone,
) -> Result<(), Error> {
    let participants = rows.clone().map(|row| row.0).collect::<BTreeSet<_>>().len();
    let worlds = rows.map(|row| row.1).collect::<BTreeSet<_>>().len();
    for (found, limit, what) in [
        (participants, MAX_PARTICIPANTS, "participants"),
        (worlds, MAX_WORLDS, "worlds"),
        (participants.saturating_mul(worlds), MAX_ASKED, "participants times worlds"),
    ] {
        if found > limit {
            let sentence = format_args!("{found} {what}; at most {limit} are read at once: split the file");
            return Err(Error::at(Place::file(file), sentence));
        }
    }
    Ok(())
}

/// The trimmed values of a row, in the order of the requested columns; empty where a column is missing.
#[derive(Clone, Debug)]
pub struct TableLine<const N: usize> {
    /// Line in the file.
    pub line: u64,
    /// The values.
    pub values: [String; N],
    /// Whether commas do not separate cells, so that one in a number is its decimal point.
    has_decimal_commas: bool,
}

impl<const N: usize> TableLine<N> {
    /// The number in a cell.
    pub fn number(&self, column: usize) -> Option<f64> {
        let cell = &self.values[column];
        match self.has_decimal_commas && !cell.contains('.') {
            true => cell.replacen(',', ".", 1).parse().ok(),
            false => cell.parse().ok(),
        }
    }

    /// The whole number in a cell, also as statistics programs write it in a column with missing ones: 36.0.
    pub fn count(&self, column: usize) -> Option<u64> {
        let whole = |number: &f64| number.fract() == 0.0 && (0.0..=MAX_COUNT).contains(number);
        self.values[column].parse().ok().or_else(|| self.number(column).filter(whole).map(|n| n as u64))
    }
}

/// The largest number up to which all whole numbers are floating-point numbers.
const MAX_COUNT: f64 = 9_007_199_254_740_992.0;

/// The rows of these participants, in their order.
pub(super) fn rows_of<R: Clone>(rows: &[R], participants: &[String], of: impl Fn(&R) -> &String) -> Vec<R> {
    let places: BTreeMap<&String, usize> = participants.iter().zip(0..).collect();
    let mut own: Vec<(usize, &R)> =
        rows.iter().filter_map(|row| Some((*places.get(of(row))?, row))).collect();
    own.sort_by_key(|(place, _)| *place);
    own.into_iter().map(|(_, row)| row.clone()).collect()
}

/// The names in rows, such as those of worlds, each with the first line that has it.
pub(super) fn named_worlds<'r>(rows: impl Iterator<Item = (&'r str, u64)>) -> Vec<(String, u64)> {
    let mut worlds: Vec<(String, u64)> = Vec::new();
    let mut known = BTreeSet::new();
    for (name, line) in rows {
        if known.insert(name) {
            worlds.push((name.to_owned(), line));
        }
    }
    worlds
}

/// Names that differ only by case or by their Unicode form, each with the first that is like it.
pub fn similar_names<'n>(names: impl IntoIterator<Item = &'n str>) -> Vec<[&'n str; 2]> {
    let mut known: BTreeMap<String, &str> = BTreeMap::new();
    let mut similar = Vec::new();
    for name in names {
        let form: String = name.nfkc().collect::<String>().to_lowercase().nfkc().collect();
        match known.entry(form) {
            Entry::Vacant(place) => drop(place.insert(name)),
            Entry::Occupied(first) if *first.get() != name => similar.push([*first.get(), name]),
            Entry::Occupied(_) => {}
        }
    }
    similar
}

/// The rows of a file. Other columns, empty lines and lines that begin with `#` are ignored.
///
/// # Errors
/// The file cannot be read, lacks a column, has no rows, or a row is longer or shorter than the
/// header.
pub fn read<const N: usize>(path: &Path, columns: [Column; N]) -> Result<Vec<TableLine<N>>, Error> {
    let file = path.display().to_string();
    let (text, delimiter) = read_csv_text(path)?;
    let names: Vec<&str> = columns.iter().map(|c| c.name).collect();
    let expected = names.join(", ");
    let not_csv = |error: csv::Error| Source { file: &file, text: &text }.invalid("CSV file", error);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut lines = Lines { text: text.as_bytes(), at: 0, line: 1 };
    let mut record = csv::StringRecord::new();
    if !reader.read_record(&mut record).map_err(not_csv)? {
        return Err(no_rows(&file, &expected));
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
            let sentence =
                format_args!("{fault} column `{}`; found `{found}`, expected {expected}", column.name);
            return Err(Error::at(Place::line(file, header_line, ""), sentence));
        }
        *place = found.first().copied();
    }
    let mut rows = Vec::new();
    while reader.read_record(&mut record).map_err(not_csv)? {
        let line = lines.up_to(reader.position().byte());
        if record.len() != width {
            let sentence = format_args!("{} fields; the header has {width}", record.len());
            return Err(Error::at(Place::line(file, line, ""), sentence));
        }
        let values = places.map(|place| place.map_or(String::new(), |i| record[i].to_owned()));
        rows.push(TableLine { line, values, has_decimal_commas: delimiter != b',' });
    }
    if rows.is_empty() { Err(no_rows(&file, &expected)) } else { Ok(rows) }
}

/// The error of a file without rows.
pub(super) fn no_rows(file: &str, expected: &str) -> Error {
    let sentence = format_args!("no rows; expected the columns {expected} and a row for every answer");
    Error::at(Place::file(file), sentence)
}

/// The error of a cell at a place, whose item is its column.
pub fn bad_cell(place: Place, value: &str, expected: &str) -> Error {
    Error::value(place, format_args!("{value:?}; it must be {expected}"))
}

/// The error of a row for the same question as the one in line `first`.
pub(super) fn duplicate(place: Place, what: impl std::fmt::Display, first: u64) -> Error {
    Error::at(place, format_args!("duplicate answer: {what} first answered in line {first}"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_look_alike_are_found() {
        let names = ["Zo\u{eb}", "zo\u{eb}", "Zoe\u{308}", "zoe", "\u{ff21}1", "a1", "Zo\u{eb}"];
        let found = similar_names(names);
        assert_eq!(found, [[names[0], names[1]], [names[0], names[2]], [names[4], names[5]]]);
    }
}

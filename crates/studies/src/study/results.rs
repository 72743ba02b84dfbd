//! Files of results, CSV or Parquet: the episode and study of each row, and its line of CSV.

use super::error::Position;
use super::origin::Origin;
use super::{SweepError, row, tables};
use cocarry::located;
use cocarry::quantities::{Heading, QuantityKind};
use cocarry_output::output_file::{OutputError, OutputFile};
use row::IDENTITY;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// The identity of a row: its episode and its study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    pub episode: u64,
    /// The number of episodes of the study.
    pub episodes: u64,
    pub study: String,
    /// The stamp of the arithmetic that calculated the row.
    pub arithmetic: String,
}

impl Identity {
    /// Parses the beginning of a row.
    pub fn of_line(line: &[u8], file: &str, position: Position) -> Result<Self, SweepError> {
        let text = String::from_utf8_lossy(line);
        let mut fields = text.splitn(IDENTITY.len() + 1, ',');
        let mut next = || fields.next().unwrap_or_default();
        let (episode, episodes, study, arithmetic) = (next().parse(), next().parse(), next(), next());
        match (episode, episodes) {
            (Ok(episode), Ok(episodes))
                if episode < episodes && study.len() == 16 && arithmetic.len() == 8 =>
            {
                Ok(Self { episode, episodes, study: study.to_owned(), arithmetic: arithmetic.to_owned() })
            }
            _ => Err(SweepError::row(position, file.to_owned(), format!("`{}`", text.trim_end().chars().take(60).collect::<String>()), "a row of results: the number of an episode, the number of episodes, the study's digest, and the arithmetic's stamp"
                        .to_owned())),
        }
    }
}

/// The first bytes of a Parquet file.
const PARQUET: &[u8] = b"PAR1";
/// The length of the longest line, bytes. A row has about 1 kB.
const MAX_LINE: u64 = 64 << 10;

/// Reads a line with its newline; nothing at the end of the file.
pub(super) fn read_line(reader: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<()> {
    line.clear();
    reader.take(MAX_LINE + 1).read_until(b'\n', line)?;
    match line.len() as u64 > MAX_LINE {
        true => Err(io::Error::other(format!("a line is longer than {MAX_LINE} bytes"))),
        false => Ok(()),
    }
}

/// The check, for rows that are kept, that their values are those that the sweep wrote.
pub(super) fn check_values(line: &[u8], file: &str, position: Position) -> Result<(), SweepError> {
    row::wrong_checksum(line).map_or(Ok(()), |[found, expected]| {
        let found = found.chars().take(60).collect::<String>();
        let found = format!("a row with changed values, whose checksum is `{found}`");
        let expected = format!("as its sweep wrote it, with checksum {expected}");
        Err(SweepError::row(position, file.to_owned(), found, expected))
    })
}

/// A cell as a sweep writes it: other programs write 36 as 36.0, false as False, and nothing as NaN.
fn as_written(heading: &Heading, cell: &str) -> String {
    let number = || cell.trim().parse::<f64>().ok().filter(|number| !number.is_nan());
    match heading.kind {
        QuantityKind::Number(_) => number().map_or_else(String::new, |number| number.to_string()),
        QuantityKind::Count => match cell.parse::<u64>() {
            Ok(_) => cell.to_owned(),
            Err(_) => number().filter(|n| n.fract() == 0.0).map_or_else(String::new, |n| n.to_string()),
        },
        QuantityKind::Flag => cell.trim().to_ascii_lowercase(),
        _ => cell.to_owned(),
    }
}

/// The columns that have a name in every row.
const NAMED: [&str; 5] = ["world", "humans", "belief", "method", "human_model"];

/// The check, for a row that another program has written anew, that it has kept the names: it may have read
/// one as a missing value.
fn check_names(
    headings: &[Heading],
    fields: &csv::StringRecord,
    file: &str,
    position: Position,
) -> Result<(), SweepError> {
    let is_missing = |cell: &str| cell.trim().is_empty() || cell.trim().eq_ignore_ascii_case("nan");
    let mut cells = headings.iter().map(|heading| heading.name).zip(fields);
    match cells.find(|(name, cell)| NAMED.contains(name) && is_missing(cell)) {
        Some((name, cell)) => Err(SweepError::missing_name(file, position, name, cell)),
        None => Ok(()),
    }
}

/// The check that the header is that of this version.
pub(super) fn check_header(line: &[u8], file: &str) -> Result<(), SweepError> {
    let text = String::from_utf8_lossy(line);
    let mut found = text.trim_end().split(',');
    let mut expected = row::columns().into_iter();
    for column in 1.. {
        match (found.next(), expected.next()) {
            (None, None) => break,
            (found, expected) if found == expected => {}
            (found, expected) => {
                let name = |column: Option<&str>| match column {
                    Some(name) => format!("`{}`", name.chars().take(60).collect::<String>()),
                    None => "none".to_owned(),
                };
                let (found, expected) = (name(found), name(expected));
                return Err(SweepError::columns(file.to_owned(), column, found, expected));
            }
        }
    }
    Ok(())
}

/// Gives a complete partial file of rows its final form: as it is, or as Parquet, by the name's extension.
pub(super) fn finish(file: OutputFile, path: &Path, origin: &Origin) -> Result<(), SweepError> {
    if !is_parquet(path) {
        return Ok(file.finish()?);
    }
    let write = |source| OutputError::write(path, source);
    Ok(file.finish_as(|lines, out| tables::write(lines, out, origin).map_err(write))?)
}

/// The check that this program can write a file of that name: other extensions are of other formats.
pub(crate) fn check_name(path: &Path) -> Result<(), SweepError> {
    let file = path.display().to_string();
    match path.extension() {
        _ if is_parquet(path) => tables::check(&file),
        Some(extension) if extension.eq_ignore_ascii_case("csv") => Ok(()),
        _ => Err(SweepError::extension(file)),
    }
}

fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}

/// Rows of results: of a file, CSV or Parquet, or in memory.
#[derive(Clone, Copy, Debug)]
pub enum Results<'a> {
    /// A file.
    File(&'a Path),
    /// Lines of CSV without the header, each with its newline.
    Lines {
        /// What errors call them.
        name: &'a str,
        /// The lines.
        lines: &'a [Vec<u8>],
    },
}

impl Results<'_> {
    /// What errors call them.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Lines { name, .. } => (*name).to_owned(),
        }
    }
}

/// Reads a file of results, CSV or Parquet, and hands on the cells of each row, as in CSV.
///
/// # Errors
/// [`SweepError`], which names the file and the row.
pub fn read_rows(
    path: &Path,
    mut each: impl FnMut(&mut dyn Iterator<Item = &str>),
) -> Result<(), SweepError> {
    let mut rows = Rows::open(path)?;
    while rows.next()?.is_some() {
        each(&mut rows.fields()?.iter());
    }
    Ok(())
}

/// A reader of rows.
pub(super) struct Rows<'a> {
    pub file: String,
    source: RowSource<'a>,
    /// The number of the line or row read last, counted from 1.
    number: u64,
    /// The line of the row read last, with its newline.
    pub line: Vec<u8>,
    splitter: Splitter,
    headings: Vec<Heading>,
    /// The number of rows so far whose values cannot be checked: without a checksum, or written anew by
    /// another program, which may have rounded them.
    pub unchecked: u64,
    /// Whether another program has written the rows anew.
    is_rewritten: bool,
    /// The first row whose values are not those of its checksum, though written as a sweep writes.
    changed: Option<SweepError>,
}

/// Splits lines into fields. It is made once: a reader takes longer to be made than to read a line.
struct Splitter {
    reader: csv_core::Reader,
    text: Vec<u8>,
    ends: Vec<usize>,
}

impl Splitter {
    fn new() -> Self {
        Self { reader: csv_core::Reader::new(), text: Vec::new(), ends: Vec::new() }
    }

    /// The fields of a line with its newline; none if it is not text.
    fn fields(&mut self, line: &[u8]) -> csv::StringRecord {
        self.reader.reset();
        // unquoted, a line becomes no longer
        self.text.resize(line.len(), 0);
        self.ends.resize(line.len() + 1, 0);
        let (_, _, length, count) = self.reader.read_record(line, &mut self.text, &mut self.ends);
        let mut fields = csv::StringRecord::with_capacity(length, count);
        let mut begin = 0;
        for &end in &self.ends[..count] {
            let Ok(field) = std::str::from_utf8(&self.text[begin..end]) else { return Default::default() };
            fields.push_field(field);
            begin = end;
        }
        fields
    }
}

enum RowSource<'a> {
    Csv(BufReader<File>),
    Parquet(Box<tables::RowReader>),
    Lines(std::slice::Iter<'a, Vec<u8>>),
}

impl<'a> Rows<'a> {
    /// Opens rows of any kind.
    pub fn of(results: Results<'a>) -> Result<Self, SweepError> {
        match results {
            Results::File(path) => Self::open(path),
            Results::Lines { name, lines } => Ok(Self::new(name.to_owned(), RowSource::Lines(lines.iter()))),
        }
    }

    fn new(file: String, source: RowSource<'a>) -> Self {
        let (line, splitter, headings) = (Vec::new(), Splitter::new(), row::headings());
        Self {
            file,
            source,
            number: 0,
            line,
            splitter,
            headings,
            unchecked: 0,
            is_rewritten: false,
            changed: None,
        }
    }

    /// Opens the file and checks its columns.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let read = |source| located::unreadable(&file, source);
        let mut opened = BufReader::new(located::open(path).map_err(read)?);
        let source = match opened.fill_buf().map_err(read)?.starts_with(PARQUET) {
            true => RowSource::Parquet(Box::new(tables::RowReader::open(opened.into_inner(), &file)?)),
            false => RowSource::Csv(opened),
        };
        let mut rows = Self::new(file, source);
        if let RowSource::Csv(_) = rows.source {
            rows.advance()?;
            check_header(&rows.line, &rows.file)?;
        }
        Ok(rows)
    }

    /// Reads the next row; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Identity>, SweepError> {
        self.advance()?;
        match self.line.is_empty() {
            true => Ok(None),
            false => Identity::of_line(&self.line, &self.file, self.position()).map(Some),
        }
    }

    /// The fields of the row read last, as a sweep writes them, after the check that its values are those
    /// that the sweep wrote. A row that another program has written anew, with other forms of numbers, is
    /// checked as far as that left its values alone.
    pub fn checked_fields(&mut self) -> Result<csv::StringRecord, SweepError> {
        let found = self.fields()?;
        if row::wrong_checksum(&self.line).is_none() {
            return Ok(found);
        }
        let fields: csv::StringRecord =
            self.headings.iter().zip(&found).map(|(heading, cell)| as_written(heading, cell)).collect();
        check_names(&self.headings, &fields, &self.file, self.position())?;
        self.is_rewritten |= fields != found;
        if row::wrong_checksum(&row::line_of_cells(fields.iter())).is_some() {
            self.unchecked += 1;
            let is_changed = self.changed.is_none() && !row::checksum(&found).is_empty();
            self.changed = match is_changed {
                true => check_values(&self.line, &self.file, self.position()).err(),
                false => self.changed.take(),
            };
        }
        Ok(fields)
    }

    /// After the last row: the check that no row has other values than its sweep wrote. In rows that another
    /// program has written anew, other values may be rounded ones.
    pub fn check_all(&mut self) -> Result<(), SweepError> {
        let changed = self.changed.take().filter(|_| !self.is_rewritten);
        changed.map_or(Ok(()), Err)
    }

    /// The fields of the row read last.
    pub fn fields(&mut self) -> Result<csv::StringRecord, SweepError> {
        let (fields, columns) = (self.splitter.fields(&self.line), self.headings.len());
        if fields.len() == columns {
            return Ok(fields);
        }
        Err(SweepError::row(
            self.position(),
            self.file.clone(),
            format!("{} fields", fields.len()),
            format!("{columns} fields of text"),
        ))
    }

    /// The place of the row read last.
    pub fn position(&self) -> Position {
        match self.source {
            RowSource::Csv(_) => Position::Line(self.number),
            RowSource::Parquet(_) | RowSource::Lines(_) => Position::Row(self.number),
        }
    }

    /// The text of the study, if the file has it.
    pub fn study_text(&self) -> Option<&str> {
        match &self.source {
            RowSource::Csv(_) | RowSource::Lines(_) => None,
            RowSource::Parquet(reader) => reader.study_text(),
        }
    }

    fn advance(&mut self) -> Result<(), SweepError> {
        self.number += 1;
        let reader = match &mut self.source {
            RowSource::Csv(reader) => reader,
            RowSource::Parquet(reader) => {
                self.line = reader.next()?;
                return Ok(());
            }
            RowSource::Lines(lines) => {
                self.line = lines.next().cloned().unwrap_or_default();
                return Ok(());
            }
        };
        let read = read_line(reader, &mut self.line);
        read.map_err(|source| located::unreadable(&self.file, source))?;
        if self.line.last().is_some_and(|end| *end != b'\n') {
            return Err(SweepError::row(
                self.position(),
                self.file.clone(),
                "cut short".to_owned(),
                "complete: run its sweep again, which resumes there".to_owned(),
            ));
        }
        Ok(())
    }
}

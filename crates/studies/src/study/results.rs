//! Files of results, CSV or Parquet: the episode and study of each row, and its line of CSV.

use super::error::Position;
use super::origin::Origin;
use super::{SweepError, row, tables};
use cocarry::located;
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

/// The check that this program can write a file of that name.
pub(super) fn check_name(path: &Path) -> Result<(), SweepError> {
    if is_parquet(path) { tables::check(&path.display().to_string()) } else { Ok(()) }
}

fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
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
    let columns = row::headings().len();
    while rows.next()?.is_some() {
        each(&mut rows.fields(columns)?.iter());
    }
    Ok(())
}

/// A reader of a file's rows.
pub(super) struct Rows {
    pub file: String,
    source: RowSource,
    /// The number of the line or row read last, counted from 1.
    number: u64,
    /// The line of the row read last, with its newline.
    pub line: Vec<u8>,
    splitter: Splitter,
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

enum RowSource {
    Csv(BufReader<File>),
    Parquet(Box<tables::Reader>),
}

impl Rows {
    /// Opens the file and checks its columns.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let read = |source| located::unreadable(&file, source);
        let mut opened = BufReader::new(located::open(path).map_err(read)?);
        let source = match opened.fill_buf().map_err(read)?.starts_with(PARQUET) {
            true => RowSource::Parquet(Box::new(tables::Reader::open(opened.into_inner(), &file)?)),
            false => RowSource::Csv(opened),
        };
        let mut rows = Self { file, source, number: 0, line: Vec::new(), splitter: Splitter::new() };
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

    /// The fields of the row read last.
    pub fn fields(&mut self, columns: usize) -> Result<csv::StringRecord, SweepError> {
        let fields = self.splitter.fields(&self.line);
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
            RowSource::Parquet(_) => Position::Row(self.number),
        }
    }

    /// The text of the study, if the file has it.
    pub fn study_text(&self) -> Option<&str> {
        match &self.source {
            RowSource::Csv(_) => None,
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

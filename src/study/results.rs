//! Files of results: the episode and study of each row.

use super::{SweepError, row};
use crate::located::{self, FileError};
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
    pub fn of_line(line: &[u8], file: &str, number: u64) -> Result<Self, SweepError> {
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
            _ => Err(SweepError::Line {
                file: file.to_owned(),
                line: number,
                found: format!("`{}`", text.trim_end().chars().take(60).collect::<String>()),
                expected:
                    "a row of results: the number of an episode, the number of episodes, the study's digest, and the arithmetic's stamp"
                        .to_owned(),
            }),
        }
    }
}

/// The length of the longest line, bytes. A row has about 1 kB.
const LONGEST_LINE: u64 = 64 << 10;

/// Reads a line with its newline; nothing at the end of the file.
pub(super) fn read_line(reader: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<()> {
    line.clear();
    reader.take(LONGEST_LINE + 1).read_until(b'\n', line)?;
    match line.len() as u64 > LONGEST_LINE {
        true => Err(io::Error::other(format!("a line is longer than {LONGEST_LINE} bytes"))),
        false => Ok(()),
    }
}

/// The check, for rows that are kept, that their values are those that the sweep wrote.
pub(super) fn check_values(line: &[u8], file: &str, number: u64) -> Result<(), SweepError> {
    row::wrong_checksum(line).map_or(Ok(()), |[found, expected]| {
        let found = found.chars().take(60).collect::<String>();
        let found = format!("a row with changed values, whose checksum is `{found}`");
        let expected = format!("as its sweep wrote it, with checksum {expected}");
        Err(SweepError::Line { file: file.to_owned(), line: number, found, expected })
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
                return Err(SweepError::Columns { file: file.to_owned(), column, found, expected });
            }
        }
    }
    Ok(())
}

/// A reader of a file's rows.
pub(super) struct Rows {
    pub file: String,
    reader: BufReader<File>,
    /// The number of the line read last, counted from 1.
    pub number: u64,
    /// The line read last, with its newline.
    pub line: Vec<u8>,
}

impl Rows {
    /// Opens the file and checks its header.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let opened = located::open(path).map_err(|source| FileError::Read { file: file.clone(), source })?;
        let mut rows = Self { file, reader: BufReader::new(opened), number: 0, line: Vec::new() };
        rows.advance()?;
        check_header(&rows.line, &rows.file)?;
        Ok(rows)
    }

    /// Reads the next row; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Identity>, SweepError> {
        self.advance()?;
        match self.line.is_empty() {
            true => Ok(None),
            false => Identity::of_line(&self.line, &self.file, self.number).map(Some),
        }
    }

    fn advance(&mut self) -> Result<(), SweepError> {
        self.number += 1;
        let read = read_line(&mut self.reader, &mut self.line);
        read.map_err(|source| FileError::Read { file: self.file.clone(), source })?;
        if self.line.last().is_some_and(|end| *end != b'\n') {
            return Err(SweepError::Line {
                file: self.file.clone(),
                line: self.number,
                found: "cut short".to_owned(),
                expected: "complete: run its sweep again, which resumes there".to_owned(),
            });
        }
        Ok(())
    }
}

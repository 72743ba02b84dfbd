//! Tables of ticks: CSV or JSON lines, one line per tick, every key with its unit.

use super::output::{Failure, write_file};
use anyhow::{Context, Error};
use cocarry::quantities::{Fields, Record, TICK, Value, View};
use cocarry_output::output_file::Outputs;
use cocarry_studies::table::{plain, text_cell};
use serde_json::json;
use std::path::{Path, PathBuf};

/// A file of ticks. Its extension gives the format.
#[derive(Clone, Debug)]
pub(super) struct File {
    pub path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Csv,
    JsonLines,
}

/// Parses the argument.
pub(super) fn file(text: &str) -> Result<File, String> {
    let path = PathBuf::from(text);
    let format = match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => Format::Csv,
        Some("jsonl") => Format::JsonLines,
        _ => return Err("expected the extension .csv or .jsonl".to_owned()),
    };
    Ok(File { path, format })
}

impl File {
    /// An empty log, before the first tick.
    pub fn begin(&self) -> TickLog<'_> {
        let lines = match self.format {
            Format::Csv => {
                Lines::Csv { table: Box::new(csv::Writer::from_writer(Vec::new())), is_empty: true }
            }
            Format::JsonLines => Lines::Json(String::new()),
        };
        TickLog { path: &self.path, lines }
    }
}

/// The ticks so far, as lines.
pub(super) struct TickLog<'a> {
    path: &'a Path,
    lines: Lines,
}

enum Lines {
    Csv { table: Box<csv::Writer<Vec<u8>>>, is_empty: bool },
    Json(String),
}

impl TickLog<'_> {
    /// Adds the last step.
    pub fn step(&mut self, view: &View) -> Result<(), Failure> {
        let record: Record = TICK.into_iter().flat_map(|table| view.read(table)).collect();
        match &mut self.lines {
            Lines::Csv { table, is_empty } => {
                let (keys, values): (Vec<String>, Vec<String>) = cells(&record).into_iter().unzip();
                let heading = is_empty.then_some(keys);
                let written = heading.into_iter().chain([values]).try_for_each(|row| table.write_record(row));
                written.map_err(|error| Failure::Output(Error::new(error)))?;
                *is_empty = false;
            }
            Lines::Json(text) => {
                *text += &format!("{}\n", json!(record.into_iter().collect::<Fields>()));
            }
        }
        Ok(())
    }

    /// Writes the file.
    pub fn finish(self, outputs: &Outputs) -> Result<(), Failure> {
        let text = match self.lines {
            Lines::Csv { table, .. } => {
                let bytes = table.into_inner().map_err(|error| error.into_error());
                let text = bytes.map_err(Error::new).and_then(|bytes| Ok(String::from_utf8(bytes)?));
                text.context("CSV").map_err(Failure::Output)?
            }
            Lines::Json(text) => text,
        };
        write_file(outputs, self.path, &text)
    }
}

/// Columns and cells of a row. Columns of list elements are named `key[name]`.
fn cells(record: &Record) -> Vec<(String, String)> {
    let mut cells = Vec::new();
    for (key, value) in record {
        match value {
            Value::List(items) => {
                for fields in items {
                    let name = fields.get("name").map_or(String::new(), Value::cell);
                    let rest = fields.iter().filter(|(key, _)| **key != "name");
                    cells.extend(rest.map(|(key, value)| (format!("{key}[{name}]"), cell(value))));
                }
            }
            _ => cells.push(((*key).to_owned(), cell(value))),
        }
    }
    cells
}

fn cell(value: &Value) -> String {
    match value {
        Value::Flag(flag) => u8::from(*flag).to_string(),
        value => text_cell(&plain(&json!(value))).into_owned(),
    }
}

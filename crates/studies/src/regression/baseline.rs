//! A baseline file (TOML): its runs, tolerances and recorded figures.

use super::{FORMAT, Figure, Figures, Tolerance, figure_names};
use cocarry::Error;
use cocarry::bounds;
use cocarry::error::Place;
use cocarry::located::{self, short_lines};
use std::path::Path;
use toml_edit::{Document, DocumentMut, Item, Table};

/// A baseline file.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// The name of the file, as given by the caller.
    pub file: String,
    /// The format of its figures; 1 if the file does not name it.
    pub format: i64,
    /// The runs, in the order of the file.
    pub runs: Vec<Run>,
    text: String,
    tolerances: Vec<(String, Tolerance)>,
}

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its name: as given, or its keys and values.
    pub name: String,
    /// The line of its `[[run]]`.
    pub line: usize,
    /// Its keys, values and lines, without `name` and `recorded`.
    pub arguments: Vec<(String, Value, usize)>,
    /// The recorded figures.
    pub recorded: Option<Vec<(String, Figure)>>,
}

/// The value of an argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// A flag.
    Flag(bool),
    /// Any other value, as on a command line.
    Text(String),
    /// Several values, for an argument that may be given several times.
    List(Vec<String>),
}

/// The name of a baseline's kind, in errors.
const KIND: &str = "file of runs";

/// The keys at the top of a file.
const TOP: [&str; 3] = ["format", "tolerance", "run"];

impl Baseline {
    /// Reads a file.
    ///
    /// # Errors
    /// The line, the key and the value. The arguments of the runs are not checked.
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::parse(path.display().to_string(), located::read(&bounds::SETTINGS, path)?)
    }

    /// Reads a file's text. Errors call it `file`.
    ///
    /// # Errors
    /// As [`Baseline::load`].
    pub fn parse(file: String, text: String) -> Result<Self, Error> {
        let located = located::Source { file: &file, text: &text };
        let document =
            Document::parse(text.clone()).map_err(|error| located.invalid(KIND, short_lines(&error)))?;
        let mut source = BaselineSource { located, is_current: false };
        if let Some((key, _)) = document.iter().find(|(key, _)| !TOP.contains(key)) {
            return Err(source.unknown(document.as_table(), key, "the file", &TOP));
        }
        let format = document.get("format").map_or(Ok(1), |item| {
            let format = item.as_integer().filter(|format| (1..=FORMAT).contains(format));
            let expected = format!("a whole number from 1 to {FORMAT}, the format of this version");
            format.ok_or_else(|| source.wrong(item, "the file", "format", &expected))
        })?;
        source.is_current = format == FORMAT;
        let tolerances =
            document.get("tolerance").map_or(Ok(Vec::new()), |item| tolerances(&source, item))?;
        let runs = document.get("run").and_then(Item::as_array_of_tables);
        let Some(runs) = runs.filter(|runs| !runs.is_empty()) else {
            return Err(no_runs(&file));
        };
        let mut read: Vec<Run> = Vec::new();
        for table in runs {
            let run = parse_run(&source, table)?;
            if read.iter().any(|other| other.name == run.name) {
                let sentence = format_args!("duplicate run `{}`; give each run its own `name`", run.name);
                return Err(Error::at(Place::line(file, run.line as u64, ""), sentence));
            }
            read.push(run);
        }
        Ok(Self { file, format, runs: read, text, tolerances })
    }

    /// The tolerance of a figure.
    pub fn tolerance(&self, figure: &str) -> Tolerance {
        let of = |name: &str| self.tolerances.iter().find(|t| t.0 == name).map(|t| t.1);
        of(figure).or_else(|| of("")).unwrap_or_default()
    }

    /// The file's text with new figures, one set for every run. The rest of the text stays as it is,
    /// including comments.
    ///
    /// # Errors
    /// None for a text that was read before.
    pub fn recorded(&self, figures: &[Figures]) -> Result<String, Error> {
        let source = located::Source { file: &self.file, text: &self.text };
        let mut document: DocumentMut = self
            .text
            .parse()
            .map_err(|error: toml_edit::TomlError| source.invalid(KIND, short_lines(&error)))?;
        let Some(runs) = document.get_mut("run").and_then(Item::as_array_of_tables_mut) else {
            return Err(no_runs(&self.file));
        };
        for (run, figures) in runs.iter_mut().zip(figures) {
            let old = run.get("recorded").and_then(Item::as_table);
            let mut table = Table::new();
            if let Some(old) = old {
                // keeps its position among the tables, and the comments around it
                *table.decor_mut() = old.decor().clone();
                if let Some(position) = old.position() {
                    table.set_position(Some(position));
                }
            } else {
                table.decor_mut().set_prefix("\n");
            }
            for (name, figure) in figures {
                let value = match figure {
                    Figure::Count(count) => toml_edit::Value::from(*count),
                    Figure::Number(number) => (*number).into(),
                    other => other.cell().into(),
                };
                table.insert(name, toml_edit::value(value));
            }
            run.insert("recorded", Item::Table(table));
        }
        document.insert("format", toml_edit::value(FORMAT));
        Ok(document.to_string())
    }
}

/// A text that errors point into.
struct BaselineSource<'a> {
    located: located::Source<'a>,
    /// Whether figures are of the latest format: earlier ones had other names.
    is_current: bool,
}

impl BaselineSource<'_> {
    fn line(&self, span: Option<std::ops::Range<usize>>) -> usize {
        self.located.line(span.map_or(0, |span| span.start))
    }

    fn unknown(&self, table: &Table, key: &str, place: &str, expected: &[&str]) -> Error {
        let span = table.key(key).and_then(|key| key.span()).unwrap_or(0..0);
        let expected = expected.join(", ");
        let sentence = format_args!("unknown key `{key}`; expected one of: {expected}");
        Error::at(self.located.place_at(span, place), sentence)
    }

    fn wrong(&self, item: &Item, place: &str, key: &str, expected: &str) -> Error {
        let place = self.located.place_at(item.span().unwrap_or(0..0), place);
        let value = item.to_string();
        Error::bad(place, format_args!("{key} = {}", value.trim()), expected)
    }
}

fn no_runs(file: &str) -> Error {
    let sentence = "no runs; write each as a table [[run]], with the keys of `cocarry run`'s arguments";
    Error::at(Place::file(file), sentence)
}

/// Tolerances by figure; that of all others has no name.
fn tolerances(source: &BaselineSource, item: &Item) -> Result<Vec<(String, Tolerance)>, Error> {
    const KEYS: [&str; 2] = ["relative", "absolute"];
    let table_of = |item: &Item, key: &str, place: &str| match item.as_table() {
        Some(table) => Ok(table.clone()),
        None => Err(source.wrong(item, place, key, "a table with relative and absolute")),
    };
    let read = |table: &Table, place: &str, default: Tolerance| {
        let number = |key: &str, default: f64| match table.get(key) {
            None => Ok(default),
            Some(item) => {
                let number = item.as_float().or_else(|| item.as_integer().map(|i| i as f64));
                let number = number.filter(|n| *n >= 0.0 && n.is_finite());
                number.ok_or_else(|| source.wrong(item, place, key, "a number of at least 0"))
            }
        };
        let relative = number(KEYS[0], default.relative)?;
        let absolute = number(KEYS[1], default.absolute)?;
        Ok::<_, Error>(Tolerance { relative, absolute })
    };
    let table = table_of(item, "tolerance", "the file")?;
    let general = read(&table, "tolerance", Tolerance::default())?;
    let names = figure_names();
    let mut all = vec![(String::new(), general)];
    for (figure, item) in table.iter().filter(|(key, _)| !KEYS.contains(key)) {
        if !names.contains(&figure) {
            return Err(source.unknown(&table, figure, "tolerance", &[&KEYS[..], &names].concat()));
        }
        let own = table_of(item, figure, "tolerance")?;
        let place = format!("tolerance.{figure}");
        if let Some((key, _)) = own.iter().find(|(key, _)| !KEYS.contains(key)) {
            return Err(source.unknown(&own, key, &place, &KEYS));
        }
        all.push((figure.to_owned(), read(&own, &place, general)?));
    }
    Ok(all)
}

fn parse_run(source: &BaselineSource, table: &Table) -> Result<Run, Error> {
    let line = source.line(table.span());
    let mut run = Run { name: String::new(), line, arguments: Vec::new(), recorded: None };
    for (key, item) in table.iter() {
        match key {
            "name" => match item.as_str().filter(|name| !name.is_empty()) {
                Some(name) => run.name = name.to_owned(),
                None => return Err(source.wrong(item, "run", key, "a word in quotes")),
            },
            "recorded" => run.recorded = Some(recorded(source, item)?),
            _ => {
                let Some(value) = item.as_value().and_then(argument) else {
                    return Err(source.wrong(item, "run", key, "a number, a word in quotes, true or false"));
                };
                run.arguments.push((key.to_owned(), value, source.line(item.span())));
            }
        }
    }
    if run.name.is_empty() {
        let words = run.arguments.iter().map(|(key, value, _)| match (key.as_str(), value) {
            ("world" | "method" | "plant", Value::Text(text)) => text.clone(),
            (_, Value::Text(text)) => format!("{key} {text}"),
            (_, Value::Flag(true)) => key.clone(),
            (_, Value::Flag(false)) => format!("no {key}"),
            (_, Value::List(texts)) => format!("{key} {}", texts.join(" ")),
        });
        run.name = words.collect::<Vec<_>>().join(", ");
    }
    Ok(run)
}

/// The value of an argument; `None` for a value of another kind.
fn argument(value: &toml_edit::Value) -> Option<Value> {
    if let Some(list) = value.as_array() {
        return list.iter().map(text).collect::<Option<_>>().map(Value::List);
    }
    value.as_bool().map(Value::Flag).or_else(|| text(value).map(Value::Text))
}

fn text(value: &toml_edit::Value) -> Option<String> {
    match value {
        toml_edit::Value::String(text) => Some(text.value().clone()),
        toml_edit::Value::Integer(number) => Some(number.value().to_string()),
        toml_edit::Value::Float(number) => Some(number.value().to_string()),
        _ => None,
    }
}

fn recorded(source: &BaselineSource, item: &Item) -> Result<Vec<(String, Figure)>, Error> {
    let Some(table) = item.as_table() else {
        return Err(source.wrong(item, "run", "recorded", "a table [run.recorded], as `record` writes it"));
    };
    let names = figure_names();
    let mut figures = Vec::new();
    for (key, item) in table.iter() {
        if source.is_current && !names.contains(&key) {
            return Err(source.unknown(table, key, "run.recorded", &names));
        }
        let figure = match item.as_value() {
            Some(toml_edit::Value::String(text)) => text.value().as_str().into(),
            Some(toml_edit::Value::Integer(count)) => (*count.value()).into(),
            Some(toml_edit::Value::Float(number)) => (*number.value()).into(),
            _ => return Err(source.wrong(item, "run.recorded", key, "a number or a word in quotes")),
        };
        figures.push((key.to_owned(), figure));
    }
    Ok(figures)
}

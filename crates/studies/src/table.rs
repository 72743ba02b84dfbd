//! Tables of results, written as Markdown for people and as CSV and JSON for programs.

use serde_json::{Map, Value};
use std::borrow::Cow;

/// A table: a text in each cell for people, and the figures behind it for programs.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// File name without extension.
    pub name: String,
    /// Title.
    pub title: String,
    /// Columns, left to right.
    pub columns: Vec<Column>,
    /// Rows, top to bottom, one cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Notes for the reader, one line each.
    pub notes: Vec<String>,
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Heading for people; empty for a column for programs only.
    pub heading: String,
    /// Whether it holds text, which is aligned left, or numbers, which are aligned right.
    pub is_text: bool,
    /// The keys of the figures behind a cell, with units; empty for a column that follows from others.
    pub keys: Vec<String>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Text for people.
    pub shown: String,
    /// Values for programs: one for each of the column's keys.
    pub values: Vec<Value>,
}

impl Cell {
    fn text(text: String) -> Self {
        Self { shown: text.clone(), values: vec![text.into()] }
    }

    fn number(number: f64, decimals: usize) -> Self {
        Self { shown: format!("{number:.decimals$}"), values: vec![number.into()] }
    }

    fn count(count: Option<u64>) -> Self {
        Self { shown: count.map_or("-".to_owned(), |n| n.to_string()), values: vec![count.into()] }
    }

    fn spread([mean, std]: [f64; 2], decimals: usize) -> Self {
        Self {
            shown: format!("{mean:.decimals$} ± {std:.decimals$}"), values: vec![mean.into(), std.into()]
        }
    }
}

/// A builder that fills a table column by column from the same rows.
#[derive(Debug)]
pub struct Columns<'a, R> {
    rows: &'a [R],
    columns: Vec<Column>,
    cells: Vec<Vec<Cell>>,
}

impl<'a, R> Columns<'a, R> {
    /// A builder without columns for these rows.
    pub fn of(rows: &'a [R]) -> Self {
        Self { rows, columns: Vec::new(), cells: vec![Vec::new(); rows.len()] }
    }

    /// Adds a column of text.
    pub fn text<T: ToString>(self, heading: &str, key: &str, text: impl Fn(&R) -> T) -> Self {
        self.column(heading, true, &[key], |row| Cell::text(text(row).to_string()))
    }

    /// Adds a column of whole numbers that name something; they are aligned left like text.
    pub fn numbered(self, heading: &str, key: &str, number: impl Fn(&R) -> u32) -> Self {
        self.column(heading, true, &[key], |row| {
            let number = number(row);
            Cell { shown: number.to_string(), values: vec![number.into()] }
        })
    }

    /// Adds a column of numbers, shown with `decimals` decimals.
    pub fn number(self, heading: &str, key: &str, decimals: usize, number: impl Fn(&R) -> f64) -> Self {
        self.column(heading, false, &[key], |row| Cell::number(number(row), decimals))
    }

    /// Adds a column of whole numbers; `-` where there is none.
    pub fn count<T: Into<Option<u64>>>(self, heading: &str, key: &str, count: impl Fn(&R) -> T) -> Self {
        self.column(heading, false, &[key], |row| Cell::count(count(row).into()))
    }

    /// Adds a column of means and standard deviations.
    pub fn spread(
        self,
        heading: &str,
        keys: [&str; 2],
        decimals: usize,
        spread: impl Fn(&R) -> [f64; 2],
    ) -> Self {
        self.column(heading, false, &keys, |row| Cell::spread(spread(row), decimals))
    }

    /// Adds a column of text that follows from other columns.
    pub fn derived(self, heading: &str, text: impl Fn(&R) -> String) -> Self {
        self.column(heading, false, &[], |row| Cell { shown: text(row), values: Vec::new() })
    }

    /// Adds a column for programs only.
    pub fn data<T: Into<Value>>(self, key: &str, value: impl Fn(&R) -> T) -> Self {
        self.column("", false, &[key], |row| Cell { shown: String::new(), values: vec![value(row).into()] })
    }

    /// Adds a column of any kind.
    pub fn column(mut self, heading: &str, is_text: bool, keys: &[&str], cell: impl Fn(&R) -> Cell) -> Self {
        self.add(heading, is_text, keys, &cell);
        self
    }

    /// Compiled once for all columns of the same rows.
    fn add(&mut self, heading: &str, is_text: bool, keys: &[&str], cell: &dyn Fn(&R) -> Cell) {
        let keys = keys.iter().map(|&key| key.to_owned()).collect();
        self.columns.push(Column { heading: heading.to_owned(), is_text, keys });
        for (cells, row) in self.cells.iter_mut().zip(self.rows) {
            cells.push(cell(row));
        }
    }

    /// The table.
    pub fn table(self, name: &str, title: impl Into<String>) -> Table {
        Table {
            name: name.to_owned(),
            title: title.into(),
            columns: self.columns,
            rows: self.cells,
            notes: Vec::new(),
        }
    }
}

impl Table {
    /// The table with one more note below it.
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Headings, whether each column holds text, and the texts of each row, for the columns that people see.
    pub fn shown(&self) -> (Vec<(&str, bool)>, Vec<Vec<&str>>) {
        let is_shown = |column: &Column| !column.heading.is_empty();
        let headings = self.columns.iter().filter(|c| is_shown(c));
        let rows = self.rows.iter().map(|row| {
            let cells = row.iter().zip(&self.columns).filter(|(_, column)| is_shown(column));
            cells.map(|(cell, _)| cell.shown.as_str()).collect()
        });
        (headings.map(|c| (c.heading.as_str(), c.is_text)).collect(), rows.collect())
    }

    /// Title, table and notes as Markdown; only the title if no column is for people.
    pub fn markdown(&self) -> String {
        let (headings, rows) = self.shown();
        let title = escaped(&self.title);
        let mut text = format!("**{title}** ([{name}.csv]({name}.csv))\n\n", name = self.name);
        if !headings.is_empty() {
            let line = |cells: &[&str]| {
                let cells = cells.iter().map(|cell| escaped(cell));
                format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
            };
            text += &line(&headings.iter().map(|h| h.0).collect::<Vec<_>>());
            text += &line(&headings.iter().map(|h| if h.1 { ":--" } else { "--:" }).collect::<Vec<_>>());
            rows.iter().for_each(|row| text += &line(row));
            text.push('\n');
        }
        if !self.notes.is_empty() {
            text += &format!("*{}*\n\n", self.notes.join(" "));
        }
        text
    }

    /// The figures as CSV with keys as headings; empty if there are none.
    pub fn csv(&self) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let lines = self.rows.iter().map(|row| {
            row.iter().flat_map(|c| &c.values).map(|value| text_cell(&plain(value)).into_owned()).collect()
        });
        let keys: Vec<String> = self.columns.iter().flat_map(|c| c.keys.clone()).collect();
        for line in [keys].into_iter().chain(lines) {
            // writing to memory does not fail, and every line has all keys
            let _ = writer.write_record(&line);
        }
        writer.into_inner().expect("writing to memory does not fail")
    }

    /// The figures as JSON: one object for each row.
    pub fn json(&self) -> Value {
        let keys: Vec<&String> = self.columns.iter().flat_map(|c| &c.keys).collect();
        let object = |row: &Vec<Cell>| -> Map<String, Value> {
            let values = row.iter().flat_map(|c| c.values.clone());
            keys.iter().map(|&key| key.clone()).zip(values).collect()
        };
        self.rows.iter().map(object).collect()
    }
}

/// A text that Markdown shows as it is, in a line or the cell of a table: names come from files.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars().map(|c| if c.is_control() { ' ' } else { c }) {
        if "\\`*_[]<>&|#!".contains(character) {
            escaped.push('\\');
        }
        escaped.push(character);
    }
    escaped
}

/// A text as the cell of a CSV file: one that a spreadsheet would take for a formula, and is no number, has an
/// apostrophe before it, as a spreadsheet marks texts.
pub fn text_cell(text: &str) -> Cow<'_, str> {
    let is_formula = text.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r']);
    let is_text = is_formula && text.parse::<f64>().is_err();
    if is_text { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

/// A value as the text of a cell: null is empty, text has no quotes.
pub fn plain(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_a_spreadsheet_would_take_for_a_formula_is_marked_and_a_number_is_not() {
        for text in ["=1+1", "+a", "-a", "@a", "'=1", "-1+1", "\t=1"] {
            assert_eq!(text_cell(text), format!("'{text}"));
        }
        for text in ["a=1", "-0.5", "+3", "-inf", "", "'a", "1e-9"] {
            assert_eq!(text_cell(text), text);
        }
    }

    #[test]
    fn golden_a_table_for_people_and_for_programs() {
        let rows = [("a|b", 0.25, None), ("c,\"", f64::NAN, Some(7u64))];
        let table = Columns::of(&rows)
            .text("name", "name", |r| r.0)
            .spread("cost (m)", ["mean_m", "std_m"], 1, |r| [r.1, 0.5])
            .derived("half", |r| format!("{:.2}", r.1 / 2.0))
            .count("step", "step", |r| r.2)
            .data("twice_m", |r| 2.0 * r.1)
            .table("t", "T")
            .with_note("Note.");
        assert_eq!(
            table.markdown(),
            "**T** ([t.csv](t.csv))\n\n| name | cost (m) | half | step |\n| :-- | --: | --: | --: |\n\
             | a\\|b | 0.2 ± 0.5 | 0.12 | - |\n| c,\" | NaN ± 0.5 | NaN | 7 |\n\n*Note.*\n\n"
        );
        let csv = String::from_utf8(table.csv()).unwrap();
        assert_eq!(csv, "name,mean_m,std_m,step,twice_m\na|b,0.25,0.5,,0.5\n\"c,\"\"\",,0.5,7,\n");
        assert_eq!(table.json()[0]["twice_m"], 0.5);
        assert!(table.json()[1]["mean_m"].is_null());
    }
}

//! The kept tables of a report, and how numbers of them are written.

use crate::support::repository;
use std::collections::BTreeMap;
use std::path::Path;

/// All tables, by name.
pub struct Tables(BTreeMap<String, Vec<FigureRow>>);

/// A row of a table.
#[derive(Clone, Debug)]
pub struct FigureRow {
    table: String,
    values: BTreeMap<String, String>,
}

/// The names of the tables in the folder of the kept ones.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let tables = names.filter(|name| name != "short.csv");
    let mut names: Vec<String> =
        tables.filter_map(|name| Some(name.strip_suffix(".csv")?.to_owned())).collect();
    names.sort();
    names
}

impl Tables {
    /// Those next to the book.
    pub fn read() -> Self {
        let folder = repository("book/figures");
        let table = |name: String| {
            let rows = csv::Reader::from_path(folder.join(format!("{name}.csv"))).unwrap().into_deserialize();
            let row =
                |values: Result<_, csv::Error>| FigureRow { table: name.clone(), values: values.unwrap() };
            (name.clone(), rows.map(row).collect())
        };
        Self(files(&folder).into_iter().map(table).collect())
    }

    /// The rows of a table with these values.
    pub fn rows(&self, table: &str, with: &[(&str, &str)]) -> Vec<&FigureRow> {
        let rows = self
            .0
            .get(table)
            .unwrap_or_else(|| panic!("book/figures/{table}.csv is missing: run book/renew"));
        rows.iter().filter(|row| with.iter().all(|(column, value)| row.text(column) == *value)).collect()
    }

    /// The row of a table with these values, of which there is one.
    pub fn row(&self, table: &str, with: &[(&str, &str)]) -> &FigureRow {
        match self.rows(table, with).as_slice() {
            [row] => row,
            rows => panic!("book/figures/{table}.csv has {} rows with {with:?}", rows.len()),
        }
    }

    /// The numbers of a column in the rows with these values.
    pub fn column(&self, table: &str, with: &[(&str, &str)], column: &str) -> Vec<f64> {
        self.rows(table, with).iter().map(|row| row.number(column)).collect()
    }
}

impl FigureRow {
    pub fn text(&self, column: &str) -> &str {
        let value = self.values.get(column);
        value.unwrap_or_else(|| panic!("book/figures/{}.csv has no column {column}", self.table))
    }

    pub fn number(&self, column: &str) -> f64 {
        let text = self.text(column);
        text.parse().unwrap_or_else(|e| panic!("book/figures/{}.csv: {column}: {text:?}: {e}", self.table))
    }

    /// A number that may be missing.
    pub fn maybe(&self, column: &str) -> Option<f64> {
        (!self.text(column).is_empty()).then(|| self.number(column))
    }
}

pub fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

pub fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

pub fn least(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(f64::INFINITY, f64::min)
}

/// A whole number with separated thousands.
pub fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let groups = digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap());
    groups.collect::<Vec<_>>().join(",")
}

/// "none", "one", or the number in digits.
pub fn counted(number: f64) -> String {
    match number {
        0.0 => "none".to_owned(),
        1.0 => "one".to_owned(),
        _ => grouped(number),
    }
}

/// A row of a Markdown table.
pub fn line<T: AsRef<str>>(cells: impl IntoIterator<Item = T>) -> String {
    let cells: Vec<String> = cells.into_iter().map(|cell| cell.as_ref().to_owned()).collect();
    format!("| {} |\n", cells.join(" | "))
}

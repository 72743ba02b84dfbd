//! Results of sweeps: summaries, paired comparisons and pictures.

use crate::error::{StudyError, raise};
use crate::table::Table;
use cocarry::quantities::{EPISODE, QuantityKind};
use cocarry::suggestion;
use cocarry_recording::rendering::{PictureFormat, Width};
use cocarry_studies::study::bench::ScoreCard;
use cocarry_studies::study::{Comparing, Drawn, OUTCOMES, Results, Summary, SweepError, columns, line_of};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};

/// Results as Python gives them: a file, a table, or names and cells of a data frame, column by column.
#[derive(FromPyObject)]
pub enum GivenResults<'py> {
    Table(PyRef<'py, Table>),
    Frame((Vec<String>, Vec<Vec<String>>)),
    File(PathBuf),
}

/// Results, with what they are read from.
enum Held {
    File(PathBuf),
    Lines { name: String, lines: Vec<Vec<u8>> },
}

impl Held {
    fn of(number: usize, given: GivenResults) -> PyResult<Self> {
        let name = format!("table {number}");
        let (names, cells) = match given {
            GivenResults::File(path) => return Ok(Self::File(path)),
            GivenResults::Frame(frame) => frame,
            GivenResults::Table(table) => table.texts(),
        };
        let expected: Vec<&str> = columns().into_iter().map(|heading| heading.name).collect();
        let places: Option<Vec<usize>> =
            expected.iter().map(|name| names.iter().position(|other| other == name)).collect();
        let Some(places) = places else {
            let missing = expected.into_iter().filter(|name| !names.iter().any(|other| other == name));
            let missing = missing.take(5).collect::<Vec<_>>().join(", ");
            return Err(StudyError::new_err(format!(
                "{name}: not the rows of a sweep: it has no {missing}; keep all columns, and filter rows only"
            )));
        };
        let count = cells.first().map_or(0, Vec::len);
        let line = |row: usize| {
            line_of(places.iter().map(|&column| cells[column].get(row).map_or("", String::as_str)))
        };
        Ok(Self::Lines { name, lines: (0..count).map(line).collect() })
    }

    fn results(&self) -> Results<'_> {
        match self {
            Self::File(path) => Results::File(path),
            Self::Lines { name, lines } => Results::Lines { name, lines },
        }
    }
}

fn held(given: Vec<GivenResults>) -> PyResult<Vec<Held>> {
    if given.is_empty() {
        return Err(StudyError::new_err(
            "there are no results; expected tables of sweep, data frames or files",
        ));
    }
    (1..).zip(given).map(|(number, given)| Held::of(number, given)).collect()
}

fn refused(error: &SweepError) -> PyErr {
    raise::<StudyError>(error)
}

/// What is compared.
fn comparing(by: Option<&str>, over: &[String], quantities: &[String]) -> PyResult<Comparing> {
    Comparing::new(by, over, quantities).map_err(|error| raise::<StudyError>(&error))
}

/// The paired comparisons of results, and notes on them.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    results: Vec<GivenResults<'_>>,
    by: Option<&str>,
    over: Vec<String>,
    quantities: Vec<String>,
) -> PyResult<(Table, Vec<String>)> {
    let (held, comparing) = (held(results)?, comparing(by, &over, &quantities)?);
    let results: Vec<Results> = held.iter().map(Held::results).collect();
    let summary = py.detach(|| Summary::load(&results, &comparing)).map_err(|error| refused(&error))?;
    let names: Vec<String> = results.iter().map(Results::name).collect();
    let by = by.unwrap_or("method or pose");
    summary.check_compared(&names, by).map_err(|error| refused(&error))?;
    Ok((Table::of_report(&summary.comparison_table(true)), summary.notes))
}

/// Means and intervals of every combination of results, and notes on them.
#[pyfunction]
pub fn summary(py: Python<'_>, results: Vec<GivenResults<'_>>) -> PyResult<(Table, Vec<String>)> {
    let held = held(results)?;
    let results: Vec<Results> = held.iter().map(Held::results).collect();
    let summary = py.detach(|| Summary::load(&results, &Comparing::default()));
    let summary = summary.map_err(|error| refused(&error))?;
    Ok((Table::of_report(&summary.group_table()), summary.notes))
}

/// The score card of results of the benchmark in a folder, or its results world by world, and notes on them.
#[pyfunction]
pub fn bench(
    py: Python<'_>,
    folder: PathBuf,
    results: Vec<GivenResults<'_>>,
    worlds: bool,
) -> PyResult<(Table, Vec<String>)> {
    let held = held(results)?;
    let results: Vec<Results> = held.iter().map(Held::results).collect();
    let card = py.detach(|| ScoreCard::load(&folder, &results)).map_err(|error| refused(&error))?;
    let table = if worlds { card.world_table() } else { card.table() };
    Ok((Table::of_report(&table), Vec::new()))
}

/// The check of the kind of a picture, and that it has the quantity.
fn check_drawn(kind: &str, quantity: &str) -> PyResult<()> {
    let numbers = EPISODE
        .iter()
        .filter(|quantity| matches!(quantity.kind, QuantityKind::Number(_) | QuantityKind::Count));
    let known: Vec<&str> = match kind {
        "means" | "map" => OUTCOMES.to_vec(),
        "differences" => numbers.map(|quantity| quantity.key).collect(),
        other => {
            return Err(StudyError::new_err(format!(
                "kind = {other:?}; it must be one of: means, differences, map"
            )));
        }
    };
    if known.contains(&quantity) {
        return Ok(());
    }
    let (listed, hint) = (known.join(", "), suggestion::hint(quantity, known));
    Err(StudyError::new_err(format!("quantity = {quantity:?}; it must be one of: {listed}{hint}")))
}

/// The check of the name of a picture's file; returns its format.
fn format_of(file: &Path) -> PyResult<PictureFormat> {
    let format = PictureFormat::of(file);
    format.map_err(|sentence| StudyError::new_err(format!("{}: {sentence}", file.display())))
}

/// The bytes of a picture of results, in the format of a file of that name, and notes on them.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords")]
pub fn plot<'py>(
    py: Python<'py>,
    results: Vec<GivenResults<'_>>,
    kind: &str,
    quantity: &str,
    by: Option<&str>,
    cells: usize,
    width: Option<&str>,
    file: PathBuf,
) -> PyResult<(Bound<'py, PyBytes>, Vec<String>)> {
    check_drawn(kind, quantity)?;
    let drawn = match kind {
        "differences" => Drawn::Differences(comparing(by, &[], &[quantity.to_owned()])?),
        "map" if (2..=60).contains(&cells) => Drawn::Map(cells),
        "map" => return Err(StudyError::new_err(format!("cells = {cells}; it must be from 2 to 60"))),
        _ => Drawn::Means,
    };
    let width = width.map(|text| {
        let width = text.parse::<Width>();
        width.map_err(|sentence| StudyError::new_err(format!("width = {text:?}: {sentence}")))
    });
    let (format, width) = (format_of(&file)?, width.transpose()?);
    let held = held(results)?;
    let results: Vec<Results> = held.iter().map(Held::results).collect();
    let (bytes, notes) = py.detach(|| {
        let drawn = cocarry_studies::study::picture(&results, quantity, &drawn, format.sheet(width));
        let (svg, notes) = drawn.map_err(|error| refused(&error))?;
        let bytes = format.bytes(svg, width).map_err(|error| raise::<StudyError>(&error))?;
        Ok::<_, PyErr>((bytes, notes))
    })?;
    Ok((PyBytes::new(py, &bytes), notes))
}

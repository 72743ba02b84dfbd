//! Tables, as Arrow data and as numpy columns.

use crate::arguments::refused;
use crate::error::{Error, no_such_key, raise};
use crate::value::{of_json, repr};
use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, RecordBatchIterator};
use arrow_schema::{DataType, Field, Schema};
use arrow_select::concat::concat_batches;
use cocarry::quantities::{Heading, QuantityKind, Record, TICK, Value};
use cocarry::suggestion;
use cocarry_studies::columns::{Column, Columns, field};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};
use serde_json::Value as Json;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// A table of rows. Opens without copies wherever Arrow data do: ``polars.DataFrame(table)``,
/// ``pyarrow.table(table)``, ``pandas.DataFrame.from_arrow(table)`` (pandas 3). Shows its first rows in a
/// notebook, and as ``print(table)``.
#[pyclass(frozen, module = "cocarry", name = "Table")]
pub struct Table {
    batch: RecordBatch,
}

/// A column while it is filled: its name, its values, and what is known of it.
type Filled = (String, Column, HashMap<String, String>);

impl Table {
    fn new(columns: Vec<Filled>) -> Self {
        let batch = || {
            let mut fields = Vec::new();
            let mut arrays: Vec<ArrayRef> = Vec::new();
            for (name, column, metadata) in columns {
                let array = column.array()?;
                fields.push(Field::new(name, array.data_type().clone(), true).with_metadata(metadata));
                arrays.push(array);
            }
            RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
        };
        // the columns have one length
        Self { batch: batch().unwrap_or_else(|_| RecordBatch::new_empty(Arc::new(Schema::empty()))) }
    }

    /// The rows of a study, as in a file of results.
    pub fn of_rows(columns: Columns) -> PyResult<Self> {
        Ok(Self { batch: columns.batch().map_err(|error| raise::<Error>(&error))? })
    }

    /// A row for every tick; items of lists have columns of their own, `key[name]`.
    pub fn of_ticks(records: &[Record]) -> Self {
        let mut order: Vec<String> = Vec::new();
        let mut columns: BTreeMap<String, (Column, HashMap<String, String>, usize)> = BTreeMap::new();
        for (row, record) in records.iter().enumerate() {
            for (key, value) in record {
                let quantity = TICK.into_iter().flatten().find(|quantity| quantity.key == *key);
                let Some(quantity) = quantity else { continue };
                let cells: Vec<(String, &Value, QuantityKind)> = match value {
                    Value::List(items) => items
                        .iter()
                        .flat_map(|fields| {
                            let name = fields.get("name").and_then(Value::as_str).unwrap_or_default();
                            let rest = fields.iter().filter(|(key, _)| **key != "name");
                            rest.map(move |(key, value)| {
                                let is_flag = matches!(value, Value::Flag(_));
                                let kind =
                                    if is_flag { QuantityKind::Flag } else { QuantityKind::Number("") };
                                (format!("{key}[{name}]"), value, kind)
                            })
                        })
                        .collect(),
                    _ if matches!(quantity.kind, QuantityKind::List(_)) => Vec::new(),
                    value => vec![((*key).to_owned(), value, quantity.kind)],
                };
                for (name, value, kind) in cells {
                    let (column, _, filled) = columns.entry(name.clone()).or_insert_with(|| {
                        order.push(name.clone());
                        (Column::of(kind), field(&Heading::from(quantity)).metadata().clone().into(), 0)
                    });
                    for _ in *filled..row {
                        column.add(&Value::Missing);
                    }
                    column.add(value);
                    *filled = row + 1;
                }
            }
        }
        let made = order.into_iter().filter_map(|name| {
            let (mut column, about, filled) = columns.remove(&name)?;
            (filled..records.len()).for_each(|_| column.add(&Value::Missing));
            Some((name, column, about))
        });
        Self::new(made.collect())
    }

    /// A table of messages: a time in seconds, then numbers and texts as they are found.
    pub fn of_messages(names: &[String], times: Vec<f64>, rows: &[Vec<Option<Json>>]) -> Self {
        let mut time = Column::of(QuantityKind::Number("s"));
        times.into_iter().for_each(|seconds| time.add(&seconds.into()));
        let time = ("time_s".to_owned(), time, HashMap::new());
        let columns = names.iter().enumerate().map(|(i, name)| {
            let cells =
                || rows.iter().filter_map(move |row| row.get(i)?.as_ref()).filter(|cell| !cell.is_null());
            let all = |is: fn(&Json) -> bool| cells().next().is_some() && cells().all(is);
            let kind = match () {
                () if all(Json::is_i64) => QuantityKind::Count,
                () if all(Json::is_number) => QuantityKind::Number(""),
                () if all(Json::is_boolean) => QuantityKind::Flag,
                () => QuantityKind::Text,
            };
            let mut column = Column::of(kind);
            for row in rows {
                match row.get(i).and_then(Option::as_ref).unwrap_or(&Json::Null) {
                    other @ (Json::Bool(_) | Json::Number(_)) if matches!(kind, QuantityKind::Text) => {
                        column.add(&other.to_string().into());
                    }
                    cell => column.add(&of_json(cell)),
                }
            }
            (name.clone(), column, HashMap::new())
        });
        Self::new([time].into_iter().chain(columns).collect())
    }

    /// A table of a report.
    pub fn of_report(table: &cocarry_studies::table::Table) -> Self {
        let names = table.columns.iter().flat_map(|column| &column.keys);
        let rows = table.rows.iter().map(|row| row.iter().flat_map(|cell| &cell.values).collect::<Vec<_>>());
        let rows: Vec<Vec<&Json>> = rows.collect();
        let columns = names.enumerate().map(|(i, name)| {
            let cells = || rows.iter().map(|row| row[i]).filter(|cell| !cell.is_null());
            let kind = match () {
                () if cells().any(Json::is_string) => QuantityKind::Text,
                () if cells().next().is_some() && cells().all(Json::is_boolean) => QuantityKind::Flag,
                () if cells().next().is_some() && cells().all(Json::is_u64) => QuantityKind::Count,
                () => QuantityKind::Number(""),
            };
            let mut column = Column::of(kind);
            rows.iter().for_each(|row| column.add(&of_json(row[i])));
            (name.clone(), column, HashMap::new())
        });
        Self::new(columns.collect())
    }

    /// The names of the columns, and their cells as texts.
    pub fn texts(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let cells = |array: &ArrayRef| (0..array.len()).map(|row| Self::cell(array, row)).collect();
        (self.columns(), self.batch.columns().iter().map(cells).collect())
    }

    fn column(&self, py: Python<'_>, name: &str) -> PyResult<&ArrayRef> {
        self.batch.column_by_name(name).ok_or_else(|| {
            let columns = self.columns();
            let (known, hint) =
                (columns.join(", "), suggestion::hint(name, columns.iter().map(String::as_str)));
            no_such_key(py, format!("unknown column `{name}`; expected one of: {known}{hint}"))
        })
    }

    /// A column as a numpy array: numbers with NaN where one is missing, texts as objects.
    fn numpy_column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self.column(py, name)?;
        Ok(match array.data_type() {
            DataType::Float64 => {
                let values = array.as_primitive::<Float64Type>();
                match values.null_count() {
                    0 => PyArray1::from_slice(py, values.values()).into_any(),
                    _ => PyArray1::from_iter(py, values.iter().map(|v| v.unwrap_or(f64::NAN))).into_any(),
                }
            }
            DataType::Int64 => {
                let values = array.as_primitive::<Int64Type>();
                match values.null_count() {
                    0 => PyArray1::from_slice(py, values.values()).into_any(),
                    _ => PyArray1::from_iter(py, values.iter().map(|v| v.map_or(f64::NAN, |v| v as f64)))
                        .into_any(),
                }
            }
            DataType::Boolean if array.null_count() == 0 => {
                PyArray1::from_iter(py, array.as_boolean().iter().map(|flag| flag.unwrap_or(false)))
                    .into_any()
            }
            DataType::Boolean => object_array(py, PyList::new(py, array.as_boolean().iter())?)?,
            _ => object_array(py, PyList::new(py, array.as_string::<i32>().iter())?)?,
        })
    }

    /// A cell as a text.
    fn cell(array: &ArrayRef, row: usize) -> String {
        if array.is_null(row) {
            return String::new();
        }
        match array.data_type() {
            DataType::Float64 => array.as_primitive::<Float64Type>().value(row).to_string(),
            DataType::Int64 => array.as_primitive::<Int64Type>().value(row).to_string(),
            DataType::Boolean => array.as_boolean().value(row).to_string(),
            _ => array.as_string::<i32>().value(row).to_owned(),
        }
    }
}

#[pymethods]
impl Table {
    /// The names of the columns, which end in their units.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.batch.schema().fields().iter().map(|field| field.name().clone()).collect()
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    /// A column as a numpy array: numbers with NaN where one is missing, texts as objects.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let Ok(name) = name.extract::<String>() else {
            return Err(no_such_key(
                py,
                format!("column = {}; it must be the name of a column, see table.columns", repr(name)),
            ));
        };
        self.numpy_column(py, &name)
    }

    /// All columns.
    fn to_numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for name in self.columns() {
            dict.set_item(&name, self.numpy_column(py, &name)?)?;
        }
        Ok(dict)
    }

    /// Unit and description of the columns that have them.
    #[getter]
    fn metadata(&self) -> BTreeMap<String, BTreeMap<String, String>> {
        let schema = self.batch.schema();
        let about = |field: &Arc<Field>| {
            (field.name().clone(), field.metadata().iter().map(|(k, v)| (k.clone(), v.clone())).collect())
        };
        schema.fields().iter().filter(|field| !field.metadata().is_empty()).map(about).collect()
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // the protocol lets a producer ignore the request
        let _ = requested_schema;
        let batches = RecordBatchIterator::new([Ok(self.batch.clone())], self.batch.schema());
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), c"arrow_array_stream")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let this = slf.get();
        let kinds: Vec<String> =
            this.batch.schema().fields().iter().map(|f| f.data_type().to_string()).collect();
        let about = this.metadata();
        let cells: Vec<Vec<Option<String>>> = this
            .batch
            .columns()
            .iter()
            .map(|array| {
                (0..array.len()).map(|row| (!array.is_null(row)).then(|| Self::cell(array, row))).collect()
            })
            .collect();
        let parts = (this.columns(), kinds, cells, about);
        Ok((slf.get_type().getattr("_rebuild")?, parts.into_pyobject(slf.py())?.into_any()))
    }

    #[staticmethod]
    fn _rebuild(
        names: Vec<String>,
        kinds: Vec<String>,
        cells: Vec<Vec<Option<String>>>,
        about: HashMap<String, HashMap<String, String>>,
    ) -> PyResult<Self> {
        if names.len() != kinds.len() || names.len() != cells.len() {
            return Err(Error::new_err("a damaged table: names, kinds and columns differ in number"));
        }
        let columns = names.into_iter().zip(kinds).zip(cells).map(|((name, kind), cells)| {
            let mut column = Column::of(match kind.as_str() {
                "Float64" => QuantityKind::Number(""),
                "Int64" => QuantityKind::Count,
                "Boolean" => QuantityKind::Flag,
                _ => QuantityKind::Text,
            });
            for cell in cells {
                match (kind.as_str(), cell) {
                    ("Float64" | "Int64" | "Boolean", cell) => {
                        column.add_text(cell.as_deref().unwrap_or_default())
                    }
                    (_, cell) => column.add(&cell.into()),
                }
            }
            let about = about.get(&name).cloned().unwrap_or_default();
            (name, column, about)
        });
        Ok(Self::new(columns.collect()))
    }

    /// The rows of tables with the same columns, one after the other.
    #[staticmethod]
    fn concatenate(tables: &Bound<'_, PyAny>) -> PyResult<Self> {
        let given: Vec<Bound<'_, PyAny>> =
            tables.extract().map_err(|_| refused::<Error>("tables", tables, "a list of cocarry.Table"))?;
        let tables = given.iter().enumerate().map(|(i, one)| {
            let table = one.cast::<Self>().map(|table| table.get());
            table.map_err(|_| refused::<Error>(&format!("tables[{i}]"), one, "a cocarry.Table"))
        });
        let tables = tables.collect::<PyResult<Vec<&Self>>>()?;
        let Some(first) = tables.first() else {
            return Err(Error::new_err("there are no tables to concatenate"));
        };
        let schema = first.batch.schema();
        if let Some(other) = tables.iter().find(|table| table.batch.schema() != schema) {
            return Err(Error::new_err(format!(
                "the tables have different columns: {:?} and {:?}",
                first.columns(),
                other.columns()
            )));
        }
        let batch = concat_batches(&schema, tables.iter().map(|table| &table.batch));
        Ok(Self { batch: batch.map_err(|error| raise::<Error>(&error))? })
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().batch == self.batch)
    }

    fn __repr__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        shown(slf, "text")
    }

    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        shown(slf, "rows")
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        shown(slf, "page")
    }
}

/// How a line (`text`), terminals (`rows`) and notebooks (`page`) show a table: the Python part knows it.
fn shown<'py>(table: &Bound<'py, Table>, how: &str) -> PyResult<Bound<'py, PyAny>> {
    table.py().import("cocarry._display")?.call_method1(how, (table,))
}

fn object_array<'py>(py: Python<'py>, values: Bound<'py, PyList>) -> PyResult<Bound<'py, PyAny>> {
    let keywords = PyDict::new(py);
    keywords.set_item("dtype", "object")?;
    py.import("numpy")?.call_method("array", (values,), Some(&keywords))
}

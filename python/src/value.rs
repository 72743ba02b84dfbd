//! Values of the library's quantities as Python objects.

use cocarry::quantities::{Fields, Quantity, Record, Value};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use serde_json::Value as Json;

/// A value as a Python object; missing values are None.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    let dict = |fields: &Fields| dictionary(py, fields.iter().map(|(key, value)| (*key, value)));
    match value {
        Value::Missing => Ok(py.None().into_bound(py)),
        Value::Flag(flag) => flag.into_bound_py_any(py),
        Value::Count(count) => count.into_bound_py_any(py),
        Value::Number(number) => number.into_bound_py_any(py),
        Value::Text(text) => text.into_bound_py_any(py),
        Value::Numbers(numbers) => {
            let numbers = numbers.iter().map(|number| to_python(py, &(*number).into()));
            PyList::new(py, numbers.collect::<PyResult<Vec<_>>>()?)?.into_bound_py_any(py)
        }
        Value::Record(fields) => dict(fields)?.into_bound_py_any(py),
        Value::List(records) => {
            PyList::new(py, records.iter().map(dict).collect::<PyResult<Vec<_>>>()?)?.into_bound_py_any(py)
        }
    }
}

/// A value of a recording's JSON as a Python object.
pub fn json_to_python<'py>(py: Python<'py>, value: &Json) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Json::Array(items) => {
            let items = items.iter().map(|item| json_to_python(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_bound_py_any(py)
        }
        Json::Object(fields) => {
            let dict = PyDict::new(py);
            for (key, value) in fields {
                dict.set_item(key, json_to_python(py, value)?)?;
            }
            dict.into_bound_py_any(py)
        }
        scalar => to_python(py, &of_json(scalar)),
    }
}

/// A value of a recording's JSON that is not a list or an object; those become their text.
pub fn of_json(value: &Json) -> Value {
    match value {
        Json::Null => Value::Missing,
        Json::Bool(flag) => Value::Flag(*flag),
        Json::Number(number) => number.as_i64().map_or_else(|| number.as_f64().into(), Value::Count),
        Json::String(text) => Value::Text(text.clone()),
        Json::Array(_) | Json::Object(_) => Value::Text(value.to_string()),
    }
}

/// A record as a dictionary, in the order of its table.
pub fn record<'py>(py: Python<'py>, record: &Record) -> PyResult<Bound<'py, PyDict>> {
    dictionary(py, record.iter().map(|(key, value)| (*key, value)))
}

fn dictionary<'py, 'v>(
    py: Python<'py>,
    values: impl Iterator<Item = (&'static str, &'v Value)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in values {
        dict.set_item(key, to_python(py, value)?)?;
    }
    Ok(dict)
}

/// Dictionaries of records of one table: copies of one without values, which are filled.
pub struct Dictionaries {
    blank: Py<PyDict>,
    keys: Vec<Py<PyString>>,
}

impl Dictionaries {
    /// Of records of these quantities.
    pub fn new(py: Python<'_>, quantities: &[Quantity]) -> PyResult<Self> {
        let keys: Vec<_> = quantities.iter().map(|quantity| PyString::new(py, quantity.key)).collect();
        let blank = PyDict::new(py);
        keys.iter().try_for_each(|key| blank.set_item(key, py.None()))?;
        Ok(Self { blank: blank.unbind(), keys: keys.into_iter().map(Bound::unbind).collect() })
    }

    /// What [`record`] gives.
    pub fn record<'py>(&self, py: Python<'py>, record: &Record) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.blank.bind(py).copy()?;
        for (key, (_, value)) in self.keys.iter().zip(record) {
            if !matches!(value, Value::Missing) {
                dict.set_item(key, to_python(py, value)?)?;
            }
        }
        Ok(dict)
    }
}

/// An object as Python shows it, at most 120 characters, for errors.
pub fn repr(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "?".to_owned(), |text| text.to_string());
    match text.char_indices().nth(120) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

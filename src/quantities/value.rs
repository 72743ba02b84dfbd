//! The value of a quantity, before it becomes a cell of a table, JSON, a column or a Python object.

use serde::Serialize;
use std::collections::BTreeMap;

/// The values of a nested record by their keys, in the order of the keys.
pub type Fields = BTreeMap<&'static str, Value>;

/// The value of a quantity, of the kind that the quantity declares. Serialized, it is the plain number, text,
/// flag, list or map; null if it is missing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// No value: the quantity does not apply, or the number is not finite.
    #[default]
    Missing,
    /// A finite number, in the quantity's unit.
    Number(f64),
    /// A whole number.
    Count(i64),
    /// A word or a sentence.
    Text(String),
    /// True or false.
    Flag(bool),
    /// Numbers in a fixed order. Those that are not finite are null in JSON.
    Numbers(Vec<f64>),
    /// A record.
    Record(Fields),
    /// Records of one kind.
    List(Vec<Fields>),
}

impl Value {
    /// The number, also of a count; `None` for other values.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Count(count) => Some(*count as f64),
            _ => None,
        }
    }

    /// The text; `None` for other values.
    pub fn as_str(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// The text of a table's cell. It is empty for a missing value, and for lists and records, whose values
    /// have cells of their own.
    pub fn cell(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Count(count) => count.to_string(),
            Self::Text(text) => text.clone(),
            Self::Flag(flag) => flag.to_string(),
            Self::Missing | Self::Numbers(_) | Self::Record(_) | Self::List(_) => String::new(),
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Missing }
    }
}

impl From<i64> for Value {
    fn from(count: i64) -> Self {
        Self::Count(count)
    }
}

impl From<u64> for Value {
    fn from(count: u64) -> Self {
        Self::Count(i64::try_from(count).expect("no simulation counts to 2^63"))
    }
}

impl From<u32> for Value {
    fn from(count: u32) -> Self {
        Self::Count(i64::from(count))
    }
}

impl From<usize> for Value {
    fn from(count: usize) -> Self {
        Self::from(count as u64)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<bool> for Value {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<Vec<f64>> for Value {
    fn from(numbers: Vec<f64>) -> Self {
        Self::Numbers(numbers)
    }
}

impl From<Fields> for Value {
    fn from(fields: Fields) -> Self {
        Self::Record(fields)
    }
}

impl From<Vec<Fields>> for Value {
    fn from(records: Vec<Fields>) -> Self {
        Self::List(records)
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

//! The typed value of a quantity, and records of values.

use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fmt;

/// The value of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// No value: the quantity does not apply, or is not finite.
    Missing,
    /// A finite real number.
    Number(f64),
    /// A whole number.
    Count(i64),
    /// A word or a sentence.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A record.
    Record(Record),
    /// A list of records.
    List(Vec<Record>),
}

impl Value {
    /// The number; `None` for what is not one.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Count(count) => Some(*count as f64),
            _ => None,
        }
    }

    /// The word or sentence; `None` for what is not one.
    pub fn as_text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// Whether there is no value.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Missing)
    }
}

impl fmt::Display for Value {
    /// As a table cell: empty if it is missing, numbers exact to the last bit.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Missing => Ok(()),
            Self::Number(number) => number.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Text(text) => text.fmt(f),
            Self::Flag(flag) => flag.fmt(f),
            Self::Numbers(_) | Self::Record(_) | Self::List(_) => write!(f, "{self:?}"),
        }
    }
}

impl Serialize for Value {
    /// As in JSON: what is missing is null.
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Missing => to.serialize_none(),
            Self::Number(number) => to.serialize_f64(*number),
            Self::Count(count) => to.serialize_i64(*count),
            Self::Text(text) => to.serialize_str(text),
            Self::Flag(flag) => to.serialize_bool(*flag),
            Self::Numbers(numbers) => numbers.serialize(to),
            Self::Record(record) => record.serialize(to),
            Self::List(records) => records.serialize(to),
        }
    }
}

/// Conversions into a kind of value.
macro_rules! from {
    ($($kind:ident: $($of:ty),+;)*) => {
        $($(impl From<$of> for Value {
            fn from(value: $of) -> Self {
                Self::$kind(value.into())
            }
        })+)*
    };
}

from! {
    Count: i64, u32;
    Text: &str, String;
    Flag: bool;
    Numbers: Vec<f64>;
    Record: Record;
    List: Vec<Record>;
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Missing }
    }
}

impl From<u64> for Value {
    fn from(count: u64) -> Self {
        Self::Count(count.try_into().expect("nothing is counted beyond 2^63"))
    }
}

impl From<usize> for Value {
    fn from(count: usize) -> Self {
        (count as u64).into()
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// Values by their keys, in the order of their tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record(Vec<(&'static str, Value)>);

impl Record {
    /// Keys and values, in the order of their tables.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&'static str, &Value)> {
        self.0.iter().map(|(key, value)| (*key, value))
    }

    /// Keys and values, ordered by key, as in JSON.
    pub fn by_key(&self) -> Vec<(&'static str, &Value)> {
        let mut pairs: Vec<_> = self.iter().collect();
        pairs.sort_by_key(|(key, _)| *key);
        pairs
    }

    /// The value under a key; [`Value::Missing`] if the record does not have it.
    pub fn get(&self, key: &str) -> &Value {
        self.iter().find(|(other, _)| *other == key).map_or(&Value::Missing, |(_, value)| value)
    }

    /// The values, in the order of their tables.
    pub fn into_values(self) -> impl Iterator<Item = Value> {
        self.0.into_iter().map(|(_, value)| value)
    }

    /// How many values there are, missing ones included.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<(&'static str, Value)> for Record {
    fn from_iter<I: IntoIterator<Item = (&'static str, Value)>>(pairs: I) -> Self {
        Self(pairs.into_iter().collect())
    }
}

impl IntoIterator for Record {
    type Item = (&'static str, Value);
    type IntoIter = std::vec::IntoIter<Self::Item>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl Serialize for Record {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.len()))?;
        for (key, value) in self.iter() {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

//! The vocabulary: every figure of a control period and of an episode, declared once.
//!
//! A [`Quantity`] has a key (with its unit), a kind, a meaning and a getter. Tables of ticks, JSON, the channels of recordings with their
//! schemas, columns of studies and figures of baselines all derive from the lists here, so that one figure has one name everywhere.

mod episode;
mod tick;

pub use episode::{EPISODE, EpisodeView};
pub use tick::{CONTROL, COORDINATION, COST, INTERACTION, OPTION, OptionView, TickView};

use serde_json::{Map, Value, json};

/// A figure: its public name, what it is, and how it is read from what it is a figure of.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<Getter> {
    /// Public name, with its unit: `length_m`.
    pub key: &'static str,
    /// What kind of value it has.
    pub kind: Kind,
    /// What it is, in words: symbol, meaning, unit, and when it is missing.
    pub about: &'static str,
    /// Reads it.
    pub get: Getter,
}

/// What kind of value a quantity has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A real number.
    Number,
    /// A whole number.
    Count,
    /// A word.
    Text,
    /// Yes or no.
    Flag,
}

/// The value of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Datum {
    /// A finite real number.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// A word.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// There is none.
    Missing,
}

impl Datum {
    /// As JSON; null where there is none.
    pub fn json(&self) -> Value {
        match self {
            Self::Number(number) => json!(number),
            Self::Count(count) => json!(count),
            Self::Text(text) => json!(text),
            Self::Flag(flag) => json!(flag),
            Self::Missing => Value::Null,
        }
    }

    /// Whether there is none.
    pub fn is_missing(&self) -> bool {
        *self == Self::Missing
    }
}

impl std::fmt::Display for Datum {
    /// As in a CSV table: flags as 0 or 1, nothing where there is none.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Text(text) => f.write_str(text),
            Self::Flag(flag) => u8::from(*flag).fmt(f),
            Self::Missing => Ok(()),
        }
    }
}

impl From<f64> for Datum {
    /// Missing where it is not finite.
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Number(number) } else { Self::Missing }
    }
}

impl From<u64> for Datum {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Datum {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Datum {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<bool> for Datum {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<&str> for Datum {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Datum {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Self>> From<Option<T>> for Datum {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// The JSON Schema of an object with these quantities, all of them optional but those that are never missing are present.
pub fn json_schema<Getter>(quantities: &[Quantity<Getter>]) -> Map<String, Value> {
    let property = |quantity: &Quantity<Getter>| {
        let kind = match quantity.kind {
            Kind::Number => "number",
            Kind::Count => "integer",
            Kind::Text => "string",
            Kind::Flag => "boolean",
        };
        (quantity.key.to_owned(), json!({ "type": kind, "description": quantity.about }))
    };
    let properties: Map<String, Value> = quantities.iter().map(property).collect();
    Map::from_iter([("type".to_owned(), json!("object")), ("properties".to_owned(), Value::Object(properties))])
}

/// A list of quantities: key, kind, meaning and getter of each.
macro_rules! quantities {
    ($getter:ty; $($key:literal $kind:ident $about:literal |$view:ident| $get:expr;)*) => {
        &[$($crate::quantities::Quantity {
            key: $key,
            kind: $crate::quantities::Kind::$kind,
            about: $about,
            get: { let get: $getter = |$view| $crate::quantities::Datum::from($get); get },
        }),*]
    };
}
use quantities;

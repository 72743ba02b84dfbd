//! For "did you mean": the names that a file format allows at the place where a TOML file has an unknown one.

use crate::suggestion;
use serde::de::value::{MapAccessDeserializer, MapDeserializer, SeqDeserializer};
use serde::de::{self, DeserializeOwned, Deserializer, IntoDeserializer, Visitor};
use serde_spanned::de::{SpannedDeserializer, is_spanned};
use std::fmt;
use toml::Value;

/// [`suggestion::hint`] for a TOML text that is not a `T`; empty unless the first fault is an unknown name.
pub(crate) fn hint<T: DeserializeOwned>(text: &str) -> String {
    let Ok(table) = text.parse::<toml::Table>() else { return String::new() };
    match T::deserialize(Entry(Value::Table(table))) {
        Err(Fault::Unknown { name, known }) => suggestion::hint(&name, known.iter().copied()),
        Err(Fault::Other) | Ok(_) => String::new(),
    }
}

/// The first fault of a file. A parser of TOML has the known names in its sentence only.
#[derive(Debug)]
enum Fault {
    /// A key or a word that is not one of those known.
    Unknown { name: String, known: &'static [&'static str] },
    /// Any other fault.
    Other,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("not of the format")
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self::Other
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::Unknown { name: name.to_owned(), known }
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::Unknown { name: name.to_owned(), known }
    }
}

/// A value of a file, to be read as the format has it.
struct Entry(Value);

impl<'de> IntoDeserializer<'de, Fault> for Entry {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Entry {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(flag) => visitor.visit_bool(flag),
            Value::Datetime(_) => Err(Fault::Other),
            Value::Array(items) => visitor.visit_seq(SeqDeserializer::new(items.into_iter().map(Entry))),
            Value::Table(table) => visitor.visit_map(entries(table)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match is_spanned(name) {
            // where it is does not matter here
            true => visitor.visit_map(SpannedDeserializer::new(self, 0..0)),
            false => self.deserialize_any(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.0 {
            Value::String(text) => text.into_deserializer().deserialize_enum(name, variants, visitor),
            Value::Table(table) => visitor.visit_enum(MapAccessDeserializer::new(entries(table))),
            _ => Err(Fault::Other),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

/// The entries of a table, in the order in which a parser of TOML visits them.
fn entries<'de>(table: toml::Table) -> MapDeserializer<'de, impl Iterator<Item = (String, Entry)>, Fault> {
    MapDeserializer::new(table.into_iter().map(|(key, value)| (key, Entry(value))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use toml::Spanned;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        #[serde(rename = "part")]
        _parts: Vec<Spanned<Part>>,
        #[serde(rename = "width_m")]
        _width: Option<Spanned<f64>>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Part {
        #[serde(rename = "shape")]
        _shape: Shape,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Shape {
        Box,
        Cylinder,
    }

    #[test]
    fn hints_are_of_the_names_known_at_the_first_fault() {
        for (text, expected) in [
            ("widht_m = 1.0", "; did you mean `width_m`?"),
            ("[[part]]\nshpae = \"box\"", "; did you mean `shape`?"),
            ("[[part]]\nshape = \"cilinder\"", "; did you mean `cylinder`?"),
            ("[[part]]\nshape = \"box\"\n[other]", ""),
            ("part = []\nwidth_m = \"wide\"", ""),
            ("part = 3\nwidht_m = 1", ""),
            ("[[part]]\nshape = \"box\"", ""),
            ("not TOML", ""),
        ] {
            assert_eq!(hint::<File>(text), expected, "{text}");
        }
        let _ = (Shape::Box, Shape::Cylinder);
    }
}

//! The values of a study file, each with the line on which it stands.

use super::SweepError;
use cocarry::error::Place;
use cocarry::located;
use cocarry::scenario::PERIOD;
use cocarry::suggestion::Expected;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The largest number of values of a key.
const MAX_VALUES: usize = 10_000;
/// The largest number of tables of a kind.
const MAX_TABLES: usize = 1000;

/// A value as written.
pub(super) type Value<'a> = Spanned<DeValue<'a>>;

/// A file's name and text, which give the places in it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub file: &'a str,
    pub text: &'a str,
}

impl<'a> Source<'a> {
    fn located(self) -> located::Source<'a> {
        located::Source { file: self.file, text: self.text }
    }

    pub fn parse(self) -> Result<Spanned<DeTable<'a>>, SweepError> {
        Ok(self.located().table("study file")?)
    }

    pub fn place(self, span: Range<usize>, item: impl Into<String>) -> Place {
        self.located().place_at(span, item)
    }

    /// The error about a value.
    pub fn wrong(self, key: &str, value: &Value, expected: impl Into<Expected>) -> SweepError {
        let place = self.place(value.span(), key);
        SweepError::value(place, self.written(value), expected.into())
    }

    /// A value as written in the file, shortened if it is long.
    pub fn written(self, value: &Value) -> String {
        let text = self.text.get(value.span()).unwrap_or_default().trim();
        match text.char_indices().nth(60) {
            None => text.to_owned(),
            Some((end, _)) => format!("{}…", &text[..end]),
        }
    }

    /// An error for the first key that is not in `known`.
    pub fn only(self, table: &DeTable, known: &[&str]) -> Result<(), SweepError> {
        match table.iter().find(|(key, _)| !known.contains(&key.get_ref().as_ref())) {
            None => Ok(()),
            Some((key, value)) if *key.get_ref() == PERIOD[0] => Err(self.wrong(PERIOD[0], value, PERIOD[2])),
            Some((key, _)) => {
                let place = self.place(key.span(), key.get_ref().as_ref());
                let known = known.iter().map(|key| (*key).to_owned()).collect();
                Err(SweepError::unknown_key(place, known))
            }
        }
    }

    /// The values of a key, a single one or a list; `None` without the key. `read` returns `None` for a value
    /// that is not allowed; the error then has `expected`.
    pub fn list<T: PartialEq>(
        self,
        table: &DeTable,
        key: &str,
        expected: &Expected,
        read: impl Fn(&DeValue) -> Option<T>,
    ) -> Result<Option<Vec<(T, Place)>>, SweepError> {
        let Some(value) = get(table, key) else { return Ok(None) };
        let one = std::slice::from_ref(value);
        let values = value.get_ref().as_array().map_or(one, |array| &array[..]);
        if values.is_empty() || values.len() > MAX_VALUES {
            let most =
                format!("{expected}, or a list of them that is not empty and has at most {MAX_VALUES}");
            return Err(self.wrong(key, value, most));
        }
        let mut read_values: Vec<(T, Place)> = Vec::with_capacity(values.len());
        for value in values {
            let Some(read) = read(value.get_ref()) else {
                return Err(self.wrong(key, value, expected.clone()));
            };
            let place = self.place(value.span(), key);
            if read_values.iter().any(|(other, _)| *other == read) {
                return Err(SweepError::duplicate(place, self.written(value)));
            }
            read_values.push((read, place));
        }
        Ok(Some(read_values))
    }

    /// The tables of an array of tables; none without the key.
    pub fn tables<'t>(
        self,
        table: &'t DeTable<'a>,
        key: &str,
    ) -> Result<Vec<(&'t DeTable<'a>, Place)>, SweepError> {
        let Some(value) = get(table, key) else { return Ok(Vec::new()) };
        let wrong = |value| self.wrong(key, value, format!("one or more tables [[{key}]]"));
        let Some(array) = value.get_ref().as_array() else { return Err(wrong(value)) };
        if array.len() > MAX_TABLES {
            return Err(self.wrong(key, value, format!("at most {MAX_TABLES} tables [[{key}]]")));
        }
        let one = |value: &'t Value<'a>| match value.get_ref().as_table() {
            Some(table) => Ok((table, self.place(value.span(), format!("[[{key}]]")))),
            None => Err(wrong(value)),
        };
        array.iter().map(one).collect()
    }

    /// The text of a required key.
    pub fn text(
        self,
        table: &DeTable,
        key: &'static str,
        expected: &'static str,
        place: &Place,
    ) -> Result<String, SweepError> {
        let missing = || SweepError::missing(place.clone(), key, expected.to_owned());
        let value = get(table, key).ok_or_else(missing)?;
        let text = value.get_ref().as_str().filter(|text| !text.is_empty());
        Ok(text.ok_or_else(|| self.wrong(key, value, expected))?.to_owned())
    }
}

pub(super) fn get<'t, 'a>(table: &'t DeTable<'a>, key: &str) -> Option<&'t Value<'a>> {
    table.iter().find(|(name, _)| name.get_ref().as_ref() == key).map(|(_, value)| value)
}

pub(super) fn whole(value: &DeValue) -> Option<u64> {
    let integer = value.as_integer()?;
    u64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

pub(super) fn number(value: &DeValue) -> Option<f64> {
    match value.as_float() {
        Some(float) => float.as_str().parse().ok(),
        None => {
            let integer = value.as_integer()?;
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|v| v as f64)
        }
    }
}

pub(super) fn text(value: &DeValue) -> Option<String> {
    value.as_str().filter(|text| !text.is_empty()).map(str::to_owned)
}

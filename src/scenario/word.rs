//! The words for the values of a setting.

/// A word for a value, and its meaning.
pub type Word = (&'static str, &'static str);

//! The error of an input that is refused: its place, a sentence that says what is wrong and what would be
//! right, and a kind where a caller acts on it.

use crate::suggestion;
use std::error::Error as StdError;
use std::fmt;
use std::iter::successors;

/// A place in a file, or in another input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The name of the file, as given by the caller.
    pub file: String,
    /// The line, counted from 1; `None` where it is unknown, as in a URDF.
    pub line: Option<usize>,
    /// The item, such as ``obstacle `pillar` ``; empty for the whole line or file.
    pub item: String,
}

impl Place {
    /// An item of a file, on a line that is not known.
    pub fn item(file: impl Into<String>, item: impl Into<String>) -> Self {
        Self { file: file.into(), line: None, item: item.into() }
    }

    /// An item on a line of a file; the whole line, if it is empty.
    pub fn line(file: impl Into<String>, line: u64, item: impl Into<String>) -> Self {
        Self { file: file.into(), line: Some(line as usize), item: item.into() }
    }

    /// A whole file.
    pub fn file(file: impl Into<String>) -> Self {
        Self::item(file, "")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if self.item.is_empty() { Ok(()) } else { write!(f, ": {}", self.item) }
    }
}

/// The kinds of errors that callers tell apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An input that is not valid.
    #[default]
    Input,
    /// A world in which no team can carry: it is not valid, its target cannot be reached, or it leaves no
    /// room for the team. A study of random worlds draws another one.
    World,
}

/// Why an input was refused.
#[derive(Debug)]
pub struct Error(Box<Refusal>);

#[derive(Debug)]
struct Refusal {
    kind: ErrorKind,
    place: Option<Place>,
    text: String,
    cause: Option<Box<dyn StdError + Send + Sync>>,
}

impl Error {
    /// An error without a place.
    pub fn new(text: impl Into<String>) -> Self {
        Self(Box::new(Refusal { kind: ErrorKind::Input, place: None, text: text.into(), cause: None }))
    }

    /// A fault at a place: `PLACE: SENTENCE`.
    pub fn at(place: Place, sentence: impl fmt::Display) -> Self {
        Self::new(format!("{place}: {sentence}")).in_place(place)
    }

    /// A fault of the value at a place, whose item is the value's key: `PLACE = SENTENCE`.
    pub fn value(place: Place, sentence: impl fmt::Display) -> Self {
        Self::new(format!("{place} = {sentence}")).in_place(place)
    }

    /// A value found at a place, and the value expected there.
    pub fn bad(place: Place, found: impl fmt::Display, expected: &str) -> Self {
        Self::at(place, format_args!("{found}; it must be {expected}"))
    }

    /// A number that is out of its range.
    pub fn number(place: Place, key: &str, value: f64, expected: &str) -> Self {
        Self::bad(place, format_args!("{key} = {value}"), expected)
    }

    /// An unknown name of something of this `kind`, such as "link". The error lists the first `most` known
    /// names.
    pub fn unknown<'n>(
        place: Place,
        kind: &str,
        name: &str,
        known: impl IntoIterator<Item = &'n str, IntoIter: Clone> + Clone,
        most: usize,
    ) -> Self {
        let (listed, hint) = (suggestion::listed(known.clone(), most), suggestion::hint(name, known));
        Self::at(place, format_args!("unknown {kind} `{name}`; expected one of: {listed}{hint}"))
    }

    /// Something that is missing at a place.
    pub fn missing(place: Place, needed: impl fmt::Display) -> Self {
        Self::at(place, format_args!("missing {needed}"))
    }

    /// A name that another item of its kind has.
    pub fn duplicate(place: Place, kind: &str) -> Self {
        Self::at(place, format_args!("duplicate name; every {kind} needs a unique name"))
    }

    /// The same with a place.
    fn in_place(mut self, place: Place) -> Self {
        self.0.place = Some(place);
        self
    }

    /// The same with its cause, such as the system's error.
    pub fn because(mut self, cause: impl Into<Box<dyn StdError + Send + Sync>>) -> Self {
        self.0.cause = Some(cause.into());
        self
    }

    /// The same as an error of this kind.
    pub fn of_kind(mut self, kind: ErrorKind) -> Self {
        self.0.kind = kind;
        self
    }

    /// Its kind.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// Its place, if that is in a file.
    pub fn place(&self) -> Option<&Place> {
        self.0.place.as_ref()
    }
}

/// An error with its causes, in one text: `ERROR: CAUSE: CAUSE`.
pub fn words(error: &dyn StdError) -> String {
    let chain = successors(Some(error), |error| (**error).source());
    chain.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0.text)
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        self.0.cause.as_ref().map(|cause| &**cause as &(dyn StdError + 'static))
    }
}

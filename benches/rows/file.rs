//! `benches/results.json`, the kept results of all benches, and how their figures are written. The test of the
//! book's table reads it with this file, too.

use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// All rows, by bench and then in the order in which the bench declares them.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Results {
    pub rows: Vec<Row>,
}

/// What was measured, and what it was compared with in the same run.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Bench target, or a script of `benches/`.
    pub bench: String,
    pub name: String,
    /// `us` for every time; a table scales it. Empty for a count or a ratio.
    pub unit: String,
    pub value: Range,
    pub against: Vec<Comparison>,
    pub measured: Measured,
}

/// The least and the most over the cases of a row, such as worlds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range(pub f64, pub f64);

#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    pub kind: Kind,
    /// The peer; empty for a budget.
    pub name: String,
    /// The limit, or what the peer takes, in the row's unit.
    pub value: Range,
    /// For a budget the row's value over the limit; for a peer the peer's value over the row's.
    pub ratio: Range,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Budget,
    Peer,
}

/// By which code, when and where.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    pub version: String,
    /// Abbreviated; a `+` behind it stands for changes that were not committed. Empty outside a clone.
    pub commit: String,
    pub date: String,
    /// Number of the processor's cores that were available.
    pub cores: usize,
}

/// Where the results are.
pub fn path(repository: &Path) -> PathBuf {
    repository.join("benches/results.json")
}

impl Results {
    /// Reads the file; without one there are no rows.
    pub fn read(repository: &Path) -> Self {
        let path = path(repository);
        match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display())),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Self::default(),
            Err(e) => panic!("{}: {e}", path.display()),
        }
    }
}

impl Range {
    /// With a unit; times in us, ms or s, whichever is shortest.
    pub fn with_unit(self, unit: &str) -> String {
        let (scale, unit) = match unit {
            "us" if self.1 >= 1e6 => (1e-6, "s"),
            "us" if self.1 >= 1e3 => (1e-3, "ms"),
            unit => (1.0, unit),
        };
        let text = Self(self.0 * scale, self.1 * scale).to_string();
        if unit.is_empty() { text } else { format!("{text} {unit}") }
    }
}

/// `1.84 to 1.98`, or one number.
impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (least, most) = (number(self.0), number(self.1));
        if least == most { write!(f, "{least}") } else { write!(f, "{least} to {most}") }
    }
}

impl Comparison {
    /// What stands in a table: the other side, and the ratio.
    pub fn described(&self, unit: &str) -> (String, String) {
        let value = self.value.with_unit(unit);
        match self.kind {
            Kind::Budget => (format!("budget of {value}"), format!("{} of it", self.ratio)),
            Kind::Peer => {
                let times = if unit == "us" { "times as long" } else { "times as much" };
                (format!("{} ({value})", self.name), format!("{} {times}", self.ratio))
            }
        }
    }
}

impl std::fmt::Display for Measured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { version, commit, date, cores } = self;
        let commit = if commit.is_empty() { "outside a clone" } else { commit };
        write!(f, "{commit} ({version}, {date}, {cores} cores)")
    }
}

/// A number of three digits, with commas between thousands.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().expect("a number");
    let size = rounded.abs();
    match size {
        0.0 => "0".to_owned(),
        1e3.. => {
            let digits = format!("{size:.0}");
            let thousands: Vec<&str> = digits
                .as_bytes()
                .rchunks(3)
                .rev()
                .map(|chunk| std::str::from_utf8(chunk).expect("digits"))
                .collect();
            format!("{}{}", if rounded < 0.0 { "-" } else { "" }, thousands.join(","))
        }
        100.0.. => format!("{rounded:.0}"),
        10.0.. => format!("{rounded:.1}"),
        1.0.. => format!("{rounded:.2}"),
        0.01.. => format!("{rounded:.3}"),
        _ => format!("{rounded:.1e}"),
    }
}

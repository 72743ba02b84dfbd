//! Warnings about a valid robot: parts that its files lack and their substitutes.

use std::fmt;

/// A warning about a robot that is valid nevertheless.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotWarning {
    text: String,
    kind: WarningKind,
    is_about_file: bool,
}

/// The subject of a [`RobotWarning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WarningKind {
    /// Anything that does not change collisions.
    Other,
    /// A collision shape that is missing.
    MissingShape,
    /// A collision shape of the base that is missing, and what the base collides as instead.
    MissingBaseShape,
}

impl RobotWarning {
    /// A warning of [`WarningKind::Other`].
    pub(super) fn new(text: String) -> Self {
        Self { text, kind: WarningKind::Other, is_about_file: false }
    }

    /// A warning of another kind.
    pub(super) fn of_kind(kind: WarningKind, text: String) -> Self {
        Self { text, kind, is_about_file: false }
    }

    /// The same, marked as a warning about a file that was searched for while the robot was loaded.
    pub(super) fn about_file(self) -> Self {
        Self { is_about_file: true, ..self }
    }

    /// Whether it is about a file that was searched for while the robot was loaded. The effect of a missing
    /// file on the robot is a separate warning.
    pub fn is_about_file(&self) -> bool {
        self.is_about_file
    }

    /// Its subject.
    pub fn kind(&self) -> WarningKind {
        self.kind
    }

    /// Whether collisions differ from those of the real robot's shapes because a shape is missing.
    pub fn is_about_missing_shapes(&self) -> bool {
        self.kind != WarningKind::Other
    }
}

impl fmt::Display for RobotWarning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The first few names of a list, each quoted.
pub(super) fn some_of(names: &[&str]) -> String {
    first_few(&names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>())
}

/// The first few items of a list.
pub(super) fn first_few(items: &[String]) -> String {
    const MAX_ITEMS: usize = 6;
    let first = items[..items.len().min(MAX_ITEMS)].join(", ");
    match items.len().saturating_sub(MAX_ITEMS) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

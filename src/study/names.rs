//! The words that study files and results use for what a program calls by a type.

use crate::control::{Avoid, CandidateSet, PoseCriterion};
use crate::policy::Method;

/// What the controller acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plants {
    Point,
    Kinematic,
    Rapier,
}

/// A word for every value.
pub(super) type Names<T> = [(&'static str, T)];

pub(super) const PLANTS: &Names<Plants> =
    &[("point", Plants::Point), ("kinematic", Plants::Kinematic), ("rapier", Plants::Rapier)];
pub(super) const METHODS: &Names<Method> = &[
    ("mutual", Method::MUTUAL),
    ("without-model", Method::WITHOUT_MODEL),
    ("human-led", Method::HUMAN_LED),
    ("robot-led", Method::ROBOT_LED),
];
pub(super) const POSES: &Names<CandidateSet> =
    &[("none", CandidateSet::None), ("arm", CandidateSet::Arm), ("whole-body", CandidateSet::WholeBody)];
pub(super) const CRITERIA: &Names<PoseCriterion> = &[
    ("expected", PoseCriterion::Expected),
    ("uniform", PoseCriterion::Uniform),
    ("tracked", PoseCriterion::Tracked),
    ("manipulability", PoseCriterion::Manipulability),
];
pub(super) const AVOID: &Names<Avoid> =
    &[("nothing", Avoid::Nothing), ("base", Avoid::Base), ("robot", Avoid::Robot)];
pub(super) const BOOLEANS: &Names<bool> = &[("true", true), ("false", false)];

/// The value of a word.
pub(super) fn value<T: Copy>(names: &Names<T>, word: &str) -> Option<T> {
    names.iter().find(|(name, _)| *name == word).map(|(_, value)| *value)
}

/// The word for a value.
pub(super) fn name<T: PartialEq>(names: &Names<T>, value: T) -> &'static str {
    names.iter().find(|(_, other)| *other == value).map_or("", |(name, _)| name)
}

/// All words, for errors.
pub(super) fn words<T>(names: &Names<T>) -> String {
    let words: Vec<_> = names.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    format!("one of {}", words.join(", "))
}

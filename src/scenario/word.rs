//! The words for the values of a setting.

use crate::control::{Avoid, CandidateSet, PoseCriterion};
use crate::suggestion::Expected;

/// A word for a value, and its meaning.
pub type Word = (&'static str, &'static str);

/// A word for every value of an enum, with its meaning.
pub(super) type Words<T> = [(T, &'static str, &'static str)];

pub(super) const POSES: &Words<CandidateSet> = &[
    (CandidateSet::None, "none", "No pose optimisation"),
    (CandidateSet::Arm, "arm", "Fifteen configurations of the arm"),
    (CandidateSet::WholeBody, "whole-body", "Fifteen configurations of base and arm"),
];
pub(super) const CRITERIA: &Words<PoseCriterion> = &[
    (PoseCriterion::Expected, "expected", "Eq. (8): costs of all options, weighted by P_o"),
    (PoseCriterion::Uniform, "uniform", "Costs of all options, equally weighted"),
    (PoseCriterion::Tracked, "tracked", "The cost of the option that the robot expects the human to walk"),
    (
        PoseCriterion::Manipulability,
        "manipulability",
        "Yoshikawa's manipulability of the arm instead of costs",
    ),
];
pub(super) const BELIEFS: &Words<bool> = &[
    (false, "prior", "It stays the prior, and eta is known, as in the paper"),
    (true, "learn", "It learns alpha, gamma and eta from what the human does"),
];
pub(super) const AVOIDED: &Words<Avoid> = &[
    (Avoid::Nothing, "nothing", "Nothing, as in the paper"),
    (Avoid::Base, "base", "The base"),
    (Avoid::Robot, "robot", "Base and arm"),
];

/// The words, with their meanings.
pub(super) fn words<T>(all: &Words<T>) -> Vec<Word> {
    all.iter().map(|(_, word, about)| (*word, *about)).collect()
}

/// The word for a value.
pub(super) fn word<T: PartialEq>(all: &Words<T>, value: T) -> Option<String> {
    all.iter().find(|(other, ..)| *other == value).map(|(_, word, _)| (*word).to_owned())
}

/// Puts the value of a word in its place; a word without a value changes nothing.
pub(super) fn put<T: Copy>(place: &mut T, all: &Words<T>, word: &str) {
    let found = all.iter().find(|(_, other, _)| *other == word);
    *place = found.map_or(*place, |(value, ..)| *value);
}

/// One of the words, for errors.
pub fn one_of(words: &[Word]) -> Expected {
    Expected::one_of(words.iter().map(|(word, _)| *word))
}

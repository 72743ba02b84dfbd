//! Runs of a study: combinations and seeds.

use super::cell::Cell;

/// The seeds of a run, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seeds {
    pub first: u64,
    pub last: u64,
}

/// Combinations with their seeds. Each combination is run with all seeds.
#[derive(Debug)]
pub(super) struct Run {
    pub cells: Vec<Cell>,
    pub seeds: Seeds,
}

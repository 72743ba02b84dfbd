//! The numbers of the roadmap's sites: the start, the target, then both straight parts of every lane of every
//! passage.

use super::passage::{Crossing, Passage};

/// The start.
pub(super) const START: usize = 0;

/// The target.
pub(super) const TARGET: usize = 1;

/// The largest number of lanes of a passage.
pub(super) const MAX_LANES: usize = 3;

/// The sites of passages. The two sides of a lane differ in the last bit.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    /// The first site of every passage, and the number of all sites.
    first: Vec<usize>,
}

impl Sites {
    pub fn new(passages: &[Passage]) -> Self {
        let mut first = vec![TARGET + 1];
        first.extend(passages.iter().scan(TARGET + 1, |next, passage| {
            *next += 2 * passage.lanes();
            Some(*next)
        }));
        Self { first }
    }

    /// Their number.
    pub fn count(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    /// The number of lanes of an opening.
    pub fn lanes(&self, opening: usize) -> usize {
        (self.first[opening + 1] - self.first[opening]) / 2
    }

    /// All sites of an opening.
    pub fn of(&self, opening: usize) -> std::ops::Range<usize> {
        self.first[opening]..self.first[opening + 1]
    }

    /// The sites at which paths to a crossing end, lane by lane.
    pub fn all_before(&self, crossing: Crossing) -> Vec<usize> {
        (0..self.lanes(crossing.opening)).map(|lane| self.before(crossing, lane)).collect()
    }

    /// The opening of a site that is neither the start nor the target.
    pub fn opening(&self, site: usize) -> usize {
        self.first.partition_point(|first| *first <= site) - 1
    }

    /// The site at which a path to a lane of a crossing ends.
    pub fn before(&self, crossing: Crossing, lane: usize) -> usize {
        self.beyond(crossing.back(), lane)
    }

    /// The site at which a path from a lane of a crossing begins.
    pub fn beyond(&self, crossing: Crossing, lane: usize) -> usize {
        self.first[crossing.opening] + 2 * lane + crossing.into
    }
}

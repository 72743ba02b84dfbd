//! The numbers of the roadmap's sites: the start, the target, then both straight parts of every passage.

use super::passage::Crossing;

/// The start.
pub(super) const START: usize = 0;

/// The target.
pub(super) const TARGET: usize = 1;

/// The straight part on a side of an opening.
pub(super) fn site(opening: usize, side: usize) -> usize {
    2 + 2 * opening + side
}

/// The site at which a path to a crossing ends.
pub(super) fn before(crossing: Crossing) -> usize {
    site(crossing.opening, 1 - crossing.into)
}

/// The site at which a path from a crossing begins.
pub(super) fn beyond(crossing: Crossing) -> usize {
    site(crossing.opening, crossing.into)
}

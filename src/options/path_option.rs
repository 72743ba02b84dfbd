//! A way from the start to the target, with its tabulated remainders.

use super::passage::Crossing;
use super::sites::MAX_LANES;

/// One option from the start to the target: openings in the order of travel.
#[derive(Clone, Debug)]
pub struct PathOption {
    /// Name, unique in its world.
    pub name: String,
    /// The openings in the order of travel, with the direction of each.
    pub crossings: Vec<Crossing>,
    /// The region before each crossing, and the region after the last one.
    pub(super) regions: Vec<usize>,
    /// The remainder of the option from each crossing's gap on, by lane.
    pub(super) after: Vec<Afters>,
    /// S_o over the crossings from each index on; 0 after the last.
    pub(super) risk_left: Vec<f64>,
}

/// The remainder of an option from a lane of a gap on.
#[derive(Clone, Copy, Debug)]
pub(super) struct After {
    /// Length along the axis to where the path leaves it, m.
    pub exit: f64,
    /// Length from there to the target, m; infinite where there is no path.
    pub length: f64,
    /// The lane in which the path goes through the next gap.
    pub lane: usize,
}

impl After {
    pub const NONE: Self = Self { exit: 0.0, length: f64::INFINITY, lane: 0 };
}

/// The remainder of an option from every lane of a gap on.
pub(super) type Afters = [After; MAX_LANES];

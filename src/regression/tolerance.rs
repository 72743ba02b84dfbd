//! By how much figures may move, and the format that they are recorded in.

/// By how much a number may move: `absolute + relative * |recorded|`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Part of what was recorded.
    pub relative: f64,
    /// In the unit of the figure.
    pub absolute: f64,
}

impl Default for Tolerance {
    /// 1e-6 of what was recorded: far more than the last bits in which mathematical libraries differ, far less than anything that matters.
    fn default() -> Self {
        Self { relative: 1e-6, absolute: 1e-9 }
    }
}

/// The format of figures that are recorded now. 2: with the openings walked. 3: all quantities of an episode,
/// by their keys.
pub const FORMAT: i64 = 3;

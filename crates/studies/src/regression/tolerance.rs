//! The tolerance of recorded figures, and their format.

/// The tolerance of a number: `absolute + relative * |recorded|`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the recorded number.
    pub relative: f64,
    /// In the unit of the figure.
    pub absolute: f64,
}

impl Default for Tolerance {
    /// 1e-6 of the recorded number. This is much more than the last bits in which mathematical libraries
    /// differ, and much less than any relevant change.
    fn default() -> Self {
        Self { relative: 1e-6, absolute: 1e-9 }
    }
}

/// The present format of recorded figures. Format 2 added the openings walked; format 3 has all quantities of
/// an episode, by their keys.
pub const FORMAT: i64 = 3;

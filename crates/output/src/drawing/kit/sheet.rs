//! The sheet that a picture is drawn on: its width, and how it has letters.

use super::Letters;
use crate::drawing::WIDTH;

/// The sheet of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Width of the layout, px, in which type is 16.5 px high.
    pub width: f64,
    /// Width at which the picture is shown, with its unit: `in`, or `` for px.
    pub shown: (f64, &'static str),
    /// Its letters.
    pub letters: Letters,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { width: WIDTH, shown: (WIDTH, ""), letters: Letters::Text }
    }
}

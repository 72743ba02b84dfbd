//! Pictures for a paper's column, as SVG: maps of worlds with their options, curves, regions and strips of
//! marks.
//!
//! Every function is pure: the same data give the same SVG text. Pictures are [`WIDTH`] px wide, meant to be
//! printed 88 mm wide, on a white background. Lines differ in colour and dash pattern, and areas in hatching,
//! so that pictures remain readable in grey print and with any colour vision. All pictures use one chart kit,
//! the submodule `kit`.

mod adaptation;
mod answers;
mod curves;
mod differences;
mod film;
mod heat;
mod intervals;
mod kit;
mod map;
mod map_view;
mod means;
mod moving;
mod opening_labels;
mod option_table;
mod ratios;
mod regions;
mod stimulus;
mod stubbornness;
mod tolerances;
mod track;

pub use adaptation::adaptation;
pub use answers::{AnswerPanel, AnswerRow, RiskWeightMark, answers};
pub use curves::{Curve, CurvePanel, curves};
pub use differences::{DifferencePanel, DifferenceRow, differences};
pub use film::{Film, Moment, NARROWEST, STAND_IN, WIDEST, stand_in};
pub use heat::{HeatPanel, heat_maps};
pub use intervals::{IntervalMarks, IntervalPanel, IntervalRow, intervals};
pub use kit::{Letters, Sheet, dark_rules};
pub use map::{MAX_LISTED, world_map};
pub use means::{MeanPanel, MeanRow, means};
pub use moving::Moving;
pub use ratios::{RatioPanel, RatioRow, cost_ratios};
pub use regions::{RegionPanel, preference_regions};
pub use stimulus::{Shown, Stimulus};
pub use tolerances::{ToleranceRow, tolerances};
pub use track::Track;

use crate::palette;
use cocarry::Error;
use std::fmt::Display;

/// Width of every picture, px.
pub const WIDTH: f64 = 720.0;

/// The error of a picture without content.
fn nothing() -> Error {
    Error::new("nothing to draw; expected at least one panel")
}

/// The error of a number that has no place in a picture: NaN, infinite or out of range.
fn not_drawable(what: impl Display, value: f64) -> Error {
    Error::new(format!("{what}: {value} cannot be drawn"))
}

/// The error of options without a probability each.
fn unequal(probabilities: usize, options: usize) -> Error {
    Error::new(format!("{probabilities} probabilities were given for {options} options"))
}

/// The colour of an option in every picture, as `#rrggbb`.
pub fn option_colour(option: usize) -> String {
    palette::hex(palette::option_colour(option))
}

/// The dash pattern of an option's line in every picture: lengths of dashes and gaps, px; empty is solid.
pub fn option_dash(option: usize) -> &'static [f64] {
    palette::option_dash(option)
}

/// The colour of a risk from 0 (light) to 1 (dark) in every picture, as `#rrggbb`.
pub fn risk_colour(risk: f64) -> String {
    kit::risk_colour(risk)
}

/// Checks that every option's P_o is a probability.
fn check_probabilities<'a>(options: impl Iterator<Item = (&'a str, f64)>) -> Result<(), Error> {
    // rounding may leave a sum of areas slightly above 1
    let mut spoiled = options.filter(|(_, p)| !(0.0..=1.0 + 1e-9).contains(p));
    spoiled.next().map_or(Ok(()), |(option, value)| {
        let sentence =
            format!("option `{option}`: its probability is {value}; expected a number from 0 to 1");
        Err(Error::new(sentence))
    })
}

#[cfg(test)]
mod tests {
    use cocarry::Error;

    /// The error of a picture without content.
    pub(super) const NOTHING: &str = "nothing to draw; expected at least one panel";

    /// The error of a picture that cannot be drawn.
    pub(super) fn error(drawn: Result<String, Error>) -> String {
        drawn.expect_err("it cannot be drawn").to_string()
    }

    /// A picture that is well formed, identical when drawn again, and free of NaN and infinity.
    pub(super) fn checked(draw: impl Fn() -> Result<String, Error>) -> String {
        let picture = draw().unwrap();
        assert_eq!(picture, draw().unwrap());
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
        let mut open = Vec::new();
        for tag in picture.split('<').skip(1) {
            let (tag, text) = tag.split_once('>').expect("a tag ends");
            assert!(text.split('&').skip(1).all(|t| t.contains(';')), "{text}");
            let name = |t: &str| t.split([' ', '/']).next().unwrap_or_default().to_owned();
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop().as_deref(), Some(closed));
            } else if !tag.ends_with('/') {
                open.push(name(tag));
            }
        }
        assert!(open.is_empty(), "{open:?}");
        picture
    }
}

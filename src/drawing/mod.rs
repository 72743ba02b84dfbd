//! A world, its options and what became of them, or what that cost, in; SVG pictures for a paper's column out.
//!
//! Every function is pure: data in, the text of one SVG picture out, the same text for the same data. Pictures are [`WIDTH`] px wide, meant
//! to be printed 88 mm wide. Lines differ in colour and in dash pattern, so that they survive print in grey.

mod adaptation;
mod answers;
mod axis;
mod chart;
mod curves;
mod labels;
mod legend;
mod map;
mod ratios;
mod regions;
mod scene;
mod style;
mod text;
mod tolerances;
mod track;

pub use adaptation::adaptation;
pub use answers::{AnswerPanel, AnswerRow, RiskWeightMark, answers};
pub use curves::{Curve, CurvePanel, curves};
pub use map::{MOST_LISTED, world_map};
pub use ratios::{RatioPanel, RatioRow, cost_ratios};
pub use regions::{RegionPanel, preference_regions};
pub use tolerances::{ToleranceRow, tolerances};
pub use track::Track;

use thiserror::Error;

/// Width of every picture, px.
pub const WIDTH: f64 = 720.0;

/// Why a picture could not be drawn.
#[derive(Debug, Error)]
pub enum DrawingError {
    /// There must be one probability per option.
    #[error("{probabilities} probabilities were given for {options} options")]
    ProbabilityCount {
        /// How many probabilities were given.
        probabilities: usize,
        /// How many options there are.
        options: usize,
    },
    /// A probability outside [0, 1].
    #[error("option `{option}`: its probability is {value}; expected a number from 0 to 1")]
    Probability {
        /// The option.
        option: String,
        /// What was given.
        value: f64,
    },
    /// A track has a position that is not finite or beyond all maps, or a stubbornness that is not a number.
    #[error("track `{track}`: its {quantity} at step {step} cannot be drawn: {value}")]
    NotDrawable {
        /// The track's label.
        track: String,
        /// `position` or `stubbornness`.
        quantity: &'static str,
        /// The step.
        step: usize,
        /// The number.
        value: f64,
    },
    /// A track's transition lies beyond its last step.
    #[error("track `{track}`: its transition is at step {transition}, but it has {positions} positions")]
    Transition {
        /// The track's label.
        track: String,
        /// Step of the transition.
        transition: usize,
        /// How many positions the track has.
        positions: usize,
    },
    /// The period must be a positive time.
    #[error("the period is {period} s; expected a positive number")]
    Period {
        /// What was given.
        period: f64,
    },
    /// A figure of panels needs one.
    #[error("there is nothing to draw: no panels were given")]
    NoPanels,
    /// A ratio of costs is negative, not a number or beyond all axes.
    #[error("row `{row}`: the ratio {value} in environment {environment} cannot be drawn")]
    Ratio {
        /// The row's label.
        row: String,
        /// The environment.
        environment: u32,
        /// The ratio.
        value: f64,
    },
    /// A fit, or what it was made to, is not a number or beyond all axes.
    #[error("{what}: {value} cannot be drawn")]
    Fit {
        /// What has the number.
        what: String,
        /// The number.
        value: f64,
    },
    /// The chart library refused.
    #[error("the chart could not be drawn: {reason}")]
    Chart {
        /// What it said.
        reason: String,
    },
}

#[cfg(test)]
mod tests {
    /// Panics unless every element of the picture is closed by its own tag and every `&` begins an entity.
    pub(super) fn check_well_formed(picture: &str) {
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
    }
}

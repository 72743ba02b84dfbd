//! The ranges that a study's humans are drawn from, by name.

use crate::episode::{PreferenceChange, Settings};
use crate::options::OptionSet;
use crate::preference::{Belief, Marginal, Perception};
use crate::scenario::{Redraws, drawn_changes, drawn_human};

/// Where one parameter of a human comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// Drawn.
    Drawn(Marginal),
    /// The same for all.
    Fixed(f64),
}

/// Humans of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Humans {
    pub alpha: Range,
    pub gamma: Range,
}

impl Humans {
    /// The human of a seed: the one that `cocarry run --seed` draws from these ranges as the robot's belief.
    pub fn draw(&self, seed: u64) -> Perception {
        self.fixed_or(drawn_human(&self.belief(), seed))
    }

    /// That human's changes of mind: those that `cocarry run --seed --redraws` draws likewise.
    pub fn draw_changes(
        &self,
        redraws: Redraws,
        seed: u64,
        options: &OptionSet,
        settings: &Settings,
    ) -> Vec<PreferenceChange> {
        let drawn = drawn_changes(redraws, &self.belief(), seed, self.draw(seed), options, settings);
        let fixed = |change: PreferenceChange| PreferenceChange {
            perception: self.fixed_or(change.perception),
            ..change
        };
        drawn.into_iter().map(fixed).collect()
    }

    /// Whether all of them are the same human, who has nothing to redraw.
    pub fn are_one(&self) -> bool {
        [self.alpha, self.gamma].iter().all(|range| range.marginal().is_none())
    }

    /// What humans are drawn from. A parameter that is fixed is drawn all the same, so that the other one is the same human's.
    fn belief(&self) -> Belief {
        match Belief::default() {
            Belief::Independent { alpha, gamma } => Belief::Independent {
                alpha: self.alpha.marginal().unwrap_or(alpha),
                gamma: self.gamma.marginal().unwrap_or(gamma),
            },
            other => other,
        }
    }

    fn fixed_or(&self, drawn: Perception) -> Perception {
        Perception { alpha: self.alpha.or(drawn.alpha), gamma: self.gamma.or(drawn.gamma) }
    }
}

impl Range {
    fn marginal(self) -> Option<Marginal> {
        match self {
            Self::Drawn(marginal) => Some(marginal),
            Self::Fixed(_) => None,
        }
    }

    fn or(self, drawn: f64) -> f64 {
        match self {
            Self::Drawn(_) => drawn,
            Self::Fixed(value) => value,
        }
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Drawn(marginal) => marginal.fmt(f),
            Self::Fixed(value) => value.fmt(f),
        }
    }
}

//! What humans are drawn from, by name; a human for every seed out.

use crate::preference::{Belief, Marginal, Perception};
use crate::scenario::drawn_human;

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
        let standard = Belief::default();
        let Belief::Independent { alpha, gamma } = &standard else { return drawn_human(&standard, seed) };
        // a parameter that is fixed is drawn all the same, so that the other one is the same human's
        let belief = Belief::Independent {
            alpha: self.alpha.marginal().unwrap_or(*alpha),
            gamma: self.gamma.marginal().unwrap_or(*gamma),
        };
        let drawn = drawn_human(&belief, seed);
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

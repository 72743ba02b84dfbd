//! Preference changes drawn from a seed: their steps, and the new alpha and gamma.

use super::{GivenPerception, drawn_human};
use crate::episode::{EpisodeSettings, PreferenceChange, prospects};
use crate::options::OptionSet;
use crate::preference::{Belief, Perception, human_choice};
use crate::suggestion::Expected;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The stream of a seed's generator that preference changes are drawn from. Humans and gaits use stream 0.
const STREAM: u64 = 1;

/// The number of preference changes of a human.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreferenceChanges {
    /// A fixed number, at most [`PreferenceChanges::MAX`].
    Times(u8),
    /// Once or twice: a fair coin decides, as in Table III.
    OnceOrTwice,
}

/// The error for a text that is not a number of preference changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be {}", PreferenceChanges::expected())]
pub struct ParsePreferenceChangesError;

impl PreferenceChanges {
    /// No preference changes.
    pub const NONE: Self = Self::Times(0);
    /// The largest number allowed.
    pub const MAX: u8 = 8;
    /// The word for [`PreferenceChanges::OnceOrTwice`].
    pub const ONCE_OR_TWICE: &str = "once-or-twice";

    /// A description of the allowed values, for errors.
    pub fn expected() -> Expected {
        let sentence = format!("a whole number from 0 to {}, or \"{}\"", Self::MAX, Self::ONCE_OR_TWICE);
        Expected::from(sentence).with_names([Self::ONCE_OR_TWICE])
    }

    /// Draws the changes of a human whose first perception is `first`: steps uniformly from 1 to half of the
    /// steps that the option preferred at the start takes, (alpha, gamma) from `belief`. The changes are in
    /// the order in which they are drawn, not by step.
    pub fn draw<R: Rng + ?Sized>(
        self,
        belief: &Belief,
        first: Perception,
        options: &OptionSet,
        settings: &EpisodeSettings,
        rng: &mut R,
    ) -> Vec<PreferenceChange> {
        let count = match self {
            Self::Times(times) => times,
            Self::OnceOrTwice if rng.random::<bool>() => 2,
            Self::OnceOrTwice => 1,
        };
        if count == 0 {
            return Vec::new();
        }
        let ahead = prospects(options, &options.begin());
        let preferred = human_choice(&ahead, settings.predictor.risk_weight(), first, None);
        let length = ahead.get(preferred).map_or(0.0, |option| option.length);
        let half = (length / (settings.speed * settings.planning_step) / 2.0) as u64;
        let mut change = |_| {
            let step = rng.random_range(1..=half.max(1));
            PreferenceChange { step, perception: belief.sample(rng) }
        };
        (0..count).map(&mut change).collect()
    }
}

/// The preference changes of a seed's human. Given values of alpha and gamma stay; the others are drawn. The
/// same seed, belief and world give the same changes for every method and plant.
pub fn drawn_changes(
    count: PreferenceChanges,
    belief: &Belief,
    given: GivenPerception,
    seed: u64,
    options: &OptionSet,
    settings: &EpisodeSettings,
) -> Vec<PreferenceChange> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(STREAM);
    let mut changes = count.draw(belief, drawn_human(belief, given, seed), options, settings, &mut rng);
    changes.iter_mut().for_each(|change| change.perception = given.or(change.perception));
    changes
}

impl std::str::FromStr for PreferenceChanges {
    type Err = ParsePreferenceChangesError;

    fn from_str(text: &str) -> Result<Self, ParsePreferenceChangesError> {
        match text {
            Self::ONCE_OR_TWICE => Ok(Self::OnceOrTwice),
            number => {
                let times = number.parse().ok().filter(|times| *times <= Self::MAX);
                times.map(Self::Times).ok_or(ParsePreferenceChangesError)
            }
        }
    }
}

impl std::fmt::Display for PreferenceChanges {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Times(times) => times.fmt(f),
            Self::OnceOrTwice => f.write_str(Self::ONCE_OR_TWICE),
        }
    }
}

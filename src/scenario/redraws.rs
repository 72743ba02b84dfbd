//! Preference changes drawn from a seed: when the human changes, and to which alpha and gamma.

use crate::episode::{PreferenceChange, Settings, prospects};
use crate::options::OptionSet;
use crate::preference::{Belief, Perception, human_choice};
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The stream of a seed's generator that changes are drawn from: humans, and gaits, are drawn from the first, 0.
const STREAM: u64 = 1;

/// How often a human redraws (alpha, gamma) on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redraws {
    /// So often, at most [`Redraws::MOST`].
    Times(u8),
    /// Once or twice: a fair coin decides, as in Table III.
    OnceOrTwice,
}

/// What is no number of redraws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be a whole number from 0 to {}, or once-or-twice", Redraws::MOST)]
pub struct NotRedraws;

impl Redraws {
    /// A human who keeps their mind.
    pub const NONE: Self = Self::Times(0);
    /// The most that may be asked for.
    pub const MOST: u8 = 8;
    /// The word for a fair coin.
    pub const ONCE_OR_TWICE: &str = "once-or-twice";

    /// So many, if that is not too many.
    pub fn times(times: u64) -> Option<Self> {
        u8::try_from(times).ok().filter(|times| *times <= Self::MOST).map(Self::Times)
    }

    /// Draws the changes of a human who sets out as `first`: steps uniformly from 1 to half of what the option that they prefer at the start
    /// takes, (alpha, gamma) from `belief`. In the order in which they are drawn, which need not be that of the steps.
    pub fn draw<R: Rng + ?Sized>(
        self,
        belief: &Belief,
        first: Perception,
        options: &OptionSet,
        settings: &Settings,
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
        let half = (length / (settings.speed * settings.period) / 2.0) as u64;
        let mut change = |_| {
            let step = rng.random_range(1..=half.max(1));
            PreferenceChange { step, perception: belief.sample(rng) }
        };
        (0..count).map(&mut change).collect()
    }
}

/// The changes of mind of a seed's human, who sets out as `first`: whoever asks for the same seed and the same belief in the same world meets
/// the same human, whoever leads and whatever carries.
pub fn drawn_changes(
    redraws: Redraws,
    belief: &Belief,
    seed: u64,
    first: Perception,
    options: &OptionSet,
    settings: &Settings,
) -> Vec<PreferenceChange> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(STREAM);
    redraws.draw(belief, first, options, settings, &mut rng)
}

impl std::str::FromStr for Redraws {
    type Err = NotRedraws;

    fn from_str(text: &str) -> Result<Self, NotRedraws> {
        match text {
            Self::ONCE_OR_TWICE => Ok(Self::OnceOrTwice),
            number => number.parse().ok().and_then(Self::times).ok_or(NotRedraws),
        }
    }
}

impl std::fmt::Display for Redraws {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Times(times) => times.fmt(f),
            Self::OnceOrTwice => f.write_str(Self::ONCE_OR_TWICE),
        }
    }
}

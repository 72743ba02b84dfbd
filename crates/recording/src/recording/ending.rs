//! The end of a recording.

use cocarry::episode::Outcome;

/// The end of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The episode is over.
    Over(Outcome),
    /// The user interrupted the episode.
    Interrupted,
}

impl Ending {
    /// Its name, as in `/outcome`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Over(outcome) => outcome.name(),
            Self::Interrupted => "interrupted",
        }
    }
}

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
    /// The outcome; `None` if the user interrupted the episode.
    pub fn outcome(self) -> Option<Outcome> {
        match self {
            Self::Over(outcome) => Some(outcome),
            Self::Interrupted => None,
        }
    }
}

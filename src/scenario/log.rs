//! A log of an episode in which somebody decided from outside: scenario, decisions and digests, from which it can
//! be run again.

use super::{Decisions, MAX_MOTION, Scenario};
use crate::error::{Error, Place};
use serde::{Deserialize, Serialize};

/// The largest number of steps of a log.
const MAX_STEPS: u64 = 1_000_000;
/// The longest of its words: a digest, an outcome, a stamp, bytes.
const MAX_WORD: usize = 64;

/// An episode to run again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EpisodeLog {
    /// The version of the format: [`EpisodeLog::VERSION`].
    pub version: u32,
    /// The scenario's text (TOML).
    pub scenario: String,
    /// The [stamp](crate::arithmetic::stamp) of the arithmetic that it was logged with.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub arithmetic: String,
    /// The decisions from outside.
    #[serde(default, skip_serializing_if = "Decisions::is_empty")]
    pub decisions: Decisions,
    /// [Digests](crate::episode::EpisodeState::digest) of 16 hexadecimal digits, by the number of steps after which
    /// they were taken.
    #[serde(default)]
    pub digests: Vec<(u64, String)>,
    /// The number of steps.
    pub steps: u64,
    /// The outcome's name; `None` if the episode was not over.
    #[serde(default)]
    pub outcome: Option<String>,
}

impl EpisodeLog {
    /// The version that is written and read.
    pub const VERSION: u32 = 1;

    /// Its scenario; everything else is checked, too. Errors call the log `file`.
    ///
    /// # Errors
    /// The key and the value.
    pub fn checked(&self, file: &str) -> Result<Scenario, Error> {
        let bad = |key: &str, value: u64, expected: &str| {
            Err(Error::number(Place::file(file), key, value as f64, expected))
        };
        if self.version != Self::VERSION {
            return bad("version", self.version.into(), &Self::VERSION.to_string());
        }
        if self.steps > MAX_STEPS {
            return bad("steps", self.steps, &format!("at most {MAX_STEPS}"));
        }
        let digests = self.digests.iter().map(|(_, digest)| digest);
        let mut words = digests.chain([&self.arithmetic]).chain(&self.outcome);
        if let Some(word) = words.find(|word| word.len() > MAX_WORD) {
            let begin: String = word.chars().take(20).collect();
            let sentence = format_args!(
                "a digest, the arithmetic or the outcome has {} bytes, at most {MAX_WORD} expected: {begin:?}...",
                word.len()
            );
            return Err(Error::at(Place::file(file), sentence));
        }
        if !self.decisions.is_bounded() {
            let sentence = format_args!("decisions: a motion or a target is beyond {MAX_MOTION}");
            return Err(Error::at(Place::file(file), sentence));
        }
        Scenario::parse(&self.scenario)
            .map_err(|error| Error::at(Place::item(file, "scenario"), "not valid").because(error))
    }
}

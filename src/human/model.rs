//! The human models that scenarios, studies and the command line know by name.

use super::{Human, PreferenceChange, PreferenceHuman, boltzmann, preference, scripted};
use crate::coordination;
use crate::options::OptionSet;
use crate::preference::Perception;
use std::str::FromStr;

/// All models. A new model needs its own file and a line here.
pub const MODELS: [&HumanModel; 3] = [&preference::MODEL, &boltzmann::MODEL, &scripted::MODEL];

/// A human, or the reason why the model cannot be made.
type Made = Result<Box<dyn Human>, ModelError>;

/// A model of human decisions.
#[derive(Debug)]
pub struct HumanModel {
    /// Name.
    pub name: &'static str,
    /// The name with its arguments, as in `boltzmann(RATIONALITY)`.
    pub form: &'static str,
    /// A description in one sentence.
    pub about: &'static str,
    /// Makes the human from the arguments between the parentheses.
    pub(super) make: fn(&str, &Participant<'_>) -> Made,
}

/// The data of one human, known before the episode.
#[derive(Clone, Copy, Debug)]
pub struct Participant<'a> {
    /// alpha and gamma at the start.
    pub perception: Perception,
    /// Preference changes.
    pub changes: &'a [PreferenceChange],
    /// phi(0) and eta.
    pub stubbornness: coordination::Settings,
    /// The episode's seed.
    pub seed: u64,
    /// The options of the world.
    pub options: &'a OptionSet,
}

/// The reason why a model cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// No model has this name.
    #[error("unknown human model `{name}`; expected one of: {}", forms())]
    Unknown {
        /// The name found.
        name: String,
    },
    /// The arguments do not fit the model.
    #[error("the arguments must be {expected}")]
    Arguments {
        /// The arguments that fit.
        expected: &'static str,
    },
    /// The script names an option that the world does not have.
    #[error("step {step}: unknown option `{option}`; expected one of: {known}")]
    Option {
        /// The script's step.
        step: u64,
        /// The name found.
        option: String,
        /// The world's options.
        known: String,
    },
}

/// A model with its arguments, written as `preference` or `boltzmann(2.5)`.
#[derive(Clone)]
pub struct ModelName {
    model: &'static HumanModel,
    arguments: String,
}

impl ModelName {
    /// Makes the human.
    ///
    /// # Errors
    /// [`ModelError`]: the arguments do not fit the model or the world.
    pub fn make(&self, participant: &Participant<'_>) -> Result<Box<dyn Human>, ModelError> {
        (self.model.make)(&self.arguments, participant)
    }

    /// The model.
    pub fn model(&self) -> &'static HumanModel {
        self.model
    }

    /// Whether this is the paper's model, the default.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Participant<'_> {
    /// This participant as the paper's human.
    pub(super) fn preference_human(&self) -> PreferenceHuman {
        PreferenceHuman::new(self.perception, self.stubbornness).with_changes(self.changes)
    }
}

impl Default for ModelName {
    fn default() -> Self {
        Self { model: MODELS[0], arguments: String::new() }
    }
}

impl PartialEq for ModelName {
    fn eq(&self, other: &Self) -> bool {
        self.model.name == other.model.name && self.arguments == other.arguments
    }
}

impl FromStr for ModelName {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let text = text.trim();
        let (name, arguments) = match text.split_once('(') {
            Some((name, rest)) => (name.trim(), rest.strip_suffix(')').unwrap_or(rest).trim()),
            None => (text, ""),
        };
        let model = MODELS.into_iter().find(|model| model.name == name);
        let model = model.ok_or_else(|| ModelError::Unknown { name: name.to_owned() })?;
        Ok(Self { model, arguments: arguments.to_owned() })
    }
}

impl std::fmt::Debug for ModelName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        std::fmt::Display::fmt(self, f)
    }
}

impl std::fmt::Display for ModelName {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.model.name)?;
        if self.arguments.is_empty() { Ok(()) } else { write!(f, "({})", self.arguments) }
    }
}

impl serde::Serialize for ModelName {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for ModelName {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

fn forms() -> String {
    MODELS.map(|model| model.form).join(", ")
}

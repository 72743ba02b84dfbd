//! The human models that scenarios, studies and the command line know by name.

use super::model::{HumanModel, Participant};
use super::{Human, boltzmann, perceiving, preference, scripted};
use crate::error::Error;
use crate::suggestion;
use std::str::FromStr;

/// All models. A new model needs its own file and a line here.
pub const MODELS: [&HumanModel; 6] = [
    &preference::MODEL,
    &boltzmann::MODEL,
    &scripted::MODEL,
    &perceiving::CUMULATIVE_PROSPECT,
    &perceiving::CONDITIONAL_VALUE_AT_RISK,
    &perceiving::EXPECTED_RISK,
];

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
    /// The arguments do not fit the model or the world.
    pub fn make(&self, participant: &Participant<'_>) -> Result<Box<dyn Human>, Error> {
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
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let text = text.trim();
        let (name, arguments) = match text.split_once('(') {
            Some((name, rest)) => (name.trim(), rest.strip_suffix(')').unwrap_or(rest).trim()),
            None => (text, ""),
        };
        let model = MODELS.into_iter().find(|model| model.name == name);
        let model = model.ok_or_else(|| {
            let forms = MODELS.map(|model| model.form);
            let (known, hint) = (forms.join(", "), suggestion::hint(name, forms));
            Error::new(format!("unknown human model `{name}`; expected one of: {known}{hint}"))
        })?;
        if arguments.is_empty() && model.form != model.name {
            return Err(Error::new(format!(
                "human model `{name}` lacks its arguments; expected {}",
                model.form
            )));
        }
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

//! The methods that scenarios, studies and the command line know by name.

use super::{MethodEntry, RobotPolicy, follow_hand, human_led, mutual, robot_led, without_model};
use crate::suggestion;
use std::str::FromStr;

/// All methods. A new method needs its own file and a line here.
pub const METHODS: [&MethodEntry; 5] =
    [&mutual::METHOD, &without_model::METHOD, &human_led::METHOD, &robot_led::METHOD, &follow_hand::METHOD];

/// A method of deciding who leads: one of [`METHODS`].
#[derive(Clone, Copy)]
pub struct Method(&'static MethodEntry);

/// No method has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown method `{name}`; expected one of: {}{}",
    METHODS.map(|m| m.name).join(", "),
    suggestion::hint(name, METHODS.map(|m| m.name))
)]
pub struct UnknownMethod {
    /// The name found.
    pub name: String,
}

impl Method {
    /// The paper's method.
    pub const MUTUAL: Self = Self(&mutual::METHOD);
    /// The baseline of Table II.
    pub const WITHOUT_MODEL: Self = Self(&without_model::METHOD);
    /// The setting of Table III.
    pub const HUMAN_LED: Self = Self(&human_led::METHOD);
    /// A robot that follows the human's hand.
    pub const FOLLOW_HAND: Self = Self(&follow_hand::METHOD);
    /// The baseline of hypothesis H2 as worded.
    pub const ROBOT_LED: Self = Self(&robot_led::METHOD);

    /// All methods, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        METHODS.into_iter().map(Self)
    }

    /// Name, as in files and on the command line.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// A description in one sentence.
    pub fn about(self) -> &'static str {
        self.0.about
    }

    /// Makes the policy.
    pub fn policy(self) -> Box<dyn RobotPolicy> {
        (self.0.make)()
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Method {}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::all().find(|m| m.name() == name).ok_or_else(|| UnknownMethod { name: name.to_owned() })
    }
}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl serde::Serialize for Method {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> serde::Deserialize<'de> for Method {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(serde::de::Error::custom)
    }
}

//! Errors of scenarios, each with its key and value.

use crate::human::ModelError;
use crate::options::OptionError;
use crate::robot::RobotError;
use crate::saved::NotRestored;
use crate::simulation::PhysicsError;
use crate::world::WorldError;
use thiserror::Error;

/// Why a scenario was refused.
#[derive(Debug, Error)]
pub enum ScenarioError {
    /// The text is not TOML, or not that of a scenario.
    #[error("not a valid scenario")]
    Syntax(#[source] Box<toml::de::Error>),
    /// The scenario cannot be written as TOML.
    #[error("the scenario cannot be written as TOML")]
    Unwritable(#[source] Box<toml::ser::Error>),
    /// A number is out of its range.
    #[error("scenario: {key} = {value}; it must be {expected}")]
    Number {
        /// The key, with those of the tables around it, or the preference change.
        key: String,
        /// The value found.
        value: f64,
        /// The values allowed.
        expected: String,
    },
    /// The robot has no posture of that name.
    #[error("scenario: posture = {posture:?}: {file} has no posture of that name; it has {known}")]
    Posture {
        /// The name found.
        posture: String,
        /// The robot file.
        file: String,
        /// The names of its postures.
        known: String,
    },
    /// The world's text is not a valid world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The world's options are not valid.
    #[error(transparent)]
    Options(#[from] OptionError),
    /// The robot's texts are not a valid robot.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The human model is not valid.
    #[error("scenario: human_model = {model:?}")]
    HumanModel {
        /// The model found.
        model: String,
        /// The reason.
        source: ModelError,
    },
    /// A saved state does not belong to the scenario.
    #[error(transparent)]
    State(#[from] NotRestored),
    /// The physical plant cannot be set up.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
}

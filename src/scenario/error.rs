//! What can be wrong with a scenario, each case with its key and value.

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
    /// The text is not the TOML that a scenario is made of.
    #[error("not a valid scenario")]
    Syntax(#[source] Box<toml::de::Error>),
    /// The scenario cannot be written as TOML.
    #[error("the scenario cannot be written as TOML")]
    Unwritable(#[source] Box<toml::ser::Error>),
    /// A number is out of its range.
    #[error("scenario: {key} = {value}; it must be {expected}")]
    Number {
        /// The key, with those of the tables around it, or the change of mind.
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
        /// The names it has.
        known: String,
    },
    /// The world's text is not a valid world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The world's options.
    #[error(transparent)]
    Options(#[from] OptionError),
    /// The robot's texts are not a valid robot.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The human's model.
    #[error("scenario: human_model = {model:?}")]
    HumanModel {
        /// The model found.
        model: String,
        /// What is wrong with it.
        source: ModelError,
    },
    /// A state to go on from does not belong to the scenario.
    #[error(transparent)]
    State(#[from] NotRestored),
    /// The physical plant cannot be set up so.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
}

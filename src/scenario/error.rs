//! Errors of scenarios, each with its key and value.

/// Why a scenario was refused.
pub type ScenarioError = crate::error::Error;

//! `cocarry fit`: estimates model parameters from the answers of participants.

mod eta;
mod risk_weight;
pub(super) mod worlds;

use super::output::Failure;
use clap::Subcommand;
use std::process::ExitCode;

/// Fit a parameter of the model to the answers of participants
#[derive(Debug, Subcommand)]
pub(super) enum Parameter {
    RiskWeight(risk_weight::RiskWeightArguments),
    Eta(eta::EtaArguments),
}

pub(super) fn run_fit(parameter: &Parameter) -> Result<ExitCode, Failure> {
    match parameter {
        Parameter::RiskWeight(arguments) => risk_weight::run_fit_risk_weight(arguments),
        Parameter::Eta(arguments) => eta::run_fit_eta(arguments),
    }?;
    Ok(ExitCode::SUCCESS)
}

//! `cocarry reproduce`: the paper's claims and tables, with the paper's figures next to ours.

mod all;
mod common;
mod contacts;
mod cycles;
mod guide;
mod h2;
mod h3;
mod h4;
mod slots;
mod starts;

pub(super) use common::Common;

use super::output::{Failure, examples, input, print, print_json, table_with_notes};
use clap::{Args, Subcommand};
use cocarry::episode::EpisodeSettings;
use cocarry_studies::paper::h1;
use cocarry_studies::report::table_1;
use serde_json::json;
use std::process::ExitCode;

/// Reproduce a table or a claim of the paper, with its figures next to ours
#[derive(Debug, Subcommand)]
pub(super) enum Claim {
    /// Table I: how humans choose between the options of four environments
    H1(H1Arguments),
    /// Table II: objective cost with and without the mode transition, and the Environment 4 example
    H2(h2::H2Arguments),
    /// Table III: control cost with and without pose optimisation, for a leading human with preference
    /// changes
    H3(h3::H3Arguments),
    /// Table III with bodies, by how much the base is guided (not in the paper)
    Guide(guide::GuideArguments),
    /// H4 (not in the paper): whether it pays that the robot learns who it carries with, over tasks in a row
    H4(h4::H4Arguments),
    /// Contacts: how often a team with bodies touches the sides of an opening, by the paper's risk S = d_r /
    /// w
    Contacts(contacts::ContactsArguments),
    /// Slots in thick walls: whether a team with bodies comes through deep openings
    Slots(slots::SlotsArguments),
    /// "No locked cycles" (Sec. IV-B): random worlds and humans, each episode run to its end
    Cycles(cycles::CyclesArguments),
    /// Starts: in how many random indoor worlds a team with bodies has room at A and B, and arrives
    Starts(starts::StartsArguments),
    /// A report with tables and pictures: all claims, and the coverage of the fits
    All(all::AllArguments),
}

#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry reproduce h1", ""),
]))]
pub(super) struct H1Arguments {
    #[command(flatten)]
    common: Common,
}

pub(super) fn run_reproduce(claim: &Claim) -> Result<ExitCode, Failure> {
    match claim {
        Claim::H1(arguments) => run_h1(arguments),
        Claim::H2(arguments) => h2::reproduce_h2(arguments),
        Claim::H3(arguments) => h3::reproduce_h3(arguments),
        Claim::Guide(arguments) => guide::reproduce_guide(arguments),
        Claim::H4(arguments) => h4::reproduce_h4(arguments),
        Claim::Contacts(arguments) => contacts::reproduce_contacts(arguments),
        Claim::Slots(arguments) => slots::reproduce_slots(arguments),
        Claim::Cycles(arguments) => cycles::reproduce_cycles(arguments),
        Claim::Starts(arguments) => starts::reproduce_starts(arguments),
        Claim::All(arguments) => all::reproduce_all(arguments),
    }?;
    Ok(ExitCode::SUCCESS)
}

fn run_h1(arguments: &H1Arguments) -> Result<(), Failure> {
    let settings = EpisodeSettings::default();
    let rows = h1::table(&settings.predictor).map_err(input)?;
    let (mean, worst) = h1::differences(&rows);
    if arguments.common.json {
        return print_json(&json!({
            "table": "I",
            "rows": rows,
            "mean_absolute_difference": mean,
            "largest_absolute_difference": worst,
        }));
    }
    print(&table_with_notes(&table_1(&rows)))
}

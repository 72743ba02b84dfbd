//! `cocarry worlds`: lists the built-in worlds.

use super::output::{Failure, examples, input, print, print_json, table, table_text};
use clap::Args;
use cocarry::options::OptionSet;
use cocarry::preference::RISK_WEIGHT;
use cocarry::world::{BUILT_IN_WORLDS, World};
use serde_json::json;
use std::process::ExitCode;

/// List the built-in worlds
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry worlds", ""),
    ("cocarry world free-form --svg map.svg", "one of them in detail, with a map"),
]))]
pub(super) struct WorldsArguments {
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

pub(super) fn run_worlds(arguments: &WorldsArguments) -> Result<ExitCode, Failure> {
    let worlds = BUILT_IN_WORLDS.iter().map(|built_in| {
        let world = World::parse(built_in.name, built_in.text).map_err(input)?;
        let options = OptionSet::new(&world, RISK_WEIGHT).map_err(input)?.options().len();
        Ok((built_in.name, world, options))
    });
    let worlds: Vec<(&str, World, usize)> = worlds.collect::<Result<_, Failure>>()?;
    if arguments.json {
        let worlds = worlds.iter().map(|(name, world, options)| {
            json!({
                "name": name,
                "title": world.name,
                "note": world.note,
                "obstacles": world.obstacles.len(),
                "openings": world.openings.len(),
                "options": options,
            })
        });
        print_json(&json!({ "worlds": worlds.collect::<Vec<_>>() }))?;
    } else {
        let mut shown = table(["world", "title", "obstacles", "openings", "options"], 2);
        for (name, world, options) in &worlds {
            let counts = [world.obstacles.len(), world.openings.len(), *options].map(|n| n.to_string());
            shown.add_row([(*name).to_owned(), world.name.clone()].into_iter().chain(counts));
        }
        print(&format!(
            "{}`cocarry world NAME` shows one of them, `cocarry export NAME` writes its file, to change it.\n",
            table_text(&shown)
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

//! `cocarry bench`: the benchmark's files, and the score card of results.

use super::export::write_silently;
use super::output::{
    Failure, OverwriteArguments, csv_file, examples, print, print_json, table_with_notes, with_spinner,
    write_file,
};
use super::sweep::failure;
use anyhow::Context;
use clap::Args;
use cocarry::suggestion::shell_word;
use cocarry_studies::study::Results;
use cocarry_studies::study::bench::{self, Best, FILES, NAME, ScoreCard};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Compare policies on worlds, humans and robots that do not change: write the benchmark into a folder, or
/// print the score card of results
///
/// The benchmark is two studies for `cocarry sweep`: small.toml (60 episodes of a policy) and full.toml (900).
/// A score is of all episodes of a set, run by this version of the program; README.md in the folder says what
/// it is.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry bench bench-1", "write the benchmark into the folder bench-1"),
    ("cocarry sweep bench-1/small.toml --method mutual -o mutual.csv", "run the small set with a policy"),
    ("cocarry bench bench-1 mutual.csv mine.csv", "the score card of both"),
    ("cocarry bench bench-1 mine.csv --worlds", "world by world, with the best known results"),
]))]
pub(super) struct BenchArguments {
    /// Folder of the benchmark; it is written if there are no results to score
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Results of the benchmark's studies, CSV or Parquet
    #[arg(value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Print a line for every world; without results, the best known ones
    #[arg(long)]
    worlds: bool,
    /// Write the score card, or with --worlds the results of every world, into this CSV file
    #[arg(short, long, value_name = "FILE", value_parser = csv_file, requires = "results")]
    output: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long, requires = "results")]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_bench(arguments: &BenchArguments) -> Result<ExitCode, Failure> {
    let BenchArguments { folder, results, worlds, output, json, overwrite } = arguments;
    if results.is_empty() {
        return if *worlds { best() } else { write(folder, *overwrite) };
    }
    let outputs = overwrite.outputs(results.iter().map(PathBuf::as_path), output)?;
    let files: Vec<Results> = results.iter().map(|file| Results::File(file)).collect();
    let card = with_spinner("checking the studies", || ScoreCard::load(folder, &files)).map_err(failure)?;
    let table = if *worlds { card.world_table() } else { card.table() };
    if let Some(path) = output {
        write_file(&outputs, path, table.csv())?;
    }
    if *json {
        print_json(&json!({ "benchmark": NAME, "entries": table.json(), "notes": table.notes }))?;
    } else {
        print(&table_with_notes(&table))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the benchmark's files, unless they are there already.
fn write(folder: &Path, overwrite: OverwriteArguments) -> Result<ExitCode, Failure> {
    let file = |name: &str| shell_word(&folder.join(name).display().to_string());
    if folder.exists() && bench::check(folder).is_ok() {
        print(&format!("{} has the files of {NAME}\n", folder.display()))?;
    } else {
        let files: Vec<(PathBuf, &[u8])> =
            FILES.iter().map(|(name, contents)| (folder.join(name), *contents)).collect();
        // before a folder is made
        overwrite.outputs([], files.iter().map(|(file, _)| file).filter(|file| file.exists()))?;
        for (file, _) in &files {
            let parent = file.parent().unwrap_or(folder);
            std::fs::create_dir_all(parent)
                .with_context(|| format!("{}: cannot be created", parent.display()))
                .map_err(Failure::Output)?;
        }
        write_silently(overwrite, &files)?;
        print(&format!("wrote {NAME} into {}: {} files\n", folder.display(), files.len()))?;
    }
    print(&format!(
        "\nTry:\n  \
        cocarry sweep {small} --method mutual -o mutual.csv\n  \
        cocarry sweep {small} --method human-led -o human-led.csv\n  \
        cocarry bench {folder} mutual.csv human-led.csv\n",
        small = file("small.toml"),
        folder = shell_word(&folder.display().to_string()),
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Prints the best known results.
fn best() -> Result<ExitCode, Failure> {
    let mut text = format!("{NAME}: best known results, 1/km\n");
    for Best { set, world, policy, result } in Best::all() {
        text += &format!("{:5}  {world:24}  {:8.4}  {policy}\n", set.name(), 1000.0 * result);
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

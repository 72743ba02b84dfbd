//! `cocarry compare`: paired comparisons of results.

use super::output::{
    Failure, OverwriteArguments, csv_file, examples, input, note, print, print_json, table_with_notes,
    write_file,
};
use super::sweep::failure;
use clap::Args;
use cocarry::Error;
use cocarry_studies::study::{Comparing, Results, Summary};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Compare results pair by pair: the same world, seed and human under two methods, policies or other inputs
///
/// Differences have their number, 95 % interval, effect size, and p-value with Holm's correction for all
/// comparisons shown. Nothing is tested where outcomes do not vary between humans.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry compare study.csv", "its methods, and its choices of the pose"),
    ("cocarry compare mine.parquet study.csv", "two sweeps over the same seeds"),
    ("cocarry compare study.csv --by eta", "another input than the method"),
    ("cocarry compare study.csv --over world --quantity final_discomfort", "each human once, with the mean over worlds"),
    ("cocarry compare study.csv -o differences.csv", "the figures as a table"),
]))]
pub(super) struct CompareArguments {
    /// Results of `cocarry sweep`, CSV or Parquet; of several sweeps, rows are paired across the files
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Input whose values are compared, all others being equal [default: method and pose]
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// Average each human's differences over this input, so that a human counts once; may be repeated
    #[arg(long, value_name = "COLUMN")]
    over: Vec<String>,
    /// Quantity of the episodes to compare; may be repeated [default: accumulated_objective_cost_m and
    /// accumulated_control_cost]
    #[arg(long, value_name = "COLUMN")]
    quantity: Vec<String>,
    /// Write the comparisons into this CSV file
    #[arg(short, long, value_name = "FILE", value_parser = csv_file)]
    output: Option<PathBuf>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_compare(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let CompareArguments { results, by, over, quantity, output, json, overwrite } = arguments;
    let outputs = overwrite.outputs(results.iter().map(PathBuf::as_path), output)?;
    let comparing =
        Comparing::new(by.as_deref(), over, quantity).map_err(|e| input(Error::new(format!("--{e}"))))?;
    let files: Vec<Results> = results.iter().map(|file| Results::File(file)).collect();
    let summary = Summary::load(&files, &comparing).map_err(failure)?;
    let names: Vec<String> = files.iter().map(Results::name).collect();
    summary.check_compared(&names, by.as_deref().unwrap_or("method or pose")).map_err(failure)?;
    let mut table = summary.comparison_table(true);
    if !over.is_empty() {
        table = table.with_note(format!("A human counts once, with the mean over {}.", over.join(" and ")));
    }
    if let Some(path) = output {
        write_file(&outputs, path, table.csv())?;
    }
    summary.notes.iter().for_each(note);
    if *json {
        print_json(&json!({ "files": names, "comparisons": table.json(), "notes": table.notes }))?;
    } else {
        print(&table_with_notes(&table))?;
    }
    Ok(ExitCode::SUCCESS)
}

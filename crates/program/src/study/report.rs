//! `cocarry study report`: a page, tables and pictures of what came out of a study.

use super::ReportArguments;
use super::run::{collect_into, of_store, read};
use crate::fit::worlds::load;
use crate::output::{Failure, OverwriteArguments, input, print, print_json};
use crate::report_folder::{PAGE, prepare, write};
use anyhow::anyhow;
use cocarry::episode::EpisodeSettings;
use cocarry::options::OptionSet;
use cocarry::preference::RISK_WEIGHT;
use cocarry::scenario::{Plant, Scenario};
use cocarry_people::{Matched, ReportSettings, Store, StudyTables, report, report_units};
use cocarry_studies::fit::Situation;
use cocarry_studies::report::Document;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

pub(super) fn run_report(arguments: &ReportArguments) -> Result<(), Failure> {
    prepare(&arguments.output, arguments.overwrite)?;
    let folder = tables(arguments)?;
    let tables = StudyTables::read(&folder).map_err(input)?;
    let matched = matched(&tables, &folder)?;
    let settings = ReportSettings {
        draws: arguments.draws as usize,
        resamples: arguments.resamples as usize,
        seed: arguments.seed,
    };
    let units = report_units(&tables, &matched, &settings);
    let document = arguments
        .common
        .with_progress(units, "report", |done| report(&tables, &matched, &settings, done))?
        .map_err(input)?;
    let made = format!("Made by cocarry {}. Equal tables give equal bytes.", env!("CARGO_PKG_VERSION"));
    let texts = [("report.md", document.markdown.clone()), (PAGE, document.page(&made))];
    let files = write(&arguments.output, document.figures(), document.tables(), texts)?;
    if arguments.common.json {
        return print_json(&report_json(&document, arguments, &files));
    }
    let page = arguments.output.join(PAGE);
    print(&format!("{}: {} files; open {}\n", arguments.output.display(), files.len(), page.display()))
}

/// The folder with the tables: the one that is given, or that of the study's answers, collected into the
/// report.
fn tables(arguments: &ReportArguments) -> Result<PathBuf, Failure> {
    let given = &arguments.study;
    if StudyTables::are_in(given) {
        if arguments.simulated {
            return Err(input(anyhow!("--simulated: {} has tables; give the study file", given.display())));
        }
        return Ok(given.clone());
    }
    if given.is_dir() && !given.join("study.toml").is_file() {
        return Err(input(anyhow!(
            "{}: has neither participants.csv, as `cocarry study collect` writes it, nor study.toml",
            given.display()
        )));
    }
    let study = read(given)?;
    let database = if arguments.simulated { study.simulated_database() } else { study.database() };
    let store = Store::open_existing(&database).map_err(of_store)?;
    let folder = arguments.output.join("answers");
    let stale = folder.join("carries.csv");
    if arguments.overwrite && stale.is_file() {
        std::fs::remove_file(&stale)
            .map_err(|error| Failure::Output(anyhow!(error).context(format!("{}", stale.display()))))?;
    }
    collect_into(&study, &store, false, &folder, OverwriteArguments { overwrite: arguments.overwrite })?;
    Ok(folder)
}

/// Answers and switches, matched with their worlds as `fit` and `infer` do by default.
fn matched(tables: &StudyTables, folder: &Path) -> Result<Matched, Failure> {
    let mut matched = Matched::default();
    if let Some(file) = &tables.answers {
        let path = folder.join("answers.csv");
        let worlds = load(&path, file.worlds(), |world| OptionSet::new(&world, RISK_WEIGHT))?;
        let situations = worlds.iter().map(|(world, set)| Situation::new(world.clone(), set)).collect();
        matched.answers = Some(file.matched(situations, false).map_err(input)?);
    }
    if let Some(file) = &tables.switches {
        let path = folder.join("switches.csv");
        let settings = EpisodeSettings { predict_while_human_leads: false, ..EpisodeSettings::default() };
        let prepared = load(&path, file.worlds(), |world| {
            Scenario { settings: settings.clone(), ..Scenario::new(world.into(), Plant::Point) }.prepare()
        })?;
        let switches = file.matched(&prepared).map_err(input)?;
        matched.switches = Some((path.display().to_string(), switches));
    }
    Ok(matched)
}

fn report_json(document: &Document, arguments: &ReportArguments, files: &[String]) -> Value {
    let tables: Map<String, Value> = document.tables().map(|t| (t.name.clone(), t.json())).collect();
    json!({
        "report": arguments.output.display().to_string(),
        "files": files,
        "seed": arguments.seed,
        "resamples": arguments.resamples,
        "draws": 4 * arguments.draws,
        "tables": tables,
    })
}

//! The folder of a report: a page, its Markdown, tables and pictures.

use super::output::{Failure, input, unwritten};
use anyhow::{Context, anyhow};
use cocarry_output::output_file::{OutputFile, Outputs};
use cocarry_studies::report::Figure;
use cocarry_studies::table::Table;
use std::path::Path;

/// The page. It is written last: where it exists, the report is complete.
pub(super) const PAGE: &str = "report.html";

/// A check, before the work, that the report can be written and replaces nothing without --overwrite.
pub(super) fn prepare(folder: &Path, overwrite: bool) -> Result<(), Failure> {
    let name = folder.display();
    if folder.as_os_str().is_empty() {
        return Err(input(anyhow!("--output: is empty; expected the name of a folder")));
    }
    if folder.exists() && !folder.is_dir() {
        return Err(input(anyhow!("--output {name}: is a file; expected a folder")));
    }
    let cannot = |error: std::io::Error| {
        Failure::Output(anyhow::Error::from(error).context(format!("{name}: cannot be written")))
    };
    if folder.exists() {
        let is_empty = std::fs::read_dir(folder).map_err(cannot)?.next().is_none();
        if !is_empty && !overwrite {
            return Err(input(anyhow!("--output {name}: is not empty; --overwrite replaces a report in it")));
        }
    }
    std::fs::create_dir_all(folder).map_err(cannot)?;
    // only writing a file shows whether the folder is writable
    let probe = folder.join(format!("{PAGE}.partial"));
    std::fs::write(&probe, "").and_then(|()| std::fs::remove_file(&probe)).map_err(cannot)
}

/// Writes all files, each complete or not at all. Returns their names. An earlier report stays until all of
/// this one is written; then it is replaced, its page, the last of `texts`, last.
pub(super) fn write<'a>(
    folder: &Path,
    figures: impl Iterator<Item = &'a Figure>,
    tables: impl Iterator<Item = &'a Table>,
    texts: impl IntoIterator<Item = (&'a str, String)>,
) -> Result<Vec<String>, Failure> {
    let pictures = folder.join("figures");
    std::fs::create_dir_all(&pictures)
        .with_context(|| format!("{}: cannot be written", pictures.display()))
        .map_err(Failure::Output)?;
    let figures = figures.map(|f| (format!("figures/{}.svg", f.name), f.svg.clone().into_bytes()));
    let tables = tables.map(|t| (format!("{}.csv", t.name), t.csv()));
    let texts = texts.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes()));
    // the folder is this report's: that was asked before the work
    let outputs = Outputs::new(true, []);
    let mut names = Vec::new();
    let mut written = Vec::new();
    for (name, contents) in figures.chain(tables).chain(texts) {
        written.push(outputs.begin(&folder.join(&name), contents).map_err(unwritten)?);
        names.push(name);
    }
    written.into_iter().try_for_each(OutputFile::finish).map_err(unwritten)?;
    Ok(names)
}

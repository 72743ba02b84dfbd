//! The figures of README and book that depend on many episodes. They are generated from the tables of one run of
//! `reproduce all`, which are kept in `book/figures`.
//!
//! A page has the name of a figure in a comment before it, and a comment behind it:
//! `<!-- = cycles.changed -->579<!-- / -->`. [`fill`] puts the figure between the two. A figure may be a number, a
//! sentence or the rows of a table.
//!
//! `book/figures/short` has a checksum for every table of a short run of the same report. Where the program's short
//! report has others, the kept tables are of an earlier program: `book/renew` measures them again.

mod learning;
mod results;
mod tables;

use super::{PAGES, is_updating, read, settle};
use crate::support::{cocarry, repository, stderr};
use std::collections::BTreeSet;
use std::sync::OnceLock;
use tables::Tables;

/// A name, and the figure of the tables.
type Figure = (&'static str, fn(&Tables) -> String);

const BEGIN: &str = "<!-- = ";
const BEGUN: &str = " -->";
const END: &str = "<!-- / -->";

/// The short version of the report, as the page of results has it.
const SHORT: &str =
    "reproduce all --episodes 2 --humans 2 --worlds 100 --worlds-with-bodies 5 --walks 1 --people 2 --report";

fn all() -> impl Iterator<Item = &'static Figure> {
    results::FIGURES.iter().chain(learning::FIGURES)
}

/// A page with its figures, and their names.
fn filled(page: &str, text: &str) -> (String, Vec<String>) {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    let (mut whole, mut names, mut rest) = (String::new(), Vec::new(), text);
    while let Some((before, behind)) = rest.split_once(BEGIN) {
        let (name, behind) = behind.split_once(BEGUN).unwrap_or_else(|| panic!("{page}: {BEGIN} without end"));
        let (old, behind) = behind.split_once(END).unwrap_or_else(|| panic!("{page}: {name} without {END}"));
        let (_, figure) =
            all().find(|(other, _)| *other == name).unwrap_or_else(|| panic!("{page}: no figure `{name}`"));
        let figure = figure(TABLES.get_or_init(Tables::read));
        // rows of a table stand by themselves
        let figure = if old.starts_with('\n') { format!("\n{}\n", figure.trim_end()) } else { figure };
        whole += &format!("{before}{BEGIN}{name}{BEGUN}{figure}{END}");
        names.push(name.to_owned());
        rest = behind;
    }
    (whole + rest, names)
}

/// A page with its figures.
pub fn fill(page: &str, text: &str) -> String {
    filled(page, text).0
}

#[test]
fn every_figure_is_on_a_page() {
    let used: BTreeSet<String> = PAGES.iter().flat_map(|page| filled(page, &read(page)).1).collect();
    let unused: Vec<&str> = all().map(|(name, _)| *name).filter(|name| !used.contains(*name)).collect();
    assert_eq!(unused, Vec::<&str>::new());
    let names: BTreeSet<&str> = all().map(|(name, _)| *name).collect();
    assert_eq!(names.len(), all().count(), "every name stands for one figure");
}

#[test]
fn the_short_report_is_the_one_on_the_page_of_results() {
    let page = read("book/src/results.md");
    let line = page.lines().find(|line| line.contains("--people 2")).expect("the short report");
    let words = |line: &str| -> BTreeSet<String> {
        line.split(' ').map(str::to_owned).filter(|word| !["cocarry", "draft"].contains(&word.as_str())).collect()
    };
    assert_eq!(words(line), words(SHORT));
}

/// The gate runs it by itself: see `.ci/run`.
#[test]
#[ignore = "minutes; where figures move, `book/renew` is due"]
fn the_figures_are_those_of_this_program() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("report");
    let mut arguments: Vec<&str> = SHORT.split(' ').collect();
    arguments.push(report.to_str().unwrap());
    let output = cocarry(&arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let mut now = String::new();
    for table in tables::files(&report) {
        let bytes = std::fs::read(report.join(format!("{table}.csv"))).unwrap();
        now += &format!("{table} {:08x}\n", crc32fast::hash(&bytes));
    }
    let file = "book/figures/short";
    if !is_updating() {
        let kept = read(file);
        let moved: Vec<&str> = now.lines().filter(|line| !kept.lines().any(|other| other == *line)).collect();
        assert!(
            moved.is_empty(),
            "the figures of the book are of an earlier program: {moved:?}. Run book/renew, read what it changes, and say in CHANGELOG.md what moved"
        );
    }
    if !repository(file).exists() {
        std::fs::write(repository(file), "").unwrap();
    }
    settle(file, &read(file), &now);
}

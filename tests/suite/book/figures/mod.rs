//! The figures of README and book that depend on many episodes. They are generated from the tables of one run
//! of `reproduce all`, which are kept in `book/figures`; the table of benches is from `benches/results.json`.
//!
//! A page has the name of a figure in a comment before it, and a comment behind it: `<!-- = cycles.changed
//! -->579<!-- / -->`. [`fill`] puts the figure between the two. A figure may be a number, a sentence or the
//! rows of a table.
//!
//! `book/figures/short.csv` has a checksum for every table of a short run of the same report. Where the
//! program's short report has others, the kept tables are of an earlier program: `book/renew --check` says so
//! in the gate, and `book/renew` measures them again.

mod benches;
mod bodies;
mod bounds;
mod coverage;
mod learning;
mod results;
mod tables;

use super::{PAGES, read};
use crate::support::repository;
use std::collections::BTreeSet;
use std::sync::OnceLock;
use tables::Tables;

/// A name, and the figure of the tables.
type Figure = (&'static str, fn(&Tables) -> String);

const BEGIN: &str = "<!-- = ";
const BEGUN: &str = " -->";
const END: &str = "<!-- / -->";

fn all() -> impl Iterator<Item = &'static Figure> {
    results::FIGURES
        .iter()
        .chain(bodies::FIGURES)
        .chain(learning::FIGURES)
        .chain(coverage::FIGURES)
        .chain(bounds::FIGURES)
        .chain(benches::FIGURES)
}

/// A page with its figures, and their names.
fn filled(page: &str, text: &str) -> (String, Vec<String>) {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    let (mut whole, mut names, mut rest) = (String::new(), Vec::new(), text);
    while let Some((before, behind)) = rest.split_once(BEGIN) {
        let (name, behind) =
            behind.split_once(BEGUN).unwrap_or_else(|| panic!("{page}: {BEGIN} without end"));
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

/// Every kept table is in the index of the short report, and nothing else is.
#[test]
fn the_kept_tables_are_those_of_the_report() {
    let index = read("book/figures/short.csv");
    let mut listed: Vec<&str> = index.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect();
    listed.sort_unstable();
    assert_eq!(tables::files(&repository("book/figures")), listed);
}

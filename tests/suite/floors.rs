//! The one-way rule: a file uses only floors below its own.

use crate::support::repository;
use std::path::{Path, PathBuf};

/// The floors from the bottom; those in one row may not use each other.
const FLOORS: [&[&str]; 22] = [
    &["math", "saved"],
    &["geometry"],
    &["robot"],
    &["world"],
    &["options"],
    &["preference"],
    &["coordination"],
    &["control"],
    &["simulation"],
    &["arithmetic"],
    &["human"],
    &["policy"],
    &["team"],
    &["episode"],
    &["scenario"],
    &["quantities"],
    &["recording", "drawing"],
    &["statistics", "table", "parallel"],
    &["paper"],
    &["study", "fit", "regression"],
    &["report"],
    &["cli"],
];

fn floor(module: &str) -> usize {
    FLOORS
        .iter()
        .position(|row| row.contains(&module))
        .unwrap_or_else(|| panic!("module `{module}` stands on no floor: add it to the list"))
}

/// The modules that a source text uses through `crate::…`, outside comments.
fn used(source: &str) -> Vec<String> {
    let code = source.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(|line| {
        line.match_indices("crate::").map(|(at, found)| {
            let rest = &line[at + found.len()..];
            rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
        })
    })
    .filter(|module| !module.is_empty())
    .collect()
}

fn offences(module: &str, source: &str) -> Vec<String> {
    used(source).into_iter().filter(|other| other != module && floor(other) >= floor(module)).collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => found.extend(sources(&path)),
            false => found.push(path),
        }
    }
    found
}

#[test]
fn every_file_uses_only_floors_below_its_own() {
    let src = repository("src");
    let mut looked_at = 0;
    for path in sources(&src) {
        let relative = path.strip_prefix(&src).expect("below src");
        let first = relative.components().next().expect("a name").as_os_str().to_string_lossy();
        let module = first.trim_end_matches(".rs");
        if ["lib", "main"].contains(&module) {
            continue;
        }
        let source = std::fs::read_to_string(&path).expect("text");
        let offences = offences(module, &source);
        assert!(offences.is_empty(), "{} uses {offences:?}, which is not below it", relative.display());
        looked_at += 1;
    }
    assert!(looked_at > 20, "only {looked_at} files were looked at");
}

#[test]
fn the_check_can_fail() {
    assert_eq!(offences("options", "use crate::geometry::Point;\nuse crate::episode::run;"), ["episode"]);
    assert_eq!(offences("recording", "fn f() { crate::drawing::map() }"), ["drawing"]);
    assert!(offences("options", "//! see crate::episode").is_empty());
}

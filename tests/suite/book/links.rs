//! Links within the repository, and the table of contents.

use super::{PAGES, read};
use crate::support::repository;
use std::collections::BTreeSet;
use std::path::{Component, Path};

/// Further pages whose links are checked.
const OTHERS: [&str; 6] = [
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "ROADMAP.md",
    "SUPPORT.md",
    "recordings/README.md",
];

/// The targets of links and pictures on a page, without those of the web.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let prose = text.split("```").step_by(2);
    let links = prose.flat_map(|part| part.split("](").skip(1)).filter_map(|rest| rest.split(')').next());
    links.filter(|link| !link.contains("://"))
}

/// The anchors of a page's headings, as forges and mdBook name them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let name = |heading: &str| -> String {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(name).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    for page in PAGES.iter().copied().chain(OTHERS) {
        let text = read(page);
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let folder = Path::new(page).parent().unwrap();
            let target = if file.is_empty() { page.into() } else { folder.join(file) };
            assert!(repository(target.to_str().unwrap()).exists(), "{page}: {link}");
            // one with values is an episode for the page that runs the simulator: site/check opens it
            if !anchor.is_empty() && !anchor.contains('=') {
                let text = read(target.to_str().unwrap());
                assert!(anchors(&text).contains(anchor), "{page}: {link}: no such heading");
            }
            // the built book has only what is in its folder
            let up = Path::new(file).components().filter(|part| *part == Component::ParentDir).count();
            let is_inside = !folder.starts_with("book") || up <= folder.components().count() - 2;
            assert!(is_inside, "{page}: {link}: the built book does not have this file");
        }
    }
}

#[test]
fn the_table_of_contents_has_every_page_of_the_book() {
    let contents = read("book/src/SUMMARY.md");
    let listed: BTreeSet<String> = links(&contents).map(|link| format!("book/src/{link}")).collect();
    let tested = PAGES.iter().filter(|page| page.starts_with("book")).map(|page| (*page).to_owned());
    assert_eq!(listed, tested.collect());
    let pages = ["book/src", "book/src/gallery"].into_iter().flat_map(|folder| {
        let files = std::fs::read_dir(repository(folder)).unwrap().map(|entry| entry.unwrap().file_name());
        let names = files.filter_map(|name| name.into_string().ok()).filter(|name| name.ends_with(".md"));
        names.filter(|name| name != "SUMMARY.md").map(move |name| format!("{folder}/{name}"))
    });
    assert_eq!(pages.collect::<BTreeSet<_>>(), listed);
}

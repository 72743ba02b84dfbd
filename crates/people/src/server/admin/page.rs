//! What the administrator's page shows.

use crate::collect::Collected;
use crate::html::{escaped, page, paragraphs, table};
use crate::order::{Trial, orders};
use crate::store::Progress;
use crate::study::PeopleStudy;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Who sends nothing for longer has left, s.
const LEFT_S: i64 = 30 * 60;
/// The largest number of rows of a table on the page; the files have all.
const MAX_ROWS: usize = 100;
/// The longest sentence about an answer, whose words may be a participant's, characters.
const MAX_SHOWN: usize = 400;
/// The number of digits of a digest that are shown.
const SHOWN_DIGITS: usize = 12;

/// Whether a file of `collect` is offered.
pub(super) fn is_download(file: &str) -> bool {
    file.ends_with(".csv") || file == "README.md"
}

/// The page. `study_sha256` is the digest of what participants see now; `now` is in seconds since 1970.
pub(super) fn overview(
    study: &PeopleStudy,
    study_sha256: &str,
    progress: &[Progress],
    collected: &Collected,
    now: i64,
) -> String {
    let orders = orders(study);
    let people = people(collected);
    let parts = [
        format!("<h1>{}</h1>\n", escaped(&study.title)),
        counts(study, progress, now),
        downloads(collected),
        "<h2>How far they are</h2>\n".to_owned(),
        places(&orders, progress, now),
        order_rows(study, &orders, progress),
        "<h2>What to look at</h2>\n".to_owned(),
        flags(&people),
        left_out(collected),
        versions(progress, study_sha256),
        "<h2>Participants</h2>\n".to_owned(),
        participants(&people),
    ];
    page(
        &study.title,
        "<link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"/plain.css\">",
        &parts.concat(),
    )
}

fn counts(study: &PeopleStudy, progress: &[Progress], now: i64) -> String {
    let finished = progress.iter().filter(|person| person.is_finished).count();
    let (left, answering) = unfinished(progress, now);
    let last = progress.iter().max_by_key(|person| person.last);
    let last = last.map_or("none".to_owned(), |person| person.last_utc.replace(['T', 'Z'], " ") + "UTC");
    let mut html = "<dl class=\"counts\">\n".to_owned();
    for (name, value, class) in [
        ("Begun", format!("{} of {}", progress.len(), study.participants), ""),
        ("Finished", finished.to_string(), ""),
        ("Answering", answering.len().to_string(), ""),
        ("Left before the end", left.len().to_string(), ""),
        ("Last activity", last, " class=\"time\""),
    ] {
        // writing to a text does not fail
        let _ = writeln!(html, "<div><dt>{name}</dt><dd{class}>{value}</dd></div>");
    }
    html + "</dl>\n<p class=\"quiet\">Who sends nothing for 30 minutes has left; they may come back. Load the page again for newer numbers.</p>\n"
}

/// Those who have not finished: who has left, and who is answering.
fn unfinished(progress: &[Progress], now: i64) -> (Vec<&Progress>, Vec<&Progress>) {
    progress.iter().filter(|person| !person.is_finished).partition(|person| now - person.last > LEFT_S)
}

fn downloads(collected: &Collected) -> String {
    let links = |folder: &str| -> String {
        let files = collected.files.iter().map(|(file, _)| file).filter(|file| is_download(file));
        // names of the program, not of participants
        files.map(|file| format!("<li><a href=\"/tables/{folder}{file}\">{file}</a></li>\n")).collect()
    };
    format!(
        "<h2>Tables</h2>\n<p>Of those who have finished, as <code>cocarry study collect</code> writes them. Recordings of carries and world \
         files are written by the command alone.</p>\n<ul class=\"files\">\n{}</ul>\n\
         <p>With those who have not finished:</p>\n<ul class=\"files\">\n{}</ul>\n",
        links(""),
        links("with-unfinished/")
    )
}

/// The pages on which those are who have not finished.
fn places(orders: &[Vec<Trial>], progress: &[Progress], now: i64) -> String {
    let (left, answering) = unfinished(progress, now);
    let mut pages: BTreeMap<(usize, &str), [usize; 2]> = BTreeMap::new();
    for (column, people) in [left, answering].into_iter().enumerate() {
        for person in people {
            let order = &orders[person.place as usize % orders.len()];
            let at = person.trial.unwrap_or(0);
            pages.entry((at, order.get(at).map_or("not a page of the study", kind))).or_default()[column] +=
                1;
        }
    }
    if pages.is_empty() {
        return "<p>Nobody is between beginning and end.</p>\n".to_owned();
    }
    let row = |(&(at, name), [left, answering]): (&(usize, &str), &[usize; 2])| {
        vec![
            format!("{} of {}", at + 1, orders[0].len()),
            name.to_owned(),
            left.to_string(),
            answering.to_string(),
        ]
    };
    let rows: Vec<_> = pages.iter().map(row).collect();
    table(
        "Page that those reached who have not finished",
        &["page", "what it is", "left", "answering"],
        &rows,
    )
}

/// What a page is.
fn kind(page: &Trial) -> &'static str {
    match page {
        Trial::Consent => "consent",
        Trial::Instructions { .. } => "instructions",
        Trial::Percentages { .. } => "percentages",
        Trial::Switch { .. } => "switch",
        Trial::Carry { .. } => "carry",
        Trial::Question { .. } => "question",
        Trial::Scale { .. } => "scale",
    }
}

/// The world of a page with an answer that counts.
fn measured_world(page: &Trial) -> Option<usize> {
    match *page {
        Trial::Percentages { world, practice: false }
        | Trial::Switch { world, practice: false, .. }
        | Trial::Carry { world, practice: false, .. } => Some(world),
        _ => None,
    }
}

/// The participants of each order of the worlds.
fn order_rows(study: &PeopleStudy, orders: &[Vec<Trial>], progress: &[Progress]) -> String {
    let row = |(at, order): (usize, &Vec<Trial>)| {
        let mut seen = BTreeSet::new();
        let worlds = order.iter().filter_map(measured_world).filter(|world| seen.insert(*world));
        let worlds: Vec<&str> = worlds.map(|world| study.worlds[world].name.as_str()).collect();
        let people = progress.iter().filter(|person| person.place as usize % orders.len() == at);
        let (begun, finished) =
            people.fold((0, 0), |(begun, finished), p| (begun + 1, finished + usize::from(p.is_finished)));
        vec![(at + 1).to_string(), worlds.join(", "), begun.to_string(), finished.to_string()]
    };
    let rows: Vec<_> = orders.iter().enumerate().map(row).collect();
    table("Orders of the worlds", &["order", "worlds", "begun", "finished"], &rows)
}

/// Participants as `participants.csv` has them: its columns, and a row for each.
fn people(collected: &Collected) -> (Vec<String>, Vec<Vec<String>>) {
    let bytes = collected
        .files
        .iter()
        .find(|(file, _)| file == "participants.csv")
        .map_or(&[][..], |(_, bytes)| bytes);
    let mut table = csv::ReaderBuilder::new().has_headers(false).from_reader(bytes);
    let row = |row: csv::StringRecord| row.iter().map(str::to_owned).collect::<Vec<_>>();
    let mut rows: Vec<_> = table.records().flatten().map(row).collect();
    let head = if rows.is_empty() { Vec::new() } else { rows.remove(0) };
    (head, rows)
}

fn flags((head, rows): &(Vec<String>, Vec<Vec<String>>)) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let column = head.iter().position(|name| name == "flags").unwrap_or(head.len());
    for flag in rows.iter().filter_map(|row| row.get(column)).flat_map(|flags| flags.split_whitespace()) {
        *counts.entry(flag).or_default() += 1;
    }
    if counts.is_empty() {
        return "<p>Nobody has a flag.</p>\n".to_owned();
    }
    let rows: Vec<_> =
        counts.iter().map(|(flag, count)| vec![(*flag).to_owned(), count.to_string()]).collect();
    table("Flags, by which nobody is left out", &["flag", "participants"], &rows)
}

fn left_out(collected: &Collected) -> String {
    if collected.left_out.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = collected
        .left_out
        .iter()
        .take(MAX_ROWS)
        .map(|line| vec![line.chars().take(MAX_SHOWN).collect()])
        .collect();
    table("Answers that do not fit the study, and are in no table", &["answer"], &rows)
        + &more(collected.left_out.len())
}

fn more(count: usize) -> String {
    match count > MAX_ROWS {
        true => paragraphs(&format!("The first {MAX_ROWS} of {count}.")),
        false => String::new(),
    }
}

/// The versions of the study that participants saw.
fn versions(progress: &[Progress], study_sha256: &str) -> String {
    let mut versions: BTreeMap<&str, [usize; 2]> = BTreeMap::from([(study_sha256, [0, 0])]);
    for person in progress {
        let [begun, finished] = versions.entry(&person.study).or_default();
        *begun += 1;
        *finished += usize::from(person.is_finished);
    }
    let row = |(version, [begun, finished]): (&&str, &[usize; 2])| {
        let is_now = if *version == study_sha256 { "now" } else { "before" };
        let shown = version.chars().take(SHOWN_DIGITS).collect();
        vec![shown, is_now.to_owned(), begun.to_string(), finished.to_string()]
    };
    let rows: Vec<_> = versions.iter().map(row).collect();
    table("Versions of the study (study_sha256)", &["version", "served", "begun", "finished"], &rows)
}

/// The latest participants, the last one first.
fn participants((head, rows): &(Vec<String>, Vec<Vec<String>>)) -> String {
    if rows.is_empty() {
        return "<p>Nobody has begun.</p>\n".to_owned();
    }
    // the versions have a table
    let is_shown = |at: &usize| head[*at] != "study_sha256";
    let shown: Vec<usize> = (0..head.len()).filter(is_shown).collect();
    let names: Vec<&str> = shown.iter().map(|&at| head[at].as_str()).collect();
    let latest = rows.iter().rev().take(MAX_ROWS);
    let rows_shown: Vec<Vec<String>> = latest
        .map(|row| shown.iter().map(|&at| row.get(at).cloned().unwrap_or_default()).collect())
        .collect();
    let caption = format!("Participants, the latest first ({} of {})", rows_shown.len(), rows.len());
    table(&caption, &names, &rows_shown)
}

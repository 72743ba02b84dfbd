//! The report of a small run: complete, by itself, the same for any number of threads, and true to the
//! commands it is made of.

use crate::support::{cocarry, cocarry_without_fma, json, stderr};
use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor};
use cocarry_output::drawing::{option_colour, risk_colour};
use cocarry_studies::paper::ENVIRONMENTS;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const TABLES: [&str; 26] = [
    "table-1",
    "table-1-fit",
    "risk-weight",
    "table-2",
    "example-environment-4",
    "table-2-bodies",
    "arrivals",
    "contacts",
    "cycles",
    "cycles-kinematic",
    "worlds-with-bodies",
    "table-3-elbow-up",
    "table-3-elbow-out",
    "table-3-ratios-elbow-up",
    "table-3-ratios-elbow-out",
    "table-3-parts-elbow-up",
    "table-3-parts-elbow-out",
    "table-3-all",
    "table-3-omni-elbow-up",
    "table-3-omni-ratios-elbow-up",
    "table-3-omni-elbow-out",
    "table-3-omni-ratios-elbow-out",
    "table-3-choices",
    "learning-by-world",
    "learning-by-human",
    "learning-control",
];

const FIGURES: [&str; 18] = [
    "preference-regions",
    "perception",
    "environment-1",
    "environment-2",
    "environment-3",
    "environment-4",
    "risk-weight",
    "table-2",
    "discomfort",
    "example-environment-4",
    "example-environment-3",
    "example-environment-2",
    "example-environment-1",
    "table-2-bodies",
    "contacts",
    "table-3-ratios",
    "learning-regret",
    "learning-control",
];

/// Runs as little as there can be, with these arguments besides.
fn small(folder: &Path, more: &[&str]) -> std::process::Output {
    cocarry(&[&as_little(folder.to_str().expect("a path")), more].concat())
}

fn as_little(folder: &str) -> [&str; 22] {
    [
        "reproduce",
        "all",
        "--episodes",
        "2",
        "--humans",
        "2",
        "--worlds",
        "20",
        "--worlds-with-robot",
        "2",
        "--worlds-with-bodies",
        "2",
        "--walks",
        "1",
        "--people",
        "2",
        "--seeds",
        "2",
        // as h3-omni, but for the plant; it takes longer than all others
        "--parts",
        "h1,risk-weight,h2,h2-bodies,arrivals,contacts,cycles,cycles-kinematic,cycles-bodies,h3,h3-omni,h3-choices,h4",
        "--output",
        folder,
    ]
}

/// A report made on two threads, and what `--json` told of it.
fn report() -> &'static (PathBuf, Value) {
    static REPORT: OnceLock<(PathBuf, Value)> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reports").join("report");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).unwrap();
        }
        let output = small(&folder, &["--threads", "2", "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        (folder, serde_json::from_slice(&output.stdout).expect("JSON"))
    })
}

fn text(name: &str) -> String {
    std::fs::read_to_string(report().0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn rows(name: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let csv = text(&format!("{name}.csv"));
    csv::Reader::from_reader(csv.as_bytes()).deserialize().map(Result::unwrap).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let names = |folder: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name());
        entries.map(|name| name.into_string().unwrap()).collect()
    };
    let figures = names(&folder.join("figures")).into_iter().map(|name| format!("figures/{name}"));
    let mut all: Vec<String> = names(folder).into_iter().filter(|n| n != "figures").chain(figures).collect();
    all.sort();
    all
}

#[test]
fn the_report_has_every_table_and_figure_as_files_and_on_the_page() {
    let (folder, told) = report();
    let tables = TABLES.iter().map(|name| format!("{name}.csv"));
    let figures = FIGURES.iter().map(|name| format!("figures/{name}.svg"));
    let texts = ["report.html", "report.md", "tables.csv"].map(str::to_owned);
    let mut expected: Vec<String> = tables.chain(figures).chain(texts).collect();
    expected.sort();
    assert_eq!(files(folder), expected);
    let mut told_files: Vec<&str> =
        told["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    told_files.sort_unstable();
    assert_eq!(told_files, expected);

    let (page, markdown) = (text("report.html"), text("report.md"));
    for name in FIGURES {
        assert!(page.contains(&format!("<figure id=\"{name}\"")), "{name}");
        assert!(markdown.contains(&format!("](figures/{name}.svg)")), "{name}");
    }
    assert_eq!(page.matches("<svg role=").count(), FIGURES.len());
    for name in TABLES {
        assert!(page.contains(&format!("href=\"{name}.csv\"")), "{name}");
        assert_eq!(told["tables"][name].as_array().unwrap().len(), rows(name).len(), "{name}");
    }
    for part in [
        "H1",
        "H2",
        "H3",
        "H4",
        "locked cycles",
        "Errors in the paper",
        "This run",
        "seed 0",
        env!("CARGO_PKG_VERSION"),
    ] {
        assert!(page.contains(part) && markdown.contains(part), "{part}");
    }
    assert_eq!(told["claims"].as_array().unwrap().len(), 13);
    let index = text("tables.csv");
    let listed: Vec<&str> = index.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect();
    assert_eq!(listed, TABLES);
    for line in index.lines().skip(1) {
        let [_, name, count, crc] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let table = text(&format!("{name}.csv"));
        assert_eq!(
            (count, crc),
            (&*rows(name).len().to_string(), &*format!("{:08x}", crc32fast::hash(table.as_bytes())))
        );
    }
}

#[test]
fn some_parts_give_the_same_tables_as_all() {
    let folder = tempfile::tempdir().unwrap();
    let some = folder.path().join("some");
    let arguments = ["reproduce", "all", "--parts", "cycles,h1", "--worlds", "20", "--output"];
    let output = cocarry(&[&arguments[..], &[some.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let index = std::fs::read_to_string(some.join("tables.csv")).unwrap();
    let parts: Vec<&str> = index.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(parts, ["h1", "h1", "cycles"]);
    for line in index.lines().skip(1) {
        assert!(text("tables.csv").contains(line), "{line}");
    }
    let output = cocarry(&["reproduce", "all", "--parts", "h9", "--output", some.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("h9"), "{}", stderr(&output));
}

#[test]
fn the_contents_lead_to_every_section_and_figures_are_numbered_in_order() {
    let (page, markdown) = (text("report.html"), text("report.md"));
    let (_, contents) = page.split_once("<nav aria-label=\"Contents\">").expect("contents");
    let (contents, sections) = contents.split_once("</nav>").expect("their end");
    let links: Vec<&str> =
        contents.split("href=\"#").skip(1).map(|link| link.split('"').next().unwrap()).collect();
    let headings: Vec<&str> =
        sections.split("<h2 id=\"").skip(1).map(|id| id.split('"').next().unwrap()).collect();
    assert_eq!(links, headings);
    assert!(links.len() > 10 && sections.matches("<h2").count() == links.len(), "{links:?}");
    let captions = |text: &str, before: &str| -> Vec<usize> {
        let numbers = text.split(before).skip(1).map(|rest| rest.split('.').next().unwrap().parse().unwrap());
        numbers.collect()
    };
    let expected: Vec<usize> = (1..=FIGURES.len()).collect();
    assert_eq!(captions(&page, "<figcaption>Figure "), expected);
    assert_eq!(captions(&markdown, "![Figure "), expected);
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let page = text("report.html");
    for loads in ["<script", "<img", "<link", "<iframe", "<object", "@import", "src=", "url(http", "data:"] {
        assert!(!page.contains(loads), "{loads}");
    }
    // addresses are names of formats only, and links lead to its sections and to the tables next to it
    assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    let is_here = |link: &str| link.ends_with(".csv") || link.starts_with('#');
    assert!(page.split("href=\"").skip(1).all(|link| is_here(link.split('"').next().unwrap())));
    let ids: Vec<&str> = page.split(" id=\"").skip(1).map(|id| id.split('"').next().unwrap()).collect();
    let different: std::collections::BTreeSet<&&str> = ids.iter().collect();
    assert_eq!(different.len(), ids.len(), "every id stands for one thing");
}

#[test]
fn every_colour_of_the_pictures_is_visible_in_the_dark_style() {
    let page = text("report.html");
    let (style, pictures) = page.split_once("</style>").expect("a style");
    let (_, dark) =
        style.rsplit_once("@media screen and (prefers-color-scheme: dark)").expect("a dark style");
    let mut ruled = 0;
    for attribute in ["fill", "stroke"] {
        for part in pictures.split(&format!(" {attribute}=\"#")).skip(1) {
            let colour = format!("#{}", &part[..6]);
            let is_ruled = dark.contains(&format!("[{attribute}=\"{colour}\"]"));
            // these mean the same in every picture; a light edge or frame is around them
            let is_of_an_option = (0..8).any(|o| option_colour(o) == colour);
            let is_of_a_risk = (0..=4000).any(|risk| risk_colour(f64::from(risk) / 4000.0) == colour);
            assert!(is_ruled || is_of_an_option || is_of_a_risk, "{attribute} {colour}");
            ruled += usize::from(is_ruled);
        }
    }
    assert!(ruled > 500, "{ruled}");
    assert!(!style.contains("filter") && dark.matches('{').count() == dark.matches('}').count());
}

#[test]
fn equal_runs_write_equal_files_for_any_number_of_threads_on_any_processor() {
    let folder = tempfile::tempdir().unwrap();
    let one = folder.path().join("one");
    // over an old report, next to a file of somebody's
    std::fs::create_dir_all(one.join("figures")).unwrap();
    for name in ["mine.txt", "report.html", "table-1.csv"] {
        std::fs::write(one.join(name), "old").unwrap();
    }
    let more = ["--threads", "1", "--overwrite"];
    let output = cocarry_without_fma(&[&as_little(one.to_str().expect("a path")), &more[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(one.join("mine.txt")).unwrap(), "old");
    std::fs::remove_file(one.join("mine.txt")).unwrap();
    assert_eq!(files(&one), files(&report().0));
    for name in files(&one).iter().filter(|name| *name != "report.html") {
        assert!(std::fs::read_to_string(one.join(name)).unwrap() == text(name), "{name}");
    }
    // the time is told on the page alone, in one line
    let page = std::fs::read_to_string(one.join("report.html")).unwrap();
    let other = text("report.html");
    let lines: Vec<_> = page.lines().zip(other.lines()).filter(|(a, b)| a != b).collect();
    assert!(lines.len() <= 1 && lines.iter().all(|(a, _)| a.contains("Made in ")), "{lines:?}");
}

#[test]
fn the_figures_are_those_of_the_single_commands() {
    let same = |table: &str, claim: &str, keys: &[(&str, &str)]| {
        let found = json(&["reproduce", claim, "--json"]);
        let (expected, rows) = (found["rows"].as_array().unwrap(), rows(table));
        assert_eq!(rows.len(), expected.len());
        for (row, expected) in rows.iter().zip(expected) {
            for (in_file, in_json) in keys {
                let expected = match &expected[in_json] {
                    Value::Null => String::new(),
                    Value::String(text) => text.clone(),
                    number => number.to_string(),
                };
                assert_eq!(row[*in_file], expected, "{table}: {in_file}");
            }
        }
    };
    same(
        "table-1",
        "h1",
        &["environment", "option", "human_percent", "paper_percent", "ours_percent"].map(|k| (k, k)),
    );
    same(
        "table-2",
        "h2",
        &[
            ("environment", "environment"),
            ("eta", "eta"),
            ("paper_mean_m", "paper_mean"),
            ("ours_mean_m", "ours_mean"),
            ("sample_mean_m", "sample_mean"),
            ("sample_std_m", "sample_std"),
            ("transition_step", "transition_step"),
        ],
    );
}

/// The paper's protocol of twenty humans stands next to the expectation over all, with intervals and tests,
/// also where it goes the other way.
#[test]
fn the_twenty_humans_of_table_2_are_compared_in_pairs() {
    let number = |row: &std::collections::BTreeMap<String, String>, key: &str| -> f64 {
        row[key].parse().unwrap_or_else(|_| panic!("{key}: {}", row[key]))
    };
    let markdown = text("report.md");
    let mut compared = 0;
    for row in rows("table-2") {
        if row["eta"].is_empty() {
            assert!(row["sample_against_without_difference_m"].is_empty());
            continue;
        }
        let [lower, mean, upper, raw, holm] = [
            "sample_against_without_difference_lower_m",
            "sample_against_without_difference_m",
            "sample_against_without_difference_upper_m",
            "sample_against_without_p_value",
            "sample_against_without_p_holm",
        ]
        .map(|key| number(&row, key));
        assert_eq!(row["sample_against_without_pairs"], "20");
        assert!(lower < mean && mean < upper && raw <= holm, "{row:?}");
        assert_eq!(raw < 0.05, lower > 0.0 || upper < 0.0, "interval and test agree: {row:?}");
        let told =
            format!("not lower in Environment {}, mutual, eta {}", row["environment"], number(&row, "eta"));
        assert_eq!(markdown.contains(&told), mean >= 0.0, "{told}");
        compared += 1;
    }
    assert_eq!(compared, 12);
    assert!(markdown.contains("the paper's protocol, 20 random humans"));
    assert!(markdown.contains("Holm's method for the 12 comparisons of this table"));
}

#[test]
fn closed_form_the_parts_of_table_3_are_its_c() {
    let mut rows_of = 0;
    for name in ["table-3-parts-elbow-up", "table-3-parts-elbow-out", "table-3-all"] {
        for row in rows(name) {
            let number = |column: &str| row[column].parse::<f64>().expect("a number");
            let sum = ["tracking", "effort", "pose"].map(number).iter().sum::<f64>();
            assert!((sum - number("mean")).abs() < 1e-9 * sum, "{name}: {row:?}");
            rows_of += 1;
        }
    }
    assert_eq!(rows_of, 32 + 32 + 256);
}

/// Every comparison of Table III is corrected, and not made where all humans have one outcome; the account of
/// H3 is in figures of the run.
#[test]
fn table_3_is_tested_where_humans_differ() {
    let mut untested = 0;
    for row in rows("table-3-all").iter().filter(|row| !row["difference"].is_empty()) {
        let is_tested = !row["p_value"].is_empty();
        assert_eq!(
            [&row["p_holm"], &row["difference_lower"], &row["effect_size"]].map(|c| !c.is_empty()),
            [is_tested; 3]
        );
        untested += usize::from(!is_tested);
        assert_eq!(row["pairs"], "2");
    }
    let markdown = text("report.md");
    assert!(
        untested > 0 && markdown.contains("not tested, as all humans there have one outcome"),
        "{untested}"
    );
    for part in [
        "What the probabilities are worth",
        "Costs against manipulability",
        "How much of it is the baseline's",
    ] {
        assert!(markdown.contains(part), "{part}");
    }
}

#[test]
fn the_regions_of_the_map_are_as_large_as_their_options_are_probable() {
    let picture = text("figures/preference-regions.svg");
    crate::pictures::settle_text("book/src/pictures/preference-regions.svg", &picture);
    let panels: Vec<&str> = picture.split("class=\"panel\"").skip(1).collect();
    assert_eq!(panels.len(), ENVIRONMENTS.len());
    for (panel, environment) in panels.iter().zip(&ENVIRONMENTS) {
        let set = OptionSet::new(&environment.world().unwrap(), 10.0).unwrap();
        let mut choice = ChoiceDistribution::default();
        Predictor::default().predict(&prospects(&set, &set.begin()), &mut choice);
        let mut areas = vec![0.0; choice.len()];
        for path in panel.split("<path").skip(1).filter(|path| path.contains("data-option=")) {
            let attribute = |name: &str| {
                path.split_once(&format!("{name}=\"")).and_then(|(_, rest)| rest.split('"').next()).unwrap()
            };
            areas[attribute("data-option").parse::<usize>().unwrap()] = area(attribute(" d"));
        }
        let all: f64 = areas.iter().sum();
        for (o, probability) in choice.probabilities().iter().enumerate() {
            assert!((areas[o] / all - probability).abs() < 1e-3, "{}: {areas:?}", environment.name);
            let named = format!(">{:.1} %<", 100.0 * probability);
            assert_eq!(panel.contains(&named), *probability > 0.0, "{named}");
        }
    }
}

/// Area of the closed outlines of a path.
fn area(data: &str) -> f64 {
    let outlines = data.split('M').skip(1).map(|outline| {
        let corners: Vec<(f64, f64)> = outline
            .trim_end_matches('Z')
            .split('L')
            .map(|pair| pair.split_once(',').unwrap())
            .map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()))
            .collect();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>().abs() / 2.0
    });
    outlines.sum()
}

#[test]
fn a_folder_that_holds_something_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.txt"), "mine").unwrap();
    let output = small(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--overwrite"), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let file = folder.path().join("mine.txt");
    let output = small(&file, &["--overwrite"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("expected a folder"), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(file).unwrap(), "mine");
}

/// One file cannot be replaced, so none is, and nothing else is left.
#[test]
fn a_report_that_cannot_be_written_whole_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("figures")).unwrap();
    let old = ["figures/environment-1.svg", "report.html", "table-1.csv"];
    old.iter().for_each(|name| std::fs::write(folder.path().join(name), "old").unwrap());
    std::fs::create_dir(folder.path().join("report.md")).unwrap();
    let output = small(folder.path(), &["--overwrite"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("report.md: is a directory"), "{}", stderr(&output));
    assert_eq!(
        files(folder.path()),
        ["figures/environment-1.svg", "report.html", "report.md", "table-1.csv"]
    );
    for name in old {
        assert_eq!(std::fs::read_to_string(folder.path().join(name)).unwrap(), "old", "{name}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_told_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let begun = std::time::Instant::now();
    // hours of work, if it came to that
    let output = cocarry(&[
        "reproduce",
        "all",
        "--episodes",
        "1000000",
        "--output",
        file.join("report").to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("cannot be written"), "{}", stderr(&output));
    assert!(begun.elapsed().as_secs() < 20, "it worked first");
}

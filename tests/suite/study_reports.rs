//! `cocarry study report` and `cocarry study power` as a researcher uses them.

use crate::support::{cocarry, done, json, stderr, stdout};
use std::collections::BTreeMap;
use std::path::Path;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of a CSV file, by column.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

/// The row of a table whose first column has this name.
fn row(path: &Path, column: &str, name: &str) -> BTreeMap<String, String> {
    let found = rows(path).into_iter().find(|row| row[column] == name);
    found.unwrap_or_else(|| panic!("{}: no {name}", path.display()))
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap_or_else(|_| panic!("{cell:?} is not a number"))
}

/// The files of a report, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for folder in [folder.to_owned(), folder.join("figures")] {
        for entry in std::fs::read_dir(&folder).unwrap().map(Result::unwrap) {
            if entry.path().is_file() {
                let name = entry.file_name().into_string().unwrap();
                files.insert(name, std::fs::read(entry.path()).unwrap());
            }
        }
    }
    files
}

/// The rows of a table in the opposite order of participants, each one's in their order.
fn turned(text: &str) -> String {
    let (header, rest) = text.split_once('\n').unwrap();
    let mut people: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in rest.lines() {
        let name = line.split(',').next().unwrap();
        match people.iter_mut().find(|(other, _)| *other == name) {
            Some((_, lines)) => lines.push(line),
            None => people.push((name, vec![line])),
        }
    }
    let lines = people.iter().rev().flat_map(|(_, lines)| lines).map(|line| format!("{line}\n"));
    format!("{header}\n{}", lines.collect::<String>())
}

const QUICK: [&str; 4] = ["--draws", "100", "--resamples", "100"];

#[test]
fn people_the_report_has_the_figures_of_fit_and_infer_and_equal_tables_give_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    done(&["study", "new", text(folder.path())]);
    let study = at("study.toml");
    done(&["study", "simulate", text(&study), "--participants", "9", "--seed", "5"]);
    let report = at("report");
    let arguments = ["study", "report", text(&study), "--simulated", "-o", text(&report)];
    done(&[&arguments[..], &QUICK].concat());
    let tables = report.join("answers");
    let (answers, switches) = (tables.join("answers.csv"), tables.join("switches.csv"));

    let fit = json(&["fit", "eta", text(&switches), "--json"]);
    let median = row(&report.join("headlines.csv"), "figure", "median of eta");
    assert_eq!(number(&median["all_value"]), fit["overall"]["median"].as_f64().unwrap());
    for (end, key) in ["all_low", "all_high"].iter().enumerate() {
        assert_eq!(number(&median[*key]), fit["median_interval"][end].as_f64().unwrap());
    }
    let people = rows(&report.join("eta.csv"));
    assert_eq!(people.len(), 9);
    for (row, fitted) in people.iter().zip(fit["participants"].as_array().unwrap()) {
        assert_eq!(row["participant"], fitted["participant"].as_str().unwrap());
        let counts = ["walks", "stopped"].map(|key| number(&row[key]) as u64);
        assert_eq!(counts, ["episodes", "switches"].map(|key| fitted[key].as_u64().unwrap()));
        for (key, value) in [("eta", &fitted["eta"]), ("eta_low", &fitted["interval"][0])] {
            assert_eq!(row[key].parse().ok(), value.as_f64(), "{row:?}");
        }
    }
    let csv = at("people.csv");
    let infer = ["infer", text(&answers), text(&switches), "--draws", "100"];
    done(&[&infer[..], &["--csv", text(&csv)]].concat());
    assert_eq!(read(&csv), read(&report.join("people.csv")));
    let inferred = json(&[&infer[..], &["--json"]].concat());
    for quantity in inferred["population"]["quantities"].as_array().unwrap() {
        let name = quantity["quantity"].as_str().unwrap();
        let headline = row(&report.join("headlines.csv"), "figure", name);
        assert_eq!(number(&headline["all_value"]), quantity["posterior"]["median"].as_f64().unwrap());
        assert_eq!(number(&headline["all_high"]), quantity["posterior"]["interval"][1].as_f64().unwrap());
    }

    // from the tables, on one thread
    let again = at("again");
    done(&[&["study", "report", text(&tables), "-o", text(&again), "--threads", "1"], &QUICK[..]].concat());
    assert_eq!(files(&report), files(&again));
    // and from tables in another order of participants
    let (other, third) = (at("other"), at("third"));
    std::fs::create_dir(&other).unwrap();
    for name in ["answers.csv", "switches.csv", "participants.csv", "responses.csv"] {
        std::fs::write(other.join(name), turned(&read(&tables.join(name)))).unwrap();
    }
    std::fs::copy(tables.join("README.md"), other.join("README.md")).unwrap();
    assert_ne!(read(&other.join("answers.csv")), read(&answers));
    done(&[&["study", "report", text(&other), "-o", text(&third), "--threads", "2"], &QUICK[..]].concat());
    assert_eq!(files(&report), files(&third));

    let page = read(&report.join("report.html"));
    assert!(page.contains("A mouse is not a beam in the hands"));
    assert!(page.contains("Absent: nobody who finished has carried"), "no carry is named");
    // nothing is replaced unasked
    let output = cocarry(&arguments);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--overwrite"));
    done(&[&arguments[..], &QUICK, &["--overwrite"]].concat());
    assert_eq!(files(&report), files(&again));
}

/// Tables of eight people in environment-1: two left, two have flags.
fn planted(folder: &Path) {
    let mut participants = "participant,number,finished_utc,pages_done,flags,left_at\n".to_owned();
    let mut answers = "participant,world,option,percent\n".to_owned();
    let mut carries = "participant,world,method,outcome,duration_s,transitions,peak_force_n\n".to_owned();
    let mut responses = "participant,page,item,answer,right,world,method\n".to_owned();
    let flags = ["", "page-hidden", "", "", "page-hidden pictures-stalled", "", "", ""];
    for (i, flags) in (1_i32..).zip(flags) {
        participants += &format!("p{i},{i},2026-01-01T00:00:00Z,9,{flags},\n");
        for (option, percent) in (1..).zip([10 * i, 100 - 10 * i, 0, 0]) {
            answers += &format!("p{i},environment-1,{option},{percent}\n");
        }
        // differences of time 1, 2, ... 8; of transitions always 1; in a second world half of it
        for (world, time) in [("environment-1", f64::from(i)), ("environment-4", f64::from(i) / 2.0)] {
            carries += &format!("p{i},{world},mutual,arrived,{},2,\n", 30.0 + time);
            carries += &format!("p{i},{world},robot-led,arrived,30,1,\n");
        }
        for (method, answer) in [("mutual", 5), ("robot-led", 3 + i % 2)] {
            responses +=
                &format!("p{i},\"<script>alert(1)</script>\",one,{answer},,environment-1,{method}\n");
            responses +=
                &format!("p{i},\"<script>alert(1)</script>\",two,{answer},,environment-1,{method}\n");
        }
    }
    for (i, page, task) in
        [(9, 3, "percentages: environment-1"), (10, 3, "percentages: environment-4"), (11, 7, "")]
    {
        participants += &format!("p{i},{i},,{page},,{task}\n");
        answers += &format!("p{i},environment-1,1,100\np{i},environment-1,2,0\n");
        answers += &format!("p{i},environment-1,3,0\np{i},environment-1,4,0\n");
    }
    let files = [
        ("participants", participants),
        ("answers", answers),
        ("carries", carries),
        ("responses", responses),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(format!("{name}.csv")), text).unwrap();
    }
    std::fs::write(folder.join("README.md"), "# <img src=x onerror=alert(1)> a study\n").unwrap();
}

#[test]
fn people_planted_drop_outs_and_flags_are_counted_and_left_out_as_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    planted(folder.path());
    let report = folder.path().join("report");
    done(&[&["study", "report", text(folder.path()), "-o", text(&report)], &QUICK[..]].concat());
    let at = |name: &str| report.join(name);
    assert_eq!(
        read(&at("participants.csv")),
        "participants,number\nbegun,11\nfinished,8\ndid not finish,3\n\"finished, with a flag\",2\n\"finished, without a flag\",6\n"
    );
    assert_eq!(read(&at("drop-outs.csv")), "page,task,left\n4,percentages,2\n8,not known,1\n");
    assert_eq!(read(&at("flags.csv")), "flag,participants\npage-hidden,2\npictures-stalled,1\n");

    // option 1 has 10, 20, ... 80 %, option 2 the rest; without 20 and 50 it is (10 + 30 + 40 + 60 + 70 + 80)
    // / 6
    let model: Vec<f64> = json(&["reproduce", "h1", "--json"])["rows"].as_array().unwrap()[..4]
        .iter()
        .map(|row| row["ours_percent"].as_f64().unwrap())
        .collect();
    let off = |first: f64| {
        let people = [first, 100.0 - first, 0.0, 0.0];
        people.iter().zip(&model).map(|(people, model)| (people - model).abs()).sum::<f64>() / 4.0
    };
    let headline = |name: &str| row(&at("headlines.csv"), "figure", name);
    let found = headline("P_o off the mean answers (points)");
    let first_without = [10.0, 30.0, 40.0, 60.0, 70.0, 80.0].iter().sum::<f64>() / 6.0;
    let first_without_stalled = (360.0 - 50.0) / 7.0;
    for (key, first) in [
        ("all", 45.0),
        ("without_flagged", first_without),
        ("without_page_hidden", first_without),
        ("without_pictures_stalled", first_without_stalled),
    ] {
        assert!((number(&found[&format!("{key}_value")]) - off(first)).abs() < 1e-9, "{key}: {found:?}");
    }
    let people = headline("participants");
    let counts = ["all", "without_flagged", "without_pictures_stalled"]
        .map(|key| people[&format!("{key}_value")].clone());
    assert_eq!(counts, ["8.0", "6.0", "7.0"]);

    // times differ by (i + i / 2) / 2 = 0.75 i: mean 0.75 * 4.5; without 2 and 5 it is 0.75 * (36 - 7) / 6
    let time = headline("duration_s: mutual - robot-led");
    assert!((number(&time["all_value"]) - 3.375).abs() < 1e-12, "{time:?}");
    assert!((number(&time["without_flagged_value"]) - 0.75 * 29.0 / 6.0).abs() < 1e-12, "{time:?}");
    let compared = rows(&at("methods-compared.csv"));
    let of = |measure: &str| compared.iter().find(|row| row["measure"] == measure).unwrap();
    // 1 to 8: standard deviation sqrt(6), so d = 4.5 / 2.449 and t = 5.196 with 7 degrees of freedom
    let time = of("duration_s");
    assert!((number(&time["effect_size"]) - 4.5 / 6f64.sqrt()).abs() < 1e-12, "{time:?}");
    assert!((number(&time["p_value"]) - 0.001_259).abs() < 1e-5, "{time:?}");
    // two comparisons vary: the time, and the scale with differences 1, 2, 1, 2, ...
    let scale = of("<script>alert(1)</script>");
    assert!((number(&scale["difference"]) - 1.5).abs() < 1e-12 && scale["pairs"] == "8");
    assert!((number(&time["p_holm"]) - number(&time["p_value"])).abs() < 1e-12, "the larger of two");
    assert!((number(&scale["p_holm"]) - 2.0 * number(&scale["p_value"])).abs() < 1e-12, "the smaller of two");
    // always one more: nothing to test
    let transitions = of("transitions");
    assert_eq!((transitions["difference"].as_str(), transitions["p_value"].as_str()), ("1.0", ""));
    // names are shown as they are
    let page = read(&at("report.html"));
    assert!(!page.contains("<script") && !page.contains("<img"), "names are escaped");
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && page.contains("(one outcome)"));
    // those who left are in no figure
    assert_eq!(row(&at("choices.csv"), "option", "1")["answers"], "8");
}

#[test]
fn people_what_a_study_has_too_few_of_is_named_and_faults_are_told_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let people = |n: u32| (1..=n).map(|i| format!("p{i},{i},t,9,\n")).collect::<String>();
    let header = "participant,number,finished_utc,pages_done,flags\n";
    write("participants.csv", &(header.to_owned() + &people(3)));
    let carry = |i: u32| format!("p{i},w,a,arrived,{},\np{i},w,b,arrived,30,\n", 30 + i);
    let carries = |rows: &str| format!("participant,world,method,outcome,duration_s,peak_force_n\n{rows}");
    write("carries.csv", &carries(&(1..=3).map(carry).collect::<String>()));
    let report = folder.path().join("report");
    let arguments =
        [&["study", "report", text(folder.path()), "--overwrite", "-o", text(&report)], &QUICK[..]].concat();
    done(&arguments);
    let page = read(&report.join("report.md"));
    for said in [
        "Absent: nobody who finished has given percentages.",
        "Absent: nobody who finished has watched a robot that leads.",
        "Absent: tests, and the picture of differences. 3 participants are too few: it needs at least 6.",
        "+2.0 (too few)",
    ] {
        assert!(page.contains(said), "{said}: {page}");
    }
    assert!(!report.join("figures/methods.svg").exists());
    for (name, spoiled, said) in [
        ("carries.csv", carries("p1,w,a,arrived,soon,\n"), ["carries.csv:2", "duration_s", "\"soon\""]),
        ("carries.csv", carries("p9,w,a,arrived,3,\n"), ["carries.csv:2", "participant", "\"p9\""]),
        ("participants.csv", format!("{header}p1,one,t,9,\n"), ["participants.csv:2", "number", "\"one\""]),
    ] {
        let whole = read(&folder.path().join(name));
        write(name, &spoiled);
        let output = cocarry(&arguments);
        assert_eq!(output.status.code(), Some(2));
        let told = stderr(&output);
        assert!(said.iter().all(|part| told.contains(part)), "{told}");
        write(name, &whole);
    }
    let empty = tempfile::tempdir().unwrap();
    let output = cocarry(&["study", "report", text(empty.path()), "-o", text(&empty.path().join("r"))]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("neither participants.csv"), "{}", stderr(&output));
}

#[test]
fn people_the_power_of_a_study_is_told_and_written_as_a_page() {
    let folder = tempfile::tempdir().unwrap();
    done(&["study", "new", text(folder.path())]);
    let (study, to) = (folder.path().join("study.toml"), folder.path().join("power"));
    let power = |more: &[&str]| {
        let arguments = ["study", "power", text(&study), "--studies", "40", "--participants", "30,8"];
        cocarry(&[&arguments[..], more].concat())
    };
    let output = power(&["--effect", "difference=0.8", "--effect", "eta=6", "-o", text(&to)]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(said.contains("80 % of the studies find it from 30 participants on"), "{said}");
    let found = rows(&to.join("power-difference.csv"));
    assert_eq!(found.iter().map(|row| row["participants"].as_str()).collect::<Vec<_>>(), ["8", "30"]);
    assert!(number(&found[1]["power_percent"]) > number(&found[0]["power_percent"]));
    assert!(read(&to.join("report.html")).contains("figure id=\"power-eta\""));
    for (more, part) in [
        (["--effect", "force=1"], "such as eta=3"),
        (["--effect", "eta=-1"], "above 0"),
        (["--power", "80"], "between 0 and 1"),
    ] {
        let output = power(&more);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
}

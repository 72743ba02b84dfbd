//! Files of participants as spreadsheets, pandas and R write them.

use super::{File, answers, refused};
use crate::support::{cocarry, json, repository, stderr};

fn file(name: &str, bytes: &[u8]) -> File {
    let file = File::new(name, "");
    std::fs::write(&file.path, bytes).expect("a temporary file");
    file
}

/// Encodings, separators and decimal commas of spreadsheets give the same fit; an encoding that is not known is
/// named with its line.
#[test]
fn answers_of_any_spreadsheet_give_the_same_fit() {
    let text = answers(10.0, 3, 0.3).replace("person 1", "pers\u{f6}n 1");
    let fit = |file: &File| json(&["fit", "risk-weight", file.path(), "--resamples", "40", "--json"]);
    let expected = fit(&file("answers.csv", text.as_bytes()));
    let semicolons = text.replace(',', ";").replace('.', ",");
    let tabs = text.replace(',', "\t");
    let units =
        |text: &str, bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    let little = [b"\xff\xfe".to_vec(), units(&tabs, u16::to_le_bytes)].concat();
    let big = [b"\xfe\xff".to_vec(), units(&semicolons, u16::to_be_bytes)].concat();
    for bytes in [semicolons.as_bytes(), tabs.as_bytes(), &marked, &little, &big] {
        assert_eq!(fit(&file("answers.csv", bytes)), expected);
    }
    let infer = |file: &File| json(&["infer", file.path(), "--draws", "100", "--json"]);
    let found = infer(&file("answers.csv", &little));
    assert_eq!(found, infer(&file("answers.csv", text.as_bytes())));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let first = 1 + text.lines().position(|line| line.contains('\u{f6}')).expect("a line");
    let latin = file("latin.csv", &latin);
    let said = format!("line {first} is not UTF-8, perhaps Latin-1 or Windows-1252");
    refused(&["fit", "risk-weight", latin.path()], &["latin.csv", &said]);
    refused(&["infer", latin.path()], &["latin.csv", &said]);
    // in a file with commas between the cells, one within a number stays refused
    let quoted = text.lines().map(|line| {
        line.rsplit_once(',').map_or(line.to_owned(), |(a, b)| format!("{a},\"{}\"", b.replace('.', ",")))
    });
    let quoted = File::new("quoted.csv", &quoted.collect::<Vec<_>>().join("\n"));
    refused(&["fit", "risk-weight", quoted.path()], &["percent", "with a decimal point"]);
}

/// pandas writes whole numbers of a column with missing ones as 36.0, R writes NA: the shipped example gives the
/// same fit.
#[test]
fn switches_survive_data_frames() {
    let shipped =
        std::fs::read_to_string(repository("docs/data/simulated-switches.csv")).expect("the example");
    let rows: Vec<&str> = shipped.lines().filter(|line| !line.starts_with('#')).collect();
    let at = rows[0].split(',').position(|name| name == "step").expect("a column");
    let with = |now: fn(&str) -> String| {
        let line = |(i, row): (usize, &&str)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            cells[at] = if i == 0 { cells[at].clone() } else { now(&cells[at]) };
            cells.join(",")
        };
        let text = rows.iter().enumerate().map(line).collect::<Vec<_>>().join("\n");
        let file = File::new("switches.csv", &text);
        let mut fit = json(&["fit", "eta", file.path(), "--json"]);
        fit.as_object_mut().expect("an object").remove("unexplained_lines");
        fit
    };
    let expected = with(str::to_owned);
    let float = |step: &str| if step.is_empty() { String::new() } else { format!("{step}.0") };
    assert!(shipped.lines().any(|line| line.ends_with(',')), "somebody never switched");
    assert_eq!(with(float), expected);
    assert_eq!(with(|step| if step.is_empty() { "NA".to_owned() } else { format!("{step}.0") }), expected);
    let half = File::new("half.csv", "participant,world,method,step\nanna,environment-4,mutual,36.5\n");
    refused(&["fit", "eta", half.path()], &["half.csv:2", "36.5", "a whole number of steps"]);
}

/// Names that other programs take for missing ones are names; those that a data frame lost are told.
#[test]
fn names_such_as_na_are_names() {
    let text = "participant,world,method,step\nNA,environment-4,mutual,36\nnull,environment-4,mutual,30\nNone,environment-4,mutual,\n";
    let found = json(&["fit", "eta", File::new("names.csv", text).path(), "--json"]);
    let names: Vec<_> =
        found["participants"].as_array().expect("people").iter().map(|p| p["participant"].clone()).collect();
    assert_eq!(names, ["NA", "null", "None"]);
    let lost = File::new("lost.csv", &text.replace("NA,", ","));
    refused(&["fit", "eta", lost.path()], &["lost.csv:2", "participant", "keep_default_na=False"]);
}

/// Participants whose names look alike are two people, and a note says so.
#[test]
fn names_that_look_alike_are_noted() {
    let text = "participant,world,method,step\nZo\u{eb},environment-4,mutual,36\nZoe\u{308},environment-4,mutual,30\nAnna,environment-4,mutual,30\nanna,environment-4,mutual,36\n";
    let file = File::new("names.csv", text);
    for arguments in [&["fit", "eta", file.path()][..], &["infer", file.path(), "--draws", "100"]] {
        let output = cocarry(arguments);
        let said = stderr(&output);
        assert!(output.status.success() && said.matches("note: ").count() == 2, "{arguments:?}: {said}");
        assert!(said.contains("`Anna` and `anna` differ only by case"), "{said}");
        assert!(said.contains("Zo\\u{eb}") && said.contains("Zoe\\u{308}"), "{said}");
    }
}

/// Where all answers are lapses, they tell nothing of c_r; and resamples that all give one c_r are no interval.
#[test]
fn what_answers_do_not_tell_has_no_interval() {
    let of = |shares: [f64; 4], people: usize| {
        let mut text = "participant,world,option,percent\n".to_owned();
        for person in 0..people {
            for (option, share) in (1..).zip(shares) {
                text += &format!("p{person},environment-1,{option},{share}\n");
            }
        }
        File::new("answers.csv", &text)
    };
    let mut total = 0;
    for first in [24.9, 24.99, 24.999, 25.0, 25.001, 25.1, 26.0, 40.0, 100.0] {
        let rest = (100.0 - first) / 3.0;
        for shares in [[first, rest, rest, rest], [rest, first, rest, rest], [rest, rest, rest, first]] {
            let file = of(shares, 3);
            let fit = json(&["fit", "risk-weight", file.path(), "--resamples", "40", "--json"]);
            for by in ["likelihood", "least_squares"] {
                let ends = fit[by]["interval_m"].as_array();
                let width = ends.map(|ends| ends[1].as_f64().unwrap() - ends[0].as_f64().unwrap());
                assert!(width.is_none_or(|width| width > 1e-4), "{shares:?}: {by}: {}", fit[by]);
            }
            let likelihood = &fit["likelihood"];
            if likelihood["lapse"].as_f64().expect("a rate") > 0.9995 {
                total += 1;
                assert!(
                    likelihood["undetermined_m"].is_array() && fit["recommended"].is_null(),
                    "{shares:?}: {fit}"
                );
                let said = String::from_utf8(
                    cocarry(&["fit", "risk-weight", file.path(), "--resamples", "40"]).stdout,
                );
                assert!(said.expect("text").contains("with a lapse rate of 100 %"), "{shares:?}");
            }
        }
    }
    assert!(total > 3, "{total}");
}

/// A folder, as `cocarry new` or `cocarry study collect` writes it, stands for the file of participants in it.
#[test]
fn a_folder_stands_for_the_file_in_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let write = |name: &str, text: &str| std::fs::write(path(name), text).expect("a file");
    let (whole, answers, switches) = (path(""), path("answers.csv"), path("switches.csv"));
    refused(&["fit", "risk-weight", &whole], &["a folder without answers.csv", "percent"]);
    refused(&["fit", "eta", &whole], &["a folder without switches.csv", "step"]);
    refused(&["infer", &whole], &["a folder without answers.csv and switches.csv"]);
    // worlds are relative to the folder
    std::fs::copy(repository("worlds/environment-4.toml"), path("room.toml")).expect("a world");
    let mut text = "participant,world,option,percent\n".to_owned();
    for (person, percents) in [("anna", [40, 20, 30, 10]), ("ben", [30, 30, 30, 10])] {
        for (option, percent) in (1..).zip(percents) {
            text += &format!("{person},room.toml,{option},{percent}\n");
        }
    }
    write("answers.csv", &text);
    let fit = |file: &str| json(&["fit", "risk-weight", file, "--resamples", "40", "--json"]);
    let inferred = |file: &str| json(&["infer", file, "--draws", "100", "--json"]);
    assert_eq!(fit(&whole), fit(&answers));
    assert_eq!(inferred(&whole), inferred(&answers));
    write("switches.csv", "participant,world,option,step\nanna,room.toml,1,40\nben,room.toml,1,30\n");
    let fit_eta = |file: &str| json(&["fit", "eta", file, "--json"]);
    assert_eq!(fit_eta(&whole), fit_eta(&switches));
    // both files
    let both = json(&["infer", &answers, &switches, "--draws", "100", "--json"]);
    assert_eq!(inferred(&whole), both);
    std::fs::remove_file(&answers).expect("the answers");
    assert_eq!(inferred(&whole), inferred(&switches));
    refused(&["fit", "risk-weight", &whole], &["a folder without answers.csv"]);
}

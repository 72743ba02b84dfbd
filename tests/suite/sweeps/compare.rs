//! Paired comparisons of the rows of one or several sweeps.

use super::*;

fn compare(bench: &Bench, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    command.arg("compare").args(arguments).env_remove("COLUMNS").current_dir(bench.folder.path());
    command.output().expect("the program starts")
}

fn compared(bench: &Bench, arguments: &[&str]) -> Value {
    let output = compare(bench, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_slice::<Value>(&output.stdout).expect("JSON")["comparisons"].clone()
}

fn refused(bench: &Bench, arguments: &[&str], said: &str) {
    let output = compare(bench, arguments);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty() && error.contains(said), "{arguments:?}: {error}");
}

/// The lines of a file of results, without its header.
fn lines(bench: &Bench, name: &str) -> (String, Vec<String>) {
    let text = String::from_utf8(bench.read(name)).expect("text");
    let mut lines = text.lines().map(str::to_owned);
    (lines.next().expect("a header"), lines.collect())
}

fn write(bench: &Bench, name: &str, header: &str, lines: &[String]) {
    std::fs::write(bench.path(name), format!("{header}\n{}\n", lines.join("\n"))).expect("a file");
}

/// Two studies whose rows are one after the other in a file, or in two files, are compared as one study is that
/// has both methods.
#[test]
fn methods_of_two_sweeps_are_compared_as_those_of_one() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "-o", "both.csv"]);
    bench.good(&["study.toml", "-o", "mutual.csv", "--method", "mutual"]);
    bench.good(&["study.toml", "-o", "without.csv", "--method", "without-model"]);
    let of_one = compared(&bench, &["both.csv"]);
    assert_eq!(of_one.as_array().map(Vec::len), Some(2 * 2 * 2));
    assert_eq!(of_one[0]["first"], "mutual");
    assert_eq!(compared(&bench, &["mutual.csv", "without.csv"]), of_one);
    let (header, first) = lines(&bench, "mutual.csv");
    let (_, second) = lines(&bench, "without.csv");
    write(&bench, "joined.csv", &header, &[first.clone(), second.clone()].concat());
    assert_eq!(compared(&bench, &["joined.csv"]), of_one);
    // rows in another order, and some of them twice
    let mut shuffled = [second, first.clone(), first[..7].to_vec()].concat();
    shuffled[30..].reverse();
    write(&bench, "shuffled.csv", &header, &shuffled);
    let output = compare(&bench, &["shuffled.csv"]);
    assert!(stderr(&output).contains("7 rows repeat others"), "{}", stderr(&output));
    for found in compared(&bench, &["shuffled.csv"]).as_array().expect("rows") {
        let is_same = |other: &&Value| {
            ["world", "eta", "humans", "quantity"].iter().all(|key| other[*key] == found[*key])
        };
        let expected = of_one.as_array().expect("rows").iter().find(is_same).expect("the same comparison");
        let number = |value: &Value, key: &str| value[key].as_f64();
        assert_eq!(number(found, "p_holm"), number(expected, "p_holm"));
        let sign = if found["first"] == expected["first"] { 1.0 } else { -1.0 };
        assert_eq!(number(found, "difference"), number(expected, "difference").map(|d| sign * d));
    }
    // `--summary` and `plot` take the same file
    assert!(stdout(&bench.good(&["--summary", "joined.csv"])).contains("mutual - without-model"));
    let mut plot = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    let plot = plot.args(["plot", "joined.csv", "-o", "joined.svg", "--kind", "differences"]);
    assert!(plot.current_dir(bench.folder.path()).status().expect("it starts").success());
}

/// Numbers and flags as data frames write them do no harm; a value that was changed by hand is refused, also by
/// `--summary` and `plot`.
#[test]
fn rows_that_another_program_wrote_are_read_and_changed_ones_refused() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "-o", "a.csv"]);
    let (header, rows) = lines(&bench, "a.csv");
    let names: Vec<&str> = header.split(',').collect();
    let at = |name: &str| names.iter().position(|other| *other == name).expect("a column");
    let changed = |column: &str, now: &dyn Fn(&str) -> String| -> Vec<String> {
        rows.iter().map(|row| with_cell(row, at(column), now)).collect()
    };
    let expected = compared(&bench, &["a.csv"]);
    write(
        &bench,
        "frame.csv",
        &header,
        &changed("eta", &|eta| eta.parse::<f64>().map_or(String::new(), |eta| format!("{eta:.1}"))),
    );
    let output = compare(&bench, &["frame.csv"]);
    assert_eq!(compared(&bench, &["frame.csv"]), expected);
    assert!(!stderr(&output).contains("could not be checked"), "{}", stderr(&output));
    // a data frame that rounds: told
    let rounded = |cost: &str| cost.parse::<f64>().map_or(String::new(), |cost| format!("{cost:.3}0"));
    write(&bench, "rounded.csv", &header, &changed("accumulated_objective_cost_m", &rounded));
    let output = compare(&bench, &["rounded.csv"]);
    assert!(
        output.status.success() && stderr(&output).contains("could not be checked"),
        "{}",
        stderr(&output)
    );
    // without checksums: told
    write(&bench, "bare.csv", &header, &changed("checksum", &|_| String::new()));
    assert!(stderr(&compare(&bench, &["bare.csv"])).contains("96 of 96 rows"));
    let mut spoiled = rows.clone();
    spoiled[40] = spoiled[40].replacen("arrived", "stuck", 1);
    write(&bench, "spoiled.csv", &header, &spoiled);
    refused(&bench, &["spoiled.csv"], "spoiled.csv: line 42 is a row with changed values");
    bench.refused(&["--summary", "spoiled.csv"], 2, &["line 42 is a row with changed values"]);
    // two results of one combination and seed
    let (_, other) = (0, changed("accumulated_objective_cost_m", &|cost| format!("1{cost}")));
    let other = changed_checksums(&header, &other);
    write(&bench, "twice.csv", &header, &[rows, other].concat());
    refused(&bench, &["twice.csv"], "with other results");
}

/// Names that a data frame took for missing values are told, as in participants' files.
#[test]
fn names_that_a_data_frame_lost_are_told() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "-o", "a.csv", "--seeds", "1"]);
    let (header, rows) = lines(&bench, "a.csv");
    for (column, lost) in [("world", ""), ("method", "nan"), ("human_model", "NaN"), ("humans", "")] {
        let at = header.split(',').position(|name| name == column).expect("a column");
        let mut rows = rows.clone();
        rows[1] = with_cell(&rows[1], at, &|_| lost.to_owned());
        write(&bench, "lost.csv", &header, &rows);
        let said = format!("lost.csv:3: {column} = {lost:?}; it must be a name");
        refused(&bench, &["lost.csv"], &said);
        bench.refused(&["--summary", "lost.csv"], 2, &[&said, "keep_default_na=False"]);
        for kind in ["means", "map"] {
            let mut plot = Command::new(env!("CARGO_BIN_EXE_cocarry"));
            let plot = plot.args(["plot", "lost.csv", "-o", "lost.svg", "--kind", kind]);
            let output = plot.current_dir(bench.folder.path()).output().expect("it starts");
            assert_eq!(output.status.code(), Some(2), "{kind}");
            assert!(stderr(&output).contains(&said), "{kind}: {}", stderr(&output));
        }
    }
}

/// The rows without checksums.
fn changed_checksums(header: &str, rows: &[String]) -> Vec<String> {
    let at = header.split(',').position(|name| name == "checksum").expect("a column");
    rows.iter().map(|row| with_cell(row, at, &|_| String::new())).collect()
}

/// A row with another cell, some of whose cells have commas.
fn with_cell(row: &str, at: usize, now: &dyn Fn(&str) -> String) -> String {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    let cells = reader.records().next().expect("a row").expect("cells");
    let mut writer = csv::Writer::from_writer(Vec::new());
    let changed = cells.iter().enumerate().map(|(i, cell)| if i == at { now(cell) } else { cell.to_owned() });
    writer.write_record(changed).expect("memory");
    String::from_utf8(writer.into_inner().expect("memory")).expect("text").trim_end().to_owned()
}

/// Other inputs than the method, a human who counts once over worlds, and names that are not columns.
#[test]
fn any_input_is_compared_and_humans_count_once() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "-o", "a.csv"]);
    let by_eta = compared(&bench, &["a.csv", "--by", "eta", "--quantity", "final_discomfort"]);
    assert_eq!(by_eta.as_array().map(Vec::len), Some(2 * 2 * 2));
    assert_eq!((&by_eta[0]["first"], &by_eta[0]["second"]), (&"5".into(), &"10.5".into()));
    let over = compared(&bench, &["a.csv", "--over", "world", "--over", "eta"]);
    let all = over.as_array().expect("rows").iter().find(|row| row["humans"] == "all").expect("a row");
    assert_eq!((&all["pairs"], &all["arrived_both"]), (&6.into(), &24.into()));
    let rows = bench.rows("a.csv");
    let cost = |row: &Row| row["accumulated_objective_cost_m"].parse::<f64>().expect("a number");
    let sum_of = |method: &str| -> f64 {
        rows.iter().filter(|row| row["method"] == method && row["humans"] == "all").map(cost).sum()
    };
    let mean = (sum_of("mutual") - sum_of("without-model")) / 24.0;
    let found = all["difference"].as_f64().expect("a number");
    assert!((found - mean).abs() < 1e-9 * mean.abs().max(1.0), "{found} {mean}");
    refused(&bench, &["a.csv", "--by", "metod"], "did you mean `method`?");
    refused(&bench, &["a.csv", "--quantity", "outcome"], "unknown column `outcome`");
    refused(&bench, &["a.csv", "--by", "belief"], "no two combinations differ in belief alone");
    refused(&bench, &["a.csv", "-o", "a.csv"], "a.csv");
    refused(&bench, &["nowhere.csv"], "nowhere.csv");
    let output = compare(&bench, &["a.csv", "-o", "table.csv"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(String::from_utf8(bench.read("table.csv")).expect("text").starts_with("world,humans,"));
}

/// Episodes that do not arrive are no pairs, and are told.
#[test]
fn a_method_that_does_not_arrive_is_told() {
    let study = "worlds = \"environment-4\"\nplants = \"point\"\nmax_steps = [150, 600]\nmethods = \"mutual\"\neta = [5, 10.5]\nseeds = 6\n";
    let bench = Bench::new(study);
    bench.good(&["study.toml", "-o", "a.csv"]);
    let rows = bench.rows("a.csv");
    let arrived =
        |steps: &str| rows.iter().filter(|r| r["max_steps"] == steps && r["outcome"] == "arrived").count();
    assert!(arrived("150") < 12 && arrived("600") == 12, "{} {}", arrived("150"), arrived("600"));
    let output = compare(&bench, &["a.csv", "--by", "max_steps"]);
    if arrived("150") > 0 {
        assert!(stdout(&output).contains("Not all arrived: 150 - 600"), "{}", stdout(&output));
    } else {
        assert!(stderr(&output).contains("no pair of episodes has both arrived"), "{}", stderr(&output));
    }
}

/// Results are CSV or Parquet: a name of another format is refused before an episode runs.
#[test]
fn results_of_another_format_are_refused() {
    let bench = Bench::new(STUDY);
    for name in ["x.xlsx", "x.json", "x.CVS", "results"] {
        bench.refused(&["study.toml", "-o", name], 2, &[name, "expected the extension .csv or .parquet"]);
        assert!(std::fs::read_dir(bench.folder.path()).expect("a folder").count() == 1);
    }
    bench.refused(&["--merge", "x.ods", "a.csv", "b.csv"], 2, &["x.ods", ".parquet"]);
    bench.good(&["study.toml", "-o", "x.CSV"]);
}

/// World files whose names differ by what a line cannot hold are two worlds.
#[cfg(unix)]
#[test]
fn worlds_whose_names_have_line_breaks_stay_apart() {
    let study = "worlds = [\"a b.toml\", \"a\\nb.toml\", \"a\\\\nb.toml\"]\nplants = \"point\"\nmethods = [\"mutual\", \"without-model\"]\nseeds = 10\n";
    let bench = Bench::new(study);
    for (i, name) in ["a b.toml", "a\nb.toml", "a\\nb.toml"].into_iter().enumerate() {
        let world =
            std::fs::read(repository(&format!("worlds/environment-{}.toml", i + 1))).expect("a world");
        std::fs::write(bench.path(name), world).expect("a file");
    }
    bench.good(&["study.toml", "-o", "a.csv"]);
    let worlds: std::collections::BTreeSet<_> =
        bench.rows("a.csv").iter().map(|row| row["world"].clone()).collect();
    assert_eq!(worlds.len(), 3, "{worlds:?}");
    let found = compared(&bench, &["a.csv"]);
    assert_eq!(found.as_array().map(Vec::len), Some(3));
    assert!(found.as_array().expect("rows").iter().all(|row| row["pairs"] == 10), "{found}");
}

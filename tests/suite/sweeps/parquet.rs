//! Results and ticks as Parquet: the values of the CSV files to the bit, read by the Parquet library.

use super::interrupted::kill_at;
use super::{Bench, STUDY};
use crate::support::{cocarry, stderr};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, RecordBatch};
use arrow_schema::DataType;
use cocarry::quantities::{EPISODE, TICK};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::Stdio;

/// The rows of a file, and its metadata.
fn read(path: &Path) -> (Vec<RecordBatch>, BTreeMap<String, String>) {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).expect("a Parquet file");
    let pairs = builder.metadata().file_metadata().key_value_metadata().expect("metadata").clone();
    let pairs = pairs.into_iter().map(|pair| (pair.key, pair.value.unwrap_or_default())).collect();
    (
        builder
            .with_batch_size(1 << 20)
            .build()
            .expect("columns")
            .map(|batch| batch.expect("rows"))
            .collect(),
        pairs,
    )
}

/// Whether a value is that of a cell of CSV.
fn is_cell(column: &dyn Array, row: usize, cell: &str) -> bool {
    if cell.is_empty() || column.is_null(row) {
        return cell.is_empty() && column.is_null(row);
    }
    match column.data_type() {
        DataType::Float64 => {
            let value = column.as_primitive::<Float64Type>().value(row);
            cell.parse().is_ok_and(|cell: f64| cell.to_bits() == value.to_bits())
        }
        DataType::Int64 => cell.parse() == Ok(column.as_primitive::<Int64Type>().value(row)),
        DataType::Boolean => {
            let value = column.as_boolean().value(row);
            cell == value.to_string() || cell == u8::from(value).to_string()
        }
        DataType::Utf8 => column.as_string::<i32>().value(row) == cell,
        other => panic!("{other}"),
    }
}

#[test]
fn parquet_results_have_the_values_of_csv_to_the_bit_their_units_and_their_study() {
    // with a robot, which has numbers in all columns but those of losses and contacts
    let study =
        "worlds = \"environment-4\"\nplants = [\"point\", \"rapier\"]\nmax_steps = 30\nsway_m = 0.02\n";
    let bench = Bench::new(&format!("# about\n{study}seeds = 2\n"));
    bench.good(&["study.toml", "--output", "a.csv"]);
    bench.good(&["study.toml", "--output", "a.parquet"]);
    let (batches, pairs) = read(&bench.path("a.parquet"));
    let rows = bench.rows("a.csv");
    assert_eq!(batches.iter().map(RecordBatch::num_rows).sum::<usize>(), rows.len());
    let schema = batches[0].schema();
    let mut numbers = 0;
    for (row, cells) in rows.iter().enumerate() {
        for (field, column) in schema.fields().iter().zip(batches[0].columns()) {
            let cell = &cells[field.name().as_str()];
            assert!(is_cell(column, row, cell), "row {row}, {}: {cell}", field.name());
            numbers += usize::from(!cell.is_empty() && *field.data_type() == DataType::Float64);
        }
    }
    assert!(numbers > 100, "{numbers}");
    for field in schema.fields() {
        assert!(!field.metadata()["description"].is_empty(), "{field}");
    }
    let unit = |name: &str| schema.field_with_name(name).expect(name).metadata().get("unit").cloned();
    assert_eq!(["walked_m", "sway_m", "eta"].map(unit), [Some("m".to_owned()), Some("m".to_owned()), None]);
    assert!(EPISODE.iter().all(|quantity| schema.field_with_name(quantity.key).is_ok()));
    assert!(pairs["cocarry.study"].starts_with("# about\nworlds"), "{pairs:?}");
    let of_row = |key: &str| rows[0][key].clone();
    let of_file = |key: &str| pairs[key].clone();
    assert_eq!(
        ["cocarry.study_digest", "cocarry.arithmetic", "cocarry.episodes"].map(of_file),
        ["study", "arithmetic", "episodes"].map(of_row)
    );
}

#[test]
fn parquet_results_are_the_same_bytes_for_any_threads_shards_and_stops() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--threads", "1", "--output", "one.parquet"]);
    bench.good(&["study.toml", "--threads", "3", "--output", "three.parquet"]);
    bench.good(&["study.toml", "--output", "one.csv"]);
    let whole = bench.read("one.parquet");
    assert!(whole == bench.read("three.parquet"));
    let ending = |number: u32| if number == 2 { "csv" } else { "parquet" };
    for number in 1..=3 {
        let (shard, out) = (format!("{number}/3"), format!("{number}.{}", ending(number)));
        bench.good(&["study.toml", "--shard", &shard, "--output", &out]);
    }
    bench.good(&["--merge", "merged.parquet", "3.parquet", "2.csv", "1.parquet"]);
    assert!(whole == bench.read("merged.parquet"));
    bench.good(&["--merge", "merged.csv", "1.parquet", "2.csv", "3.parquet"]);
    assert!(bench.read("one.csv") == bench.read("merged.csv"));
    let refusal = ["new.parquet", "1.parquet", "3.parquet"];
    bench.refused(&[&["--merge"], &refusal[..]].concat(), 2, &["episodes 32 to 63 of 96", "shard 2/3"]);
    assert!(!bench.path("new.parquet").exists() && !bench.path("new.parquet.partial").exists());
    let summary = |file: &str| {
        let output = bench.good(&["--summary", file, "--json"]);
        String::from_utf8(output.stdout).expect("text").replace(file, "")
    };
    assert_eq!(summary("one.parquet"), summary("one.csv"));
    // rows of an unfinished sweep are CSV
    let csv = bench.read("one.csv");
    std::fs::write(bench.path("stopped.parquet.partial"), &csv[..csv.len() / 2]).expect("a partial file");
    bench.good(&["study.toml", "--output", "stopped.parquet"]);
    assert!(whole == bench.read("stopped.parquet"));
    assert!(!bench.path("stopped.parquet.partial").exists());
    bench.refused(&["study.toml", "--output", "one.parquet"], 2, &["one.parquet: exists already"]);
}

#[test]
fn parquet_results_that_are_damaged_or_changed_are_refused() {
    let bench = Bench::new(&STUDY.replace("seeds = 6", "seeds = 1"));
    bench.good(&["study.toml", "--output", "a.parquet"]);
    let whole = bench.read("a.parquet");
    let mut refused = 0;
    for i in 0..60 {
        let mut bytes = whole.clone();
        match i {
            0..10 => bytes.truncate(whole.len() * i / 10),
            _ => bytes[(whole.len() - 5) * (i - 9) / 51] ^= 1 << (i % 8),
        }
        std::fs::write(bench.path("damaged.parquet"), bytes).expect("a file");
        let output =
            bench.sweep(&["--overwrite", "--merge", "out.csv", "damaged.parquet", "damaged.parquet"]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{i}: {error}");
        assert!(error.contains("error: ") && !error.contains("panicked"), "{i}: {error}");
        refused += u32::from(!error.contains("duplicate episode"));
    }
    assert!(refused > 20, "{refused}");
}

/// Cells of the ticks that `cocarry run` writes, for a column of the data set.
fn ticks_of_run(arguments: &[&str], out: &Path) -> Vec<BTreeMap<String, String>> {
    let out = out.display().to_string();
    let run = cocarry(&[&["run"], arguments, &["--ticks", &out]].concat());
    assert!(run.status.code().is_some_and(|code| code != 2), "{}", stderr(&run));
    let mut reader = csv::Reader::from_path(&out).expect("ticks");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn parquet_ticks_are_those_of_run() {
    let bench = Bench::new(
        "worlds = \"environment-4\"\nplants = [\"point\", \"kinematic\"]\neta = 5\nmax_steps = 60\nseeds = { first = 3, last = 4 }\n",
    );
    bench.good(&["study.toml", "--output", "a.csv", "--ticks", "ticks"]);
    bench.good(&["study.toml", "--output", "b.csv"]);
    assert!(bench.read("a.csv") == bench.read("b.csv"), "rows do not depend on ticks");
    let names: Vec<_> =
        std::fs::read_dir(bench.path("ticks")).expect("files").map(|e| e.expect("a file")).collect();
    assert_eq!(names.len(), 1);
    let (batches, pairs) = read(&names[0].path());
    assert_eq!(pairs["cocarry.study_digest"], bench.rows("a.csv")[0]["study"]);
    let [batch] = &batches[..] else { panic!("one row group") };
    let column = |name: &str| batch.column_by_name(name).unwrap_or_else(|| panic!("{name}"));
    for quantity in TICK.into_iter().flatten() {
        column(quantity.key);
    }
    let mut row = 0;
    for (episode, (seed, plant)) in
        [("3", "point"), ("3", "kinematic"), ("4", "point"), ("4", "kinematic")].into_iter().enumerate()
    {
        let arguments = [
            "environment-4",
            "--plant",
            plant,
            "--seed",
            seed,
            "--eta",
            "5",
            "--max-steps",
            "60",
            "--overwrite",
        ];
        for cells in ticks_of_run(&arguments, &bench.path("run.csv")) {
            let mut compared = 0;
            for (name, cell) in &cells {
                let Some((key, item)) = name.strip_suffix(']').and_then(|name| name.split_once('[')) else {
                    assert!(is_cell(column(name), row, cell), "episode {episode}, row {row}, {name}: {cell}");
                    continue;
                };
                // an option or a joint: the item of that name in its list
                let found = ["options", "joints"].into_iter().find_map(|list| {
                    let items = column(list).as_list::<i32>().value(row);
                    let items = items.as_struct();
                    let names = items.column_by_name("name")?.as_string::<i32>();
                    let at = (0..names.len()).find(|at| names.value(*at) == item)?;
                    Some(is_cell(items.column_by_name(key)?, at, cell))
                });
                assert_eq!(found, Some(true), "episode {episode}, row {row}, {name}: {cell}");
                compared += 1;
            }
            assert!(compared >= 24, "{compared}");
            assert!(is_cell(column("episode"), row, &episode.to_string()));
            assert!(is_cell(column("seed"), row, seed) && is_cell(column("plant"), row, plant));
            row += 1;
        }
    }
    assert_eq!(row, batch.num_rows(), "no tick is lost or doubled");
}

/// The files of a folder, by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let file = |entry: std::fs::DirEntry| {
        (entry.file_name().into_string().expect("a name"), std::fs::read(entry.path()).expect("a file"))
    };
    entries.map(|entry| file(entry.expect("an entry"))).collect()
}

#[test]
fn parquet_ticks_are_the_same_bytes_after_stops_and_for_any_threads() {
    let bench = Bench::new(&STUDY.replace("seeds = 6", "seeds = 40"));
    bench.good(&["study.toml", "--output", "one.parquet", "--ticks", "one", "--threads", "1"]);
    let whole = files(&bench.path("one"));
    let names: Vec<&str> = whole.keys().map(String::as_str).collect();
    assert_eq!((names.len(), names[0]), (7, "episodes-0000000000-0000000099.parquet"));
    assert_eq!(names[6], "episodes-0000000600-0000000639.parquet");
    let (out, partial) = (bench.path("two.parquet"), bench.path("two.parquet.partial"));
    let rows = bench.read("one.parquet");
    let length = {
        bench.good(&["study.toml", "--output", "rows.csv"]);
        bench.read("rows.csv").len() as u64
    };
    let arguments = ["study.toml", "--output", "two.parquet", "--ticks", "two", "--threads", "2"];
    let mut killed = 0;
    for tenths in [1, 4, 7] {
        let mut command = bench.command(&arguments);
        let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
        killed += u32::from(kill_at(child, &partial, length * tenths / 10));
        assert!(!bench.path("two").exists(), "the folder has its name when it is complete");
    }
    assert_eq!((killed, out.exists()), (3, false), "the sweep is too fast to be killed");
    let told = bench.good(&arguments);
    assert!(String::from_utf8_lossy(&told.stdout).contains("00 of them from the earlier run"));
    assert!(files(&bench.path("two")) == whole && bench.read("two.parquet") == rows);
    assert!(!bench.path("two.partial").exists() && !partial.exists());
    // a part of the files and a part of the rows
    std::fs::create_dir(bench.path("three.partial")).expect("a folder");
    for name in [0, 1, 3].map(|i| names[i]) {
        std::fs::write(bench.path("three.partial").join(name), &whole[name]).expect("a file");
    }
    std::fs::write(bench.path("three.partial/.cocarry-0.tmp"), "half a file").expect("a file");
    std::fs::write(bench.path("three.csv.partial"), bench.read("rows.csv")).expect("rows");
    let told = bench.good(&["study.toml", "--output", "three.csv", "--ticks", "three"]);
    assert!(String::from_utf8_lossy(&told.stdout).contains("200 of them from the earlier run"));
    assert!(files(&bench.path("three")) == whole && bench.read("three.csv") == bench.read("rows.csv"));
    // the shards' files together have every episode once
    for number in 1..=2 {
        let (shard, name) = (format!("{number}/2"), format!("half-{number}"));
        bench.good(&["study.toml", "--shard", &shard, "--output", &format!("{name}.csv"), "--ticks", &name]);
    }
    let parts: usize = ["half-1", "half-2"].map(|name| files(&bench.path(name)).len()).iter().sum();
    assert_eq!(parts, 8, "320 episodes each");
}

#[test]
fn parquet_ticks_replace_nothing_but_ticks() {
    let bench = Bench::new(&STUDY.replace("seeds = 6", "seeds = 1"));
    let sweep = ["study.toml", "--output", "a.csv", "--ticks", "ticks"];
    bench.good(&sweep);
    let again = ["study.toml", "--output", "b.csv", "--ticks", "ticks"];
    bench.refused(&again, 2, &["ticks: exists already", "--overwrite"]);
    bench.good(&[&again[..], &["--overwrite"]].concat());
    std::fs::write(bench.path("ticks/mine.txt"), "mine").expect("a file");
    let overwriting = [&sweep[..], &["--overwrite"]].concat();
    bench.refused(&overwriting, 2, &["ticks: holds mine.txt", "choose another folder"]);
    assert_eq!(bench.read("ticks/mine.txt"), b"mine");
    std::fs::write(bench.path("file"), "mine").expect("a file");
    bench.refused(
        &["study.toml", "--output", "c.csv", "--ticks", "file", "--overwrite"],
        2,
        &["file: is a file"],
    );
    bench.refused(&["study.toml", "--output", "same", "--ticks", "same"], 2, &["same: duplicate output"]);
    // files of another study
    let copied = bench.path("d.partial");
    std::fs::create_dir(&copied).expect("a folder");
    let name = "episodes-0000000000-0000000015.parquet";
    std::fs::copy(bench.path("ticks").join(name), copied.join(name)).expect("a copy");
    std::fs::write(bench.path("study.toml"), STUDY.replace("seeds = 6", "seeds = 1").replace("10.5", "11"))
        .expect("a study");
    let other = ["study.toml", "--output", "d.csv", "--ticks", "d"];
    bench.refused(&other, 2, &["d.partial: holds episodes-", "another study", "--overwrite"]);
    bench.good(&[&other[..], &["--overwrite"]].concat());
    assert_eq!(files(&bench.path("d")).len(), 1);
}

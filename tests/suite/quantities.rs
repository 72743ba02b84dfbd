//! One vocabulary: every output has every quantity, under the same key and with the same value.

use crate::recording::path;
use crate::support::{cocarry, json, stderr};
use cocarry::quantities::{EPISODE, LEARNED, OPTION, PREPARATION, TICK};
use cocarry_recording::recording::{Channel, Reader};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

type Keys = BTreeSet<String>;

fn keys<'a>(keys: impl IntoIterator<Item = &'a str>) -> Keys {
    keys.into_iter().map(str::to_owned).collect()
}

fn of_object(value: &Value) -> Keys {
    value.as_object().expect("an object").keys().cloned().collect()
}

fn of_ticks() -> Keys {
    keys(TICK.iter().flat_map(|table| table.iter().map(|quantity| quantity.key)))
}

/// The messages on JSON channels, by topic.
fn recorded(file: &str) -> BTreeMap<String, Vec<Value>> {
    let mut reader = Reader::open(Path::new(file)).expect("a recording");
    let mut recorded: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    while let Some(entry) = reader.next().expect("a whole recording") {
        if let Some(message) = entry.message().filter(|m| m.channel.encoding == "json") {
            let value = serde_json::from_slice(message.data).expect("JSON");
            recorded.entry(message.channel.topic.clone()).or_default().push(value);
        }
    }
    recorded
}

/// Without what is null.
fn present(value: &Value) -> Value {
    match value {
        Value::Object(fields) => {
            let fields = fields.iter().filter(|(_, value)| !value.is_null());
            fields.map(|(key, value)| (key.clone(), present(value))).collect::<Map<_, _>>().into()
        }
        Value::Array(items) => items.iter().map(present).collect(),
        other => other.clone(),
    }
}

/// The cells of a CSV row, by column, that a JSON line has.
fn cells(line: &Value) -> BTreeMap<String, Value> {
    let mut cells = BTreeMap::new();
    for (key, value) in line.as_object().expect("an object") {
        for item in value.as_array().into_iter().flatten() {
            let name = item["name"].as_str().expect("a name");
            let rest = item.as_object().expect("an object").iter().filter(|(key, _)| *key != "name");
            cells.extend(rest.map(|(key, value)| (format!("{key}[{name}]"), value.clone())));
        }
        if !value.is_array() {
            cells.insert(key.clone(), value.clone());
        }
    }
    cells
}

fn agrees(cell: &str, value: &Value) -> bool {
    match value {
        Value::Null => cell.is_empty(),
        Value::Bool(flag) => cell == if *flag { "1" } else { "0" },
        Value::Number(number) => cell.parse::<f64>().ok() == number.as_f64(),
        Value::String(text) => cell == text,
        _ => false,
    }
}

#[test]
fn every_output_has_every_quantity_under_one_name_and_with_one_value() {
    let folder = tempfile::tempdir().expect("a folder");
    let [table, lines, recording] = ["t.csv", "t.jsonl", "r.mcap"].map(|name| path(folder.path(), name));
    for (plant, more) in [("point", &[][..]), ("kinematic", &["--method", "human-led"]), ("rapier", &[])] {
        let episode = [
            &["run", "--plant", plant, "--seed", "3", "--change", "30:0.6,0.9", "--json", "--overwrite"][..],
            more,
        ]
        .concat();
        let told = json(&[&episode[..], &["--ticks", &lines, "--record", &recording]].concat());
        assert_eq!(told, json(&[&episode[..], &["--ticks", &table]].concat()));
        let of_episode = keys(EPISODE.iter().map(|quantity| quantity.key));
        assert!(of_object(&told).is_superset(&of_episode), "{plant}: {told}");
        let recorded = recorded(&recording);
        let figures: Map<String, Value> =
            of_episode.iter().map(|key| (key.clone(), told[key].clone())).collect();
        assert_eq!(recorded["/outcome"], [present(&figures.into())], "{plant}");

        let mut rows = csv::Reader::from_path(&table).expect("a table");
        let columns = rows.headers().expect("columns").clone();
        let rows: Vec<csv::StringRecord> = rows.records().map(|row| row.expect("a row")).collect();
        let lines = std::fs::read_to_string(&lines).expect("lines");
        let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        assert_eq!((rows.len(), lines.len() as u64), (lines.len(), told["steps"].as_u64().expect("a count")));
        for (i, (row, line)) in rows.iter().zip(&lines).enumerate() {
            assert_eq!(of_object(line), of_ticks(), "{plant}");
            let option = &line["options"][0];
            assert_eq!(of_object(option), keys(OPTION.iter().map(|quantity| quantity.key)), "{plant}");
            let cells = cells(line);
            assert_eq!(cells.len(), columns.len(), "{plant}");
            for (column, cell) in columns.iter().zip(row) {
                assert!(agrees(cell, &cells[column]), "{plant}: {column}: {cell} and {}", cells[column]);
            }
            let mut messages = Map::new();
            let channels =
                recorded.iter().filter(|(topic, _)| !["/outcome", "/preparation"].contains(&topic.as_str()));
            for (_, of_channel) in channels {
                messages.extend(of_channel[i].as_object().expect("an object").clone());
            }
            let mut expected = present(line);
            let figures = expected.as_object_mut().expect("an object");
            // messages are stamped with the time; a point has no joints, and no channel for them
            figures.remove("time_s");
            figures.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
            assert_eq!(Value::from(messages), expected, "{plant}: step {i}");
        }
    }
}

#[test]
fn every_quantity_is_in_the_schema_of_a_channel() {
    let mut described = Keys::new();
    for channel in Channel::ALL.into_iter().filter(|channel| channel.encoding() == "json") {
        let schema: Value = serde_json::from_slice(&channel.schema().data).expect("JSON");
        described.extend(of_object(&schema["properties"]));
    }
    let further = [PREPARATION, LEARNED, EPISODE].into_iter().flatten().map(|quantity| quantity.key);
    assert_eq!(described, &of_ticks() | &keys(further));
}

#[test]
fn old_names_of_quantities_are_refused_where_names_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = path(folder.path(), "costs.toml");
    let text = "[tolerance.control_cost]\nrelative = 1e-3\n[[run]]\nworld = \"environment-4\"\nplant = \"point\"\nseed = 1\n";
    std::fs::write(&file, text).expect("a file");
    let output = cocarry(&["regress", "record", &file]);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("control_cost") && error.contains("accumulated_control_cost"), "{error}");
}

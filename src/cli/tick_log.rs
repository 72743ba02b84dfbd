//! Ticks in; CSV or JSON lines out, one line a tick, every key with its unit.

use super::output::{Failure, write_file};
use crate::coordination::Mode;
use crate::episode::Tick;
use anyhow::{Context, Error};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A file to log ticks to; its ending says how.
#[derive(Clone, Debug)]
pub(super) struct File {
    path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Csv,
    JsonLines,
}

/// Reads the argument.
pub(super) fn file(text: &str) -> Result<File, String> {
    let path = PathBuf::from(text);
    let format = match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => Format::Csv,
        Some("jsonl") => Format::JsonLines,
        _ => return Err("the name must end in .csv or .jsonl".to_owned()),
    };
    Ok(File { path, format })
}

impl File {
    /// Writes all ticks; `name` gives an option's name.
    pub fn write<'a>(&self, ticks: &[Tick], name: impl Fn(usize) -> &'a str) -> Result<(), Failure> {
        let text = match self.format {
            Format::Csv => csv(ticks, name).map_err(Failure::Output)?,
            Format::JsonLines => ticks.iter().map(|t| json_line(t, &name).to_string() + "\n").collect(),
        };
        write_file(&self.path, &text)
    }
}

/// The values of a tick that do not belong to an option, in the order of the columns. NaN does not occur among them.
fn columns<'a>(tick: &Tick, name: impl Fn(usize) -> &'a str) -> [(&'static str, Value); 12] {
    let mode = match tick.mode {
        Mode::RobotLed => "robot-led",
        Mode::HumanLed => "human-led",
    };
    [
        ("step", json!(tick.step)),
        ("time_s", json!(tick.time)),
        ("x_m", json!(tick.position.x)),
        ("y_m", json!(tick.position.y)),
        ("heading_deg", json!(tick.heading.to_degrees())),
        ("mode", json!(mode)),
        ("stubbornness", json!(tick.stubbornness)),
        ("discomfort", json!(tick.discomfort)),
        ("executed", json!(name(tick.executed))),
        ("preferred", json!(name(tick.preferred))),
        ("objective_cost_m", json!(tick.objective_cost)),
        ("accumulated_cost_m", json!(tick.accumulated_cost)),
    ]
}

/// The values of one option in a tick, in the order of the columns; null where a value was not evaluated.
fn option_columns(tick: &Tick, option: usize) -> [(&'static str, Value); 6] {
    let o = &tick.options[option];
    [
        ("length_m", json!(o.remaining.length)),
        ("risk", json!(o.remaining.risk)),
        ("objective_m", json!(o.objective)),
        ("expected_subjective_m", json!(o.expected)),
        ("probability", json!(o.probability)),
        ("misaligned", json!(u8::from(o.misaligned))),
    ]
}

fn csv<'a>(ticks: &[Tick], name: impl Fn(usize) -> &'a str) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (i, tick) in ticks.iter().enumerate() {
        let common = columns(tick, &name).into_iter().map(|(key, value)| (key.to_owned(), value));
        let options = (0..tick.options.len()).flat_map(|o| {
            let name = name(o);
            option_columns(tick, o).into_iter().map(move |(key, value)| (format!("{key}[{name}]"), value))
        });
        let (keys, values): (Vec<String>, Vec<Value>) = common.chain(options).unzip();
        if i == 0 {
            writer.write_record(&keys)?;
        }
        writer.write_record(values.iter().map(|value| match value {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }))?;
    }
    let bytes = writer.into_inner().context("CSV")?;
    String::from_utf8(bytes).context("CSV")
}

fn json_line<'a>(tick: &Tick, name: impl Fn(usize) -> &'a str) -> Value {
    let mut line: serde_json::Map<String, Value> =
        columns(tick, &name).into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    let options = (0..tick.options.len())
        .map(|o| {
            let values = option_columns(tick, o).into_iter().map(|(key, value)| (key.to_owned(), value));
            Value::Object([("name".to_owned(), json!(name(o)))].into_iter().chain(values).collect())
        })
        .collect();
    line.insert("options".to_owned(), Value::Array(options));
    Value::Object(line)
}

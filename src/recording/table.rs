//! Tables of the messages on a topic.

use super::decode::{decode, flatten};
use super::{Definition, Entry, ReadError, Reader};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read;

/// The largest number of columns of a table.
const MOST: usize = 4096;

/// The columns of the messages on a topic, in the order in which they first occur; then those of its schema
/// that no message has.
///
/// # Errors
/// [`ReadError`], also if the topic does not exist or its messages cannot be decoded.
pub fn columns<R: Read>(reader: &mut Reader<R>, topic: &str) -> Result<Vec<String>, ReadError> {
    let mut columns = Vec::new();
    let mut known = BTreeMap::new();
    let mut topics = Vec::new();
    let mut declared = Vec::new();
    let file = reader.name().to_owned();
    while let Some(entry) = reader.next()? {
        if let Entry::Channel { definition, .. } = &entry {
            topics.push(format!("`{}`", definition.topic));
            if definition.topic == topic {
                declared = declared_fields(definition);
            }
        }
        let Some(message) = entry.message().filter(|m| m.channel.topic == topic) else { continue };
        let Some(value) = decode(message.channel, message.data) else {
            return Err(undecodable(&file, topic, message.time));
        };
        for (path, _) in flatten(&value) {
            if known.len() == MOST && !known.contains_key(&path) {
                let what = format!("`{topic}` has more than {MOST} fields, too many for a table");
                return Err(ReadError::Lacks { file, what });
            }
            known.entry(path).or_insert_with_key(|path| {
                columns.push(path.clone());
                columns.len() - 1
            });
        }
    }
    topics.dedup();
    if columns.is_empty() {
        let what = match topics.contains(&format!("`{topic}`")) {
            true => format!("there are no messages on `{topic}`"),
            false if topics.is_empty() => format!("has no channel `{topic}`; it has no channels"),
            false => format!("has no channel `{topic}`; it has {}", topics.join(", ")),
        };
        return Err(ReadError::Lacks { file, what });
    }
    declared.retain(|path| !known.contains_key(path));
    columns.extend(declared.into_iter().take(MOST - columns.len()));
    Ok(columns)
}

/// The paths of the single values in a JSON Schema, without those in lists.
fn declared_fields(definition: &Definition) -> Vec<String> {
    fn descend(path: &str, schema: &Value, found: &mut Vec<String>) {
        match &schema["properties"] {
            Value::Object(properties) => {
                for (key, property) in properties {
                    let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                    descend(&path, property, found);
                }
            }
            _ if schema["type"] != "array" => found.push(path.to_owned()),
            _ => {}
        }
    }
    let mut found = Vec::new();
    let schema = definition.schema.as_ref().filter(|schema| schema.encoding == "jsonschema");
    if let Some(schema) = schema.and_then(|schema| serde_json::from_slice::<Value>(&schema.data).ok()) {
        descend("", &schema, &mut found);
    }
    found
}

/// Calls `row` for every message on a topic, with its time (ns) and its cells in the order of `columns`. A
/// missing cell is `None`.
///
/// # Errors
/// [`ReadError`], or the error of `row`.
pub fn rows<R: Read, E: From<ReadError>>(
    reader: &mut Reader<R>,
    topic: &str,
    columns: &[String],
    mut row: impl FnMut(u64, &[Option<&Value>]) -> Result<(), E>,
) -> Result<(), E> {
    let index: BTreeMap<&str, usize> = columns.iter().enumerate().map(|(i, c)| (c.as_str(), i)).collect();
    let file = reader.name().to_owned();
    while let Some(entry) = reader.next()? {
        let Some(message) = entry.message().filter(|m| m.channel.topic == topic) else { continue };
        let Some(value) = decode(message.channel, message.data) else {
            return Err(undecodable(&file, topic, message.time).into());
        };
        let mut cells = vec![None; columns.len()];
        for (path, value) in flatten(&value) {
            if let Some(&i) = index.get(path.as_str()) {
                cells[i] = Some(value);
            }
        }
        row(message.time, &cells)?;
    }
    Ok(())
}

fn undecodable(file: &str, topic: &str, time: u64) -> ReadError {
    let what = format!(
        "the message on `{topic}` at {} s cannot be decoded: it does not match its schema, or is too long",
        time as f64 / 1e9
    );
    ReadError::Lacks { file: file.to_owned(), what }
}

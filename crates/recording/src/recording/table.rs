//! Tables of the messages on a topic.

use super::decode::{MAX_FIELDS, MAX_PATHS, decode, flatten};
use super::{Definition, Entry, ReadError, Reader};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

/// The largest number of cells of a table.
const MAX_CELLS: usize = 20_000_000;
/// The number of channels that an error lists.
const LISTED: usize = 40;

/// The columns of the messages on a topic, in the order in which they first occur; then those of its schema
/// that no message has.
///
/// # Errors
/// [`ReadError`], also if the topic does not exist, its messages cannot be decoded, or the table would be too
/// large: it has at most 4096 columns, whose names have at most 1 MiB, and 20 million cells.
pub fn columns<R: Read>(reader: &mut Reader<R>, topic: &str) -> Result<Vec<String>, ReadError> {
    let mut columns = Vec::new();
    let mut known = BTreeSet::new();
    let (mut messages, mut bytes) = (0_usize, 0);
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
        messages += 1;
        let fields = flatten(&value).ok_or_else(|| too_large(&file, topic, "the paths in a message"))?;
        for (path, _) in fields {
            if !known.contains(&path) {
                bytes += path.len();
                columns.push(path.clone());
                known.insert(path);
            }
        }
        if columns.len() > MAX_FIELDS || bytes > MAX_PATHS {
            return Err(too_large(&file, topic, "the paths in its messages"));
        }
        if columns.len().saturating_mul(messages) > MAX_CELLS {
            let what = format!("`{topic}` has more than {MAX_CELLS} cells, too many for a table");
            return Err(ReadError::Lacks { file, what });
        }
    }
    topics.dedup();
    if columns.is_empty() {
        let what = match topics.contains(&format!("`{topic}`")) {
            true => format!("there are no messages on `{topic}`"),
            false if topics.is_empty() => format!("has no channel `{topic}`; it has no channels"),
            false => {
                format!("has no channel `{topic}`; it has {}", topics[..topics.len().min(LISTED)].join(", "))
            }
        };
        return Err(ReadError::Lacks { file, what });
    }
    declared.retain(|path| !known.contains(path));
    columns.extend(declared.into_iter().take((MAX_CELLS / messages.max(1)).min(MAX_FIELDS) - columns.len()));
    Ok(columns)
}

/// The paths of the single values in a JSON Schema, without those in lists; none of a schema that is too large
/// for a table.
fn declared_fields(definition: &Definition) -> Vec<String> {
    /// The paths, built from a message with a value for every property.
    fn example(schema: &Value) -> Value {
        match &schema["properties"] {
            Value::Object(properties) => {
                properties.iter().map(|(key, property)| (key.clone(), example(property))).collect()
            }
            _ if schema["type"] == "array" => Value::Array(Vec::new()),
            _ => Value::Null,
        }
    }
    let schema = definition.schema.as_ref().filter(|schema| schema.encoding == "jsonschema");
    let schema = schema.and_then(|schema| serde_json::from_slice::<Value>(&schema.data).ok());
    let example = schema.as_ref().map(example).unwrap_or_default();
    flatten(&example).into_iter().flatten().map(|(path, _)| path).filter(|path| !path.is_empty()).collect()
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
        for (path, value) in flatten(&value).into_iter().flatten() {
            if let Some(&i) = index.get(path.as_str()) {
                cells[i] = Some(value);
            }
        }
        row(message.time, &cells)?;
    }
    Ok(())
}

fn too_large(file: &str, topic: &str, what: &str) -> ReadError {
    let what = format!(
        "`{topic}` is too large for a table: {what} are more than {MAX_FIELDS}, or longer than {MAX_PATHS} bytes"
    );
    ReadError::Lacks { file: file.to_owned(), what }
}

fn undecodable(file: &str, topic: &str, time: u64) -> ReadError {
    let what = format!(
        "the message on `{topic}` at {} s cannot be decoded: it does not match its schema, or is too long",
        time as f64 / 1e9
    );
    ReadError::Lacks { file: file.to_owned(), what }
}

//! Decoded messages: fields by name as JSON, or flat as the cells of a table.

use super::schema::Definition;
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use serde_json::Value;

/// The length of the longest message that is decoded, bytes. A decoded message takes many times as much
/// memory.
pub(super) const LONGEST: usize = 256 << 10;

/// The fields of a message; `None` if it does not match its channel, is longer than 256 kB, or has an unknown
/// type.
pub fn decode(channel: &Definition, data: &[u8]) -> Option<Value> {
    if data.len() > LONGEST {
        return None;
    }
    if channel.encoding == "json" {
        return serde_json::from_slice(data).ok();
    }
    match &*channel.schema.as_ref()?.name {
        "foxglove.FrameTransforms" => value::<FrameTransforms>(data),
        "foxglove.SceneUpdate" => value::<SceneUpdate>(data),
        "foxglove.JointStates" => value::<JointStates>(data),
        "foxglove.Log" => value::<Log>(data),
        _ => None,
    }
}

fn value<T: Decode + serde::Serialize>(data: &[u8]) -> Option<Value> {
    serde_json::to_value(T::decode(data).ok()?).ok()
}

/// The single values in a message with their paths, such as `grip.force_n.x`. An element of a list is named
/// by its own name, as in `options[left].length_m`, or by its index from 0 if it has none.
pub fn flatten(message: &Value) -> Vec<(String, &Value)> {
    let mut cells = Vec::new();
    flatten_into(String::new(), message, None, &mut cells);
    cells
}

/// `called` is the field whose value is already in the path.
fn flatten_into<'v>(
    path: String,
    value: &'v Value,
    called: Option<&str>,
    cells: &mut Vec<(String, &'v Value)>,
) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields.iter().filter(|(key, _)| called != Some(key)) {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten_into(path, value, None, cells);
            }
        }
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                let named = |key: &'static str| Some((key, item.get(key)?.as_str()?));
                let called = ["name", "child_frame_id", "id"].into_iter().find_map(named);
                let path = match called {
                    Some((_, name)) => format!("{path}[{name}]"),
                    None => format!("{path}[{i}]"),
                };
                flatten_into(path, item, called.map(|(key, _)| key), cells);
            }
        }
        single => cells.push((path, single)),
    }
}

//! Decoded messages: fields by name as JSON, or flat as the cells of a table.

use super::schema::Definition;
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use serde_json::Value;

/// The length of the longest message that is decoded, bytes. A decoded message takes many times as much
/// memory.
pub(super) const MAX_MESSAGE_BYTES: usize = 256 << 10;

/// The fields of a message; `None` if it does not match its channel, is longer than 256 kB, or has an unknown
/// type.
pub fn decode(channel: &Definition, data: &[u8]) -> Option<Value> {
    if data.len() > MAX_MESSAGE_BYTES {
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

/// The largest number of single values in a message, and of columns of a table.
pub(super) const MAX_FIELDS: usize = 4096;
/// The largest total length of their paths, bytes.
pub(super) const MAX_PATHS: usize = 1 << 20;

/// The single values in a message with their paths, such as `grip.force_n.x`. An element of a list is named
/// by its own name, as in `options[left].length_m`, or by its index from 0 if it has none. `None` if there are
/// more than 4096, or their paths have more than 1 MiB.
pub fn flatten(message: &Value) -> Option<Vec<(String, &Value)>> {
    let mut paths = Paths::default();
    paths.flatten(String::new(), message, None)?;
    Some(paths.cells)
}

/// Paths, and the bytes of all that were built, of lists and objects too.
#[derive(Default)]
struct Paths<'v> {
    cells: Vec<(String, &'v Value)>,
    bytes: usize,
}

impl<'v> Paths<'v> {
    /// A path below another one; `None` beyond the limit.
    fn below(&mut self, path: &str, parts: [&str; 3]) -> Option<String> {
        self.bytes += path.len() + parts.iter().map(|part| part.len()).sum::<usize>();
        (self.bytes <= MAX_PATHS).then(|| [path, parts[0], parts[1], parts[2]].concat())
    }

    /// `called` is the field whose value is already in the path.
    fn flatten(&mut self, path: String, value: &'v Value, called: Option<&str>) -> Option<()> {
        match value {
            Value::Object(fields) => {
                for (key, value) in fields.iter().filter(|(key, _)| called != Some(key)) {
                    let path = self.below(&path, [if path.is_empty() { "" } else { "." }, key, ""])?;
                    self.flatten(path, value, None)?;
                }
            }
            Value::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let named = |key: &'static str| Some((key, item.get(key)?.as_str()?));
                    let called = ["name", "child_frame_id", "id"].into_iter().find_map(named);
                    let index = i.to_string();
                    let path = self.below(&path, ["[", called.map_or(&*index, |(_, name)| name), "]"])?;
                    self.flatten(path, item, called.map(|(key, _)| key))?;
                }
            }
            _ if self.cells.len() == MAX_FIELDS => return None,
            single => self.cells.push((path, single)),
        }
        Some(())
    }
}

//! The first difference between a recorded and a replayed message.

use super::channel::Message;
use super::decode::{decode, flatten};
use super::schema::Definition;
use super::{Channel, Recorded};

/// The first difference of a recording from its replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Simulated time of the message, ns.
    pub time: u64,
    /// Its topic.
    pub topic: String,
    /// The path of the field, or a description of the difference.
    pub field: String,
    /// The recorded value.
    pub recorded: String,
    /// The replayed value.
    pub expected: String,
}

impl Difference {
    /// The first difference between two messages; `None` if they are equal. A missing message is `None`.
    pub fn between(recorded: Option<&Recorded>, expected: Option<&Message>) -> Option<Self> {
        let differs = |time, topic: &str, field: &str, recorded: String, expected: String| {
            Some(Self { time, topic: topic.to_owned(), field: field.to_owned(), recorded, expected })
        };
        match (recorded, expected) {
            (None, None) => None,
            (None, Some(e)) => {
                let nothing = "the end of the recording".to_owned();
                differs(e.time, e.channel.topic(), "message", nothing, "a message".to_owned())
            }
            (Some(r), None) => {
                let nothing = "the end of the run".to_owned();
                differs(r.time, &r.channel.topic, "message", "a message".to_owned(), nothing)
            }
            (Some(r), Some(e)) => {
                let topic = e.channel.topic();
                if r.time != e.time {
                    let time = r.time.min(e.time);
                    let seconds = |time: u64| format!("{} s on", time as f64 / 1e9);
                    let recorded = format!("{} {}", seconds(r.time), r.channel.topic);
                    return differs(
                        time,
                        topic,
                        "time of the message",
                        recorded,
                        format!("{} {topic}", seconds(e.time)),
                    );
                }
                if r.channel.topic != topic {
                    return differs(e.time, topic, "topic", r.channel.topic.clone(), topic.to_owned());
                }
                let known = Definition::of(e.channel);
                if known.encoding != r.channel.encoding || known.schema != r.channel.schema {
                    let (recorded, expected) = (words(r.channel), words(&known));
                    return differs(e.time, topic, "schema", recorded, expected);
                }
                if r.data == e.data {
                    return None;
                }
                let (field, recorded, expected) = field(r, e.channel, &e.data);
                differs(e.time, topic, &field, recorded, expected)
            }
        }
    }
}

fn words(definition: &Definition) -> String {
    match &definition.schema {
        None => "none".to_owned(),
        Some(schema) => {
            let checksum = crc32fast::hash(&schema.data);
            format!(
                "{} ({}, {} bytes, checksum {checksum:08x})",
                schema.name,
                schema.encoding,
                schema.data.len()
            )
        }
    }
}

/// The first field that differs, and its two values.
fn field(recorded: &Recorded, channel: Channel, data: &[u8]) -> (String, String, String) {
    let known = Definition::of(channel);
    let (ours, theirs) = (decode(&known, data), decode(recorded.channel, recorded.data));
    let [ours, theirs] = [&ours, &theirs].map(|message| message.as_ref().and_then(flatten));
    let (Some(ours), Some(theirs)) = (ours, theirs) else {
        let bytes = |data: &[u8]| format!("{} bytes, checksum {:08x}", data.len(), crc32fast::hash(data));
        return ("message (not decodable)".to_owned(), bytes(recorded.data), bytes(data));
    };
    let missing = || "nothing".to_owned();
    for (path, value) in &ours {
        let other = theirs.iter().find(|(p, _)| p == path).map(|(_, v)| *v);
        if other != Some(*value) {
            return (path.clone(), other.map_or_else(missing, ToString::to_string), value.to_string());
        }
    }
    match theirs.iter().find(|(path, _)| !ours.iter().any(|(p, _)| p == path)) {
        Some((path, value)) => (path.clone(), value.to_string(), missing()),
        None => {
            let bytes = |data: &[u8]| format!("checksum {:08x}", crc32fast::hash(data));
            ("encoding of the same fields".to_owned(), bytes(recorded.data), bytes(data))
        }
    }
}

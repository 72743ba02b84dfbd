//! The definitions of the channels: the quantities of each JSON channel, and its JSON Schema.
//!
//! Foxglove reads one plain type per field and refuses lists of types. A field without a value is therefore
//! left out of the message, and the schema does not require it.

use super::channel::Channel;
use crate::quantities::{
    CONTROL, COORDINATION, COST, EPISODE, INTERACTION, JOINTS, OPTIONS, PREPARATION, Quantity, STEP, schema,
};
use serde_json::Value;
use std::collections::BTreeMap;

/// The definition of a channel in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Topic.
    pub topic: String,
    /// The encoding of its messages.
    pub encoding: String,
    /// The schema of its messages; `None` if the file has none.
    pub schema: Option<SchemaText>,
    /// Its metadata.
    pub metadata: BTreeMap<String, String>,
}

/// The definition of a schema in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchemaText {
    /// Name.
    pub name: String,
    /// `protobuf` or `jsonschema`.
    pub encoding: String,
    /// A protobuf `FileDescriptorSet`, or the text of a JSON Schema.
    pub data: Vec<u8>,
}

impl Definition {
    /// The definition of a channel by this crate.
    pub fn of(channel: Channel) -> Self {
        let schema = channel.schema();
        Self {
            topic: channel.topic().to_owned(),
            encoding: channel.encoding().to_owned(),
            schema: Some(SchemaText {
                name: schema.name,
                encoding: schema.encoding,
                data: schema.data.into_owned(),
            }),
            metadata: BTreeMap::new(),
        }
    }
}

/// The quantities in the messages of a JSON channel; none for the others.
pub(super) fn quantities(channel: Channel) -> &'static [&'static [Quantity]] {
    match channel {
        Channel::Options => &[STEP, OPTIONS],
        Channel::Coordination => &[STEP, COORDINATION],
        Channel::Control => &[STEP, CONTROL, JOINTS],
        Channel::Preparation => &[STEP, PREPARATION],
        Channel::Interaction => &[STEP, INTERACTION],
        Channel::Cost => &[STEP, COST],
        Channel::Outcome => &[EPISODE],
        _ => &[],
    }
}

/// The JSON Schema of the messages of a JSON channel.
pub(super) fn json_schema(channel: Channel) -> Value {
    let mut schema = schema(quantities(channel).iter().copied().flatten());
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = channel.topic().trim_start_matches('/').into();
    schema
}

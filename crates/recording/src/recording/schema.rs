//! The definition of a channel as a file has it.

use super::channel::Channel;
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

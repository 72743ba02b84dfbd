//! What a recording says of where it comes from.

use std::collections::BTreeMap;

/// The name of the metadata record that says where a recording comes from.
pub const METADATA: &str = "cocarry";
/// The name of the metadata record that says what [`recover`](super::recover) had to leave out.
pub const RECOVERED: &str = "recovered";
/// The name of the attachment that is the world file's text.
pub const WORLD: &str = "world.toml";

/// Where a recording comes from: enough to run it again. No wall clock, host or path, so that equal runs give equal bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Short facts by name.
    pub metadata: BTreeMap<String, String>,
    /// Texts that the run was made from.
    pub attachments: Vec<Attachment>,
}

/// A file inside a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// File name.
    pub name: String,
    /// As in `text/plain`.
    pub media_type: String,
    /// Contents.
    pub data: Vec<u8>,
}

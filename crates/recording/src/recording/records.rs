//! The records of MCAP files: their names in errors, and attachments.

use mcap::records::op;

/// A file in a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// File name.
    pub name: String,
    /// The media type, such as `text/plain`.
    pub media_type: String,
    /// Contents.
    pub data: Vec<u8>,
}

/// The name of a record in errors.
pub(super) fn record_name(opcode: u8) -> &'static str {
    match opcode {
        op::HEADER => "the header",
        op::FOOTER => "the footer",
        op::SCHEMA => "a schema",
        op::CHANNEL => "a channel",
        op::MESSAGE => "a message",
        op::CHUNK => "a chunk",
        op::ATTACHMENT => "an attachment",
        op::METADATA => "a metadata record",
        op::DATA_END => "the end of the data",
        _ => "a record",
    }
}

/// Whether an attachment is long enough for its fields without contents: two times, name, media type, length,
/// checksum.
pub(super) fn has_attachment_fields(body: &[u8]) -> bool {
    let text_end = |begin: usize| {
        let length = body.get(begin..)?.get(..4)?.try_into().ok()?;
        (begin + 4).checked_add(usize::try_from(u32::from_le_bytes(length)).ok()?)
    };
    text_end(16).and_then(text_end).is_some_and(|end| body.len() >= end.saturating_add(12))
}

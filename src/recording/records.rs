//! The records of MCAP files: opcodes, length limits, and the fields of records that are read.

use super::fields::Fields;

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

pub(super) const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// The length of the longest record, and of the longest unpacked chunk, bytes. A simulated second takes 0.1
/// MB.
pub(super) const LONGEST: u64 = 32 << 20;
/// The largest total length of all definitions of channels, bytes.
pub(super) const DEFINITIONS: usize = 16 << 20;

pub(super) mod op {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const ATTACHMENT: u8 = 0x09;
    pub const METADATA: u8 = 0x0c;
    pub const DATA_END: u8 = 0x0f;
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

/// A chunk: unpacked length, checksum, compression and packed bytes.
pub(super) fn chunk_fields<'a>(fields: &mut Fields<'a>) -> Option<(u64, u32, &'a str, &'a [u8])> {
    fields.bytes(16)?;
    Some((fields.u64()?, fields.u32()?, fields.text()?, fields.long_block()?))
}

/// The head of a message: channel and time.
pub(super) fn message_header(fields: &mut Fields) -> Option<(u16, u64)> {
    let id = fields.u16()?;
    fields.u32()?;
    let time = fields.u64()?;
    fields.u64()?;
    Some((id, time))
}

/// An attachment: name, media type and contents.
pub(super) fn attachment(fields: &mut Fields) -> Option<Attachment> {
    fields.bytes(16)?;
    let (name, media_type) = (fields.text()?.to_owned(), fields.text()?.to_owned());
    Some(Attachment { name, media_type, data: fields.long_block()?.to_owned() })
}

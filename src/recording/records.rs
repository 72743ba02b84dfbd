//! The records of an MCAP file: their numbers, how long they may be, and the fields of those that are read.

use super::fields::Fields;

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

pub(super) const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// The longest record, and the longest chunk when unpacked, B. A simulated second takes 0.1 MB.
pub(super) const LONGEST: u64 = 32 << 20;
/// The most that all definitions of channels may take, B.
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

/// What errors call a record.
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

/// Length unpacked, checksum, compression, and the packed bytes.
pub(super) fn chunk_fields<'a>(fields: &mut Fields<'a>) -> Option<(u64, u32, &'a str, &'a [u8])> {
    fields.bytes(16)?;
    Some((fields.u64()?, fields.u32()?, fields.text()?, fields.long_block()?))
}

/// Channel and time.
pub(super) fn message_header(fields: &mut Fields) -> Option<(u16, u64)> {
    let id = fields.u16()?;
    fields.u32()?;
    let time = fields.u64()?;
    fields.u64()?;
    Some((id, time))
}

/// Name, media type and contents.
pub(super) fn attachment(fields: &mut Fields) -> Option<Attachment> {
    fields.bytes(16)?;
    let (name, media_type) = (fields.text()?.to_owned(), fields.text()?.to_owned());
    Some(Attachment { name, media_type, data: fields.long_block()?.to_owned() })
}

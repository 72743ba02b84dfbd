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

/// Whether the texts, maps and contents of a record fit into it. The crate's parser takes memory for the
/// lengths that they claim, and panics on a short attachment.
pub(super) fn has_its_fields(opcode: u8, body: &[u8]) -> bool {
    let mut fields = Fields(body);
    let read = match opcode {
        op::SCHEMA => fields.skip(2).and_then(|()| fields.texts(3)),
        op::CHANNEL => fields.skip(4).and_then(|()| fields.texts(2)).and_then(|()| fields.map()),
        op::METADATA => fields.texts(1).and_then(|()| fields.map()),
        // two times, lengths and checksum; the compression, the records
        op::CHUNK => fields.skip(28).and_then(|()| fields.texts(1)).and_then(|()| fields.contents()),
        // two times; name and media type, the file, its checksum
        op::ATTACHMENT => {
            let file = fields.skip(16).and_then(|()| fields.texts(2)).and_then(|()| fields.contents());
            file.and_then(|()| fields.skip(4))
        }
        _ => Some(()),
    };
    read.is_some()
}

/// The bytes of a record that are not looked at yet.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn skip(&mut self, count: usize) -> Option<()> {
        self.0 = self.0.get(count..)?;
        Some(())
    }

    fn length(&mut self) -> Option<usize> {
        let (length, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        usize::try_from(u32::from_le_bytes(*length)).ok()
    }

    fn texts(&mut self, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| {
            let length = self.length()?;
            self.skip(length)
        })
    }

    fn map(&mut self) -> Option<()> {
        let length = self.length()?;
        let mut entries = Fields(self.0.get(..length)?);
        while !entries.0.is_empty() {
            entries.texts(2)?;
        }
        self.skip(length)
    }

    /// Bytes behind a length of 8 bytes.
    fn contents(&mut self) -> Option<()> {
        let (length, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        self.skip(usize::try_from(u64::from_le_bytes(*length)).ok()?)
    }
}

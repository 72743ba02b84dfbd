//! The writer of MCAP files.
//!
//! Chunks are built in memory and each is written in one call, so that after a crash the file is intact up to
//! its last chunk.

use super::records::Attachment;
use super::schema::Definition;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{Error, Seek, Write};

/// The name of the writing library in files: the same for all versions, so that equal runs give equal bytes.
const LIBRARY: &str = "cocarry";

/// An MCAP file that is being written.
pub(super) struct MessageFile<W: Write + Seek> {
    /// `None` after an error: the crate's writer would otherwise add a summary after the damage.
    writer: Option<Writer<W>>,
    sequences: BTreeMap<u16, u32>,
    /// The largest number of a channel or schema.
    defined: u16,
}

/// The largest number of a channel or schema: the crate's writer overflows at the largest of its type.
const MAX_DEFINED: u16 = 65_000;

/// A channel or schema for which a file has no number.
#[derive(Debug, thiserror::Error)]
#[error("it has more than {MAX_DEFINED} channels or schemas")]
struct TooMany;

impl<W: Write + Seek> MessageFile<W> {
    pub fn new(to: W) -> Result<Self, Error> {
        let options = WriteOptions::new()
            .library(LIBRARY)
            .compression_threads(0)
            // Zstandard's default, 3, takes nearly twice the time for files that are at most 1.3 % smaller
            .compression_level(1)
            // `flush` closes chunks long before that, by simulated time
            .chunk_size(Some(1 << 20))
            .disable_seeking(true);
        let writer = options.create(to).map_err(error)?;
        Ok(Self { writer: Some(writer), sequences: BTreeMap::new(), defined: 0 })
    }

    /// Defines a channel. Returns its number.
    pub fn define(&mut self, definition: &Definition) -> Result<u16, Error> {
        if self.defined >= MAX_DEFINED {
            return Err(Error::other(TooMany));
        }
        let (schema, channel) = self.with(|writer| {
            let schema = match &definition.schema {
                Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
                None => 0,
            };
            let Definition { topic, encoding, metadata, .. } = definition;
            Ok((schema, writer.add_channel(schema, topic, encoding, metadata)?))
        })?;
        self.defined = self.defined.max(schema).max(channel);
        Ok(channel)
    }

    /// Adds a message at a simulated time (ns).
    pub fn write(&mut self, channel: u16, time: u64, data: &[u8]) -> Result<(), Error> {
        let sequence = self.sequences.entry(channel).or_default();
        let header =
            MessageHeader { channel_id: channel, sequence: *sequence, log_time: time, publish_time: time };
        *sequence = sequence.wrapping_add(1);
        self.with(|writer| writer.write_to_known_channel(&header, data))
    }

    pub fn metadata(&mut self, name: &str, entries: &BTreeMap<String, String>) -> Result<(), Error> {
        let metadata = Metadata { name: name.to_owned(), metadata: entries.clone() };
        self.with(|writer| writer.write_metadata(&metadata))
    }

    pub fn attach(&mut self, attachment: &Attachment) -> Result<(), Error> {
        let attachment = mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: attachment.name.clone(),
            media_type: attachment.media_type.clone(),
            data: attachment.data.as_slice().into(),
        };
        self.with(|writer| writer.attach(&attachment))
    }

    /// Hands all messages to the system. A crash of the program does not lose them.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.with(Writer::flush)
    }

    /// Ends the file with its summary.
    pub fn finish(mut self) -> Result<W, Error> {
        self.with(|writer| writer.finish().map(drop))?;
        let mut to = self.writer.take().ok_or_else(gone)?.into_inner();
        to.flush()?;
        Ok(to)
    }

    fn with<T>(&mut self, act: impl FnOnce(&mut Writer<W>) -> Result<T, McapError>) -> Result<T, Error> {
        let done = act(self.writer.as_mut().ok_or_else(gone)?);
        done.map_err(|fault| {
            // the crate's writer would write the summary on drop
            self.writer.take().map(Writer::into_inner);
            error(fault)
        })
    }
}

/// Whether a channel cannot be defined because a file has no more numbers for channels or schemas.
pub(super) fn is_too_many(error: &Error) -> bool {
    error.get_ref().is_some_and(|cause| cause.is::<TooMany>())
}

fn gone() -> Error {
    Error::other("an earlier write failed")
}

fn error(error: McapError) -> Error {
    match error {
        McapError::Io(error) => error,
        other => Error::other(other),
    }
}

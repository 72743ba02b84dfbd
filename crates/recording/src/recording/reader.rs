//! A reader of MCAP files, entry by entry, in bounded memory whatever the file's length fields say.
//!
//! The mcap crate frames and parses the records. This file gives its errors their place, unpacks a chunk only
//! as a whole and with the right checksum, and sets limits: a record, or a chunk's contents, has at most 32
//! MiB; all definitions have at most 16 MiB; all chunks together unpack to at most 100 times the bytes of the
//! file so far and 1 MiB.

use super::ReadError;
use super::records::{Attachment, has_its_fields, record_name};
use super::schema::{Definition, SchemaText};
use cocarry::located;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, parse_record};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;

/// The length of the longest record, and of the longest unpacked chunk, bytes. A simulated second takes 0.1
/// MB.
const MAX_BYTES: u64 = 32 << 20;
/// The largest total length of all definitions of channels, bytes.
const DEFINITIONS: usize = 16 << 20;
/// The largest length of all unpacked chunks: bytes for each byte of the file so far, and further bytes.
/// Recordings unpack to 3 to 4 times their length.
const EXPANSION: (u64, u64) = (100, 1 << 20);
/// The number of bytes that are read from the file at once.
const PIECE: usize = 64 << 10;
/// The bytes before a record's contents: its opcode and its length.
const HEAD: usize = 9;

/// An entry of a file.
#[derive(Debug)]
pub enum Entry<'r> {
    /// A metadata record.
    Metadata {
        /// Its name.
        name: String,
        /// Its keys and values.
        entries: BTreeMap<String, String>,
    },
    /// An attachment.
    Attachment(Attachment),
    /// The definition of a channel.
    Channel {
        /// Its number in this file.
        id: u16,
        /// The channel.
        definition: &'r Definition,
    },
    /// A message.
    Message(Recorded<'r>),
}

/// A message in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorded<'r> {
    /// The number of its channel in this file.
    pub id: u16,
    /// Its channel.
    pub channel: &'r Definition,
    /// The offset in the file of its chunk, or of itself if it is in no chunk, bytes.
    pub chunk: u64,
    /// Time, ns.
    pub time: u64,
    /// The data, in the channel's encoding.
    pub data: &'r [u8],
}

impl<'r> Entry<'r> {
    /// The message; `None` for other entries.
    pub fn message(self) -> Option<Recorded<'r>> {
        match self {
            Self::Message(message) => Some(message),
            _ => None,
        }
    }
}

/// A reader of a file from its beginning to its end.
pub struct Reader<R> {
    name: String,
    input: R,
    records: LinearReader,
    /// Bytes read so far.
    read: u64,
    /// The offset of the record that is read next, and whether the last one was the footer.
    offset: u64,
    is_behind_footer: bool,
    block: Block,
    /// Bytes of all chunks so far, unpacked.
    unpacked: u64,
    schemas: BTreeMap<u16, SchemaText>,
    channels: BTreeMap<u16, Definition>,
    definitions: usize,
    stage: Stage,
}

/// Records in memory: those of a chunk, or a single one.
#[derive(Default)]
struct Block {
    /// Its offset in the file.
    offset: u64,
    is_chunk: bool,
    bytes: Vec<u8>,
    /// The number of bytes that were parsed.
    parsed: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Data,
    /// It repeats earlier records.
    Summary,
    Over,
}

/// An entry that was parsed, without borrowing from the reader.
enum FoundRecord {
    Metadata(String, BTreeMap<String, String>),
    Attachment(Attachment),
    Channel(u16),
    /// The number of the channel, the time, and the length of the data, which end the parsed part of the
    /// block.
    Message(u16, u64, usize),
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`ReadError`]: it cannot be read, or is not an MCAP file.
    pub fn open(file: &Path) -> Result<Self, ReadError> {
        let name = file.display().to_string();
        match located::open(file) {
            Ok(opened) => Self::new(BufReader::new(opened), &name),
            Err(source) => Err(ReadError::Read { file: name, source }),
        }
    }
}

impl<R: Read> Reader<R> {
    /// A reader at the beginning of a file. Errors call the file `name`.
    ///
    /// # Errors
    /// [`ReadError`]: it cannot be read, or is not an MCAP file.
    pub fn new(input: R, name: &str) -> Result<Self, ReadError> {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(MAX_BYTES as usize)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true);
        let mut reader = Self {
            name: name.to_owned(),
            input,
            records: LinearReader::new_with_options(options),
            read: 0,
            offset: MAGIC.len() as u64,
            is_behind_footer: false,
            block: Block::default(),
            unpacked: 0,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            definitions: 0,
            stage: Stage::Data,
        };
        let mut first = Vec::new();
        let read = reader.input.by_ref().take(MAGIC.len() as u64).read_to_end(&mut first);
        reader.read = read.map_err(|source| ReadError::Read { file: name.to_owned(), source })? as u64;
        if first.is_empty() || !MAGIC.starts_with(&first) {
            return Err(ReadError::NotMcap { file: reader.name });
        }
        if first.len() < MAGIC.len() {
            return Err(reader.cut());
        }
        reader.records.insert(first.len()).copy_from_slice(&first);
        reader.records.notify_read(first.len());
        Ok(reader)
    }

    /// The name of the file in errors.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The next entry; `None` at the end. After an error for which [`ReadError::is_local`], reading may go on
    /// behind it.
    ///
    /// # Errors
    /// [`ReadError`], which names the file, the place and the expected value.
    #[allow(clippy::should_implement_trait, reason = "entries borrow from the reader")]
    pub fn next(&mut self) -> Result<Option<Entry<'_>>, ReadError> {
        let found = loop {
            if self.block.parsed < self.block.bytes.len() {
                if let Some(found) = self.next_in_block()? {
                    break found;
                }
            } else if !self.next_block()? {
                return Ok(None);
            }
        };
        Ok(match found {
            FoundRecord::Metadata(name, entries) => Some(Entry::Metadata { name, entries }),
            FoundRecord::Attachment(attachment) => Some(Entry::Attachment(attachment)),
            FoundRecord::Channel(id) => {
                self.channels.get(&id).map(|definition| Entry::Channel { id, definition })
            }
            FoundRecord::Message(id, time, length) => {
                let Block { offset: chunk, bytes, parsed, .. } = &self.block;
                let data = &bytes[parsed - length..*parsed];
                let channel = self.channels.get(&id);
                channel.map(|channel| Entry::Message(Recorded { id, channel, chunk: *chunk, time, data }))
            }
        })
    }

    /// Reads the next chunk or single record that has entries into the block; `false` at the end.
    fn next_block(&mut self) -> Result<bool, ReadError> {
        while self.stage != Stage::Over {
            match self.records.next_event() {
                None => self.stage = Stage::Over,
                Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                    let read = match self.input.read(self.records.insert(count.min(PIECE))) {
                        Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                        read => read,
                    };
                    let read = read.map_err(|source| ReadError::Read { file: self.name.clone(), source })?;
                    self.records.notify_read(read);
                    self.read += read as u64;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    let offset = self.offset;
                    self.offset += (HEAD + data.len()) as u64;
                    self.is_behind_footer = opcode == op::FOOTER;
                    self.block = Block { offset, parsed: 0, ..std::mem::take(&mut self.block) };
                    self.block.bytes.clear();
                    match opcode {
                        op::DATA_END => self.stage = Stage::Summary,
                        _ if self.stage == Stage::Summary => {}
                        op::CHUNK => {
                            let allowed = EXPANSION.0.saturating_mul(self.offset).saturating_add(EXPANSION.1);
                            self.block.is_chunk = true;
                            let left = allowed.saturating_sub(self.unpacked);
                            let unpacked = unpack(data, left, &self.name, offset)?;
                            self.unpacked += unpacked.len() as u64;
                            self.block.bytes = unpacked;
                            return Ok(true);
                        }
                        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT | op::METADATA => {
                            self.block.is_chunk = false;
                            self.block.bytes.push(opcode);
                            self.block.bytes.extend((data.len() as u64).to_le_bytes());
                            self.block.bytes.extend(data);
                            return Ok(true);
                        }
                        _ => {}
                    }
                }
                // the crate's reader does not go on after an error
                Some(Err(error)) => {
                    self.stage = Stage::Over;
                    return Err(self.framing(&error));
                }
            }
        }
        Ok(false)
    }

    /// Parses the next record of the block; `None` if it is not an entry.
    fn next_in_block(&mut self) -> Result<Option<FoundRecord>, ReadError> {
        let begin = self.block.parsed;
        let framed = self.block.bytes[begin..].split_at_checked(HEAD).and_then(|(head, rest)| {
            let length = u64::from_le_bytes(head[1..].try_into().ok()?);
            Some((head[0], rest.get(..usize::try_from(length).ok()?)?.len()))
        });
        let Some((opcode, length)) = framed else {
            self.block.parsed = self.block.bytes.len();
            let why = format!("{begin} bytes into it, a record is longer than the rest of it");
            return Err(self.damaged(op::CHUNK, why));
        };
        self.block.parsed += HEAD + length;
        let bytes = std::mem::take(&mut self.block.bytes);
        let found = self.parse(opcode, &bytes[begin + HEAD..self.block.parsed]);
        self.block.bytes = bytes;
        found
    }

    fn parse(&mut self, opcode: u8, body: &[u8]) -> Result<Option<FoundRecord>, ReadError> {
        if self.block.is_chunk && !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            let why = "it is in a chunk, where only schemas, channels and messages may be";
            return Err(self.damaged(opcode, why.to_owned()));
        }
        if !has_its_fields(opcode, body) {
            return Err(self.damaged(opcode, SHORT.to_owned()));
        }
        let record = parse_record(opcode, body).map_err(|error| self.damaged(opcode, words(&error)))?;
        Ok(match record {
            Record::Schema { header, data } => {
                self.keep(opcode, header.name.len() + header.encoding.len() + data.len())?;
                let (name, encoding, data) = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, SchemaText { name, encoding, data });
                None
            }
            Record::Channel(channel) => {
                let (id, topic) = (channel.schema_id, channel.topic);
                let schema = self.schemas.get(&id).filter(|_| id != 0).cloned();
                if id != 0 && schema.is_none() {
                    let why = format!("channel `{topic}` is of schema {id}, which was not defined before it");
                    return Err(self.damaged(opcode, why));
                }
                self.keep(opcode, body.len() + schema.as_ref().map_or(0, |schema| schema.data.len()))?;
                let (encoding, metadata) = (channel.message_encoding, channel.metadata);
                self.channels.insert(channel.id, Definition { topic, encoding, schema, metadata });
                Some(FoundRecord::Channel(channel.id))
            }
            Record::Message { header, data } => {
                let id = header.channel_id;
                if !self.channels.contains_key(&id) {
                    let why = format!("it is on channel {id}, which was not defined before it");
                    return Err(self.damaged(opcode, why));
                }
                Some(FoundRecord::Message(id, header.log_time, data.len()))
            }
            Record::Metadata(metadata) => Some(FoundRecord::Metadata(metadata.name, metadata.metadata)),
            Record::Attachment { header, data, .. } => {
                let (name, media_type, data) = (header.name, header.media_type, data.into_owned());
                Some(FoundRecord::Attachment(Attachment { name, media_type, data }))
            }
            _ => None,
        })
    }

    /// The check that the definitions stay within their limit.
    fn keep(&mut self, opcode: u8, length: usize) -> Result<(), ReadError> {
        self.definitions += length;
        if self.definitions > DEFINITIONS {
            return Err(ReadError::TooLong {
                file: self.name.clone(),
                offset: self.block.offset,
                what: if opcode == op::SCHEMA { "all schemas up to that" } else { "all channels up to that" },
                length: self.definitions as u64,
                limit: DEFINITIONS as u64,
            });
        }
        Ok(())
    }

    /// An error of the crate's reader, with its place.
    fn framing(&self, error: &McapError) -> ReadError {
        let (file, offset) = (self.name.clone(), self.offset);
        let (opcode, why) = match error {
            McapError::UnexpectedEof => return self.cut(),
            McapError::RecordTooLarge { opcode, len } => {
                let what = record_name(*opcode);
                return ReadError::TooLong { file, offset, what, length: *len, limit: MAX_BYTES };
            }
            McapError::BadMagic | McapError::BytesAfterEndMagic => {
                let why = "the last record must be followed by the bytes that the file begins with, and nothing else";
                (op::FOOTER, why.to_owned())
            }
            McapError::BadDataCrc { .. } => (op::DATA_END, format!("the data: {}", words(error))),
            McapError::BadSummaryCrc { .. } => (op::FOOTER, format!("the summary: {}", words(error))),
            other => (0, words(other)),
        };
        ReadError::Damaged { file, offset, what: record_name(opcode), why }
    }

    fn cut(&self) -> ReadError {
        let what = match self.is_behind_footer {
            true => "the last bytes".to_owned(),
            false => format!("the record that begins at byte {}", self.offset.min(self.read)),
        };
        ReadError::Cut { file: self.name.clone(), offset: self.read, what }
    }

    /// The error of a record in the block.
    fn damaged(&self, opcode: u8, why: String) -> ReadError {
        let (file, offset) = (self.name.clone(), self.block.offset);
        ReadError::Damaged { file, offset, what: record_name(opcode), why }
    }
}

/// The records of a chunk with at most `allowed` bytes.
fn unpack(body: &[u8], allowed: u64, file: &str, offset: u64) -> Result<Vec<u8>, ReadError> {
    let damaged =
        |why| ReadError::Damaged { file: file.to_owned(), offset, what: record_name(op::CHUNK), why };
    if !has_its_fields(op::CHUNK, body) {
        return Err(damaged(SHORT.to_owned()));
    }
    let (header, packed) = match parse_record(op::CHUNK, body) {
        Ok(Record::Chunk { header, data }) => (header, data),
        Ok(_) => return Err(damaged(SHORT.to_owned())),
        Err(error) => return Err(damaged(words(&error))),
    };
    let size = header.uncompressed_size;
    let too_long =
        |what, limit| Err(ReadError::TooLong { file: file.to_owned(), offset, what, length: size, limit });
    if size > MAX_BYTES {
        return too_long("the contents of a chunk", MAX_BYTES);
    }
    if size > allowed {
        return too_long("the contents of a chunk, with all chunks before it in so short a file,", allowed);
    }
    let unpacked = match &*header.compression {
        "" => packed.into_owned(),
        "zstd" => zstd::bulk::decompress(&packed, size as usize)
            .map_err(|error| damaged(format!("it cannot be unpacked: {error}")))?,
        other => {
            let other = other.escape_debug();
            return Err(damaged(format!("its compression is `{other}`; only zstd and none are read")));
        }
    };
    if unpacked.len() as u64 != size {
        return Err(damaged(format!(
            "it has {} bytes; according to its header it should be {size}",
            unpacked.len()
        )));
    }
    let (saved, calculated) = (header.uncompressed_crc, crc32fast::hash(&unpacked));
    if saved != 0 && saved != calculated {
        return Err(damaged(words(&McapError::BadChunkCrc { saved, calculated })));
    }
    Ok(unpacked)
}

const SHORT: &str = "its fields exceed its length, or are not UTF-8";

/// What is wrong with a record.
fn words(error: &McapError) -> String {
    match error {
        McapError::BadChunkCrc { saved, calculated }
        | McapError::BadDataCrc { saved, calculated }
        | McapError::BadSummaryCrc { saved, calculated }
        | McapError::BadAttachmentCrc { saved, calculated } => {
            format!("its checksum is {calculated:08x}; according to the file it should be {saved:08x}")
        }
        // the crate names offsets within the record
        _ => SHORT.to_owned(),
    }
}

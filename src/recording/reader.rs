//! A reader of MCAP files, entry by entry, in bounded memory whatever the file's length fields say.
//!
//! The mcap crate is not used, because its errors do not name the offset of a fault, and length fields do not
//! limit its allocations.

use super::fields::Fields;
use super::records::{
    DEFINITIONS, LONGEST, MAGIC, attachment, chunk_fields, message_header, op, record_name,
};
use super::schema::{Definition, SchemaText};
use super::{Attachment, ReadError};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

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
    /// Bytes read so far.
    offset: u64,
    record: Vec<u8>,
    /// The present chunk, unpacked: its offset in the file, its bytes, and the number of bytes read.
    chunk_offset: u64,
    chunk: Vec<u8>,
    read: usize,
    schemas: BTreeMap<u16, SchemaText>,
    channels: BTreeMap<u16, Definition>,
    definitions: usize,
    /// The checksum of the data, then of the summary; the file has both.
    checksum: crc32fast::Hasher,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Data,
    Summary,
    Over,
}

/// The kind of a record that was read, without borrowing from the reader.
enum Found {
    Metadata(String, BTreeMap<String, String>),
    Attachment(Attachment),
    Channel(u16),
    /// The number of the channel, the time, and the offset of the message's data in the record.
    Message(u16, u64, usize),
    /// A record that is no entry.
    Nothing,
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`ReadError`]: it cannot be read, or is no MCAP file.
    pub fn open(file: &Path) -> Result<Self, ReadError> {
        let name = file.display().to_string();
        match File::open(file) {
            Ok(opened) => Self::new(BufReader::new(opened), &name),
            Err(source) => Err(ReadError::Read { file: name, source }),
        }
    }
}

impl<R: Read> Reader<R> {
    /// A reader at the beginning of a file. Errors call the file `name`.
    ///
    /// # Errors
    /// [`ReadError`]: it cannot be read, or is no MCAP file.
    pub fn new(input: R, name: &str) -> Result<Self, ReadError> {
        let mut reader = Self {
            name: name.to_owned(),
            input,
            offset: 0,
            record: Vec::new(),
            chunk_offset: 0,
            chunk: Vec::new(),
            read: 0,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            definitions: 0,
            checksum: crc32fast::Hasher::new(),
            stage: Stage::Data,
        };
        let count = reader.fill(MAGIC.len() as u64)?;
        if reader.record != MAGIC[..count] || count == 0 {
            return Err(ReadError::NotMcap { file: reader.name });
        }
        if count < MAGIC.len() {
            return Err(reader.cut("the first bytes"));
        }
        reader.checksum.update(&MAGIC);
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
        let Some((found, in_chunk)) = self.advance()? else { return Ok(None) };
        Ok(match found {
            Found::Metadata(name, entries) => Some(Entry::Metadata { name, entries }),
            Found::Attachment(attachment) => Some(Entry::Attachment(attachment)),
            Found::Channel(id) => self.channels.get(&id).map(|definition| Entry::Channel { id, definition }),
            Found::Message(id, time, begin) => {
                let data = if in_chunk { &self.chunk[begin..self.read] } else { &self.record[begin..] };
                let chunk = if in_chunk { self.chunk_offset } else { self.offset - begin as u64 };
                let channel = self.channels.get(&id);
                channel.map(|channel| Entry::Message(Recorded { id, channel, chunk, time, data }))
            }
            Found::Nothing => None,
        })
    }

    /// Reads up to the next entry. Returns it, and whether it is in a chunk; `None` at the end.
    fn advance(&mut self) -> Result<Option<(Found, bool)>, ReadError> {
        loop {
            let in_chunk = self.read < self.chunk.len();
            let found = match (in_chunk, self.stage) {
                (true, _) => self.next_in_chunk()?,
                (false, Stage::Over) => return Ok(None),
                (false, _) => self.next_in_file()?,
            };
            if !matches!(found, Found::Nothing) {
                return Ok(Some((found, in_chunk)));
            }
        }
    }

    fn next_in_chunk(&mut self) -> Result<Found, ReadError> {
        let begin = self.read;
        let offset = self.chunk_offset;
        let mut fields = Fields(&self.chunk[begin..]);
        let framed = fields.byte().zip(fields.long_block());
        let Some((opcode, body)) = framed else {
            self.read = self.chunk.len();
            let why = format!("{begin} bytes into it, a record is longer than what is left of it");
            return Err(self.damaged(op::CHUNK, offset, why));
        };
        let start = begin + 9;
        self.read = start + body.len();
        let chunk = std::mem::take(&mut self.chunk);
        let found = self.parse(opcode, offset, &chunk[start..self.read], start);
        self.chunk = chunk;
        found
    }

    fn next_in_file(&mut self) -> Result<Found, ReadError> {
        let offset = self.offset;
        let count = self.fill(9)?;
        if count < 9 {
            return Err(self.cut(if count == 0 { "front of a record" } else { "a record" }));
        }
        let mut fields = Fields(&self.record);
        let (Some(opcode), Some(length)) = (fields.byte(), fields.u64()) else {
            return Err(self.cut("a record"));
        };
        let head = self.record.clone();
        let what = record_name(opcode);
        if length > LONGEST {
            return Err(ReadError::TooLong { file: self.name.clone(), offset, what, length, limit: LONGEST });
        }
        if (self.fill(length)? as u64) < length {
            return Err(self.cut(what));
        }
        let record = std::mem::take(&mut self.record);
        let found = self.in_file(opcode, offset, &head, &record);
        self.record = record;
        found
    }

    /// Reads a record outside chunks: one that is only allowed there, or one that may be in a chunk too.
    fn in_file(&mut self, opcode: u8, offset: u64, head: &[u8], body: &[u8]) -> Result<Found, ReadError> {
        match opcode {
            op::DATA_END => {
                let checksum = std::mem::take(&mut self.checksum).finalize();
                self.stage = Stage::Summary;
                let saved = Fields(body).u32().ok_or_else(|| self.short(opcode, offset))?;
                self.check("the data's", opcode, offset, saved, checksum).map(|()| Found::Nothing)
            }
            op::FOOTER => {
                self.checksum.update(head);
                self.checksum.update(body.get(..16).ok_or_else(|| self.short(opcode, offset))?);
                let checksum = std::mem::take(&mut self.checksum).finalize();
                let saved = Fields(&body[16..]).u32().ok_or_else(|| self.short(opcode, offset))?;
                self.stage = Stage::Over;
                self.check("the summary's", opcode, offset, saved, checksum)?;
                if self.fill(MAGIC.len() as u64)? < MAGIC.len() {
                    return Err(self.cut("the last bytes"));
                }
                if self.record != MAGIC || self.fill(1)? > 0 {
                    let why = "it must be followed by the bytes that the file begins with, and nothing else";
                    return Err(self.damaged(opcode, offset, why.to_owned()));
                }
                Ok(Found::Nothing)
            }
            // the summary repeats earlier records
            _ if self.stage == Stage::Summary => {
                self.checksum.update(head);
                self.checksum.update(body);
                Ok(Found::Nothing)
            }
            _ => {
                self.checksum.update(head);
                self.checksum.update(body);
                match opcode {
                    op::CHUNK => self.unpack(offset, body).map(|()| Found::Nothing),
                    _ => self.parse(opcode, offset, body, 0),
                }
            }
        }
    }

    fn check(&self, what: &str, op: u8, offset: u64, saved: u32, checksum: u32) -> Result<(), ReadError> {
        if saved == 0 || saved == checksum {
            return Ok(());
        }
        let why =
            format!("{what} checksum is {checksum:08x}; according to the file it should be {saved:08x}");
        Err(self.damaged(op, offset, why))
    }

    fn unpack(&mut self, offset: u64, body: &[u8]) -> Result<(), ReadError> {
        let mut fields = Fields(body);
        let Some((size, checksum, compression, packed)) = chunk_fields(&mut fields) else {
            return Err(self.short(op::CHUNK, offset));
        };
        if size > LONGEST {
            return Err(ReadError::TooLong {
                file: self.name.clone(),
                offset,
                what: "the contents of a chunk",
                length: size,
                limit: LONGEST,
            });
        }
        let unpacked = match compression {
            "" => packed.to_vec(),
            "zstd" => zstd::bulk::decompress(packed, size as usize)
                .map_err(|e| self.damaged(op::CHUNK, offset, format!("it cannot be unpacked: {e}")))?,
            other => {
                let why = format!("its compression is `{other}`; only zstd and none are read");
                return Err(self.damaged(op::CHUNK, offset, why));
            }
        };
        if unpacked.len() as u64 != size {
            let why = format!("it has {} bytes; according to its header it should be {size}", unpacked.len());
            return Err(self.damaged(op::CHUNK, offset, why));
        }
        self.check("its", op::CHUNK, offset, checksum, crc32fast::hash(&unpacked))?;
        (self.chunk, self.read, self.chunk_offset) = (unpacked, 0, offset);
        Ok(())
    }

    /// Reads a record that may be in a chunk. `begin` is its offset in the chunk or in the file.
    fn parse(&mut self, opcode: u8, offset: u64, body: &[u8], begin: usize) -> Result<Found, ReadError> {
        let mut fields = Fields(body);
        let found = match opcode {
            op::SCHEMA => self.define_schema(&mut fields, offset)?,
            op::CHANNEL => self.define_channel(&mut fields, offset)?,
            op::MESSAGE => {
                let header = message_header(&mut fields);
                if let Some((id, _)) = header
                    && !self.channels.contains_key(&id)
                {
                    let why = format!("it is on channel {id}, which was not defined before it");
                    return Err(self.damaged(opcode, offset, why));
                }
                header.map(|(id, time)| Found::Message(id, time, begin + body.len() - fields.0.len()))
            }
            op::METADATA => {
                let name = fields.text();
                name.zip(fields.map()).map(|(name, entries)| Found::Metadata(name.to_owned(), entries))
            }
            op::ATTACHMENT => {
                let found = attachment(&mut fields);
                let checksum = crc32fast::hash(&body[..body.len() - fields.0.len()]);
                if let Some(saved) = fields.u32() {
                    self.check("its", opcode, offset, saved, checksum)?;
                }
                found.map(Found::Attachment)
            }
            _ => Some(Found::Nothing),
        };
        found.ok_or_else(|| self.short(opcode, offset))
    }

    fn define_schema(&mut self, fields: &mut Fields, offset: u64) -> Result<Option<Found>, ReadError> {
        let mut read = || Some((fields.u16()?, fields.text()?, fields.text()?, fields.block()?));
        let Some((id, name, encoding, data)) = read() else { return Ok(None) };
        self.keep(op::SCHEMA, offset, name.len() + encoding.len() + data.len())?;
        let schema =
            SchemaText { name: name.to_owned(), encoding: encoding.to_owned(), data: data.to_owned() };
        self.schemas.insert(id, schema);
        Ok(Some(Found::Nothing))
    }

    fn define_channel(&mut self, fields: &mut Fields, offset: u64) -> Result<Option<Found>, ReadError> {
        let length = fields.0.len();
        let mut read = || Some((fields.u16()?, fields.u16()?, fields.text()?, fields.text()?, fields.map()?));
        let Some((id, schema, topic, encoding, metadata)) = read() else { return Ok(None) };
        if schema != 0 && !self.schemas.contains_key(&schema) {
            let why = format!("channel `{topic}` is of schema {schema}, which was not defined before it");
            return Err(self.damaged(op::CHANNEL, offset, why));
        }
        let schema = self.schemas.get(&schema).cloned();
        self.keep(op::CHANNEL, offset, length + schema.as_ref().map_or(0, |s| s.data.len()))?;
        let (topic, encoding) = (topic.to_owned(), encoding.to_owned());
        self.channels.insert(id, Definition { topic, encoding, schema, metadata });
        Ok(Some(Found::Channel(id)))
    }

    /// The check that the definitions stay within their limit.
    fn keep(&mut self, opcode: u8, offset: u64, length: usize) -> Result<(), ReadError> {
        self.definitions += length;
        if self.definitions > DEFINITIONS {
            return Err(ReadError::TooLong {
                file: self.name.clone(),
                offset,
                what: if opcode == op::SCHEMA { "all schemas up to that" } else { "all channels up to that" },
                length: self.definitions as u64,
                limit: DEFINITIONS as u64,
            });
        }
        Ok(())
    }

    /// Reads a number of bytes, or fewer at the end of the file. Returns how many. Memory grows with the
    /// bytes that exist, not with those requested.
    fn fill(&mut self, count: u64) -> Result<usize, ReadError> {
        self.record.clear();
        let read = self.input.by_ref().take(count).read_to_end(&mut self.record);
        let read = read.map_err(|source| ReadError::Read { file: self.name.clone(), source })?;
        self.offset += read as u64;
        Ok(read)
    }

    fn cut(&self, what: &'static str) -> ReadError {
        ReadError::Cut { file: self.name.clone(), offset: self.offset, what }
    }

    fn damaged(&self, opcode: u8, offset: u64, why: String) -> ReadError {
        ReadError::Damaged { file: self.name.clone(), offset, what: record_name(opcode), why }
    }

    fn short(&self, opcode: u8, offset: u64) -> ReadError {
        self.damaged(opcode, offset, "its fields exceed its length, or are not UTF-8".to_owned())
    }
}

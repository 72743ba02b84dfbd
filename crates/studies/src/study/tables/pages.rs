//! The bounds of a Parquet file, checked before the library reads it. The library allocates what a page's
//! header claims, and repeats a value as often as an encoding says.

use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ParquetMetaData;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// The length of the longest description of a file, at its end, bytes. A row group of a study's rows takes
/// 20 kB.
const MAX_DESCRIPTION: u64 = 8 << 20;
/// The length of the longest page, unpacked, bytes. Writers begin another page after 1 MiB.
const MAX_PAGE: u64 = 16 << 20;
/// The largest total length of the largest page and the dictionary of all columns, unpacked, bytes.
const MAX_IN_MEMORY: u64 = 512 << 20;
/// The largest number of values of a page.
const MAX_VALUES: u64 = 1 << 20;
/// The encoding in which a value may be the beginning of the one before it, however long that is.
const DELTA_BYTE_ARRAY: i32 = 7;
/// The kind of a page that is a dictionary.
const DICTIONARY: i32 = 2;
/// The number of bytes in which a page's header is searched for at first, and at most.
const WINDOWS: [usize; 2] = [4 << 10, 1 << 20];

fn refused<T>(why: String) -> Result<T> {
    Err(ParquetError::General(why))
}

fn bounded(found: u64, limit: u64, what: &str) -> Result<()> {
    if found <= limit { Ok(()) } else { refused(format!("{what} = {found}; it must be at most {limit}")) }
}

/// The check of the length of a file's description.
pub(super) fn check_description(mut file: &File) -> Result<()> {
    let mut length = [0; 4];
    // a shorter file is no Parquet, as the library says
    if file.seek(SeekFrom::End(-8)).is_ok() {
        file.read_exact(&mut length)?;
    }
    bounded(u32::from_le_bytes(length).into(), MAX_DESCRIPTION, "length of the file's description")
}

/// The check of all pages of a file.
pub(super) fn check_pages(file: &File, metadata: &ParquetMetaData) -> Result<()> {
    let length = file.metadata()?.len();
    for group in metadata.row_groups() {
        let mut in_memory = 0;
        for column in group.columns() {
            let (begin, size) = column.byte_range();
            let end = begin.checked_add(size).filter(|end| *end <= length);
            let Some(end) = end else { return refused("a column exceeds the file".to_owned()) };
            in_memory += largest_pages(file, begin, end)?;
            bounded(in_memory, MAX_IN_MEMORY, "total length of the largest page of each column")?;
        }
    }
    Ok(())
}

/// The unpacked length of the largest page and the dictionary of a column that is at these bytes.
fn largest_pages(file: &File, begin: u64, end: u64) -> Result<u64> {
    let (mut at, mut largest, mut dictionary) = (begin, 0, 0);
    while at < end {
        let (header, length) = page_header(file, at, end)?;
        let [unpacked, packed] = header.lengths().ok_or(malformed())?;
        bounded(unpacked, MAX_PAGE, "length of a page")?;
        bounded(header.values.into(), MAX_VALUES, "number of values of a page")?;
        if header.is_delta {
            return refused("a page has the encoding DELTA_BYTE_ARRAY, which is not read".to_owned());
        }
        at += length;
        bounded(packed, end - at.min(end), "length of a page, packed,")?;
        at += packed;
        let of_kind = if header.kind == DICTIONARY { &mut dictionary } else { &mut largest };
        *of_kind = unpacked.max(*of_kind);
    }
    Ok(largest + dictionary)
}

fn malformed() -> ParquetError {
    ParquetError::General("a page has no valid header".to_owned())
}

/// The header of the page at a byte, and its length.
fn page_header(mut file: &File, at: u64, end: u64) -> Result<(PageHeader, u64)> {
    for window in WINDOWS {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(at))?;
        file.take((end - at).min(window as u64)).read_to_end(&mut bytes)?;
        let mut thrift = Thrift { rest: &bytes };
        if let Some(header) = PageHeader::read(&mut thrift) {
            return Ok((header, (bytes.len() - thrift.rest.len()) as u64));
        }
    }
    Err(malformed())
}

/// What a page's header claims; of several parts, the largest number of values.
#[derive(Debug, Default, PartialEq, Eq)]
struct PageHeader {
    kind: i32,
    unpacked: i32,
    packed: i32,
    values: u32,
    /// Whether a part has the encoding that is not read.
    is_delta: bool,
}

impl PageHeader {
    /// Reads a header as the library does: numbers where it expects them, whatever type a field claims.
    fn read(thrift: &mut Thrift) -> Option<Self> {
        let mut header = Self::default();
        thrift.fields(0, &mut |thrift, id| {
            match id {
                1 => header.kind = thrift.number()?,
                2 => header.unpacked = thrift.number()?,
                3 => header.packed = thrift.number()?,
                4 => drop(thrift.number()?),
                // of a data page, of an index, of a dictionary, of a data page of version 2
                5..=8 => {
                    let (numbers, encoding) = [(4, 2), (0, 0), (2, 2), (6, 4)][id as usize - 5];
                    thrift.fields(1, &mut |thrift, id| {
                        if !(1..=numbers).contains(&id) {
                            return Some(false);
                        }
                        let number = thrift.number()?;
                        if id == 1 {
                            header.values = header.values.max(u32::try_from(number).ok()?);
                        }
                        header.is_delta |= id == encoding && number == DELTA_BYTE_ARRAY;
                        Some(true)
                    })?;
                }
                _ => return Some(false),
            }
            Some(true)
        })?;
        Some(header)
    }

    /// The unpacked and the packed length; `None` if one is negative.
    fn lengths(&self) -> Option<[u64; 2]> {
        Some([u64::try_from(self.unpacked).ok()?, u64::try_from(self.packed).ok()?])
    }
}

/// The largest depth of a header's parts.
const MAX_DEPTH: usize = 8;

/// A reader of Thrift's compact protocol.
struct Thrift<'a> {
    rest: &'a [u8],
}

impl Thrift<'_> {
    fn byte(&mut self) -> Option<u8> {
        self.rest.split_off_first().copied()
    }

    fn bytes(&mut self, count: u64) -> Option<()> {
        self.rest = self.rest.get(usize::try_from(count).ok()?..)?;
        Some(())
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..70).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn number(&mut self) -> Option<i32> {
        let value = self.varint()?;
        Some((value >> 1) as i32 ^ -((value & 1) as i32))
    }

    /// Calls `act` with the number of every field of a structure. Fields that it does not read are passed
    /// over.
    fn fields(&mut self, depth: usize, act: &mut dyn FnMut(&mut Self, i16) -> Option<bool>) -> Option<()> {
        let mut id = 0_i16;
        loop {
            let head = self.byte()?;
            if head & 0x0f == 0 {
                return Some(());
            }
            id = match head >> 4 {
                0 => self.number()? as i16,
                more => id.checked_add(more.into())?,
            };
            if !act(self, id)? {
                self.pass(head & 0x0f, depth)?;
            }
        }
    }

    /// Passes over a value of a type.
    fn pass(&mut self, kind: u8, depth: usize) -> Option<()> {
        if depth == MAX_DEPTH {
            return None;
        }
        match kind {
            // a flag of a field is in its type
            1 | 2 => Some(()),
            3 => self.bytes(1),
            4..=6 => self.varint().map(drop),
            7 => self.bytes(8),
            8 => self.varint().and_then(|length| self.bytes(length)),
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                (0..count).try_for_each(|_| self.pass_item(head & 0x0f, depth))
            }
            11 => {
                let count = self.varint()?;
                let kinds = if count == 0 { 0 } else { self.byte()? };
                (0..count).try_for_each(|_| {
                    self.pass_item(kinds >> 4, depth)?;
                    self.pass_item(kinds & 0x0f, depth)
                })
            }
            12 => self.fields(depth + 1, &mut |_, _| Some(false)),
            _ => None,
        }
    }

    /// Passes over an item of a list, of which a flag is a byte.
    fn pass_item(&mut self, kind: u8, depth: usize) -> Option<()> {
        if matches!(kind, 1 | 2) { self.bytes(1) } else { self.pass(kind, depth + 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of a data page: kind 0, 100 bytes unpacked, 40 packed, 7 values, dictionary-encoded.
    const HEADER: [u8; 15] = [0x15, 0, 0x15, 0xc8, 1, 0x15, 80, 0x2c, 0x15, 14, 0x15, 16, 0, 0, 0xff];

    #[test]
    fn closed_form_the_header_of_a_page() {
        let mut thrift = Thrift { rest: &HEADER };
        let header = PageHeader::read(&mut thrift).expect("a header");
        assert_eq!(header, PageHeader { kind: 0, unpacked: 100, packed: 40, values: 7, is_delta: false });
        assert_eq!(thrift.rest, [0xff]);
        // unknown fields of every type before it: a flag, a list of flags, a map, a text, a structure
        let unknown: &[u8] = &[
            0x01, 40, 0x09, 42, 0x21, 1, 2, 0x0b, 44, 1, 0x85, 1, b'x', 9, 0x08, 46, 2, b'a', b'b', 0x0c, 48,
            0x15, 3, 0, 0x05, 2,
        ];
        let long = [unknown, &HEADER[1..]].concat();
        let mut thrift = Thrift { rest: &long };
        assert_eq!(PageHeader::read(&mut thrift).map(|header| header.packed), Some(40));
    }

    #[test]
    fn what_is_cut_deep_or_endless_is_no_header() {
        for end in 0..HEADER.len() - 1 {
            assert_eq!(PageHeader::read(&mut Thrift { rest: &HEADER[..end] }), None, "{end}");
        }
        let deep = [0xcc; 100];
        assert_eq!(PageHeader::read(&mut Thrift { rest: &deep }), None);
        let endless = [0x99, 0xfc, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01];
        assert_eq!(PageHeader::read(&mut Thrift { rest: &endless }), None);
    }
}

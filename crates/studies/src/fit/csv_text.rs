//! The text of a CSV file of participants, as spreadsheets and statistics programs write it.

use cocarry::Error;
use cocarry::bounds;
use cocarry::located;
use std::io::{Error as SystemError, ErrorKind};
use std::path::Path;

/// What separates cells, the usual one first.
const DELIMITERS: [u8; 3] = [b',', b';', b'\t'];

/// The text of a CSV file, and what separates its cells: a comma, or a semicolon or tab where the header has
/// more of them. Text is UTF-8, or UTF-16 as spreadsheets write it.
///
/// # Errors
/// The file cannot be read, or is in another encoding.
pub fn read_csv_text(path: &Path) -> Result<(String, u8), Error> {
    let text = located::read_with(&bounds::TABLE, path, decoded)?;
    let delimiter = header(&text).map_or(b',', delimiter);
    Ok((text, delimiter))
}

/// The first line that is neither empty nor a comment.
pub(super) fn header(text: &str) -> Option<&str> {
    text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'))
}

fn delimiter(header: &str) -> u8 {
    let count = |delimiter: &u8| header.bytes().filter(|byte| byte == delimiter).count();
    // of equal counts the last one wins: the usual delimiter
    DELIMITERS.into_iter().rev().max_by_key(count).unwrap_or(b',')
}

fn decoded(bytes: Vec<u8>) -> Result<String, SystemError> {
    let units = |read: fn([u8; 2]) -> u16| bytes.chunks_exact(2).map(move |pair| read([pair[0], pair[1]]));
    let (first, second) = (bytes.first().copied(), bytes.get(1).copied());
    let text = match (first, second) {
        // with a byte order mark, or without: the first letter of a header is ASCII
        (Some(0xff), Some(0xfe)) | (Some(1..), Some(0)) => of_utf_16(units(u16::from_le_bytes), bytes.len())?,
        (Some(0xfe), Some(0xff)) | (Some(0), Some(1..)) => of_utf_16(units(u16::from_be_bytes), bytes.len())?,
        _ => String::from_utf8(bytes).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let line = 1 + error.as_bytes()[..valid].iter().filter(|byte| **byte == b'\n').count();
            let sentence = format!(
                "line {line} is not UTF-8, perhaps Latin-1 or Windows-1252; save the file as UTF-8 (in Excel: CSV UTF-8)"
            );
            SystemError::new(ErrorKind::InvalidData, sentence)
        })?,
    };
    Ok(text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned))
}

fn of_utf_16(units: impl Iterator<Item = u16>, bytes: usize) -> Result<String, SystemError> {
    let text: Result<String, _> = char::decode_utf16(units).collect();
    let text = text.ok().filter(|_| bytes.is_multiple_of(2));
    text.ok_or_else(|| SystemError::new(ErrorKind::InvalidData, "not whole UTF-16; save the file as UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_a_spreadsheet_is_read_whatever_its_encoding_and_separator() {
        let text = "participant,world\nM\u{fc}ller,\u{1f3e0}\n";
        let units = || text.encode_utf16();
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        let with = |mark: &[u8], rest: &[u8]| [mark, rest].concat();
        let all = [
            text.as_bytes().to_vec(),
            with(b"\xef\xbb\xbf", text.as_bytes()),
            with(b"\xff\xfe", &little),
            with(b"\xfe\xff", &big),
            little,
            big,
        ];
        for bytes in all {
            assert_eq!(decoded(bytes).unwrap(), text);
        }
        let latin = "# one\nparticipant\nM\u{fc}".chars().map(|c| c as u8).collect();
        assert!(decoded(latin).unwrap_err().to_string().starts_with("line 3 is not UTF-8"));
        assert!(decoded(b"\xff\xfea".to_vec()).is_err());
        for (line, separator) in [("a,b;c,d", b','), ("a;b", b';'), ("a\tb\tc", b'\t'), ("a", b',')] {
            assert_eq!(delimiter(line), separator, "{line}");
        }
    }
}

//! CBOR, of bounded depth: the parser recurses for nested items where a type asks what an item is.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::error::Error;

/// The largest depth of lists, maps and tags. Snapshots have less than 20.
const MAX_DEPTH: usize = 64;

/// A value as CBOR.
///
/// # Errors
/// It cannot be written as CBOR.
pub(crate) fn to_vec<T: Serialize>(value: &T) -> Result<Vec<u8>, Box<dyn Error + Send + Sync>> {
    minicbor_serde::to_vec(value).map_err(|error| error.to_string().into())
}

/// A value from CBOR.
///
/// # Errors
/// It is not CBOR of that type, or nested too deeply.
pub(crate) fn from_slice<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Box<dyn Error + Send + Sync>> {
    if is_deep(bytes) {
        return Err(format!("its values are nested deeper than {MAX_DEPTH}").into());
    }
    minicbor_serde::from_slice(bytes).map_err(|error| error.to_string().into())
}

/// Whether items are nested too deep. Bytes after invalid CBOR, where the parser stops, are not examined.
fn is_deep(bytes: &[u8]) -> bool {
    // the numbers of items that are left in each list; `None` up to a break
    let mut open: Vec<Option<u64>> = Vec::new();
    let mut rest = bytes;
    while let Some((&head, behind)) = rest.split_first() {
        while open.pop_if(|left| *left == Some(0)).is_some() {}
        if let Some(Some(left)) = open.last_mut() {
            *left -= 1;
        }
        let (major, info) = (head >> 5, head & 31);
        let length = match info {
            0..24 | 31 => 0,
            24..28 => 1 << (info - 24),
            _ => return false,
        };
        let Some((number, behind)) = behind.split_at_checked(length) else { return false };
        rest = behind;
        let number = match info {
            0..24 => u64::from(info),
            _ => number.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)),
        };
        let number = (info != 31).then_some(number);
        match (major, number) {
            // a text in pieces ends with a break too
            (2 | 3, None) | (4 | 5, None) => open.push(None),
            (2 | 3, Some(length)) => match usize::try_from(length).ok().and_then(|length| rest.get(length..))
            {
                Some(behind) => rest = behind,
                None => return false,
            },
            (4, count) => open.push(count),
            (5, Some(count)) => open.push(Some(count.saturating_mul(2))),
            (6, _) => open.push(Some(1)),
            (7, None) => drop(open.pop()),
            _ => {}
        }
        if open.len() > MAX_DEPTH {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_depth_of_items() {
        for (begin, end) in [(&[0x81][..], &[0][..]), (&[0x9f], &[0xff]), (&[0xa1, 0], &[0]), (&[0xc1], &[0])]
        {
            for (depth, expected) in [(MAX_DEPTH, false), (MAX_DEPTH + 1, true)] {
                let bytes = [begin.repeat(depth), end.repeat(if end == [0xff] { depth } else { 1 })].concat();
                assert_eq!(is_deep(&bytes), expected, "{begin:x?} {depth}");
            }
        }
        // side by side, in texts, and behind a number as long as a list's head
        let flat = [&[0x98, 200][..], &[0x80; 200]].concat();
        assert!(!is_deep(&flat) && !is_deep(&[&[0x78, 200][..], &[0x81; 200]].concat()));
        assert!(!is_deep(&[0x1b; 1000]) && !is_deep(&[0x5f; 3]) && is_deep(&[0x5f; 100]));
        let pieces = [&[0x7f][..], &[0x61, b'a'].repeat(500), &[0xff]].concat();
        assert!(!is_deep(&pieces.repeat(100)));
        assert!(!is_deep(&[]) && !is_deep(&[0x9e]));
    }
}

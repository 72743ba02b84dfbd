//! The contents of a snapshot in; parsed behind a right header and checksum: without a panic.
#![no_main]

use cocarry::scenario::Snapshot;

libfuzzer_sys::fuzz_target!(|contents: &[u8]| {
    let length = (contents.len() as u64).to_le_bytes();
    let mut bytes = [b"cocarry snapshot", &1u32.to_le_bytes()[..], &[0], &length, contents].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    let _ = Snapshot::parse("s", &bytes);
});

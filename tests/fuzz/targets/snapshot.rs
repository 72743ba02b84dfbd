//! The contents of a snapshot in; parsed behind a right header and checksum, and resumed: without a panic.
#![no_main]

use cocarry::scenario::{Plant, Snapshot};

libfuzzer_sys::fuzz_target!(|contents: &[u8]| {
    let length = (contents.len() as u64).to_le_bytes();
    let mut bytes = [b"cocarry snapshot", &Snapshot::FORMAT.to_le_bytes()[..], &[0], &length, contents].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    let Ok(Snapshot { scenario, state, .. }) = Snapshot::parse("s", &bytes) else { return };
    // the physics engine may panic on a state of its own that is not consistent
    if !matches!(scenario.plant, Plant::Rapier { .. })
        && let Ok(prepared) = scenario.prepare()
        && let Ok(mut episode) = prepared.resume(state)
    {
        let _ = (0..20).find(|_| episode.step().is_some());
    }
});

//! Recordings and snapshots.

use crate::file;
use cocarry::scenario::{Plant, Scenario, Snapshot};
use cocarry_recording::recording::{Contents, Playback, Reader, columns, recover, replay, scenario};
use cocarry_recording::rendering::{Width, filmstrip_svg, player};

/// Long episodes, and the physics, would take all the time.
fn is_short(scenario: &Scenario) -> bool {
    matches!(scenario.plant, Plant::Point) && scenario.settings.tick_limit.is_some_and(|limit| limit < 100)
}

/// Listed and recovered, and what is recovered is a recording.
pub fn recording(bytes: &[u8]) {
    let Ok(mut reader) = Reader::new(bytes, "m") else { return };
    let _ = Contents::read(&mut reader);
    for topic in ["/options", "/log"] {
        let _ = Reader::new(bytes, "m").and_then(|mut reader| columns(&mut reader, topic));
    }
    let to = file("recovered.mcap", b"");
    let Ok(mut reader) = Reader::new(bytes, "m") else { return };
    // it may have more channels than a file can have
    let Ok(saved) = recover(&mut reader, &to, true) else { return };
    let contents = Reader::open(&to).and_then(|mut reader| Contents::read(&mut reader));
    // the reader may list fewer than are recovered
    let Ok(contents) = contents else { return };
    let messages: u64 = contents.channels.values().map(|channel| channel.messages).sum();
    assert!(messages <= saved.messages);
}

/// Drawn.
pub fn playback(bytes: &[u8]) {
    let is_made = |bytes| Reader::new(bytes, "m").and_then(|mut reader| scenario(&mut reader)).is_ok();
    if !is_made(bytes) {
        return;
    }
    let Ok(playback) = Reader::new(bytes, "m").and_then(|mut reader| Playback::read(&mut reader)) else { return };
    let _ = player(&playback, "m", None, "x");
    let _ = filmstrip_svg(&playback, 3, Width::Inches(7.0));
}

/// Run again.
pub fn replayed(bytes: &[u8]) {
    let made_of = Reader::new(bytes, "m").and_then(|mut reader| scenario(&mut reader));
    if made_of.is_ok_and(|scenario| is_short(&scenario)) {
        let _ = Reader::new(bytes, "m").and_then(|first| replay(first, Reader::new(bytes, "m")?));
    }
}

/// The contents of a snapshot, parsed behind a right header and checksum, and resumed.
pub fn snapshot(contents: &[u8]) {
    let length = (contents.len() as u64).to_le_bytes();
    let mut bytes =
        [b"cocarry snapshot", &Snapshot::FORMAT.to_le_bytes()[..], &[0], &length, contents].concat();
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    let Ok(Snapshot { scenario, state, .. }) = Snapshot::parse("s", &bytes) else { return };
    // the physics engine may panic on a state of its own that is not consistent
    if !matches!(scenario.plant, Plant::Rapier { .. })
        && let Ok(prepared) = scenario.prepare()
        && let Ok(mut episode) = prepared.resume(state)
    {
        let _ = (0..20).find(|_| episode.step().is_some());
    }
}

//! Bytes in; run again as a recording: without a panic.
#![no_main]

use cocarry_recording::recording::{Reader, replay, scenario};
use cocarry::scenario::Plant;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let made_of = Reader::new(bytes, "m").and_then(|mut reader| scenario(&mut reader));
    // long episodes, and the physics, would take all the time
    if made_of.is_ok_and(|s| matches!(s.plant, Plant::Point) && s.settings.tick_limit.is_some_and(|t| t < 100)) {
        let _ = Reader::new(bytes, "m").and_then(|first| replay(first, Reader::new(bytes, "m")?));
    }
});

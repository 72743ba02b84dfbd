//! Bytes in; read as a recording, listed, and recovered: whatever they are, without a panic, and what is
//! recovered is a recording.
#![no_main]

use cocarry_recording::recording::{Contents, Reader, columns, recover};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(mut reader) = Reader::new(bytes, "m") else { return };
    let _ = Contents::read(&mut reader);
    for topic in ["/options", "/log"] {
        let _ = Reader::new(bytes, "m").and_then(|mut reader| columns(&mut reader, topic));
    }
    let to = std::env::temp_dir().join(format!("cocarry-fuzz-{}.mcap", std::process::id()));
    let Ok(mut reader) = Reader::new(bytes, "m") else { return };
    let saved = recover(&mut reader, &to, true).expect("a place to write to");
    let contents = Reader::open(&to).and_then(|mut reader| Contents::read(&mut reader));
    let messages: u64 = contents.expect("a recording").channels.values().map(|c| c.messages).sum();
    assert!(messages <= saved.messages);
});

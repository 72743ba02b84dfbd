//! Text in; parsed as a scenario, and made ready to run: without a panic, and the same again from its own
//! text.
#![no_main]

use cocarry::scenario::Scenario;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(scenario) = Scenario::parse(text) else { return };
    let written = scenario.text().expect("what was read can be written");
    assert_eq!(Scenario::parse(&written).expect("what was written can be read"), scenario);
    if let Ok(prepared) = scenario.prepare() {
        let _ = prepared.episode();
    }
});

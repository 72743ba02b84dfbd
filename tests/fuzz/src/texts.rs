//! Texts of settings: worlds, scenarios, studies, baselines.

use cocarry::options::OptionSet;
use cocarry::scenario::{EpisodeLog, Scenario};
use cocarry::world::World;
use cocarry_studies::regression::Baseline;
use cocarry_studies::study::Study;
use std::path::Path;

/// Options of worlds with more obstacles take their time.
const MAX_OBSTACLES: usize = 30;

pub fn world(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(world) = World::parse("w", text) else { return };
    if world.obstacles.len() <= MAX_OBSTACLES {
        let _ = OptionSet::new(&world, 10.0);
    }
}

/// Parsed as a scenario, made ready to run, and the same again from its own text.
pub fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(scenario) = Scenario::parse(text) else { return };
    let written = scenario.text().expect("what was read can be written");
    assert_eq!(Scenario::parse(&written).expect("what was written can be read"), scenario);
    if let Ok(prepared) = scenario.prepare() {
        let _ = prepared.episode();
    }
}

/// A log of the page: checked, and run again for a few steps.
pub fn log(bytes: &[u8]) {
    let Ok(log) = serde_json::from_slice::<EpisodeLog>(bytes) else { return };
    let Ok(prepared) = log.checked("log").and_then(Scenario::prepare) else { return };
    let Ok(mut episode) = prepared.episode_of(log.decisions.partners(&prepared)) else { return };
    let _ = (0..log.steps.min(5)).find(|_| episode.step().is_some());
}

pub fn study(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Study::parse("s", text, Path::new("worlds"), None);
}

pub fn baseline(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Baseline::parse("b".to_owned(), text.to_owned());
}

//! A recording: an episode as an MCAP file in memory, and the same episode run again from it: the same
//! bytes.
//!
//! ```text
//! cargo run --release --example record_and_replay
//! ```

use cocarry::scenario::{Plant, Scenario};
use cocarry::world::World;
use cocarry_recording::recording::{Ending, Reader, Recorder, scenario};
use std::io::Cursor;
use std::path::Path;

/// The episode of a scenario as the bytes of a recording.
fn recorded(scenario: Scenario) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let prepared = scenario.prepare()?;
    let mut episode = prepared.episode()?;
    let mut recorder = Recorder::new(Cursor::new(Vec::new()), "memory", &prepared, &episode)?;
    let outcome = loop {
        match episode.step() {
            None => recorder.step(&episode)?,
            Some(outcome) => break outcome,
        }
    };
    println!("{} after {} steps", outcome.name(), episode.summary().steps);
    Ok(recorder.finish(&episode, Ending::Over(outcome))?.into_inner())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::load(Path::new("worlds/environment-1.toml"))?;
    let first = recorded(Scenario::new(world.into(), Plant::Point))?;
    // a recording holds the scenario that it was made of
    let again = recorded(scenario(&mut Reader::new(Cursor::new(&first[..]), "first")?)?)?;
    assert_eq!(first, again, "the same bytes");
    println!("replayed: {} bytes, all the same", again.len());
    Ok(())
}

//! A snapshot: an episode is written to bytes half way, read again, and goes on with the same bits.
//!
//! ```text
//! cargo run --release --example snapshot
//! ```

use cocarry::episode::Episode;
use cocarry::scenario::{Plant, Scenario, Snapshot};
use cocarry::world::World;
use std::path::Path;

/// Runs to the end; the bits of the accumulated cost.
fn cost_at_end(mut episode: Episode<'_>) -> u64 {
    while episode.step().is_none() {}
    episode.summary().accumulated_cost.to_bits()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::load(Path::new("worlds/free-form.toml"))?;
    let prepared = Scenario::new(world.into(), Plant::Point).prepare()?;
    let mut episode = prepared.episode()?;
    for _ in 0..40 {
        episode.step();
    }
    let bytes = prepared.snapshot(&episode).bytes()?;
    println!("a snapshot after {} steps: {} bytes", episode.summary().steps, bytes.len());

    let read = Snapshot::parse("memory", &bytes)?;
    let prepared_again = read.scenario.prepare()?;
    let resumed = prepared_again.resume(read.state)?;
    assert_eq!(cost_at_end(resumed), cost_at_end(episode), "the same bits");
    println!("both end with the same bits");
    Ok(())
}

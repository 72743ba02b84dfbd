//! A first episode: a world, a human and a robot that adapts, on the planning level.
//!
//! ```text
//! cargo run --release --example first_episode
//! ```

use cocarry::preference::Perception;
use cocarry::scenario::{Plant, Scenario};
use cocarry::world::World;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::load(Path::new("worlds/environment-4.toml"))?;
    let human = Perception { alpha: 0.747, gamma: 0.765 };
    let scenario = Scenario { human, ..Scenario::new(world.into(), Plant::Point) };
    let prepared = scenario.prepare()?;
    let mut episode = prepared.episode()?;
    while episode.step().is_none() {
        let tick = episode.tick();
        if tick.step % 25 == 0 {
            let [x, y] = [tick.position.x, tick.position.y];
            println!("{:5.1} s at ({x:5.2}, {y:5.2}) m: phi {:.3}", tick.time, tick.stubbornness);
        }
    }
    let end = episode.summary();
    println!("{} after {} steps, J accumulated {:.1} m", end.outcome.name(), end.steps, end.accumulated_cost);
    assert_eq!(end.transition.map(|transition| transition.step), Some(47), "as in the README");
    Ok(())
}

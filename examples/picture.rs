//! A picture: a world with its openings, options and the probability of each, as SVG.
//!
//! ```text
//! cargo run --release --example picture > map.svg
//! ```

use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor};
use cocarry::world::World;
use cocarry_output::drawing::{Sheet, world_map};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::load(Path::new("worlds/environment-2.toml"))?;
    let mut predictor = Predictor::default();
    let options = OptionSet::new(&world, predictor.risk_weight())?;
    let mut choice = ChoiceDistribution::default();
    predictor.predict(&prospects(&options, &options.begin()), &mut choice);
    println!("{}", world_map(&world, &options, choice.probabilities(), Sheet::default())?);
    Ok(())
}

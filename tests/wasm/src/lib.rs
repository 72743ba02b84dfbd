//! The package `cocarry` as a WebAssembly module: default episodes in the built-in worlds.

use cocarry::episode::Summary;
use cocarry::robot::Robot;
use cocarry::scenario::{GivenPerception, Plant, PlantKind, RobotSetup, Scenario, drawn_human};
use cocarry::world::{BUILT_IN_WORLDS, World};

/// The accumulated cost J (m) of `cocarry run`; NaN if there is no such world or plant. Worlds and plants
/// are counted from 0.
#[unsafe(no_mangle)]
pub extern "C" fn accumulated_objective_cost_m(world: usize, plant: usize, seed: u64) -> f64 {
    run(world, plant, seed).map_or(f64::NAN, |summary| summary.accumulated_cost)
}

/// The accumulated control cost C of the same episode; NaN on the point plant.
#[unsafe(no_mangle)]
pub extern "C" fn accumulated_control_cost(world: usize, plant: usize, seed: u64) -> f64 {
    run(world, plant, seed).and_then(|summary| summary.control).map_or(f64::NAN, |control| control.cost())
}

fn run(world: usize, plant: usize, seed: u64) -> Option<Summary> {
    let world = BUILT_IN_WORLDS.get(world)?;
    let world = World::parse(world.name, world.text).ok()?;
    let plant = Plant::new(*PlantKind::ALL.get(plant)?, RobotSetup::new(&Robot::built_in().ok()?));
    let mut scenario = Scenario { seed, ..Scenario::new(world.into(), plant) };
    scenario.human = drawn_human(scenario.settings.predictor.belief(), GivenPerception::default(), seed);
    // as text, the way a page would receive it
    let scenario = Scenario::parse(&scenario.text().ok()?).ok()?;
    let prepared = scenario.prepare().ok()?;
    let mut episode = prepared.episode().ok()?;
    while episode.step().is_none() {}
    Some(episode.summary().clone())
}

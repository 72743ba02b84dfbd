//! One planning tick (all options, P_o, expected costs, eq. 6) against a budget of 20 us and against planning
//! anew in every tick.

use cocarry::episode::{Episode, Settings};
use cocarry::options::OptionSet;
use cocarry::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use cocarry::world::World;
use criterion::{BatchSize, Criterion, criterion_group};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Budget for a tick with four options.
const BUDGET: Duration = Duration::from_micros(20);
/// The step at which ticks are measured: the robot leads, and no two options are equal yet.
const STEP: usize = 10;

fn worlds() -> Vec<(World, OptionSet)> {
    let environments = ENVIRONMENTS.iter().map(|e| e.world());
    let free_form = World::parse("free-form", include_str!("../worlds/free-form.toml"));
    environments
        .chain([free_form])
        .map(|world| {
            let world = world.expect("a world of the repository");
            let set = OptionSet::new(&world, 10.0).expect("its options");
            (world, set)
        })
        .collect()
}

fn at_step<'a>(set: &'a OptionSet, settings: &'a Settings) -> Episode<'a> {
    let mut episode = Episode::new(set, settings, EXAMPLE_HUMAN);
    for _ in 0..STEP {
        episode.step();
    }
    episode
}

fn planning(c: &mut Criterion) {
    let settings = Settings::default();
    let mut group = c.benchmark_group("planning_tick");
    for (world, set) in &worlds() {
        let episode = at_step(set, &settings);
        let name = format!("{}, {} options", world.name, set.options().len());
        group.bench_function(name, |b| {
            b.iter_batched_ref(|| episode.clone(), |e| black_box(e.step()), BatchSize::SmallInput);
        });
    }
    group.bench_function("Environment 4, searched anew", |b| {
        let (world, _) = &worlds()[3];
        b.iter(|| black_box(OptionSet::new(world, 10.0).expect("options")));
    });
    group.finish();
}

/// Median time of one call, each on a fresh copy.
fn median<T>(mut make: impl FnMut() -> T, mut call: impl FnMut(&mut T)) -> Duration {
    let mut times: Vec<Duration> = (0..4000)
        .map(|_| {
            let mut subject = make();
            let begun = Instant::now();
            call(&mut subject);
            begun.elapsed()
        })
        .collect();
    times.sort_unstable();
    times[times.len() / 2]
}

fn report() {
    let settings = Settings::default();
    println!("\nplanning tick, median (budget {BUDGET:?} for 4 options)");
    let worlds = worlds();
    for (world, set) in &worlds {
        let episode = at_step(set, &settings);
        let tick = median(
            || episode.clone(),
            |e| {
                black_box(e.step());
            },
        );
        let anew = median(|| (), |()| drop(black_box(OptionSet::new(world, 10.0)))) + tick;
        println!(
            "  {:20} {:2} options: {:6.2} us, {:4.2} of the budget; planning anew takes {:4.0} times as long",
            world.name,
            set.options().len(),
            tick.as_secs_f64() * 1e6,
            tick.as_secs_f64() / BUDGET.as_secs_f64(),
            anew.as_secs_f64() / tick.as_secs_f64(),
        );
    }
}

criterion_group!(benches, planning);

fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    report();
}

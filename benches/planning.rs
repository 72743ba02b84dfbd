//! One planning tick (all options, P_o, expected costs, eq. 6) against a budget of 20 us and against planning
//! anew in every tick; and the options of worlds of 100 to 3,000 obstacles.

use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::options::OptionSet;
use cocarry::world::World;
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use criterion::{BatchSize, Criterion, criterion_group};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
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

fn at_step<'a>(set: &'a OptionSet, settings: &'a EpisodeSettings) -> Episode<'a> {
    let mut episode = Episode::new(set, settings, EXAMPLE_HUMAN);
    for _ in 0..STEP {
        episode.step();
    }
    episode
}

fn planning(c: &mut Criterion) {
    let settings = EpisodeSettings::default();
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
    let settings = EpisodeSettings::default();
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

/// A world of cylinders and boxes near the points of a square grid, with gaps of about a metre.
fn clutter(count: usize) -> World {
    const PITCH_M: f64 = 2.0;
    let mut rng = ChaCha8Rng::seed_from_u64(count as u64);
    let columns = (count as f64).sqrt().ceil() as usize;
    let side = PITCH_M * columns as f64;
    let mut text = format!(
        "name = \"clutter\"\nrobot_width_m = 0.5\nstart_m = [-1.0, {0:?}]\ntarget_m = [{0:?}, {0:?}]\n",
        side / 2.0
    );
    for i in 0..count {
        let mut near = |k: usize| PITCH_M * (k as f64 + 0.5 + rng.random_range(-0.2..0.2));
        let center = [near(i % columns), near(i / columns)];
        let size: [f64; 2] = [rng.random_range(0.2..0.4), rng.random_range(0.2..0.4)];
        let shape = match i % 2 {
            0 => format!("shape = \"cylinder\"\nradius_m = {:?}", size[0]),
            _ => format!("shape = \"box\"\nsize_m = [{:?}, {:?}]", 2.0 * size[0], 2.0 * size[1]),
        };
        text += &format!("[[obstacle]]\nname = \"o{i}\"\n{shape}\ncenter_m = {center:?}\nheight_m = 1.0\n");
    }
    // the target is in the middle, where an obstacle may stand
    (0..20)
        .find_map(|step| {
            let aside = format!("target_m = [{:?}, ", side / 2.0 + 0.1 * f64::from(step));
            World::parse("clutter", &text.replace(&format!("target_m = [{:?}, ", side / 2.0), &aside)).ok()
        })
        .expect("a free target")
}

/// Time from the text of a world to its options, and how it grows.
fn report_clutter() {
    println!("\noptions of worlds of many obstacles");
    let mut before: Option<(f64, f64)> = None;
    for count in [100, 300, 1000, 3000] {
        let begun = Instant::now();
        let world = clutter(count);
        let set = OptionSet::new(&world, 10.0).expect("options");
        let time = begun.elapsed().as_secs_f64();
        let growth = before.map_or(String::new(), |(n, t)| {
            format!(", n^{:.1}", cocarry::math::ln(time / t) / cocarry::math::ln(count as f64 / n))
        });
        println!(
            "  {count:5} obstacles, {:5} openings, {} options: {time:6.2} s{growth}",
            world.openings.len(),
            set.options().len(),
        );
        before = Some((count as f64, time));
    }
}

criterion_group!(benches, planning);

fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    report();
    report_clutter();
}

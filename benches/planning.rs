//! One planning tick (all options, P_o, expected costs, eq. 6) against a budget of 20 us and against planning
//! anew in every tick; and the options of worlds of 100 and 1,000 obstacles.

mod rows;

use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::options::OptionSet;
use cocarry::world::World;
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use criterion::{BatchSize, Criterion};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rows::{Against, Bench, Declared};
use std::hint::black_box;
use std::time::Instant;

const ROWS: &[Declared] = &[
    Declared {
        name: "planning tick, 4 options",
        unit: "us",
        cases: &[
            "planning_tick/Environment 1",
            "planning_tick/Environment 2",
            "planning_tick/Environment 3",
            "planning_tick/Environment 4",
        ],
        against: &[
            Against::Budget(20.0),
            Against::Peer(
                "the same after a new path search",
                &[
                    "searched_anew/Environment 1",
                    "searched_anew/Environment 2",
                    "searched_anew/Environment 3",
                    "searched_anew/Environment 4",
                ],
            ),
        ],
    },
    Declared {
        name: "planning tick, free-form world, 8 options",
        unit: "us",
        cases: &["planning_tick/Free-form workshop"],
        against: &[Against::Peer("the same after a new path search", &["searched_anew/Free-form workshop"])],
    },
    Declared {
        name: "options of a world of 1,000 obstacles",
        unit: "us",
        cases: &["clutter/1000"],
        against: &[],
    },
    Declared {
        name: "exponent of the obstacles' number, 100 to 1,000",
        unit: "",
        cases: &["clutter/exponent"],
        against: &[],
    },
];
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
    for (world, set) in &worlds() {
        let episode = at_step(set, &settings);
        c.benchmark_group("planning_tick").bench_function(&world.name, |b| {
            b.iter_batched_ref(|| episode.clone(), |e| black_box(e.step()), BatchSize::SmallInput);
        });
        c.benchmark_group("searched_anew").bench_function(&world.name, |b| {
            b.iter_batched_ref(
                || episode.clone(),
                |e| {
                    drop(black_box(OptionSet::new(world, 10.0)));
                    black_box(e.step())
                },
                BatchSize::SmallInput,
            );
        });
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
fn crowded(bench: &mut Bench) {
    let time = |count: usize| {
        let begun = Instant::now();
        let world = clutter(count);
        let set = OptionSet::new(&world, 10.0).expect("options");
        let time = begun.elapsed().as_secs_f64();
        println!(
            "{count:5} obstacles, {:5} openings, {} options: {time:6.3} s",
            world.openings.len(),
            set.options().len()
        );
        time
    };
    let [few, many] = [100, 1000].map(time);
    bench.give("clutter/1000", many * 1e6);
    bench.give("clutter/exponent", cocarry::math::ln(many / few) / cocarry::math::ln(10.0));
}

fn main() {
    rows::run("planning", ROWS, |criterion, bench| {
        planning(criterion);
        if bench.is_whole() {
            crowded(bench);
        }
    });
}

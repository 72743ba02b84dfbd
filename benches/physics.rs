//! One control tick of the physical plant (48 steps) against a budget of 1.5 ms, and what fewer sweeps or steps would save and spoil.

use cocarry::geometry::PlanarPose;
use cocarry::robot::{InputVector, Robot};
use cocarry::simulation::{HumanCommand, Observation, PhysicalPlant, PhysicsSettings};
use cocarry::world::World;
use criterion::{BatchSize, Criterion, criterion_group};
use std::hint::black_box;
use std::time::{Duration, Instant};

const PERIOD: f64 = 0.2;
/// Budget for a tick: the whole episode is to run at 100 times real time.
const BUDGET: Duration = Duration::from_micros(1500);
const TICKS: usize = 200;

fn plant(rate_hz: f64, sweeps: usize) -> (Robot, PhysicalPlant) {
    let text = include_str!("../worlds/environment-4.toml");
    let world = World::parse("environment-4", text).expect("a world of the repository");
    let robot = Robot::built_in().expect("the built-in robot");
    let settings = PhysicsSettings { rate_hz, sweeps, ..PhysicsSettings::default() };
    let team = PlanarPose { position: world.start, yaw: 0.0 };
    let plant = PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &team, &settings, 1);
    (robot, plant.expect("room at the start"))
}

/// Rates of a gentle drive with all joints moving.
fn rates(robot: &Robot, tick: usize) -> InputVector {
    let mut rates = InputVector::zeros();
    let phase = 0.2 * tick as f64;
    let turn = 0.3 * phase.cos() * robot.drive.track / 2.0;
    (rates[0], rates[1]) = (0.4 * (0.5 * phase).sin() - turn, 0.4 * (0.5 * phase).sin() + turn);
    for i in 0..robot.joint_count() {
        rates[2 + i] = 0.1 * (phase + i as f64).cos();
    }
    rates
}

/// A drive, what was seen of it, and how long a tick took in the median.
fn drive(rate_hz: f64, sweeps: usize) -> (Vec<Observation>, Duration) {
    let (robot, mut plant) = plant(rate_hz, sweeps);
    let mut times = Vec::with_capacity(TICKS);
    let seen = (0..TICKS)
        .map(|tick| {
            let rates = rates(&robot, tick);
            let begun = Instant::now();
            let seen = black_box(plant.step(&rates, &HumanCommand::Follow, PERIOD));
            times.push(begun.elapsed());
            seen
        })
        .collect();
    times.sort_unstable();
    (seen, times[times.len() / 2])
}

fn physics(c: &mut Criterion) {
    let (robot, mut start) = plant(240.0, 16);
    for tick in 0..20 {
        start.step(&rates(&robot, tick), &HumanCommand::Follow, PERIOD);
    }
    let rates = rates(&robot, 20);
    let mut group = c.benchmark_group("physics_tick");
    group.bench_function("Environment 4, 48 steps", |b| {
        b.iter_batched_ref(
            || start.clone(),
            |plant| black_box(plant.step(&rates, &HumanCommand::Follow, PERIOD)),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("what is seen", |b| b.iter(|| black_box(start.observe())));
    group.finish();
}

fn report() {
    println!("\nphysics tick of {PERIOD} s in Environment 4, median (budget {BUDGET:?})");
    let (exact, _) = drive(1920.0, 64);
    for (rate_hz, sweeps) in [(240.0, 16), (240.0, 8), (240.0, 4), (240.0, 1), (120.0, 16), (480.0, 16)] {
        let (seen, tick) = drive(rate_hz, sweeps);
        let (mut off, mut force) = (0.0_f64, 0.0_f64);
        for (seen, exact) in seen.iter().zip(&exact) {
            off = off.max((seen.object.translation.vector - exact.object.translation.vector).norm());
            force = force.max((seen.grip.mean.force - exact.grip.mean.force).norm());
        }
        println!(
            "  {rate_hz:4} Hz, {sweeps:2} sweeps: {:7.1} us a tick, {:5.2} us a step, {:4.0} times real time, {:4.2} of the budget; the object is \
             off by {:6.2} mm at most, the grip's force by {force:5.2} N, from 1920 Hz and 64 sweeps",
            tick.as_secs_f64() * 1e6,
            tick.as_secs_f64() / (PERIOD * rate_hz) * 1e6,
            PERIOD / tick.as_secs_f64(),
            tick.as_secs_f64() / BUDGET.as_secs_f64(),
            off * 1e3,
        );
    }
}

criterion_group!(benches, physics);

fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    report();
}

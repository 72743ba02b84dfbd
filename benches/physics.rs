//! The physical plant against a budget and the time that is simulated: a control period of 0.2 s, and a whole
//! episode. `--steps` prints what other steps and solver iterations would save of these, and spoil; `--peer`
//! figures for `benches/mujoco_peer.py`, which has the same scene in MuJoCo.

mod rows;

use cocarry::control;
use cocarry::episode::Summary;
use cocarry::geometry::{PlanarPose, Point};
use cocarry::math;
use cocarry::robot::{InputVector, Robot};
use cocarry::scenario::{Plant, PreparedScenario, RobotSetup, Scenario};
use cocarry::simulation::{HumanCommand, PhysicalPlant, PhysicsSettings};
use cocarry::world::World;
use cocarry_studies::paper;
use criterion::{BatchSize, Criterion};
use rows::{Against, Bench, Declared};
use std::hint::black_box;
use std::time::{Duration, Instant};

const ROWS: &[Declared] = &[
    Declared {
        name: "physics of a control period",
        unit: "us",
        cases: &["physics_tick/Environment 4"],
        against: &[
            Against::Budget(BUDGET_US),
            Against::Peer("the time that is simulated", &["simulated/period"]),
        ],
    },
    Declared {
        name: "what is seen after it",
        unit: "us",
        cases: &["physics_tick/what is seen"],
        against: &[Against::Peer("the physics", &["physics_tick/Environment 4"])],
    },
    Declared {
        name: "whole episode with bodies, control included",
        unit: "us",
        cases: &["physics_episode/Environment 4"],
        against: &[Against::Peer("the time that is simulated", &["simulated/episode"])],
    },
];

const PERIOD: f64 = 0.2;
/// Budget for a tick, us.
const BUDGET_US: f64 = 1500.0;
const TICKS: usize = 200;
const EPISODES: usize = 5;
/// Physics steps per second and solver iterations: twelve iterations at all rates, then others at the plant's.
const CHOICES: [(f64, usize); 10] = [
    (60.0, 12),
    (80.0, 12),
    (100.0, 12),
    (120.0, 12),
    (160.0, 12),
    (240.0, 12),
    (480.0, 12),
    (100.0, 4),
    (100.0, 8),
    (100.0, 16),
];
/// What others are measured against.
const FINE: (f64, usize) = (1920.0, 64);
/// The rates that `--peer` prints.
const PEER: [f64; 4] = [60.0, 100.0, 240.0, 480.0];
/// How often `--peer` takes times.
const ROUNDS: usize = 3;

fn plant(rate_hz: f64, solver_iterations: usize) -> (Robot, PhysicalPlant) {
    let text = include_str!("../worlds/environment-4.toml");
    let world = World::parse("environment-4", text).expect("a world of the repository");
    let robot = Robot::built_in().expect("the built-in robot");
    let settings = PhysicsSettings { rate_hz, solver_iterations, ..PhysicsSettings::default() };
    let team = PlanarPose { position: world.start, yaw: 0.0 };
    let plant = PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &team, &settings, 1);
    (robot, plant.expect("room at the start"))
}

/// Rates of a gentle drive with all joints moving.
fn rates(robot: &Robot, tick: usize) -> InputVector {
    let mut rates = InputVector::zeros();
    let phase = 0.2 * tick as f64;
    let turn = 0.3 * math::cos(phase) * robot.drive.track / 2.0;
    (rates[0], rates[1]) = (0.4 * math::sin(0.5 * phase) - turn, 0.4 * math::sin(0.5 * phase) + turn);
    for i in 0..robot.joint_count() {
        rates[2 + i] = 0.1 * math::cos(phase + i as f64);
    }
    rates
}

/// The drive at a rate: how long its control periods take, and where the object is after each.
fn drive(rate_hz: f64, solver_iterations: usize) -> (Vec<Duration>, Vec<nalgebra::Vector3<f64>>) {
    let (robot, mut plant) = plant(rate_hz, solver_iterations);
    let periods = (0..TICKS).map(|tick| {
        let rates = rates(&robot, tick);
        let begun = Instant::now();
        let seen = black_box(plant.step(&rates, &HumanCommand::Follow, PERIOD));
        (begun.elapsed(), seen.object.translation.vector)
    });
    periods.unzip()
}

/// How long a control period takes in the median.
fn tick(rate_hz: f64, solver_iterations: usize) -> Duration {
    let mut times = drive(rate_hz, solver_iterations).0;
    times.sort_unstable();
    times[times.len() / 2]
}

/// Figures of the drive and of a whole episode, one JSON object a line.
fn peer() {
    let exact = drive(FINE.0, FINE.1).1;
    let default = PhysicsSettings::default();
    for rate_hz in PEER {
        let off = drive(rate_hz, default.solver_iterations).1;
        let off = off.iter().zip(&exact).map(|(at, exact)| (at - exact).norm()).fold(0.0, f64::max);
        let median = (0..ROUNDS).map(|_| tick(rate_hz, default.solver_iterations)).min().expect("a round");
        println!("{{\"rate_hz\": {rate_hz}, \"period_s\": {}, \"error_m\": {off}}}", median.as_secs_f64());
    }
    let run = episode(default.rate_hz, default.solver_iterations);
    println!(
        "{{\"rate_hz\": {}, \"episode_s\": {}, \"simulated_s\": {}}}",
        default.rate_hz,
        run.took.as_secs_f64(),
        run.seconds
    );
}

/// An episode with all that belongs to it.
struct Run {
    took: Duration,
    /// Simulated time, s.
    seconds: f64,
    summary: Summary,
    /// Where the object is after each control period.
    object: Vec<Point>,
}

/// The paper's example human in Environment 4.
fn prepared(rate_hz: f64, solver_iterations: usize) -> PreparedScenario {
    let robot = Robot::built_in().expect("the built-in robot");
    let posture = robot.postures[0].name.clone();
    let carrier = RobotSetup { posture, control: control::ControlSettings::default(), robot: robot.into() };
    let physics = PhysicsSettings { rate_hz, solver_iterations, ..PhysicsSettings::default() };
    let scenario = Scenario {
        seed: 1,
        world: paper::ENVIRONMENTS[3].world().expect("a world of the repository").into(),
        human: paper::EXAMPLE_HUMAN,
        changes: Vec::new(),
        human_model: Default::default(),
        settings: Default::default(),
        plant: Plant::Rapier { setup: carrier, physics },
    };
    scenario.prepare().expect("a scenario")
}

fn run(prepared: &PreparedScenario) -> Run {
    let mut episode = prepared.episode().expect("room at the start");
    let mut object = Vec::new();
    let begun = Instant::now();
    while episode.step().is_none() {
        let physics = episode.tick().robot.as_ref().and_then(|robot| robot.physics.as_ref());
        object.extend(physics.map(|physics| physics.object.position));
    }
    let summary = episode.summary().clone();
    Run { took: begun.elapsed(), seconds: summary.steps as f64 * PERIOD, summary, object }
}

/// The fastest of some episodes.
fn episode(rate_hz: f64, solver_iterations: usize) -> Run {
    let prepared = prepared(rate_hz, solver_iterations);
    (0..EPISODES).map(|_| run(&prepared)).min_by_key(|run| run.took).expect("an episode")
}

fn physics(c: &mut Criterion, bench: &mut Bench) {
    let default = PhysicsSettings::default();
    let (robot, mut start) = plant(default.rate_hz, default.solver_iterations);
    for tick in 0..20 {
        start.step(&rates(&robot, tick), &HumanCommand::Follow, PERIOD);
    }
    let rates = rates(&robot, 20);
    let mut group = c.benchmark_group("physics_tick");
    group.bench_function("Environment 4", |b| {
        b.iter_batched_ref(
            || start.clone(),
            |plant| black_box(plant.step(&rates, &HumanCommand::Follow, PERIOD)),
            BatchSize::LargeInput,
        );
    });
    group.bench_function("what is seen", |b| b.iter(|| black_box(start.observe())));
    group.finish();
    bench.give("simulated/period", PERIOD * 1e6);
    let prepared = prepared(default.rate_hz, default.solver_iterations);
    let mut group = c.benchmark_group("physics_episode");
    group.sample_size(20).measurement_time(Duration::from_secs(4));
    group.bench_function("Environment 4", |b| {
        b.iter_custom(|iterations| (0..iterations).map(|_| black_box(run(&prepared)).took).sum());
    });
    group.finish();
    bench.give("simulated/episode", run(&prepared).seconds * 1e6);
}

/// What other steps and solver iterations would save, and spoil.
fn report_steps() {
    println!("\nphysics of a control period of {PERIOD} s in Environment 4, median of {TICKS}");
    for (rate_hz, solver_iterations) in CHOICES {
        let tick = tick(rate_hz, solver_iterations);
        println!(
            "  {rate_hz:4} Hz, {solver_iterations:2} solver iterations: {:7.1} us, {:5.2} us a step, {:6.0} steps a second, {:4.0} times real time",
            tick.as_secs_f64() * 1e6,
            tick.as_secs_f64() / (PERIOD * rate_hz) * 1e6,
            PERIOD * rate_hz / tick.as_secs_f64(),
            PERIOD / tick.as_secs_f64(),
        );
    }
    println!(
        "\nwhole episode in Environment 4, fastest of {EPISODES}; against 1920 Hz and 64 solver iterations: how far off the object is at most, the human's force (rms and peak), \
         the objective cost; the force above 10 Hz, and the most that a grip yields"
    );
    let exact = episode(FINE.0, FINE.1);
    let interaction = |run: &Run| run.summary.interaction.expect("a physical plant");
    for (rate_hz, solver_iterations) in CHOICES {
        let run = episode(rate_hz, solver_iterations);
        let off = run.object.iter().zip(&exact.object).map(|(at, exact)| (at - exact).norm());
        let (forces, forces_exact) = (interaction(&run), interaction(&exact));
        println!(
            "  {rate_hz:4} Hz, {solver_iterations:2} solver iterations: {:5.1} s in {:5.1} ms, {:4.0} times real time; {:5.2} mm, {:7.4} N, {:7.4} N, {:+.3} %; {:5.3} N, {:5.2} mm",
            run.seconds,
            run.took.as_secs_f64() * 1e3,
            run.seconds / run.took.as_secs_f64(),
            off.fold(0.0, f64::max) * 1e3,
            (forces.rms_force() - forces_exact.rms_force()).abs(),
            (forces.peak_force - forces_exact.peak_force).abs(),
            (run.summary.accumulated_cost / exact.summary.accumulated_cost - 1.0) * 100.0,
            forces.force_noise(),
            forces.deflection * 1e3,
        );
    }
}

fn main() {
    let has = |argument: &str| std::env::args().any(|other| other == argument);
    if has("--peer") {
        return peer();
    }
    if has("--steps") {
        return report_steps();
    }
    rows::run("physics", ROWS, physics);
}

//! Whole episodes of the physical plant, one a line: where they end and at what cost, to the last bit; `measure`
//! builds this with one rapier and another. With `--first`, the first alone; with `--time N`, the CPU time of N
//! rounds as well.

use cocarry::control::ControlSettings;
use cocarry::preference::Perception;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, RobotSetup, Scenario};
use cocarry::simulation::PhysicsSettings;
use cocarry::world::World;

const WORLDS: [(&str, &str); 4] = [
    ("environment-1", include_str!("../../worlds/environment-1.toml")),
    ("environment-2", include_str!("../../worlds/environment-2.toml")),
    ("environment-3", include_str!("../../worlds/environment-3.toml")),
    ("environment-4", include_str!("../../worlds/environment-4.toml")),
];
/// Humans that go ahead, that give way, and those in between: alpha and gamma.
const HUMANS: [(f64, f64); 5] = [(0.747, 0.765), (0.9, 0.5), (0.5, 0.9), (0.3, 0.3), (0.65, 1.0)];
const SEEDS: [u64; 2] = [1, 2];

/// 64-bit FNV-1a.
fn mix(digest: u64, bits: u64) -> u64 {
    bits.to_le_bytes()
        .iter()
        .fold(digest, |digest, byte| (digest ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

fn run(file: &str, text: &str, (alpha, gamma): (f64, f64), seed: u64) -> String {
    let world = World::parse(file, text).expect("a world of the repository");
    let robot = Robot::built_in().expect("the built-in robot");
    let posture = robot.postures[0].name.clone();
    let setup = RobotSetup { posture, control: ControlSettings::default(), robot: robot.into() };
    let plant = Plant::Rapier { setup, physics: PhysicsSettings::default() };
    let human = Perception { alpha, gamma };
    let prepared =
        Scenario { seed, human, ..Scenario::new(world.into(), plant) }.prepare().expect("a scenario");
    let mut episode = prepared.episode().expect("room at the start");
    let (mut digest, mut end) = (0xcbf2_9ce4_8422_2325, [0.0; 2]);
    while episode.step().is_none() {
        let tick = episode.tick();
        if let Some(physics) = tick.robot.as_ref().and_then(|robot| robot.physics.as_ref()) {
            end = [physics.object.position.x, physics.object.position.y];
            digest = end.iter().fold(digest, |digest, value| mix(digest, value.to_bits()));
        }
    }
    let summary = episode.summary();
    digest = mix(digest, summary.accumulated_cost.to_bits());
    let force = summary.interaction.map_or(f64::NAN, |interaction| interaction.peak_force);
    format!(
        "{file} {alpha} {gamma} {seed} {} {} {digest:016x} {} {} {} {force}",
        summary.outcome.name(),
        summary.steps,
        end[0],
        end[1],
        summary.accumulated_cost,
    )
}

/// CPU time of this process, s, as Linux tells it.
fn cpu_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/schedstat").expect("Linux");
    let ns: f64 = stat.split(' ').next().and_then(|ns| ns.parse().ok()).expect("a number of ns");
    ns / 1e9
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, flag, rounds] = &arguments[..] {
        assert_eq!(flag, "--time");
        for _ in 0..rounds.parse::<usize>().expect("a number of rounds") {
            let begun = cpu_time();
            for (file, text) in WORLDS {
                run(file, text, HUMANS[0], 1);
            }
            println!("{}", cpu_time() - begun);
        }
        return;
    }
    if arguments.len() == 2 {
        return println!("{}", run(WORLDS[3].0, WORLDS[3].1, HUMANS[0], 1));
    }
    for (file, text) in WORLDS {
        for human in HUMANS {
            for seed in SEEDS {
                println!("{}", run(file, text, human, seed));
            }
        }
    }
}

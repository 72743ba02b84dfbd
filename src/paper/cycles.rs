//! Sec. IV-B.2 claims without proof that eq. (6) causes no locked cycles (infinite oscillation between options). Random worlds and humans,
//! each episode run until the team stands at the target or ten times the longest option has passed.

use crate::coordination;
use crate::episode::{Outcome, Settings, run};
use crate::math;
use crate::options::OptionSet;
use crate::parallel::{OnDone, in_parallel};
use crate::preference::Perception;
use crate::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;
use std::ops::Range;

/// How many worlds are tried, where nobody says.
pub const WORLDS: usize = 10_000;

/// What came of the random worlds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Episodes run.
    pub episodes: usize,
    /// Of them, those in worlds with two options or more.
    pub with_choice: usize,
    /// Of them, those in which the executed option changed at least once.
    pub with_changes: usize,
    /// The most changes of the executed option in one episode.
    pub most_changes: u32,
    /// The most steps that an episode took, as a multiple of its shortest option's.
    pub longest_detour: f64,
    /// Episodes that did not end at the target.
    pub counterexamples: Vec<Counterexample>,
}

/// An episode that did not end at the target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Counterexample {
    /// Its index: the seed of its world, human and eta.
    pub index: u64,
    /// The world, as a world file.
    pub world: String,
    /// alpha.
    pub alpha: f64,
    /// gamma.
    pub gamma: f64,
    /// eta.
    pub eta: f64,
}

/// One episode in a random world.
struct Trial {
    world: String,
    human: Perception,
    eta: f64,
    outcome: Outcome,
    options: usize,
    changes: u32,
    detour: f64,
}

/// Runs `episodes` random worlds, each with a random human and eta from 1 to 30, under eq. (6) and the single transition.
pub fn search(episodes: usize, seed: u64, settings: &Settings, on_done: OnDone) -> Findings {
    let trials = in_parallel(episodes, on_done, |i| trial(seed.wrapping_add(i as u64), settings));
    Findings {
        episodes,
        with_choice: trials.iter().filter(|t| t.options > 1).count(),
        with_changes: trials.iter().filter(|t| t.changes > 0).count(),
        most_changes: trials.iter().map(|t| t.changes).max().unwrap_or(0),
        longest_detour: trials.iter().map(|t| t.detour).fold(0.0, f64::max),
        counterexamples: trials
            .into_iter()
            .enumerate()
            .filter(|(_, t)| t.outcome != Outcome::Arrived)
            .map(|(i, t)| Counterexample {
                index: seed.wrapping_add(i as u64),
                world: t.world,
                alpha: t.human.alpha,
                gamma: t.human.gamma,
                eta: t.eta,
            })
            .collect(),
    }
}

fn trial(seed: u64, settings: &Settings) -> Trial {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (human, eta) = random_human(settings, &mut rng);
    let coordination = coordination::Settings { eta, ..settings.coordination };
    let settings = Settings { coordination, predict_while_human_leads: false, ..settings.clone() };
    loop {
        let text = random_world(&mut rng);
        // start or target built over, or closed in: draw again
        let Ok(world) = World::parse("random world", &text) else { continue };
        let Ok(set) = OptionSet::new(&world, settings.predictor.risk_weight()) else { continue };
        let shortest = set.remaining(&set.begin(), 0).length / (settings.speed * settings.period);
        let summary = run(&set, &settings, human, |_| {});
        return Trial {
            world: text,
            human,
            eta,
            outcome: summary.outcome,
            options: set.options().len(),
            changes: summary.option_changes,
            detour: summary.steps as f64 / shortest.max(1.0),
        };
    }
}

/// A human and their eta, from 1 to 30: as many sensitive as tolerant ones.
pub(super) fn random_human(settings: &Settings, rng: &mut ChaCha8Rng) -> (Perception, f64) {
    let human = settings.predictor.belief().sample(rng);
    (human, math::exp(rng.random_range(0.0..math::ln(30f64))))
}

/// A random world file: a walled field with boxes, cylinders and polygons strewn over it, start on the left, target on the right, nothing
/// declared.
pub fn random_world(rng: &mut ChaCha8Rng) -> String {
    random_field(rng, 0.6, 0.0, usize::MAX)
}

/// The same with room for a team with bodies, which is 2 to 3 m long: start and target twice as far from the walls at the sides, 2 m more behind them,
/// and eight obstacles at most.
pub fn roomy_world(rng: &mut ChaCha8Rng) -> String {
    random_field(rng, 1.2, 2.0, 8)
}

/// A random world file of 3 to 20 mixed obstacles: rotated boxes, some of them long and thin as walls are, cylinders and irregular convex
/// polygons, on a field that every other world has no walls around; start and target anywhere but near to each other.
pub fn mixed_world(rng: &mut ChaCha8Rng) -> String {
    let size: [f64; 2] = [rng.random_range(8.0..16.0), rng.random_range(5.0..12.0)];
    let mut place = || [0, 1].map(|i| rng.random_range(0.4..size[i] - 0.4));
    let start = place();
    let target = loop {
        let target = place();
        if math::hypot(target[0] - start[0], target[1] - start[1]) > size[0] / 2.0 {
            break target;
        }
    };
    let mut text = head(start, target);
    if rng.random_bool(0.5) {
        text += &walls(size, 0.0);
    }
    for i in 0..rng.random_range(3..=20) {
        let [x, y] = size.map(|size| rng.random_range(0.0..size));
        let shape = match rng.random_range(0..4) {
            0 => rotated_box(rng, [x, y], [0.1..0.2, 1.0..4.0]),
            1 => irregular_polygon(rng, [x, y]),
            _ => random_shape(rng, x, y),
        };
        text += &obstacle(&format!("obstacle-{}", i + 1), &shape);
    }
    text
}

/// Start and target `beside` (m) off the walls at the sides at least, `room` (m) more behind them, and so many obstacles at most.
fn random_field(rng: &mut ChaCha8Rng, beside: f64, room: f64, most: usize) -> String {
    let width: f64 = rng.random_range(8.0..16.0);
    let depth: f64 = rng.random_range(5.0..12.0);
    let start_y = rng.random_range(beside..depth - beside);
    let target_y = rng.random_range(beside..depth - beside);
    let mut text = head([0.8, start_y], [width - 0.8, target_y]) + &walls([width, depth], room);
    for i in 0..rng.random_range(4..18).min(most) {
        let x = rng.random_range(1.5..width - 1.5);
        let y = rng.random_range(0.0..depth);
        text += &obstacle(&format!("obstacle-{}", i + 1), &random_shape(rng, x, y));
    }
    text
}

fn head([start_x, start_y]: [f64; 2], [target_x, target_y]: [f64; 2]) -> String {
    format!(
        "name = \"random\"\nrobot_width_m = 0.5\nstart_m = [{start_x:.3}, {start_y:.3}]\ntarget_m = [{target_x:.3}, {target_y:.3}]\n"
    )
}

/// Walls around a field, with `room` (m) between it and those in the west and the east.
fn walls([width, depth]: [f64; 2], room: f64) -> String {
    let long = width + 2.0 * room;
    let walls = [
        ("south", width / 2.0, -0.05, long, 0.1),
        ("north", width / 2.0, depth + 0.05, long, 0.1),
        ("west", -0.05 - room, depth / 2.0, 0.1, depth + 0.2),
        ("east", width + 0.05 + room, depth / 2.0, 0.1, depth + 0.2),
    ];
    let wall = |(name, x, y, sx, sy): (&str, f64, f64, f64, f64)| {
        obstacle(name, &format!("shape = \"box\"\ncenter_m = [{x:.3}, {y:.3}]\nsize_m = [{sx:.3}, {sy:.3}]"))
    };
    walls.into_iter().map(wall).collect()
}

/// A shape at (x, y), m, as in a world file.
fn random_shape(rng: &mut ChaCha8Rng, x: f64, y: f64) -> String {
    match rng.random_range(0..3) {
        0 => rotated_box(rng, [x, y], [0.1..1.0, 0.3..2.0]),
        1 => {
            let radius = rng.random_range(0.1..0.7);
            format!("shape = \"cylinder\"\ncenter_m = [{x:.3}, {y:.3}]\nradius_m = {radius:.3}")
        }
        _ => {
            let (corners, radius) = (rng.random_range(3..7), rng.random_range(0.3..0.9));
            let turn: f64 = rng.random_range(0.0..std::f64::consts::TAU);
            let vertices: Vec<String> = (0..corners)
                .map(|c| turn + std::f64::consts::TAU * c as f64 / corners as f64)
                .map(|angle| {
                    format!("[{:.3}, {:.3}]", x + radius * math::cos(angle), y + radius * math::sin(angle))
                })
                .collect();
            format!("shape = \"polygon\"\nvertices_m = [{}]", vertices.join(", "))
        }
    }
}

fn rotated_box(rng: &mut ChaCha8Rng, [x, y]: [f64; 2], size: [Range<f64>; 2]) -> String {
    let [sx, sy] = size.map(|range| rng.random_range(range));
    let yaw = rng.random_range(-90.0..90.0);
    format!("shape = \"box\"\ncenter_m = [{x:.3}, {y:.3}]\nsize_m = [{sx:.3}, {sy:.3}]\nyaw_deg = {yaw:.2}")
}

/// Corners on an ellipse, in a random turn, each in a sector of its own.
fn irregular_polygon(rng: &mut ChaCha8Rng, [x, y]: [f64; 2]) -> String {
    let corners = rng.random_range(3..9);
    let radii = [0, 1].map(|_| rng.random_range(0.3..1.2));
    let (sin, cos) = math::sin_cos(rng.random_range(0.0..std::f64::consts::PI));
    let vertices: Vec<String> = (0..corners)
        .map(|c| std::f64::consts::TAU * (f64::from(c) + rng.random_range(0.0..0.8)) / f64::from(corners))
        .map(|angle| [radii[0] * math::cos(angle), radii[1] * math::sin(angle)])
        .map(|[a, b]| format!("[{:.3}, {:.3}]", x + cos * a - sin * b, y + sin * a + cos * b))
        .collect();
    format!("shape = \"polygon\"\nvertices_m = [{}]", vertices.join(", "))
}

fn obstacle(name: &str, shape: &str) -> String {
    format!("\n[[obstacle]]\nname = \"{name}\"\n{shape}\nheight_m = 1.0\n")
}

//! Sec. IV-B.2 claims without proof that eq. (6) causes no locked cycles (infinite oscillation between
//! options). This study runs random worlds and humans, each episode until the team arrives or takes ten times
//! the steps of the longest option. The team is a point, has a robot, or has bodies, which must not touch
//! anything either.

mod dropped;
pub mod section;

pub use dropped::{Cause, Dropped, SOON_STEPS};

use super::placed::Placed;
use super::{prepared, run_episode};
use crate::parallel::{OnDone, in_parallel};
use cocarry::coordination;
use cocarry::episode::{EpisodeSettings, Outcome, Tick};
use cocarry::math;
use cocarry::preference::Perception;
use cocarry::scenario::{Plant, PlantKind, Scenario, WorldText};
use cocarry::simulation::{BodyKind, Contact};
use cocarry::{Error, ErrorKind};
use dropped::Leader;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;
use std::ops::Range;

/// Default number of worlds for a team that is a point.
pub const WORLDS: usize = 10_000;
/// Default number of worlds on the kinematic plant.
pub const WORLDS_WITH_ROBOT: usize = 5000;
/// Default number of worlds for a team with bodies.
pub const WORLDS_WITH_BODIES: usize = 200;

/// The search for locked cycles.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a> {
    /// The plant.
    pub plant: &'a Plant,
    /// The episode's settings; eta is replaced.
    pub settings: &'a EpisodeSettings,
    /// Number of worlds.
    pub worlds: usize,
    /// Seed of the first world, its human, eta and gait; the other worlds have the seeds that follow.
    pub seed: u64,
    /// Where the worlds lie.
    pub placed: Placed,
}

/// The results of the search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Episodes run.
    pub episodes: usize,
    /// Episodes in worlds with two options or more.
    pub with_choice: usize,
    /// Episodes in which the executed option changed at least once.
    pub with_changes: usize,
    /// Largest number of changes of the executed option in one episode.
    pub most_changes: u32,
    /// The first option of each episode that the same leader took up and dropped again within 5 steps.
    pub dropped_soon: Vec<Dropped>,
    /// Episodes that arrived without contact.
    pub arrived: usize,
    /// Episodes in which the robot, the object or the human touched an obstacle.
    pub touched: [usize; 3],
    /// Episodes in which the robot lost the object; on the kinematic plant they go on.
    pub lost_object: usize,
    /// Largest number of steps of an episode that arrived, as a multiple of the steps of its cheapest option.
    pub longest_detour: f64,
    /// Episodes that did not arrive: on the planning level, counterexamples.
    pub lost: Vec<Lost>,
}

/// An episode that did not arrive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lost {
    /// Its index: the seed of its world, human, eta and gait.
    pub index: u64,
    /// The world, as a world file.
    pub world: String,
    /// alpha.
    pub alpha: f64,
    /// gamma.
    pub gamma: f64,
    /// eta.
    pub eta: f64,
    /// Its outcome, as in [`Outcome::name`].
    pub outcome: &'static str,
    /// The contact, if any.
    pub contact: Option<Contact>,
    /// Distance of the contact from the target, m.
    pub from_target: Option<f64>,
}

/// One episode in a random world. It does not keep the world: 100,000 do not fit into memory.
struct Trial {
    options: usize,
    detour: f64,
    /// The first option that was taken up and dropped again soon.
    dropped_soon: Option<Dropped>,
    option_changes: u32,
    has_lost_object: bool,
    /// The body that touched an obstacle, if any.
    touched_by: Option<BodyKind>,
    /// The run, kept if it did not arrive.
    lost: Option<Lost>,
}

impl Search<'_> {
    /// Runs random worlds, each with a random human and eta from 1 to 30, under eq. (6) and the single
    /// transition.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn run(&self, on_done: OnDone) -> Result<Findings, Error> {
        let trials = in_parallel(self.worlds, on_done, |i| self.trial(self.seed.wrapping_add(i as u64)));
        let trials = trials.into_iter().collect::<Result<Vec<_>, _>>()?;
        let arrived = |t: &&Trial| t.lost.is_none();
        let by = |by| trials.iter().filter(|t| t.touched_by == Some(by)).count();
        Ok(Findings {
            episodes: trials.len(),
            with_choice: trials.iter().filter(|t| t.options > 1).count(),
            with_changes: trials.iter().filter(|t| t.option_changes > 0).count(),
            most_changes: trials.iter().map(|t| t.option_changes).max().unwrap_or(0),
            dropped_soon: trials.iter().filter_map(|t| t.dropped_soon.clone()).collect(),
            arrived: trials.iter().filter(arrived).count(),
            touched: [BodyKind::Robot, BodyKind::Object, BodyKind::Human].map(by),
            lost_object: trials.iter().filter(|t| t.has_lost_object).count(),
            longest_detour: trials.iter().filter(arrived).map(|t| t.detour).fold(0.0, f64::max),
            lost: trials.iter().filter_map(|t| t.lost.clone()).collect(),
        })
    }

    fn trial(&self, seed: u64) -> Result<Trial, Error> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (human, eta) = random_human(self.settings, &mut rng);
        let coordination = coordination::StubbornnessSettings { eta, ..self.settings.coordination };
        let settings =
            EpisodeSettings { coordination, predict_while_human_leads: false, ..self.settings.clone() };
        let draw_world = |rng: &mut ChaCha8Rng| match self.plant.kind() {
            PlantKind::Point | PlantKind::Kinematic => random_world(rng),
            PlantKind::Rapier => mixed_world(rng, true),
        };
        loop {
            // draw again if the start or target is inside an obstacle, enclosed, or without room for the team
            let world =
                WorldText { file: "random world".to_owned(), text: self.placed.world(draw_world(&mut rng)) };
            let prepared = match prepared(world, &settings, self.plant) {
                Err(error) if error.kind() == ErrorKind::World => continue,
                prepared => prepared?,
            };
            let prepared = prepared.prepare(Scenario { seed, human, ..prepared.scenario().clone() })?;
            let mut predictor = settings.predictor.clone();
            let step = settings.speed * settings.planning_step;
            let mut leader = Leader { predictor: &mut predictor, human, step };
            // the first tick of the option executed, and the option before it
            let mut taken_up: Option<(Tick, Option<usize>)> = None;
            let mut dropped_soon: Option<Dropped> = None;
            let on_tick = |tick: &Tick| {
                let Some((first, before)) = &taken_up else {
                    // the first option is not taken up but given
                    taken_up = Some((tick.clone(), None));
                    return;
                };
                if first.executed == tick.executed {
                    return;
                }
                let is_soon = tick.step - first.step <= SOON_STEPS && first.mode == tick.mode;
                if let (Some(before), None, true) = (before, &dropped_soon, is_soon) {
                    let name = |option: usize| prepared.options().options()[option].name.clone();
                    dropped_soon = Some(Dropped {
                        seed,
                        taken_up: first.step,
                        dropped: tick.step,
                        mode: tick.mode,
                        options: [*before, first.executed, tick.executed].map(name),
                        cause: leader.cause(first, tick),
                        world: prepared.scenario().world.text().to_owned(),
                        human,
                        eta,
                    });
                }
                taken_up = Some((tick.clone(), Some(first.executed)));
            };
            let episode = match prepared.episode() {
                Err(error) if error.kind() == ErrorKind::World => continue,
                episode => episode?,
            };
            // on the kinematic plant the human walks on whatever the robot does, and the robot may begin
            // inside a wall behind A
            let goes_on = self.plant.kind() == PlantKind::Kinematic;
            let summary = run_episode(if goes_on { episode.ignoring_loss() } else { episode }, on_tick);
            let options = prepared.options();
            let shortest =
                options.remaining(&options.begin(), 0).length / (settings.speed * settings.planning_step);
            let contact = summary.collision.as_ref();
            let lost = || Lost {
                index: seed,
                world: prepared.scenario().world.text().to_owned(),
                alpha: human.alpha,
                gamma: human.gamma,
                eta,
                outcome: summary.outcome.name(),
                contact: contact.cloned(),
                from_target: contact.map(|c| (c.point.xy() - prepared.world().target).norm()),
            };
            return Ok(Trial {
                options: options.options().len(),
                detour: summary.steps as f64 / shortest.max(1.0),
                dropped_soon,
                option_changes: summary.option_changes,
                has_lost_object: summary.has_lost_object(),
                touched_by: contact.map(|contact| contact.between[0].kind),
                lost: (summary.outcome != Outcome::Arrived).then(lost),
            });
        }
    }
}

/// A random human and eta, from 1 to 30: sensitive and tolerant humans are equally frequent.
pub(super) fn random_human(settings: &EpisodeSettings, rng: &mut ChaCha8Rng) -> (Perception, f64) {
    let human = settings.predictor.belief().sample(rng);
    (human, math::exp(rng.random_range(0.0..math::ln(30f64))))
}

/// A random world file: a walled field with 4 to 17 boxes, cylinders and polygons, start on the left, target
/// on the right, without declared openings and options.
pub fn random_world(rng: &mut ChaCha8Rng) -> String {
    let width: f64 = rng.random_range(8.0..16.0);
    let depth: f64 = rng.random_range(5.0..12.0);
    let start_y = rng.random_range(0.6..depth - 0.6);
    let target_y = rng.random_range(0.6..depth - 0.6);
    let mut text = head([0.8, start_y], [width - 0.8, target_y]) + &walls([width, depth]);
    for i in 0..rng.random_range(4..18) {
        let x = rng.random_range(1.5..width - 1.5);
        let y = rng.random_range(0.0..depth);
        text += &obstacle(&format!("obstacle-{}", i + 1), &random_shape(rng, x, y));
    }
    text
}

/// A random world file of 3 to 20 mixed obstacles: rotated boxes, some of them long and thin as walls are,
/// cylinders and irregular convex polygons. The field has walls around it or not. Start and target are
/// anywhere, but not near each other.
pub fn mixed_world(rng: &mut ChaCha8Rng, has_walls: bool) -> String {
    let size: [f64; 2] = [rng.random_range(8.0..16.0), rng.random_range(5.0..12.0)];
    let mut place = || [0, 1].map(|i| rng.random_range(0.4..size[i] - 0.4));
    let is_far = |[x, y]: [f64; 2]| math::hypot(x, y) > size[0] / 2.0;
    // from the middle of a field, even its corners may be near
    let to_corner = |at: [f64; 2]| [0, 1].map(|i| at[i].max(size[i] - at[i]) - 0.4);
    let start = loop {
        let start = place();
        if is_far(to_corner(start)) {
            break start;
        }
    };
    let target = loop {
        let target = place();
        if is_far([target[0] - start[0], target[1] - start[1]]) {
            break target;
        }
    };
    let mut text = head(start, target);
    if has_walls {
        text += &walls(size);
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

fn head([start_x, start_y]: [f64; 2], [target_x, target_y]: [f64; 2]) -> String {
    format!(
        "name = \"random\"\nrobot_width_m = 0.5\nstart_m = [{start_x:.3}, {start_y:.3}]\ntarget_m = [{target_x:.3}, {target_y:.3}]\n"
    )
}

/// Walls around a field.
fn walls([width, depth]: [f64; 2]) -> String {
    let walls = [
        ("south", width / 2.0, -0.05, width, 0.1),
        ("north", width / 2.0, depth + 0.05, width, 0.1),
        ("west", -0.05, depth / 2.0, 0.1, depth + 0.2),
        ("east", width + 0.05, depth / 2.0, 0.1, depth + 0.2),
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

/// Corners on an ellipse with a random rotation, one in each sector.
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

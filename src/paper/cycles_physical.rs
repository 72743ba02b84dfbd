//! Random worlds and humans as in the search for locked cycles, by a team with bodies: whether it arrives without touching anything.

use super::cycles::{random_human, roomy_world};
use crate::control::{self, RobotObstacles};
use crate::coordination;
use crate::episode::{Episode, Manipulator, Outcome, Settings, Summary};
use crate::options::OptionSet;
use crate::parallel::{OnDone, in_parallel};
use crate::preference::Perception;
use crate::robot::Robot;
use crate::simulation::{BodyKind, Contact, PhysicsError, PhysicsSettings};
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// How many worlds are tried, where nobody says.
pub const WORLDS: usize = 200;

/// What is run.
#[derive(Clone, Copy, Debug)]
pub struct Study<'a> {
    /// The robot, which starts from its first posture.
    pub robot: &'a Robot,
    /// The plant, with the human's sway.
    pub physics: PhysicsSettings,
    /// The loop's settings, but for eta.
    pub episode: &'a Settings,
    /// How many worlds.
    pub worlds: usize,
    /// Seed of the first world, its human, eta and gait; the others follow it.
    pub seed: u64,
}

/// What came of it.
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
    /// Those that arrived without touching anything.
    pub arrived: usize,
    /// Those in which the robot, the object or the human touched an obstacle.
    pub touched: [usize; 3],
    /// The most steps that an episode that arrived took, as a multiple of its shortest option's.
    pub longest_detour: f64,
    /// Episodes that did not arrive.
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
    /// How it ended, as in [`Outcome::name`].
    pub outcome: &'static str,
    /// What touched what.
    pub contact: Option<Contact>,
    /// How far from the target that was, m.
    pub from_target: Option<f64>,
}

/// One episode in a random world.
struct Trial {
    world: World,
    text: String,
    human: Perception,
    eta: f64,
    options: usize,
    detour: f64,
    summary: Summary,
}

impl Study<'_> {
    /// Runs all.
    ///
    /// # Errors
    /// If the plant's settings are out of their range.
    pub fn search(&self, on_done: OnDone) -> Result<Findings, PhysicsError> {
        let trials = in_parallel(self.worlds, on_done, |i| self.trial(self.seed.wrapping_add(i as u64)));
        let trials = trials.into_iter().collect::<Result<Vec<_>, _>>()?;
        let arrived = |t: &&Trial| t.summary.outcome == Outcome::Arrived;
        let kind = |t: &Trial| t.summary.collision.as_ref().map(|contact| contact.between[0].kind);
        let by = |by| trials.iter().filter(|t| kind(t) == Some(by)).count();
        Ok(Findings {
            episodes: trials.len(),
            with_choice: trials.iter().filter(|t| t.options > 1).count(),
            with_changes: trials.iter().filter(|t| t.summary.option_changes > 0).count(),
            most_changes: trials.iter().map(|t| t.summary.option_changes).max().unwrap_or(0),
            arrived: trials.iter().filter(arrived).count(),
            touched: [BodyKind::Robot, BodyKind::Object, BodyKind::Human].map(by),
            longest_detour: trials.iter().filter(arrived).map(|t| t.detour).fold(0.0, f64::max),
            lost: (self.seed..)
                .zip(&trials)
                .filter(|(_, t)| !arrived(t))
                .map(|(index, t)| t.lost(index))
                .collect(),
        })
    }

    fn trial(&self, seed: u64) -> Result<Trial, PhysicsError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (human, eta) = random_human(self.episode, &mut rng);
        let coordination = coordination::Settings { eta, ..self.episode.coordination };
        let settings = Settings { coordination, ..self.episode.clone() };
        loop {
            let text = roomy_world(&mut rng);
            // start or target built over, or closed in, or no room for the team at the start or the target: draw again
            let Ok(world) = World::parse("random world", &text) else { continue };
            let Ok(options) = OptionSet::new(&world, settings.predictor.risk_weight()) else { continue };
            let obstacles = RobotObstacles::new(&world);
            let manipulator = Manipulator {
                robot: self.robot,
                posture: self.robot.postures[0].joints,
                control: control::Settings::default(),
                obstacles: &obstacles,
            };
            let episode = Episode::new(&options, &settings, human);
            let mut episode = match episode.with_physics(manipulator, &world, &self.physics, seed) {
                Err(PhysicsError::Occupied { .. } | PhysicsError::NoRoomAtTarget { .. }) => continue,
                episode => episode?,
            };
            while episode.step().is_none() {}
            let shortest = options.remaining(&options.begin(), 0).length / (settings.speed * settings.period);
            let summary = episode.summary().clone();
            let detour = summary.steps as f64 / shortest.max(1.0);
            let options = options.options().len();
            return Ok(Trial { world, text, human, eta, options, detour, summary });
        }
    }
}

impl Trial {
    fn lost(&self, index: u64) -> Lost {
        let contact = self.summary.collision.clone();
        let from_target = contact.as_ref().map(|c| (c.point.xy() - self.world.target).norm());
        Lost {
            index,
            world: self.text.clone(),
            alpha: self.human.alpha,
            gamma: self.human.gamma,
            eta: self.eta,
            outcome: self.summary.outcome.name(),
            contact,
            from_target,
        }
    }
}

//! Starts of teams with bodies in random indoor worlds: how many have room at A and B, and how many arrive.
//! Not in the paper.

mod indoor;
pub(crate) mod section;

pub use indoor::{CLEAR_M, indoor_world};

use super::cycles::random_human;
use super::{prepared, run_prepared};
use crate::parallel::{OnDone, in_parallel};
use cocarry::coordination;
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::scenario::{Plant, Scenario, WorldText};
use cocarry::simulation::BodyKind;
use cocarry::{Error, ErrorKind};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// Default number of worlds.
pub const WORLDS: usize = 200;

/// The study of starts.
#[derive(Clone, Copy, Debug)]
pub struct StartStudy<'a> {
    /// The physical plant.
    pub plant: &'a Plant,
    /// The episode's settings; eta is replaced.
    pub settings: &'a EpisodeSettings,
    /// Number of worlds.
    pub worlds: usize,
    /// Seed of the first world, its human, eta and gait; the other worlds have the seeds that follow.
    pub seed: u64,
}

/// The results of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Starts {
    /// Worlds in which a point reaches B.
    pub worlds: usize,
    /// Worlds in which the team with bodies starts.
    pub started: usize,
    /// Worlds in which it arrives without contact.
    pub arrived: usize,
    /// Worlds in which the robot, the object or the human touches an obstacle.
    pub touched: [usize; 3],
    /// Worlds in which it is refused, with the reason.
    pub refused: Vec<Refused>,
    /// Worlds in which it starts and does not arrive.
    pub lost: Vec<Lost>,
}

/// A world in which the team is refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refused {
    /// The seed of the world.
    pub seed: u64,
    /// The world, as a world file.
    pub world: String,
    /// The reason.
    pub reason: String,
}

/// A world in which the team starts and does not arrive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lost {
    /// The seed of the world.
    pub seed: u64,
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
    /// The body that touched an obstacle first, if any, and the obstacle.
    pub contact: Option<[String; 2]>,
    /// When, s.
    pub time: f64,
}

/// The end of one world.
enum End {
    Arrived,
    Lost(Lost, Option<BodyKind>),
    Refused(Refused),
}

impl StartStudy<'_> {
    /// Runs the worlds, each with a random human and eta.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn run(&self, on_done: OnDone) -> Result<Starts, Error> {
        let ends = in_parallel(self.worlds, on_done, |i| self.end(self.seed.wrapping_add(i as u64)));
        let mut starts = Starts {
            worlds: ends.len(),
            started: 0,
            arrived: 0,
            touched: [0; 3],
            refused: Vec::new(),
            lost: Vec::new(),
        };
        for end in ends {
            match end? {
                End::Arrived => starts.arrived += 1,
                End::Lost(lost, by) => {
                    starts.lost.push(lost);
                    by.into_iter().for_each(|by| starts.touched[by as usize] += 1);
                }
                End::Refused(refused) => starts.refused.push(refused),
            }
        }
        starts.started = starts.worlds - starts.refused.len();
        Ok(starts)
    }

    fn end(&self, seed: u64) -> Result<End, Error> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (human, eta) = random_human(self.settings, &mut rng);
        let coordination = coordination::StubbornnessSettings { eta, ..self.settings.coordination };
        let settings =
            EpisodeSettings { coordination, predict_while_human_leads: false, ..self.settings.clone() };
        let (prepared, world) = loop {
            let text = indoor_world(&mut rng);
            // draw again if even a point does not get to B
            let world = WorldText { file: "random rooms".to_owned(), text: text.clone() };
            match prepared(world, &settings, self.plant) {
                Err(error) if error.kind() == ErrorKind::World => continue,
                prepared => break (prepared?, text),
            }
        };
        let prepared = prepared.prepare(Scenario { seed, human, ..prepared.scenario().clone() })?;
        let mut time = 0.0;
        let summary = match run_prepared(&prepared, |tick| time = tick.time) {
            Err(error) if error.kind() == ErrorKind::World => {
                return Ok(End::Refused(Refused { seed, world, reason: error.to_string() }));
            }
            summary => summary?,
        };
        if summary.outcome == Outcome::Arrived {
            return Ok(End::Arrived);
        }
        let between = summary.collision.as_ref().map(|contact| &contact.between);
        let by = between.map(|[own, _]| own.kind);
        let lost = Lost {
            seed,
            world,
            alpha: human.alpha,
            gamma: human.gamma,
            eta,
            outcome: summary.outcome.name(),
            contact: between.map(|bodies| bodies.each_ref().map(|body| body.name.clone())),
            time,
        };
        Ok(End::Lost(lost, by))
    }
}

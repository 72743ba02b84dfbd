//! A scenario: everything that defines an episode, as one plain struct and as text.
//!
//! ```
//! use cocarry::scenario::{Plant, Scenario};
//! # let world = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
//! # let world = cocarry::world::World::parse("w.toml", world)?;
//!
//! let human = cocarry::preference::Perception { alpha: 0.7, gamma: 0.8 };
//! let scenario = Scenario { seed: 7, human, ..Scenario::new(world.into(), Plant::Point) };
//! let again = Scenario::parse(&scenario.text()?)?;
//! assert_eq!(again, scenario);
//! let prepared = again.prepare()?;
//! let mut episode = prepared.episode()?;
//! while episode.step().is_none() {}
//! assert_eq!(episode.summary().outcome.name(), "arrived");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod decisions;
mod given;
mod log;
mod plant;
mod preference_changes;
mod prepared;
mod setting;
mod settings;
mod snapshot;
mod warnings;
mod word;

pub use decisions::{Decisions, MAX_MOTION, PolicyLog};
pub use given::{GivenRobot, GivenWorld, WorldText};
pub use log::EpisodeLog;
pub use plant::{Plant, PlantKind, RobotSetup};
pub use preference_changes::{ParsePreferenceChangesError, PreferenceChanges, drawn_changes};
pub use prepared::{Partners, PreparedScenario};
pub use setting::{Applies, Field, Range, Setting, SettingGroup, SettingKind, Value};
pub use settings::{
    AVOID, BELIEF_LAPSE, BELIEF_RATIONALITY, INITIAL_STUBBORNNESS, PERCEPTION, PERIOD, PLANNING_STEP, POSE,
    POSTURE, RISK_WEIGHT, SETTINGS, SWAY,
};
pub use snapshot::Snapshot;
pub use word::{Word, one_of};

use crate::episode::{self, PreferenceChange};
use crate::error::Error;
use crate::human::ModelName;
use crate::located::short_lines;
use crate::preference::{Belief, Perception};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// The given values of a human's alpha and gamma; missing ones are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenPerception {
    /// alpha.
    pub alpha: Option<f64>,
    /// gamma.
    pub gamma: Option<f64>,
}

impl GivenPerception {
    /// The given values, completed by those drawn.
    pub fn or(self, drawn: Perception) -> Perception {
        Perception { alpha: self.alpha.unwrap_or(drawn.alpha), gamma: self.gamma.unwrap_or(drawn.gamma) }
    }

    /// Whether both values are given.
    pub fn is_complete(self) -> bool {
        self.alpha.is_some() && self.gamma.is_some()
    }
}

/// The human of a seed: given values, completed by values drawn from a belief. The same seed and belief
/// always give the same human.
pub fn drawn_human(belief: &Belief, given: GivenPerception, seed: u64) -> Perception {
    given.or(belief.sample(&mut ChaCha8Rng::seed_from_u64(seed)))
}

/// The complete definition of one episode: the same scenario gives the same episode, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// The seed of the gait, and of the human if the human was drawn.
    pub seed: u64,
    /// The world.
    pub world: GivenWorld,
    /// The human, as given or drawn.
    pub human: Perception,
    /// The human model.
    #[serde(default, skip_serializing_if = "ModelName::is_default")]
    pub human_model: ModelName,
    /// The human's preference changes, given or drawn. Of several at the same step, the last one applies.
    #[serde(rename = "change", default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<PreferenceChange>,
    /// Settings of the episode: belief, method, speed, step limit.
    pub settings: episode::EpisodeSettings,
    /// The plant.
    pub plant: Plant,
}

impl Scenario {
    /// The default episode of `cocarry run` in a world: seed 0, its human, and all defaults.
    pub fn new(world: GivenWorld, plant: Plant) -> Self {
        let settings = episode::EpisodeSettings::default();
        let belief = settings.predictor.belief().clone();
        Self::of_seed(0, world, plant, settings, &belief, GivenPerception::default())
    }

    /// The scenario of a seed, without preference changes: on the command line, in studies and in Python.
    /// Parameters of its human that are not given are drawn from `humans`.
    pub fn of_seed(
        seed: u64,
        world: GivenWorld,
        plant: Plant,
        settings: episode::EpisodeSettings,
        humans: &Belief,
        given: GivenPerception,
    ) -> Self {
        let (human, human_model) = (drawn_human(humans, given, seed), ModelName::default());
        Self { seed, world, human, human_model, changes: Vec::new(), settings, plant }
    }

    /// All defaults, without a world: every [setting](Setting) that has a default has it here.
    pub fn defaults() -> Self {
        Self::new(GivenWorld::default(), Plant::new(PlantKind::Rapier, RobotSetup::default()))
    }

    /// Reads a scenario's text (TOML) and checks its numbers.
    ///
    /// # Errors
    /// The line, or the key and the value. World, robot and posture are checked by [`Scenario::prepare`].
    pub fn parse(text: &str) -> Result<Self, Error> {
        let scenario: Self =
            toml::from_str(text).map_err(|e| Error::new("not a valid scenario").because(short_lines(&e)))?;
        scenario.check()?;
        Ok(scenario)
    }

    /// The scenario as text (TOML); numbers are exact to the last bit.
    ///
    /// # Errors
    /// TOML cannot represent a value.
    pub fn text(&self) -> Result<String, Error> {
        let unwritable = |e| Error::new("the scenario cannot be written as TOML").because(e);
        toml::to_string_pretty(self).map_err(unwritable)
    }
}

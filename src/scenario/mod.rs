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
//! let stage = again.prepare()?;
//! let mut episode = stage.episode()?;
//! while episode.step().is_none() {}
//! assert_eq!(episode.summary().outcome.name(), "arrived");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod error;
mod plant;
mod preference_changes;
mod prepared;
mod settings;
mod snapshot;

pub use error::ScenarioError;
pub use plant::{Plant, PlantKind, RobotSetup};
pub use preference_changes::{NotPreferenceChanges, PreferenceChanges, drawn_changes};
pub use prepared::PreparedScenario;
pub use settings::{
    AVOID, Applies, Field, INITIAL_STUBBORNNESS, Kind, PERCEPTION, POSE, POSTURE, RISK_WEIGHT, Range,
    SETTINGS, SWAY, Setting, Value, Word, one_of,
};
pub use snapshot::{Snapshot, SnapshotError};

use crate::episode::{self, PreferenceChange};
use crate::human::ModelName;
use crate::preference::{Belief, Perception};
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// alpha and gamma of a human, as far as they are given; the rest is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenPerception {
    /// alpha.
    pub alpha: Option<f64>,
    /// gamma.
    pub gamma: Option<f64>,
}

impl GivenPerception {
    /// What is given, the rest as drawn.
    pub fn or(self, drawn: Perception) -> Perception {
        Perception { alpha: self.alpha.unwrap_or(drawn.alpha), gamma: self.gamma.unwrap_or(drawn.gamma) }
    }

    /// Whether nothing is left to draw.
    pub fn is_complete(self) -> bool {
        self.alpha.is_some() && self.gamma.is_some()
    }
}

/// The human of a seed, drawn from a belief but for what is given: whoever asks for the same seed of the same
/// belief meets the same human.
pub fn drawn_human(belief: &Belief, given: GivenPerception, seed: u64) -> Perception {
    given.or(belief.sample(&mut ChaCha8Rng::seed_from_u64(seed)))
}

/// One episode, settled: whoever has it needs nothing else to run the same episode to the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Settles the gait; and from it the human was drawn, where one was.
    pub seed: u64,
    /// The world.
    pub world: WorldText,
    /// The human, as given or drawn.
    pub human: Perception,
    /// How the human decides.
    #[serde(default, skip_serializing_if = "ModelName::is_default")]
    pub human_model: ModelName,
    /// When the human changes their mind, and to what; as given or drawn. Of several at the same step, the
    /// last stands.
    #[serde(rename = "change", default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<PreferenceChange>,
    /// What the robot believes, who leads, how fast they walk, when the episode ends at the latest.
    pub settings: episode::Settings,
    /// What the controller acts on.
    pub plant: Plant,
}

/// A world file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldText {
    /// What errors call it.
    pub file: String,
    /// Its text.
    pub text: String,
}

impl From<World> for WorldText {
    fn from(world: World) -> Self {
        Self { file: world.file, text: world.text }
    }
}

impl Scenario {
    /// The episode that `cocarry run` begins in that world where nothing else is said: seed 0, its human, and
    /// all defaults.
    pub fn new(world: WorldText, plant: Plant) -> Self {
        let settings = episode::Settings::default();
        let human = drawn_human(settings.predictor.belief(), GivenPerception::default(), 0);
        Self {
            seed: 0,
            world,
            human,
            human_model: ModelName::default(),
            changes: Vec::new(),
            settings,
            plant,
        }
    }

    /// All defaults, without a world: every [setting](Setting) that has a default has it here.
    pub fn defaults() -> Self {
        Self::new(WorldText::default(), Plant::new(PlantKind::Rapier, RobotSetup::default()))
    }

    /// Reads a scenario's text (TOML) and checks its numbers.
    ///
    /// # Errors
    /// [`ScenarioError`], which names the line, or the key and the value. What is wrong with world, robot and
    /// posture shows when the scenario is prepared.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|e| ScenarioError::Syntax(Box::new(e)))?;
        scenario.check()?;
        Ok(scenario)
    }

    /// The scenario as text (TOML), every number to the last bit.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`], for what TOML has no form for.
    pub fn text(&self) -> Result<String, ScenarioError> {
        toml::to_string_pretty(self).map_err(|e| ScenarioError::Unwritable(Box::new(e)))
    }
}

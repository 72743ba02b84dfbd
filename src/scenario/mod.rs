//! A scenario: everything that defines an episode, as one plain struct and as text.
//!
//! ```
//! use cocarry::scenario::{Plant, Scenario};
//! # let world = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
//! # let world = cocarry::world::World::parse("w.toml", world)?;
//!
//! let scenario = Scenario {
//!     seed: 7,
//!     world: world.into(),
//!     human: cocarry::preference::Perception { alpha: 0.7, gamma: 0.8 },
//!     human_model: Default::default(),
//!     changes: Vec::new(),
//!     settings: Default::default(),
//!     plant: Plant::Point,
//! };
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
mod redraws;
mod snapshot;
mod stage;

pub use error::ScenarioError;
pub use redraws::{Redraws, drawn_changes};
pub use snapshot::{Snapshot, SnapshotError};
pub use stage::Stage;

use crate::control;
use crate::episode::{self, PreferenceChange};
use crate::human::ModelName;
use crate::preference::{Belief, Perception};
use crate::robot::RobotTexts;
use crate::simulation::PhysicsSettings;
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// The human of a seed, drawn from a belief: whoever asks for the same seed of the same belief meets the same human.
pub fn drawn_human(belief: &Belief, seed: u64) -> Perception {
    belief.sample(&mut ChaCha8Rng::seed_from_u64(seed))
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
    /// When the human changes their mind, and to what; as given or drawn. Of several at the same step, the last stands.
    #[serde(rename = "change", default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<PreferenceChange>,
    /// What the robot believes, who leads, how fast they walk, when the episode ends at the latest.
    pub settings: episode::Settings,
    /// What the controller acts on.
    pub plant: Plant,
}

/// A world file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

/// What the controller acts on, with what it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Plant {
    /// The planning level alone: no robot.
    Point,
    /// The robot moves exactly as its inputs say.
    Kinematic {
        /// The robot.
        carrier: Carrier,
    },
    /// Robot, object, human and obstacles as bodies.
    Rapier {
        /// The robot.
        carrier: Carrier,
        /// How the bodies are stepped, and how the human moves.
        physics: PhysicsSettings,
    },
}

/// Who carries, from which posture, controlled how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Carrier {
    /// The posture to start from, by its name in the robot file.
    pub posture: String,
    /// The controller.
    pub control: control::Settings,
    /// The robot.
    pub robot: RobotTexts,
}

impl Plant {
    /// Name, as in files and on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Kinematic { .. } => "kinematic",
            Self::Rapier { .. } => "rapier",
        }
    }

    /// Who carries; none on the planning level alone.
    pub fn carrier(&self) -> Option<&Carrier> {
        match self {
            Self::Point => None,
            Self::Kinematic { carrier } | Self::Rapier { carrier, .. } => Some(carrier),
        }
    }

    /// The physical plant's settings; none on the others.
    pub fn physics(&self) -> Option<&PhysicsSettings> {
        match self {
            Self::Point | Self::Kinematic { .. } => None,
            Self::Rapier { physics, .. } => Some(physics),
        }
    }
}

impl Scenario {
    /// Reads a scenario's text (TOML) and checks its numbers.
    ///
    /// # Errors
    /// [`ScenarioError`], which names the line, or the key and the value. What is wrong with world, robot and posture shows when the scenario
    /// is prepared.
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

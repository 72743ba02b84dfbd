//! The plants and their robots.

use super::GivenRobot;
use super::word::Word;
use crate::control;
use crate::robot::Robot;
use crate::simulation::PhysicsSettings;
use serde::{Deserialize, Serialize};

/// A plant, which the controller moves, with its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Plant {
    /// The planning level alone, without a robot.
    Point,
    /// The robot moves exactly as its inputs say.
    Kinematic {
        /// The robot.
        #[serde(rename = "robot", alias = "carrier")]
        setup: RobotSetup,
    },
    /// Robot, object, human and obstacles as bodies.
    Rapier {
        /// The robot.
        #[serde(rename = "robot", alias = "carrier")]
        setup: RobotSetup,
        /// Settings of the physics and of the human's motion.
        physics: PhysicsSettings,
    },
}

/// A robot with its posture at the start and its controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSetup {
    /// The posture at the start, by its name in the robot file.
    pub posture: String,
    /// The controller.
    pub control: control::ControlSettings,
    /// The robot.
    pub robot: GivenRobot,
}

/// A plant by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantKind {
    /// [`Plant::Point`].
    Point,
    /// [`Plant::Kinematic`].
    Kinematic,
    /// [`Plant::Rapier`].
    Rapier,
}

impl PlantKind {
    /// All plants.
    pub const ALL: [Self; 3] = [Self::Point, Self::Kinematic, Self::Rapier];

    /// Its name, as in files and on the command line, and its description.
    pub fn word(self) -> Word {
        match self {
            Self::Point => {
                ("point", "The planning level alone: the team is a point that walks its path exactly")
            }
            Self::Kinematic => ("kinematic", "The robot moves exactly as its inputs say, without dynamics"),
            Self::Rapier => (
                "rapier",
                "Robot, object, human and obstacles as bodies, with dynamics and contacts (rapier)",
            ),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.word().0
    }

    /// The plant of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl RobotSetup {
    /// A robot that starts from its first posture, with the default controller.
    pub fn new(robot: &Robot) -> Self {
        let posture = robot.postures.first().map_or(String::new(), |posture| posture.name.clone());
        Self { posture, control: control::ControlSettings::default(), robot: robot.clone().into() }
    }
}

impl Plant {
    /// The plant of a kind, with default physics. The planning level ignores the robot.
    pub fn new(kind: PlantKind, setup: RobotSetup) -> Self {
        match kind {
            PlantKind::Point => Self::Point,
            PlantKind::Kinematic => Self::Kinematic { setup },
            PlantKind::Rapier => Self::Rapier { setup, physics: PhysicsSettings::default() },
        }
    }

    /// Its kind.
    pub fn kind(&self) -> PlantKind {
        match self {
            Self::Point => PlantKind::Point,
            Self::Kinematic { .. } => PlantKind::Kinematic,
            Self::Rapier { .. } => PlantKind::Rapier,
        }
    }

    /// Name, as in files and on the command line.
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// The robot; `None` on the planning level alone.
    pub fn robot_setup(&self) -> Option<&RobotSetup> {
        match self {
            Self::Point => None,
            Self::Kinematic { setup } | Self::Rapier { setup, .. } => Some(setup),
        }
    }

    /// The physical plant's settings; `None` on the others.
    pub fn physics(&self) -> Option<&PhysicsSettings> {
        match self {
            Self::Point | Self::Kinematic { .. } => None,
            Self::Rapier { physics, .. } => Some(physics),
        }
    }

    /// [`Plant::robot_setup`], mutable.
    pub fn robot_setup_mut(&mut self) -> Option<&mut RobotSetup> {
        match self {
            Self::Point => None,
            Self::Kinematic { setup } | Self::Rapier { setup, .. } => Some(setup),
        }
    }

    /// [`Plant::physics`], mutable.
    pub fn physics_mut(&mut self) -> Option<&mut PhysicsSettings> {
        match self {
            Self::Point | Self::Kinematic { .. } => None,
            Self::Rapier { physics, .. } => Some(physics),
        }
    }
}

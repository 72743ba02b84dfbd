//! The robot's policy: it decides who leads, on which option, and optionally by which motion.
//!
//! Implement [`RobotPolicy`] to use your own policy. Pass it to an episode with
//! [`EpisodeBuilder::with_policy`](crate::episode::EpisodeBuilder::with_policy), or add it to [`METHODS`],
//! which serves the command line, studies, scenarios and recordings.

mod entry;
mod follow_hand;
mod human_led;
mod method;
mod mutual;
mod robot_led;
mod without_model;

pub use entry::MethodEntry;
pub use method::{METHODS, Method, UnknownMethod};

use crate::control::HORIZON;
use crate::coordination::{Mode, OptionTick, robot_choice};
use crate::geometry::{PlanarPose, Point, Pose};
use crate::human::Stance;
use crate::options::{OptionSet, Progress};
use crate::robot::{Configuration, InputVector, without_last};
use crate::saved::{RestoreError, Saved};
use crate::simulation::Wrench;
use serde::{Deserialize, Serialize};

/// A robot policy, which decides in every planning step.
///
/// A clone decides independently and identically. [`RobotPolicy::save`] and [`RobotPolicy::restore`] carry
/// the state that later decisions depend on through snapshots.
pub trait RobotPolicy: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The mode before the first step.
    fn initial_mode(&self) -> Mode {
        Mode::RobotLed
    }

    /// Whether the policy also needs P_o and J~_o while the human leads.
    fn predicts(&self) -> bool {
        false
    }

    /// The robot's decision at the beginning of a planning step.
    fn decide(&mut self, view: &RobotView<'_>) -> Decision;

    /// The state that later decisions depend on; empty by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Restores what [`RobotPolicy::save`] returned.
    ///
    /// # Errors
    /// [`RestoreError`] if the state belongs to another policy.
    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        saved.is_empty("policy")
    }
}

dyn_clone::clone_trait_object!(RobotPolicy);

/// The robot's view at the beginning of a planning step.
#[derive(Clone, Copy, Debug)]
pub struct RobotView<'a> {
    /// k, from 0.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Planning step, s.
    pub planning_step: f64,
    /// The team's position, m, world frame.
    pub position: Point,
    /// The options of the world.
    pub options: &'a OptionSet,
    /// The team's progress on each option.
    pub progress: &'a Progress,
    /// D_o, S_o, J_o, P_o, J~_o and omega_o, in the order of the options.
    pub evaluated: &'a [OptionTick],
    /// The option that the settings prescribe to a robot that leads; none by default.
    pub prescribed: Option<usize>,
    /// The executed option; none before the first step.
    pub executed: Option<usize>,
    /// The mode of the last planning step.
    pub mode: Mode,
    /// The human's response to the robot's lead. The robot does not know the human's option, alpha or gamma.
    pub stance: Stance,
    /// phi(k) as the robot takes it: the human's, or its mean over what was learned about eta.
    pub stubbornness: f64,
    /// g(k).
    pub discomfort: f64,
    /// The robot's base and joints; none on the point plant.
    pub configuration: Option<&'a Configuration>,
    /// `world_from_grasp`; none on the point plant.
    pub grasp: Option<Pose>,
    /// `world_from_object`. This and the fields below are there on the physical plant only.
    pub object: Option<&'a Pose>,
    /// `world_from_hand`.
    pub hand: Option<&'a Pose>,
    /// The mean wrench of the robot on the object in the last planning step, world axes, N and Nm.
    pub grip_wrench: Option<&'a Wrench>,
    /// The mean wrench of the hand on the object in the last planning step, world axes, N and Nm.
    pub hand_wrench: Option<&'a Wrench>,
}

impl RobotView<'_> {
    /// o*(k) of eq. (6), or the option that the settings prescribe. J~_o is known while the robot leads.
    pub fn best_option(&self) -> usize {
        if let Some(prescribed) = self.prescribed {
            return prescribed;
        }
        let costs = self.evaluated.iter().map(|o| (o.objective, o.expected));
        robot_choice(costs, self.stubbornness, self.executed)
    }
}

/// The robot's decision in a planning step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The leader and the option.
    pub lead: Lead,
    /// The robot's motion.
    pub motion: Motion,
}

/// The leader of the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lead {
    /// The robot, on an option (an index).
    Robot(usize),
    /// The human, on the option that the human prefers now.
    Human,
    /// The human, on the option chosen at the start.
    HumanKeepingOption,
}

/// The robot's motion: the controller's, or one that the policy gives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// Eq. (8) and (7): pose optimisation and MPC track the leader's path.
    Controlled,
    /// Eq. (7) with the policy's reference: poses of the grasp on the floor, one at the end of each planning
    /// step, this one first. Shorter control periods interpolate between them.
    Reference([PlanarPose; HORIZON]),
    /// The policy's inputs u: the base's inputs, then joint rates, rad/s (prismatic: m/s).
    Inputs(#[serde(with = "without_last")] InputVector),
    /// Eq. (8) and (7), with these inputs added to u. The sum with the rates of eq. (8) stays within the
    /// robot's limits, or, where eq. (8) alone exceeds them, does not exceed them further.
    Residual(#[serde(with = "without_last")] InputVector),
}

impl Decision {
    /// The robot leads on `option`.
    pub fn lead(option: usize) -> Self {
        Self { lead: Lead::Robot(option), motion: Motion::Controlled }
    }

    /// The robot follows the human.
    pub fn follow() -> Self {
        Self { lead: Lead::Human, motion: Motion::Controlled }
    }

    /// The same lead with another motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }

    /// The resulting mode.
    pub fn mode(&self) -> Mode {
        match self.lead {
            Lead::Robot(_) => Mode::RobotLed,
            Lead::Human | Lead::HumanKeepingOption => Mode::HumanLed,
        }
    }
}

//! The robot's controller: it computes a command from what is seen, who leads where, and what the human may
//! choose.
//!
//! Implement [`Controller`] to carry with your own control law on any plant; [`References`] has the motion
//! that the grasp should make. Pass it to an episode with
//! [`EpisodeBuilder::with_controller`](crate::episode::EpisodeBuilder::with_controller).

mod guide;
mod hitch;
mod predictive;
mod references;

pub use guide::Guide;
pub use predictive::Predictive;
pub use references::References;

use crate::control::{PoseOptimiser, Reference};
use crate::coordination::Mode;
use crate::geometry::Path;
use crate::options::{OptionSet, Progress};
use crate::plant::{Command, Seen};
use crate::policy::Motion;
use crate::preference::ChoiceDistribution;
use crate::robot::Configuration;
use crate::saved::{RestoreError, Saved};
use crate::team::{Travel, Walk};

/// A controller of the robot, called in every control period. A clone continues independently and
/// identically.
pub trait Controller: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// Whether it needs P_o while the human leads.
    fn anticipates(&self) -> bool {
        true
    }

    /// The robot's motion in this period: eqs. (8) and (7). `belief` is P_o at this position.
    fn command(&mut self, seen: &Seen<'_>, way: &Way<'_>, belief: &ChoiceDistribution) -> Command;

    /// The basis of the last command; none by default.
    fn decision_basis(&self) -> Option<DecisionBasis<'_>> {
        None
    }

    /// The state that later commands depend on; empty by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Restores what [`Controller::save`] returned.
    ///
    /// # Errors
    /// [`RestoreError`] if the state belongs to another controller.
    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        saved.is_empty("controller")
    }
}

dyn_clone::clone_trait_object!(Controller);

/// Who leads in a control period, and where.
#[derive(Clone, Copy, Debug)]
pub struct Way<'s> {
    /// Who leads.
    pub mode: Mode,
    /// The motion that the robot's policy has chosen.
    pub motion: &'s Motion,
    /// The options of the world.
    pub options: &'s OptionSet,
    /// The team's progress on each option.
    pub progress: &'s Progress,
    /// The present path, which the robot knows while it leads.
    pub path: &'s Path,
    /// The team's position along it, m.
    pub along: f64,
    /// The team's direction of travel along it.
    pub travel: Travel,
    /// How the team walks.
    pub walk: &'s dyn Walk,
    /// The index of the control period within the planning step, from 0, and the number of periods in a step.
    pub period: [u32; 2],
}

/// The basis of a command: the data of eq. (8) that others need to check it.
#[derive(Clone, Copy, Debug)]
pub struct DecisionBasis<'e> {
    /// s_o(1..H) of every option while the human leads, else of the robot's own path only. On the physical
    /// plant, the part that the path-following base leaves for the arm.
    pub references: &'e [Reference],
    /// The weight of each in eq. (8); by default P_o.
    pub weights: &'e [f64],
    /// q*.
    pub target: &'e Configuration,
    /// The candidates with their objectives, in a period that has a
    /// [`Preparation`](crate::plant::Preparation).
    pub poses: &'e PoseOptimiser,
}

/// The controller of a team without a robot.
#[derive(Clone, Copy, Debug)]
pub struct NoRobot;

impl Controller for NoRobot {
    fn anticipates(&self) -> bool {
        false
    }

    fn command(&mut self, _: &Seen<'_>, _: &Way<'_>, _: &ChoiceDistribution) -> Command {
        Command::none()
    }
}

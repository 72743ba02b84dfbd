//! The human of an episode: what they see, what they decide, and models of how.
//!
//! [`Human`] is the seam for a model of one's own: hand it to an episode with
//! [`Episode::with_human`](crate::episode::Episode::with_human), or add it to [`MODELS`], which serves the command line, studies,
//! scenarios and recordings alike.

mod boltzmann;
mod model;
mod preference;
mod scripted;

pub use boltzmann::Boltzmann;
pub use model::{HumanModel, MODELS, ModelError, ModelName, Participant};
pub use preference::{PreferenceChange, PreferenceHuman};
pub use scripted::Scripted;

use crate::coordination::{Mode, OptionTick, Stubbornness};
use crate::geometry::{Point, Pose};
use crate::options::OptionSet;
use crate::preference::{Perception, Prospect};
use crate::saved::{NotRestored, Saved};
use crate::simulation::Wrench;

/// Decides for the human in every control period.
///
/// A clone decides independently and identically; [`Human::save`] and [`Human::restore`] carry what later decisions depend on through
/// snapshots.
pub trait Human: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The human's decision at the beginning of a control period.
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision;

    /// Perceives risk and distance with this alpha and gamma from here on; models without them take no notice.
    fn set_preference(&mut self, preference: Perception) {
        let _ = preference;
    }

    /// The preference change with which step `step` began; none by default.
    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        let _ = step;
        None
    }

    /// What later decisions depend on; nothing by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Takes over what [`Human::save`] returned.
    ///
    /// # Errors
    /// [`NotRestored`] if it is not of this model.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        saved.is_empty("human")
    }
}

dyn_clone::clone_trait_object!(Human);

/// What the human sees at the beginning of a control period.
#[derive(Clone, Copy, Debug)]
pub struct HumanView<'a> {
    /// k, from 0.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// The team's position, m, world frame.
    pub position: Point,
    /// The ways through the world.
    pub options: &'a OptionSet,
    /// D_o (m) and S_o of what is left of every option, in the order of the options.
    pub prospects: &'a [Prospect],
    /// The same with J_o, P_o and omega_o.
    pub evaluated: &'a [OptionTick],
    /// c_r, m.
    pub risk_weight: f64,
    /// The option under way; none before the first step.
    pub executed: Option<usize>,
    /// Who led in the last period.
    pub mode: Mode,
    /// `world_from_hand`, on the physical plant.
    pub hand: Option<&'a Pose>,
    /// The mean wrench of the hand on the object in the last period, world axes, N and Nm, on the physical plant.
    pub wrench: Option<&'a Wrench>,
}

impl HumanView<'_> {
    /// One step of eq. (5): discomfort accumulates once the team moves, while the robot leads.
    pub fn accumulate(&self, stubbornness: &mut Stubbornness) {
        if self.executed.is_some() && self.mode == Mode::RobotLed {
            stubbornness.accumulate(crate::coordination::misalignment(self.evaluated));
        }
    }
}

/// What the human does in a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumanDecision {
    /// The option that the human would walk, as an index.
    pub option: usize,
    /// How the human answers the robot's lead.
    pub stance: Stance,
    /// phi(k), eq. (5): what a robot that adapts weighs the human's cost by. 0 for humans who never grow stubborn.
    pub stubbornness: f64,
    /// g(k), eq. (5).
    pub discomfort: f64,
    /// The alpha and gamma behind the decision, eq. (2); none for humans without.
    pub perception: Option<Perception>,
    /// Where the hand goes in this period, m, world frame, on the physical plant; by default where the leader's path leads it.
    pub hand: Option<Point>,
}

/// How the human answers the robot's lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stance {
    /// The human goes along.
    Follow,
    /// The human does not walk on: bodies are held back by the hand, a team without forces stands still.
    Resist,
    /// The human takes the lead, if the robot's policy yields it.
    TakeOver,
}

impl HumanDecision {
    /// Walks `option`; takes the lead once stubbornness exceeds 1 (Sec. IV-B.2).
    pub fn new(option: usize, stubbornness: &Stubbornness, perception: Option<Perception>) -> Self {
        Self {
            option,
            stance: if stubbornness.is_exhausted() { Stance::TakeOver } else { Stance::Follow },
            stubbornness: stubbornness.measure(),
            discomfort: stubbornness.discomfort(),
            perception,
            hand: None,
        }
    }
}

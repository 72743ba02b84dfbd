//! The human of an episode: the trait [`Human`], what a human sees and decides, and models of human
//! decisions.
//!
//! Implement [`Human`] to use your own model. Pass it to an episode with
//! [`EpisodeBuilder::with_human`](crate::episode::EpisodeBuilder::with_human), or add it to [`MODELS`], which
//! serves the command line, studies, scenarios and recordings.

mod boltzmann;
mod model;
mod models;
mod perceiving;
mod preference;
mod scripted;

pub use boltzmann::{Boltzmann, disturbances};
pub use model::{HumanModel, Participant, PreferenceChange};
pub use models::{MODELS, ModelName};
pub use perceiving::Perceiving;
pub use preference::PreferenceHuman;
pub use scripted::Scripted;

use crate::coordination::{Mode, OptionTick, Stubbornness};
use crate::geometry::{Point, Pose};
use crate::options::{OptionSet, Progress};
use crate::preference::{Perception, Prospect};
use crate::saved::{RestoreError, Saved};
use crate::simulation::Wrench;
use serde::{Deserialize, Serialize};

/// A human, who decides in every planning step, and may move the hand in every control period.
///
/// A clone decides independently and identically. [`Human::save`] and [`Human::restore`] carry the state that
/// later decisions depend on through snapshots.
pub trait Human: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// The human's decision at the beginning of a planning step.
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision;

    /// Where the hand goes by the end of a control period, m, world frame, on plants with bodies. By default,
    /// or with `None`, it goes straight to the target of the decision until the end of the planning step, or,
    /// if the decision has none, with the leader.
    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        let _ = view;
        None
    }

    /// Sets alpha and gamma from this step on. Models without them ignore the call.
    fn set_preference(&mut self, preference: Perception) {
        let _ = preference;
    }

    /// The preference change at the beginning of step `step`; none by default.
    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        let _ = step;
        None
    }

    /// The state that later decisions depend on; empty by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Restores what [`Human::save`] returned.
    ///
    /// # Errors
    /// [`RestoreError`] if the state belongs to another model.
    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        saved.is_empty("human")
    }
}

dyn_clone::clone_trait_object!(Human);

/// The human's view at the beginning of a planning step.
#[derive(Clone, Copy, Debug)]
pub struct HumanView<'a> {
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
    /// Remaining length D_o (m) and risk S_o of every option, in the order of the options.
    pub prospects: &'a [Prospect],
    /// The options with J_o, P_o and omega_o, in the same order.
    pub evaluated: &'a [OptionTick],
    /// c_r, m.
    pub risk_weight: f64,
    /// The executed option; none before the first step.
    pub executed: Option<usize>,
    /// The mode of the last planning step.
    pub mode: Mode,
    /// `world_from_hand`, on the physical plant.
    pub hand: Option<&'a Pose>,
    /// The mean wrench of the hand on the object in the last planning step, world axes, N and Nm, on the
    /// physical plant.
    pub wrench: Option<&'a Wrench>,
}

/// The human's view at the beginning of a control period.
#[derive(Clone, Copy, Debug)]
pub struct HandView<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// The index of the control period within the planning step, from 0, and the number of periods in a step.
    pub period: [u32; 2],
    /// Control period, s.
    pub control_period: f64,
    /// The decision of this planning step.
    pub decision: &'a HumanDecision,
    /// Position of the hand without its sway, m; at the beginning of the planning step, and now.
    pub hand: [Point; 2],
    /// The direction in which the hand faces now without its sway, yaw, rad, world frame.
    pub heading: f64,
    /// The mean wrench of the hand on the object in this planning step so far, world axes, N and Nm.
    pub wrench: Option<&'a Wrench>,
}

impl HandView<'_> {
    /// A point on the straight way to the decision's target, if there is one.
    pub fn toward_target(&self) -> Option<Point> {
        let target = self.decision.hand?;
        let [period, count] = self.period;
        let left = f64::from(count - period - 1) / f64::from(count);
        Some(if left == 0.0 { target } else { target - (target - self.hand[0]) * left })
    }
}

impl HumanView<'_> {
    /// One step of eq. (5): discomfort accumulates after the first step while the robot leads.
    pub fn accumulate(&self, stubbornness: &mut Stubbornness) {
        if self.executed.is_some() && self.mode == Mode::RobotLed {
            stubbornness.accumulate(crate::coordination::misalignment(self.evaluated));
        }
    }
}

/// The human's decision in a planning step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanDecision {
    /// The option that the human prefers (an index).
    pub option: usize,
    /// The human's response to the robot's lead.
    pub stance: Stance,
    /// phi(k), eq. (5): the weight of the human's cost for a robot that adapts. 0 for humans whose
    /// stubbornness does not grow.
    pub stubbornness: f64,
    /// g(k), eq. (5).
    pub discomfort: f64,
    /// The alpha and gamma behind the decision, eq. (2); none for humans without them.
    pub perception: Option<Perception>,
    /// The target of the hand at the end of this planning step on the physical plant, m, world frame. By
    /// default the hand follows the leader's path. [`Human::hand`] gives targets of control periods.
    pub hand: Option<Point>,
}

/// The human's response to the robot's lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stance {
    /// The human walks along.
    Follow,
    /// The human stops. On the physical plant the hand holds the bodies back; on the other plants the team
    /// stands still.
    Resist,
    /// The human takes the lead, if the robot's policy yields it.
    TakeOver,
}

impl HumanDecision {
    /// A human who prefers `option`, is at ease and follows.
    pub fn following(option: usize) -> Self {
        let stance = Stance::Follow;
        Self { option, stance, stubbornness: 0.0, discomfort: 0.0, perception: None, hand: None }
    }

    /// A human who prefers `option` and takes the lead once stubbornness exceeds 1 (Sec. IV-B.2).
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

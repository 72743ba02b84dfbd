//! The robot's policy: who leads, on which option, and, if it wants, by which motion.
//!
//! [`RobotPolicy`] is the seam for a policy of one's own: hand it to an episode with
//! [`Episode::with_policy`](crate::episode::Episode::with_policy), or add it to [`METHODS`], which serves the command line, studies,
//! scenarios and recordings alike.

mod human_led;
mod method;
mod mutual;
mod robot_led;
mod without_model;

pub use method::{METHODS, Method, MethodEntry, UnknownMethod};

use crate::control::HORIZON;
use crate::coordination::{Mode, OptionTick, robot_choice};
use crate::geometry::{PlanarPose, Point, Pose};
use crate::human::HumanDecision;
use crate::options::{OptionSet, Progress};
use crate::robot::{Configuration, InputVector};
use crate::saved::{NotRestored, Saved};
use crate::simulation::Observation;

/// Decides for the robot in every control period.
///
/// A clone decides independently and identically; [`RobotPolicy::save`] and [`RobotPolicy::restore`] carry what later decisions depend on
/// through snapshots.
pub trait RobotPolicy: dyn_clone::DynClone + std::fmt::Debug + Send + Sync {
    /// Who leads before the first step.
    fn initial_mode(&self) -> Mode {
        Mode::RobotLed
    }

    /// Whether the policy needs P_o and J~_o also while the human leads.
    fn predicts(&self) -> bool {
        false
    }

    /// The robot's decision at the beginning of a control period.
    fn decide(&mut self, view: &RobotView<'_>) -> Decision;

    /// What later decisions depend on; nothing by default.
    fn save(&self) -> Saved {
        Saved::default()
    }

    /// Takes over what [`RobotPolicy::save`] returned.
    ///
    /// # Errors
    /// [`NotRestored`] if it is not of this policy.
    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        saved.is_empty("policy")
    }
}

dyn_clone::clone_trait_object!(RobotPolicy);

/// What the robot knows at the beginning of a control period.
#[derive(Clone, Copy, Debug)]
pub struct RobotView<'a> {
    /// k, from 0.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// The team's position, m, world frame.
    pub position: Point,
    /// The ways through the world.
    pub options: &'a OptionSet,
    /// Where the team is on each of them.
    pub progress: &'a Progress,
    /// D_o, S_o, J_o, P_o, J~_o and omega_o, in the order of the options.
    pub evaluated: &'a [OptionTick],
    /// The option under way; none before the first step.
    pub executed: Option<usize>,
    /// Who led in the last period.
    pub mode: Mode,
    /// phi(k) and g(k), and how the human answers the robot's lead. The human's own option is known to the robot only by what it observes.
    pub human: &'a HumanDecision,
    /// The robot: base and joints; none on the point plant.
    pub configuration: Option<&'a Configuration>,
    /// `world_from_grasp`; none on the point plant.
    pub grasp: Option<Pose>,
    /// All that is seen of object, hand and wrenches; on the physical plant only.
    pub seen: Option<&'a Observation>,
}

impl RobotView<'_> {
    /// o*(k) of eq. (6). J~_o is known while the robot leads.
    pub fn best_option(&self) -> usize {
        let costs = self.evaluated.iter().map(|o| (o.objective, o.expected));
        robot_choice(costs, self.human.stubbornness, self.executed)
    }
}

/// What the robot does in a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Who leads, and where to.
    pub lead: Lead,
    /// How the robot moves.
    pub motion: Motion,
}

/// Who leads the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lead {
    /// The robot, on an option (as an index).
    Robot(usize),
    /// The human, on the option that they prefer now.
    Human,
    /// The human, on the option that was chosen first.
    HumanKeepingOption,
}

/// How the robot moves, from the least to the most of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// By eq. (8) and (7): pose optimisation and MPC track the path of whoever leads.
    Controlled,
    /// By eq. (7), the grasp tracking these poses on the floor, one a control period, from the end of this one on.
    Reference([PlanarPose; HORIZON]),
    /// By these inputs u: rim speeds, m/s, then joint rates, rad/s (prismatic: m/s).
    Inputs(InputVector),
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

    /// The same lead, by another motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }

    /// The mode that follows.
    pub fn mode(&self) -> Mode {
        match self.lead {
            Lead::Robot(_) => Mode::RobotLed,
            Lead::Human | Lead::HumanKeepingOption => Mode::HumanLed,
        }
    }
}

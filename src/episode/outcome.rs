//! How an episode ended, and what is worth knowing of it afterwards.

use super::{PhysicsTick, RobotTick};
use crate::control::SolveOutcome;
use crate::geometry::Point;
use crate::simulation::{Contact, Failure, Observation, Party};
use serde::{Deserialize, Serialize};

/// How an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// The team stands at the target.
    Arrived,
    /// The tick limit passed before.
    OutOfTime,
    /// No way leads on from where the team stands.
    NoWay,
    /// Robot, object or human touched an obstacle: see [`Summary::collision`].
    Collided,
    /// The team did not come on for ten seconds.
    Stuck,
    /// The object fell.
    Dropped,
    /// Robot or human no longer held the object: see [`Summary::loss`].
    ObjectLost,
    /// A state stopped being a number: see [`Summary::failure`].
    NonFinite,
}

impl Outcome {
    /// Name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::OutOfTime => "out-of-time",
            Self::NoWay => "no-way",
            Self::Collided => "collided",
            Self::Stuck => "stuck",
            Self::Dropped => "dropped",
            Self::ObjectLost => "object-lost",
            Self::NonFinite => "non-finite",
        }
    }
}

/// The one transition from robot-led to human-led.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transition {
    /// k at which phi first exceeded 1.
    pub step: u64,
    /// Where the team was, m, world frame.
    pub position: Point,
}

/// How far (m) the grasp may be from where it should be, and a grip may yield; beyond, the object is lost. On the kinematic plant it is lost
/// where that holds in two periods one after the other: the human there comes to full speed, or turns, at once, and the robot sees it a
/// period later.
pub const LOSS_DISTANCE_M: f64 = 0.1;
/// From this grasp error (m, root mean square over an episode) on, a robot is said not to keep up.
pub const GRASP_WARNING_RMS_M: f64 = 0.05;

/// The loss of the object: a grasp or a grip that was more than [`LOSS_DISTANCE_M`] off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loss {
    /// At whose end: the robot or the human.
    pub by: Party,
    /// k of the step in which it happened.
    pub step: u64,
    /// How far the grasp was from where it should have been, or the grip yielded, m.
    pub distance: f64,
}

/// What is worth knowing of an episode afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How it ended.
    pub outcome: Outcome,
    /// Planning steps taken.
    pub steps: u64,
    /// Way walked, m.
    pub walked: f64,
    /// Sum over the steps of J of the option executed, m.
    pub accumulated_cost: f64,
    /// The option executed first.
    pub first_option: usize,
    /// The option executed last.
    pub last_option: usize,
    /// How often the executed option changed.
    pub changes: u32,
    /// The transition of the mode, if there was one.
    pub transition: Option<Transition>,
    /// What the human made of it.
    pub human: HumanSummary,
    /// What the robot's part cost, in an episode that has one.
    pub control: Option<ControlSummary>,
    /// What robot, object and human did to each other, on the physical plant.
    pub interaction: Option<InteractionSummary>,
    /// The first contact with an obstacle, which ends an episode.
    pub collision: Option<Contact>,
    /// The loss of the object, which ends an episode.
    pub loss: Option<Loss>,
    /// Steps up to now, one after the other, in which the grasp was too far off.
    pub(super) steps_beyond: u32,
    /// What broke, if anything did.
    pub failure: Option<Failure>,
}

/// What an episode was to the human.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HumanSummary {
    /// phi in the last step.
    pub stubbornness: f64,
    /// g in the last step.
    pub discomfort: f64,
    /// Steps in which another option was executed than this human preferred.
    pub steps_off_preference: u64,
    /// Sum over the steps of J^, eq. (2), of the option executed, with the alpha and gamma that the human had then; cost units.
    pub subjective_cost: f64,
    /// How often the human's alpha and gamma changed.
    pub changes_of_mind: u32,
    /// How often the option that the human preferred changed.
    pub preference_switches: u32,
}

impl HumanSummary {
    /// Share of so many steps in which another option was executed than this human preferred.
    pub fn share_off_preference(&self, steps: u64) -> f64 {
        self.steps_off_preference as f64 / steps.max(1) as f64
    }
}

/// What robot, object and human did to each other over an episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InteractionSummary {
    /// Steps summed over.
    pub steps: u64,
    /// Sum of the human's force on the object, N (its root mean square in each step).
    pub hand_force: f64,
    /// Sum of its square, N^2.
    pub squared_hand_force: f64,
    /// Largest force in either grip, N.
    pub peak_force: f64,
    /// Sums of the squares of what the robot's and the human's force change by from one physics step to the next, N^2 (the mean square in each
    /// planning step).
    pub squared_force_change: [f64; 2],
    /// Work that the robot and the human did on the object, J.
    pub work: [f64; 2],
    /// Integral of the square of the object's jerk, m^2/s^5.
    pub squared_jerk: f64,
    /// The most that a grip yielded, m.
    pub stretch: f64,
    /// The most that a motor of the arm exerted in a physics step, as a share of the URDF's effort limit.
    pub effort_share: f64,
}

impl InteractionSummary {
    pub(super) fn add(&mut self, tick: &PhysicsTick) {
        self.steps += 1;
        self.hand_force += tick.hand_force;
        self.squared_hand_force += tick.hand_force * tick.hand_force;
        self.peak_force = self.peak_force.max(tick.peak_force);
        for (sum, change) in self.squared_force_change.iter_mut().zip(tick.force_change) {
            *sum += change * change;
        }
        self.work[0] += tick.work[0];
        self.work[1] += tick.work[1];
        self.squared_jerk += tick.squared_jerk;
        self.stretch = self.stretch.max(tick.stretch[0]).max(tick.stretch[1]);
        self.effort_share = self.effort_share.max(tick.effort_share);
    }

    /// Mean of the human's force on the object, N.
    pub fn mean_force(&self) -> f64 {
        self.hand_force / self.steps.max(1) as f64
    }

    /// Its root mean square, N.
    pub fn rms_force(&self) -> f64 {
        (self.squared_hand_force / self.steps.max(1) as f64).sqrt()
    }

    /// How much forces chatter: the root mean square of what a grip's force changes by from one physics step to the next, N; the larger of the
    /// two grips'.
    pub fn force_noise(&self) -> f64 {
        let [robot, human] = self.squared_force_change;
        (robot.max(human) / self.steps.max(1) as f64).sqrt()
    }
}

/// The control cost C of an episode (Sec. V-C), and what went with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlSummary {
    /// Sum of ||x - s||_Q^2.
    pub tracking: f64,
    /// Sum of ||u||_R^2.
    pub effort: f64,
    /// Sum of kappa ||q* - q_c||^2.
    pub pose: f64,
    /// Sum of squared distances between grasp and reference, m^2.
    pub squared_error: f64,
    /// The largest of these distances, m.
    pub largest_error: f64,
    /// Steps in which a limit of joints or wheels was active, or an obstacle kept the robot off.
    pub constrained_steps: u64,
    /// Steps without a solution of eq. (7).
    pub fallback_steps: u64,
    /// Steps in which eq. (8) chose another configuration.
    pub pose_changes: u64,
    /// Steps in which the base overlapped an obstacle.
    pub overlapping_steps: u64,
    /// The least distance between the base and an obstacle, m; infinite without obstacles.
    pub least_clearance: f64,
}

impl Default for ControlSummary {
    fn default() -> Self {
        Self {
            tracking: 0.0,
            effort: 0.0,
            pose: 0.0,
            squared_error: 0.0,
            largest_error: 0.0,
            constrained_steps: 0,
            fallback_steps: 0,
            pose_changes: 0,
            overlapping_steps: 0,
            least_clearance: f64::INFINITY,
        }
    }
}

impl ControlSummary {
    /// C.
    pub fn cost(&self) -> f64 {
        self.tracking + self.effort + self.pose
    }

    /// Root mean square distance between grasp and reference over so many steps, m.
    pub fn error_rms(&self, steps: u64) -> f64 {
        (self.squared_error / steps.max(1) as f64).sqrt()
    }

    pub(super) fn add(&mut self, tick: &RobotTick) {
        self.tracking += tick.tracking_cost;
        self.effort += tick.control_effort;
        self.pose += tick.pose_cost;
        self.squared_error += tick.position_error * tick.position_error;
        self.largest_error = self.largest_error.max(tick.position_error);
        match tick.outcome {
            SolveOutcome::Unconstrained => {}
            SolveOutcome::Constrained { active, .. } => self.constrained_steps += u64::from(active > 0),
            SolveOutcome::Fallback(_) => self.fallback_steps += 1,
        }
        self.pose_changes += u64::from(tick.preparation.is_some_and(|p| p.candidate != 0));
        self.overlapping_steps += u64::from(tick.base_clearance < 0.0);
        self.least_clearance = self.least_clearance.min(tick.base_clearance);
    }
}

impl Summary {
    /// Books a step: what the robot did, what is seen of the bodies, and the loss of the object, unless that is to be ignored.
    pub(super) fn add(&mut self, robot: Option<&RobotTick>, seen: Option<&Observation>, ignores_loss: bool) {
        if let Some(tick) = robot {
            let (by, distance) = tick.worst_hold();
            self.steps_beyond = if distance > LOSS_DISTANCE_M { self.steps_beyond + 1 } else { 0 };
            let enough = if tick.physics.is_some() { 1 } else { 2 };
            if self.steps_beyond >= enough && !ignores_loss {
                self.loss = Some(Loss { by, step: self.steps, distance });
            }
            self.control.get_or_insert_default().add(tick);
            if let Some(physics) = &tick.physics {
                self.interaction.get_or_insert_default().add(physics);
            }
        }
        if let Some(seen) = seen {
            let obstacle = |contact: &&Contact| contact.between.iter().any(|p| p.party == Party::Obstacle);
            self.collision = seen.contacts.iter().find(obstacle).cloned();
            self.failure.clone_from(&seen.failure);
        }
    }

    /// The outcome of an episode that cannot go on: something broke, or touched an obstacle.
    pub(super) fn incident(&self) -> Option<Outcome> {
        match &self.failure {
            Some(Failure::NonFinite { .. }) => return Some(Outcome::NonFinite),
            Some(Failure::Dropped) => return Some(Outcome::Dropped),
            None => {}
        }
        if self.collision.is_some() {
            return Some(Outcome::Collided);
        }
        self.loss.map(|_| Outcome::ObjectLost)
    }

    pub(super) fn empty() -> Self {
        Self {
            outcome: Outcome::OutOfTime,
            steps: 0,
            walked: 0.0,
            accumulated_cost: 0.0,
            first_option: 0,
            last_option: 0,
            changes: 0,
            transition: None,
            human: HumanSummary::default(),
            control: None,
            interaction: None,
            collision: None,
            loss: None,
            steps_beyond: 0,
            failure: None,
        }
    }
}

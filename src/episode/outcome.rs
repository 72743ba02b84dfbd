//! The outcome and the summary of an episode.

use super::{MotionSummary, PhysicsTick, RobotTick, Tick};
use crate::control::SolveOutcome;
use crate::coordination::{Mode, STUBBORNNESS_THRESHOLD};
use crate::geometry::Point;
use crate::robot::JointVector;
use crate::simulation::{BodyKind, Contact, Failure, Observation, Sharing};
use serde::{Deserialize, Serialize};

/// The outcome of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// The team stands at the target.
    Arrived,
    /// The tick limit passed before arrival.
    OutOfTime,
    /// No path leads on from the team's position.
    NoWay,
    /// Robot, object or human touched an obstacle: see [`Summary::collision`].
    Collided,
    /// The team made no progress for ten seconds.
    Stuck,
    /// The object fell.
    Dropped,
    /// Robot or human no longer held the object: see [`Summary::loss`].
    ObjectLost,
    /// A state is no longer finite: see [`Summary::failure`].
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

/// The transition from robot-led to human-led, which happens once.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transition {
    /// k at which phi first exceeded 1.
    pub step: u64,
    /// Position of the team, m, world frame.
    pub position: Point,
}

/// Largest deflection of a grip before the object is lost, m. The kinematic plant has no grips: there the
/// object is lost if the grasp is farther than this from where the human holds the object at the ends of two
/// consecutive planning steps, because the human there reaches full speed, or turns, at once, and the robot
/// reacts later. The distance from the planned path loses nothing.
pub const LOSS_DISTANCE_M: f64 = 0.1;
/// The distance of the grasp from its reference on the planned path (m, root mean square over an episode)
/// above which an episode has a warning.
pub const GRASP_WARNING_RMS_M: f64 = 0.05;

/// The loss of the object: a grip's deflection, or the distance of hand, object and grasp where there are no
/// grips, beyond [`LOSS_DISTANCE_M`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loss {
    /// The end at which it happened: the robot's or the human's.
    pub by: BodyKind,
    /// k of the step in which it happened.
    pub step: u64,
    /// The grip's deflection or the distance of the grasp, m.
    pub distance: f64,
}

/// The summary of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the episode ended.
    pub outcome: Outcome,
    /// Planning steps taken.
    pub steps: u64,
    /// Distance walked, m.
    pub walked: f64,
    /// Length of the shortest option at the start, m.
    pub shortest: f64,
    /// Sum of J of the executed option over the steps, m.
    pub accumulated_cost: f64,
    /// The option executed first.
    pub first_option: usize,
    /// The option executed last.
    pub last_option: usize,
    /// Number of changes of the executed option.
    pub option_changes: u32,
    /// The transition of the mode, if there was one.
    pub transition: Option<Transition>,
    /// The human's part.
    pub human: HumanSummary,
    /// The robot's control cost, in an episode with a robot.
    pub control: Option<ControlSummary>,
    /// How both ends of the object moved, in an episode with a robot.
    pub motion: Option<MotionSummary>,
    /// The physical interaction of robot, object and human, on the physical plant.
    pub interaction: Option<InteractionSummary>,
    /// The first contact with an obstacle, which ends an episode.
    pub collision: Option<Contact>,
    /// The loss of the object, which ends an episode.
    pub loss: Option<Loss>,
    /// Number of consecutive steps up to now with a grasp error beyond the limit.
    pub(super) steps_beyond: u32,
    /// The failure, if any.
    pub failure: Option<Failure>,
}

/// The human's part of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanSummary {
    /// phi in the last step.
    pub stubbornness: f64,
    /// g in the last step.
    pub discomfort: f64,
    /// The option that the human preferred in the first step.
    pub preferred_at_start: usize,
    /// Steps in which the executed option was not the one that this human preferred.
    pub steps_off_preference: u64,
    /// Steps in which the robot led although phi exceeded 1.
    pub steps_overruled: u64,
    /// Sum over the steps of J^, eq. (2), of the executed option with the human's alpha and gamma at that
    /// step; cost units. None once a human without alpha and gamma has decided.
    pub subjective_cost: Option<f64>,
    /// Number of changes of the human's alpha and gamma.
    pub preference_changes: u32,
    /// Number of changes of the preferred option.
    pub preferred_option_switches: u32,
}

impl Default for HumanSummary {
    fn default() -> Self {
        Self {
            stubbornness: 0.0,
            discomfort: 0.0,
            preferred_at_start: 0,
            steps_off_preference: 0,
            steps_overruled: 0,
            subjective_cost: Some(0.0),
            preference_changes: 0,
            preferred_option_switches: 0,
        }
    }
}

impl HumanSummary {
    /// Share of `steps` in which the executed option was not the one that this human preferred.
    pub fn share_off_preference(&self, steps: u64) -> f64 {
        self.steps_off_preference as f64 / steps.max(1) as f64
    }
}

/// The physical interaction of robot, object and human over an episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InteractionSummary {
    /// Number of steps in the sums.
    pub steps: u64,
    /// Sum of the human's force on the object over the steps, N (in each step its root mean square).
    pub hand_force: f64,
    /// Sum of its squares, N^2.
    pub squared_hand_force: f64,
    /// Largest force in either grip, N.
    pub peak_force: f64,
    /// Sums of the squares of the noise of the robot's and of the human's force, its part above 10 Hz, N^2 (in
    /// each planning step the mean square).
    pub squared_force_noise: [f64; 2],
    /// How both shared the object.
    pub sharing: Sharing,
    /// Work that the robot and the human did on the object, J.
    pub work: [f64; 2],
    /// Integral of the square of the object's jerk, m^2/s^5.
    pub squared_jerk: f64,
    /// Least distance at the end of a step of robot, object or human to an obstacle, infinite without
    /// obstacles, and between robot and human, m; `None` before the first step.
    pub least_distances: Option<[f64; 2]>,
    /// Largest deflection of a grip, m.
    pub deflection: f64,
    /// Largest motor effort of the arm in a physics step, as a share of the URDF's effort limit.
    pub effort_share: f64,
    /// How long each joint's motor was at its limit, s.
    #[serde(default)]
    pub time_at_limit: JointVector,
}

impl InteractionSummary {
    pub(super) fn add(&mut self, tick: &PhysicsTick) {
        self.steps += 1;
        self.hand_force += tick.hand_force;
        self.squared_hand_force += tick.hand_force * tick.hand_force;
        self.peak_force = self.peak_force.max(tick.peak_force);
        for (sum, noise) in self.squared_force_noise.iter_mut().zip(tick.force_noise) {
            *sum += noise * noise;
        }
        self.sharing.add(&tick.sharing);
        self.work[0] += tick.work[0];
        self.work[1] += tick.work[1];
        let [obstacle, human] = self.least_distances.unwrap_or([f64::INFINITY; 2]);
        self.least_distances = Some([obstacle.min(tick.obstacle_distance), human.min(tick.human_distance)]);
        self.squared_jerk += tick.squared_jerk;
        self.deflection = self.deflection.max(tick.deflection[0]).max(tick.deflection[1]);
        self.effort_share = self.effort_share.max(tick.effort_share);
        self.time_at_limit += tick.time_at_limit;
    }

    /// Mean of the human's force on the object, N.
    pub fn mean_force(&self) -> f64 {
        self.hand_force / self.steps.max(1) as f64
    }

    /// Its root mean square, N.
    pub fn rms_force(&self) -> f64 {
        (self.squared_hand_force / self.steps.max(1) as f64).sqrt()
    }

    /// The noise of the forces: root mean square of a grip's force above 10 Hz, N; the larger of the two
    /// grips'. See [`Forces::noise`](crate::simulation::Forces::noise).
    pub fn force_noise(&self) -> f64 {
        let [robot, human] = self.squared_force_noise;
        (robot.max(human) / self.steps.max(1) as f64).sqrt()
    }
}

/// The control cost C of an episode (Sec. V-C), with related figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlSummary {
    /// Sum of ||x - s||_Q^2.
    pub tracking: f64,
    /// Sum of ||u||_R^2.
    pub effort: f64,
    /// The base's part of it.
    #[serde(default)]
    pub wheels: f64,
    /// Sum of ||x - s||_Q^2 against a human who does not wait for the robot.
    #[serde(default)]
    pub intended_tracking: f64,
    /// Sum of kappa ||q* - q_c||^2.
    pub pose: f64,
    /// Sum of squared distances between grasp and reference, m^2.
    pub squared_error: f64,
    /// The largest of these distances, m.
    pub largest_error: f64,
    /// Steps in which a limit of joints or wheels, or a half-plane of an obstacle, was active.
    pub constrained_steps: u64,
    /// Steps without a solution of eq. (7).
    pub fallback_steps: u64,
    /// Steps in which eq. (8) chose another configuration.
    pub pose_changes: u64,
    /// Steps in which the base overlapped an obstacle at the beginning of a control period.
    pub overlapping_steps: u64,
    /// Smallest distance between the base and an obstacle, m; infinite without obstacles.
    pub least_clearance: f64,
    /// Steps in which the robot touched itself at the end of a control period.
    #[serde(default)]
    pub self_contact_steps: u64,
    /// The first two links that did: indices into [`Robot::links`](crate::robot::Robot::links).
    #[serde(default)]
    pub self_contact: Option<[usize; 2]>,
}

impl Default for ControlSummary {
    fn default() -> Self {
        Self {
            tracking: 0.0,
            effort: 0.0,
            wheels: 0.0,
            intended_tracking: 0.0,
            pose: 0.0,
            squared_error: 0.0,
            largest_error: 0.0,
            constrained_steps: 0,
            fallback_steps: 0,
            pose_changes: 0,
            overlapping_steps: 0,
            least_clearance: f64::INFINITY,
            self_contact_steps: 0,
            self_contact: None,
        }
    }
}

impl ControlSummary {
    /// The control cost C.
    pub fn cost(&self) -> f64 {
        self.tracking + self.effort + self.pose
    }

    /// The arm's part of the effort.
    pub fn arm(&self) -> f64 {
        self.effort - self.wheels
    }

    /// C against the intended walk of a human who does not wait for the robot.
    pub fn intended_cost(&self) -> f64 {
        self.intended_tracking + self.effort + self.pose
    }

    /// Root mean square distance between grasp and reference over `steps` steps, m.
    pub fn error_rms(&self, steps: u64) -> f64 {
        (self.squared_error / steps.max(1) as f64).sqrt()
    }

    pub(super) fn add(&mut self, tick: &RobotTick) {
        self.tracking += tick.tracking_cost;
        self.effort += tick.effort_cost;
        self.wheels += tick.wheel_cost;
        self.intended_tracking += tick.intended_cost;
        self.pose += tick.pose_cost;
        self.squared_error += tick.position_error * tick.position_error;
        self.largest_error = self.largest_error.max(tick.position_error);
        match tick.outcome {
            SolveOutcome::Unconstrained => {}
            SolveOutcome::Constrained { active } => self.constrained_steps += u64::from(active > 0),
            SolveOutcome::Fallback(_) => self.fallback_steps += 1,
        }
        self.pose_changes += u64::from(tick.pose_changed);
        self.overlapping_steps += u64::from(tick.base_clearance < 0.0);
        self.least_clearance = self.least_clearance.min(tick.base_clearance);
        self.self_contact_steps += u64::from(tick.self_contact.is_some());
        self.self_contact = self.self_contact.or(tick.self_contact);
    }
}

/// The decisions of the step before.
#[derive(Clone, Copy)]
pub(super) struct Before {
    pub executed: usize,
    pub preferred: usize,
    pub mode: Mode,
}

/// A step that is over.
pub(super) struct Done<'s> {
    pub tick: &'s Tick,
    /// The step before; none before the first.
    pub before: Option<Before>,
    /// J^ of the executed option, for a human who has alpha and gamma.
    pub subjective_cost: Option<f64>,
    /// Whether it began with a preference change.
    pub has_changed: bool,
    /// Distance walked, m.
    pub walked: f64,
    /// Length of the shortest option at its beginning, m.
    pub shortest: f64,
    /// The team's walking speed, m/s.
    pub speed: f64,
    /// The observation of the bodies at its end.
    pub bodies: Option<&'s Observation>,
    pub ignores_loss: bool,
}

impl HumanSummary {
    fn add(&mut self, done: &Done) {
        let Tick { executed, preferred, stubbornness, discomfort, mode, .. } = *done.tick;
        match done.before {
            None => self.preferred_at_start = preferred,
            Some(before) => self.preferred_option_switches += u32::from(before.preferred != preferred),
        }
        self.preference_changes += u32::from(done.has_changed);
        self.steps_off_preference += u64::from(executed != preferred);
        self.steps_overruled += u64::from(mode == Mode::RobotLed && stubbornness > STUBBORNNESS_THRESHOLD);
        self.subjective_cost = self.subjective_cost.zip(done.subjective_cost).map(|(sum, cost)| sum + cost);
        (self.stubbornness, self.discomfort) = (stubbornness, discomfort);
    }
}

impl Summary {
    /// Adds a step.
    pub(super) fn add(&mut self, done: &Done) {
        let tick = done.tick;
        match done.before {
            None => (self.first_option, self.shortest) = (tick.executed, done.shortest),
            Some(before) => {
                self.option_changes += u32::from(before.executed != tick.executed);
                if before.mode == Mode::RobotLed && tick.mode == Mode::HumanLed {
                    self.transition = Some(Transition { step: tick.step, position: tick.position });
                }
            }
        }
        self.last_option = tick.executed;
        self.accumulated_cost = tick.accumulated_cost;
        self.walked += done.walked;
        self.human.add(done);
        if let Some(robot) = &tick.robot {
            self.add_robot(robot, done.ignores_loss);
        }
        if let Some(ends) = &tick.ends {
            self.motion.get_or_insert_default().add(ends, done.speed);
        }
        if let Some(seen) = done.bodies {
            let obstacle = |contact: &&Contact| contact.between.iter().any(|p| p.kind == BodyKind::Obstacle);
            self.collision = seen.contacts.iter().find(obstacle).cloned();
            self.failure.clone_from(&seen.failure);
        }
        self.steps += 1;
    }

    /// Adds the robot's part, with the loss of the object unless it is ignored.
    fn add_robot(&mut self, tick: &RobotTick, ignores_loss: bool) {
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

    /// Whether the object was lost, also in an episode that went on.
    pub fn has_lost_object(&self) -> bool {
        let worst = match (&self.interaction, &self.control) {
            (Some(interaction), _) => interaction.deflection,
            (None, control) => control.map_or(0.0, |control| control.largest_error),
        };
        self.loss.is_some() || worst > LOSS_DISTANCE_M
    }

    /// The outcome of an episode that cannot continue after a failure or a collision.
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
            shortest: f64::INFINITY,
            accumulated_cost: 0.0,
            first_option: 0,
            last_option: 0,
            option_changes: 0,
            transition: None,
            human: HumanSummary::default(),
            control: None,
            motion: None,
            interaction: None,
            collision: None,
            loss: None,
            steps_beyond: 0,
            failure: None,
        }
    }
}

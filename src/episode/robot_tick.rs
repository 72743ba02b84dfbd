//! The robot's part of one planning step, as data.

use crate::control::{Manipulator, SolveOutcome, least_singular_value};
use crate::geometry::{PlanarPose, Pose};
use crate::plant::{Command, Preparation, Seen};
use crate::robot::{Configuration, InputJacobian, InputVector, JointVector, pose_difference, without_last};
use crate::simulation::{BodyKind, Clearance, Observation, Sharing};
use crate::team::Place;
use serde::{Deserialize, Serialize};

/// The robot in one planning step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotTick {
    /// q_c: the configuration at the beginning of the step.
    pub configuration: Configuration,
    /// s: the pose that the grasp should have at the beginning of the step. On the kinematic plant, the human
    /// has no other state.
    pub grasp_goal: PlanarPose,
    /// The prepared configuration: while the human leads, or in every step if so configured.
    /// That of the step's last control period.
    pub preparation: Option<Preparation>,
    /// Whether eq. (8) chose another configuration in a control period of the step.
    #[serde(default)]
    pub pose_changed: bool,
    /// u: the base's inputs and joint rates.
    #[serde(with = "without_last")]
    pub input: InputVector,
    /// How eq. (7) was solved.
    pub outcome: SolveOutcome,
    /// B(q*) of eq. (7); zeros in a tick that was read from a snapshot.
    #[serde(skip)]
    pub input_matrix: InputJacobian,
    /// Distance between grasp and reference at the end of the step, m.
    pub position_error: f64,
    /// Angle between them, rad.
    pub orientation_error: f64,
    /// ||x - s||_Q^2 at the end of a control period. All costs and u are means over the control periods of the
    /// planning step, so that C does not grow with the controller's rate.
    pub tracking_cost: f64,
    /// ||u||_R^2.
    pub effort_cost: f64,
    /// The base's part of it.
    #[serde(default)]
    pub wheel_cost: f64,
    /// ||x - s||_Q^2 against a human who does not wait for the robot, as `tracking_cost`.
    #[serde(default)]
    pub intended_cost: f64,
    /// kappa ||q* - q_c||^2.
    pub pose_cost: f64,
    /// Distance between the base and the nearest obstacle at the beginning of the step, m: the least over its
    /// control periods. Negative where they overlap, infinite without obstacles.
    pub base_clearance: f64,
    /// The first two links of the robot that touch each other at the end of a control period of the step:
    /// indices into [`Robot::links`](crate::robot::Robot::links).
    #[serde(default)]
    pub self_contact: Option<[usize; 2]>,
    /// Further observations on the physical plant.
    pub physics: Option<PhysicsTick>,
}

/// The physical plant in one planning step. Forces are magnitudes over the step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhysicsTick {
    /// The object's centre and heading at the end of the step, seen from above.
    pub object: PlanarPose,
    /// The human's hand at the end of the step, seen from above.
    pub hand: PlanarPose,
    /// The human's torso at the end of the step, seen from above.
    pub torso: PlanarPose,
    /// Root mean square of the robot's force on the object, N.
    pub grip_force: f64,
    /// Root mean square of the human's force on the object, N.
    pub hand_force: f64,
    /// The larger of the two forces' peaks, N.
    pub peak_force: f64,
    /// Noise of the robot's and of the human's force on the object: root mean square of its part above 10 Hz,
    /// N.
    pub force_noise: [f64; 2],
    /// Largest deflection of the robot's and of the human's grip, m.
    pub deflection: [f64; 2],
    /// Largest motor effort of the arm in a physics step, as a share of the URDF's effort limit; 0 without
    /// such limits.
    pub effort_share: f64,
    /// How long each joint's motor was at its limit in the step, s.
    #[serde(default)]
    pub time_at_limit: JointVector,
    /// How both share the object.
    pub sharing: Sharing,
    /// Work done on the object by the robot and by the human, J.
    pub work: [f64; 2],
    /// Integral of the square of the object's jerk, m^2/s^5.
    pub squared_jerk: f64,
    /// Smallest distance of robot, object or human to an obstacle at the end of the step, m; infinite without
    /// obstacles.
    pub obstacle_distance: f64,
    /// Distance between robot and human at the end of the step, m.
    pub human_distance: f64,
    /// How far the leader's intended position is ahead of the object along the path at the end of the step,
    /// m.
    pub path_lead: f64,
}

impl PhysicsTick {
    fn of(seen: &Observation, path_lead: f64) -> Self {
        let near = &seen.clearances;
        let distance = |c: &Option<Clearance>| c.as_ref().map_or(f64::INFINITY, |c| c.distance);
        Self {
            object: PlanarPose::from_above(&seen.object),
            hand: seen.hand_planar,
            torso: PlanarPose::from_above(&seen.torso),
            grip_force: seen.grip.rms,
            hand_force: seen.hand_grip.rms,
            peak_force: seen.grip.peak.max(seen.hand_grip.peak),
            force_noise: [seen.grip.noise, seen.hand_grip.noise],
            deflection: [seen.grip.deflection, seen.hand_grip.deflection],
            effort_share: seen.effort_share,
            time_at_limit: seen.time_at_limit,
            sharing: seen.sharing,
            work: [seen.grip.work, seen.hand_grip.work],
            squared_jerk: seen.squared_jerk,
            obstacle_distance: distance(&near.robot_obstacle)
                .min(distance(&near.object_obstacle))
                .min(distance(&near.human_obstacle)),
            human_distance: distance(&near.robot_human),
            path_lead,
        }
    }
}

/// The beginning and the end of a control period, as a robot's tick needs them.
pub(super) struct Period<'p> {
    /// q_c, and s as the pose that the grasp should have, at its beginning.
    pub begin: (Configuration, PlanarPose),
    /// The observation at its end.
    pub end: Seen<'p>,
    /// s at its end.
    pub goal: PlanarPose,
    /// s at its end of a human who does not wait for the robot.
    pub intended: PlanarPose,
    /// Where the team has come.
    pub place: Place,
}

impl RobotTick {
    /// The step's contribution to the control cost C (Sec. V-C).
    pub fn cost(&self) -> f64 {
        self.tracking_cost + self.effort_cost + self.pose_cost
    }

    /// The smallest singular value of B(q*), m or rad for a unit input.
    pub fn least_singular_value(&self) -> f64 {
        least_singular_value(&self.input_matrix)
    }

    /// The body with the worst hold on the object, and the deviation (m): the deflection of its grip. On the
    /// kinematic plant, which has no grips, it is the distance of the grasp from s, where the human holds it.
    pub fn worst_hold(&self) -> (BodyKind, f64) {
        let Some(physics) = &self.physics else { return (BodyKind::Robot, self.position_error) };
        let [gripper, hand] = physics.deflection;
        if hand > gripper { (BodyKind::Human, hand) } else { (BodyKind::Robot, gripper) }
    }

    /// The tick of a period in which the robot had this command. `poses` is memory for the poses of the robot's
    /// bodies.
    pub(super) fn of(
        manipulator: &Manipulator<'_>,
        command: &Command,
        period: &Period<'_>,
        poses: &mut Vec<Pose>,
    ) -> Self {
        let Manipulator { robot, control, obstacles, .. } = *manipulator;
        let (configuration, grasp_goal) = period.begin;
        let Seen { configuration: reached, grasp, bodies, .. } = period.end;
        let reached = reached.copied().unwrap_or(configuration);
        let grasp = bodies.map(|bodies| bodies.grasp).or(grasp).unwrap_or_else(Pose::identity);
        let off = |goal: &PlanarPose| pose_difference(&goal.at_height(robot.grasp_height), &grasp);
        let error = off(&period.goal);
        Self {
            configuration,
            grasp_goal,
            preparation: command.preparation,
            pose_changed: command.preparation.is_some_and(|p| p.candidate != 0),
            input: command.input,
            outcome: command.outcome,
            input_matrix: command.input_matrix,
            position_error: error.fixed_rows::<3>(0).norm(),
            orientation_error: error.fixed_rows::<3>(3).norm(),
            tracking_cost: control.state_weight * error.norm_squared(),
            effort_cost: control.input_weight * command.input.norm_squared(),
            wheel_cost: control.input_weight * robot.base_input(&command.input).norm_squared(),
            intended_cost: control.state_weight * off(&period.intended).norm_squared(),
            pose_cost: command.pose_cost,
            base_clearance: obstacles.clearance(&configuration.base, &robot.footprint),
            self_contact: robot.self_contact(&reached.joints, poses),
            physics: bodies.map(|bodies| PhysicsTick::of(bodies, period.place.path_lead)),
        }
    }

    /// This period and the next one of a planning step: costs and inputs added up, states at the end.
    pub(super) fn and(self, next: &Self) -> Self {
        let Self { configuration, grasp_goal, .. } = self;
        Self {
            configuration,
            grasp_goal,
            pose_changed: self.pose_changed || next.pose_changed,
            input: self.input + next.input,
            outcome: harder(self.outcome, next.outcome),
            tracking_cost: self.tracking_cost + next.tracking_cost,
            effort_cost: self.effort_cost + next.effort_cost,
            wheel_cost: self.wheel_cost + next.wheel_cost,
            intended_cost: self.intended_cost + next.intended_cost,
            pose_cost: self.pose_cost + next.pose_cost,
            base_clearance: self.base_clearance.min(next.base_clearance),
            self_contact: self.self_contact.or(next.self_contact),
            ..*next
        }
    }

    /// The mean over this number of periods of what [`RobotTick::and`] has added up.
    pub(super) fn mean_of(self, periods: u32) -> Self {
        if periods == 1 {
            return self;
        }
        let share = 1.0 / f64::from(periods);
        Self {
            input: self.input * share,
            tracking_cost: self.tracking_cost * share,
            effort_cost: self.effort_cost * share,
            wheel_cost: self.wheel_cost * share,
            intended_cost: self.intended_cost * share,
            pose_cost: self.pose_cost * share,
            ..self
        }
    }
}

/// The outcome of the harder problem: the one with more active constraints, or a fallback.
fn harder(one: SolveOutcome, other: SolveOutcome) -> SolveOutcome {
    let rank = |outcome: SolveOutcome| match outcome {
        SolveOutcome::Unconstrained => 0,
        SolveOutcome::Constrained { active } => 1 + active,
        SolveOutcome::Fallback(_) => usize::MAX,
    };
    if rank(other) > rank(one) { other } else { one }
}

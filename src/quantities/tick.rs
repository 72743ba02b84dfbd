//! The quantities of one planning step.

use super::{
    ACCELERATION, DEGREES, Fields, JERK, JOULES, METRES, METRES_PER_SECOND, NEWTON_METRES, NEWTONS, PLAIN,
    Quantity, QuantityKind, RADIANS, RADIANS_PER_SECOND, Record, SECONDS, SQUARED_JERK, Value, View, fields,
    headings, quantities, read,
};
use crate::control::{Failure, SolveOutcome};
use crate::coordination::{OptionTick, STUBBORNNESS_THRESHOLD};
use crate::episode::{ControlSummary, EndMotions, PhysicsTick, Preparation, RobotTick, Summary, Tick};
use crate::robot::{ArmJoint, Motion};
use crate::simulation::Observation;
use QuantityKind::{Count, Flag, List, Text};

impl View<'_> {
    pub(super) fn tick(&self) -> &Tick {
        self.episode.tick()
    }

    pub(super) fn robot_tick(&self) -> Option<&RobotTick> {
        self.tick().robot.as_ref()
    }

    /// The base's inputs, for an omnidirectional base or for others.
    fn base_input(&self, is_omnidirectional: bool) -> Option<[f64; 3]> {
        let (robot, tick) = (self.prepared.robot()?, self.robot_tick()?);
        let is_asked = robot.drive.is_omnidirectional() == is_omnidirectional;
        is_asked.then(|| robot.base_input(&tick.input).into())
    }

    pub(super) fn preparation(&self) -> Option<Preparation> {
        self.robot_tick()?.preparation
    }

    fn ends(&self) -> Option<&EndMotions> {
        self.tick().ends.as_ref()
    }

    fn physics(&self) -> Option<&PhysicsTick> {
        self.robot_tick()?.physics.as_ref()
    }

    fn seen(&self) -> Option<&Observation> {
        self.episode.observation()
    }

    fn so_far(&self) -> &Summary {
        self.episode.summary()
    }

    fn control_so_far(&self) -> Option<&ControlSummary> {
        self.so_far().control.as_ref()
    }

    fn work_so_far(&self) -> Option<[f64; 2]> {
        self.so_far().interaction.as_ref().map(|interaction| interaction.work)
    }

    /// Limits active in the solution of eq. (7).
    fn active(&self) -> Option<usize> {
        self.robot_tick().map(|robot| match robot.outcome {
            SolveOutcome::Constrained { active } => active,
            _ => 0,
        })
    }
}

/// The quantities of a planning step in one row: all except the controller's preparation.
pub const TICK: [&[Quantity]; 9] =
    [STEP, TIME, COORDINATION, COST, CONTROL, BASE, INTERACTION, OPTIONS, JOINTS];

/// The number of the step.
pub const STEP: &[Quantity] = quantities! {
    "step", Count, "k, from 0", |v| v.tick().step;
};

/// The time of the step; messages of recordings have it as their time stamp.
pub const TIME: &[Quantity] = quantities! {
    "time_s", SECONDS, "simulated time at the beginning of the step", |v| v.tick().time;
};

/// Position of the team, leader and chosen options.
#[rustfmt::skip]
pub const COORDINATION: &[Quantity] = quantities! {
    "x_m", METRES, "position of the team at the beginning of the step, world x", |v| v.tick().position.x;
    "y_m", METRES, "position of the team at the beginning of the step, world y", |v| v.tick().position.y;
    "heading_deg", DEGREES, "direction of travel, counter-clockwise from x", |v| v.tick().heading.to_degrees();
    "mode", Text, "who leads: robot-led or human-led", |v| v.tick().mode.name();
    "stubbornness", PLAIN, "phi(k), eq. (5)", |v| v.tick().stubbornness;
    "stubbornness_threshold", PLAIN, "the human takes the lead when phi exceeds this: 1", |_| STUBBORNNESS_THRESHOLD;
    "discomfort", PLAIN, "g(k), eq. (5)", |v| v.tick().discomfort;
    "executed", Text, "the option executed", |v| v.option(v.tick().executed);
    "executed_index", Count, "its place among the options, from 0", |v| v.tick().executed;
    "preferred", Text, "the option that this human would choose from here", |v| v.option(v.tick().preferred);
    "preferred_index", Count, "its place among the options, from 0", |v| v.tick().preferred;
    "reverses_for", Text, "the option for which the team reverses, to where there is room to turn onto it; mostly missing", |v| v.tick().reverses_for.map(|o| v.option(o));
};

/// Costs and work, of this step and accumulated up to its end.
#[rustfmt::skip]
pub const COST: &[Quantity] = quantities! {
    "objective_cost_m", METRES, "J of the option executed", |v| v.tick().objective_cost;
    "accumulated_objective_cost_m", METRES, "sum of J of the options executed", |v| v.tick().accumulated_cost;
    "walked_m", METRES, "length of the path walked", |v| v.so_far().walked;
    "accumulated_control_cost", PLAIN, "C so far: tracking + effort + pose; missing without a robot", |v| v.control_so_far().map(ControlSummary::cost);
    "accumulated_tracking_cost", PLAIN, "sum of ||x - s||_Q^2; missing without a robot", |v| v.control_so_far().map(|c| c.tracking);
    "accumulated_effort_cost", PLAIN, "sum of ||u||_R^2; missing without a robot", |v| v.control_so_far().map(|c| c.effort);
    "accumulated_pose_cost", PLAIN, "sum of kappa ||q* - q_c||^2; missing without a robot", |v| v.control_so_far().map(|c| c.pose);
    "robot_work_j", JOULES, "work that the robot did on the object so far; missing without physics", |v| v.work_so_far().map(|w| w[0]);
    "human_work_j", JOULES, "work that the human did on the object so far; missing without physics", |v| v.work_so_far().map(|w| w[1]);
};

/// The controller's decision, its tracking error, and how both ends of the object move. Missing without a
/// robot.
#[rustfmt::skip]
pub const CONTROL: &[Quantity] = quantities! {
    "grasp_goal_x_m", METRES, "s: where the grasp should be at the beginning of the step, world x", |v| v.robot_tick().map(|r| r.grasp_goal.position.x);
    "grasp_goal_y_m", METRES, "s: where the grasp should be at the beginning of the step, world y", |v| v.robot_tick().map(|r| r.grasp_goal.position.y);
    "grasp_goal_yaw_deg", DEGREES, "s: the heading that the grasp should have", |v| v.robot_tick().map(|r| r.grasp_goal.yaw.to_degrees());
    "base_x_m", METRES, "position of the base at the beginning of the step, world x", |v| v.robot_tick().map(|r| r.configuration.base.position.x);
    "base_y_m", METRES, "position of the base at the beginning of the step, world y", |v| v.robot_tick().map(|r| r.configuration.base.position.y);
    "base_yaw_deg", DEGREES, "heading of the base at the beginning of the step", |v| v.robot_tick().map(|r| r.configuration.base.yaw.to_degrees());
    "base_clearance_m", METRES, "least distance of the base to an obstacle at the beginning of a control period of the step; missing without obstacles", |v| v.robot_tick().map(|r| r.base_clearance);
    "tracked", Text, "the option that the robot takes the human to be on; missing while it leads", |v| v.preparation().and_then(|p| p.tracked).map(|o| v.option(o));
    "pose_candidate", Count, "the configuration that eq. (8) chose in the last control period of the step, 0 the present one; missing where eq. (8) was not solved", |v| v.preparation().map(|p| p.candidate);
    "pose_candidates", Count, "|Q| of that control period; missing where eq. (8) was not solved", |v| v.preparation().map(|p| p.candidates);
    "pose_constrained_problems", Count, "problems of eq. (8) solved with limits in that control period; missing where eq. (8) was not solved", |v| v.preparation().map(|p| p.constrained);
    "mpc_outcome", Text, "how eq. (7) was solved: unconstrained, constrained, or fallback with the reason", |v| v.robot_tick().map(|r| solved(&r.outcome));
    "mpc_active_limits", Count, "limits of joints, wheels and obstacles active in its solution", |v| v.active();
    "least_singular_value", PLAIN, "least singular value of B(q*) in the last control period of the step, m or rad for a unit input", |v| v.robot_tick().map(RobotTick::least_singular_value);
    "position_error_m", METRES, "distance between grasp and reference at the end of the step", |v| v.robot_tick().map(|r| r.position_error);
    "orientation_error_deg", DEGREES, "angle between grasp and reference at the end of the step", |v| v.robot_tick().map(|r| r.orientation_error.to_degrees());
    "tracking_cost", PLAIN, "||x - s||_Q^2 at the end of a control period, the mean over those of the step", |v| v.robot_tick().map(|r| r.tracking_cost);
    "effort_cost", PLAIN, "||u||_R^2, the mean over the control periods of the step", |v| v.robot_tick().map(|r| r.effort_cost);
    "pose_cost", PLAIN, "kappa ||q* - q_c||^2, the mean over the control periods of the step", |v| v.robot_tick().map(|r| r.pose_cost);
    "self_contact", Text, "the first two links of the robot that touch each other at the end of a control period of the step; missing if none do", |v| v.links(v.robot_tick().and_then(|r| r.self_contact));
    "left_rim_m_per_s", METRES_PER_SECOND, "u of the left wheel's rim, the mean over the step", |v| v.base_input(false).map(|u| u[0]);
    "right_rim_m_per_s", METRES_PER_SECOND, "u of the right wheel's rim, the mean over the step", |v| v.base_input(false).map(|u| u[1]);
    "grasp_speed_m_per_s", METRES_PER_SECOND, "speed of the grasp in the step, by its positions at the ends of steps", |v| v.ends().map(|e| e.robot.velocity.norm());
    "hand_speed_m_per_s", METRES_PER_SECOND, "speed of the human's hand in the step, without sway; where the human has no body, of s", |v| v.ends().map(|e| e.human.velocity.norm());
    "grasp_acceleration_m_per_s2", ACCELERATION, "magnitude of the grasp's acceleration, by differences of its velocities in this step and the one before", |v| v.ends().map(|e| e.robot.acceleration.norm());
    "hand_acceleration_m_per_s2", ACCELERATION, "magnitude of the acceleration of the human's hand, by the same differences", |v| v.ends().map(|e| e.human.acceleration.norm());
    "grasp_jerk_m_per_s3", JERK, "magnitude of the grasp's jerk, by differences of its accelerations", |v| v.ends().map(|e| e.robot.jerk.norm());
    "hand_jerk_m_per_s3", JERK, "magnitude of the jerk of the human's hand, by differences of its accelerations", |v| v.ends().map(|e| e.human.jerk.norm());
};

/// The inputs of an omnidirectional base, which has no rim speeds. Missing for other drives.
#[rustfmt::skip]
pub const BASE: &[Quantity] = quantities! {
    "base_ahead_m_per_s", METRES_PER_SECOND, "u of an omnidirectional base ahead, the mean over the step; it has no rim speeds", |v| v.base_input(true).map(|u| u[0]);
    "base_left_m_per_s", METRES_PER_SECOND, "u of an omnidirectional base to its left, the mean over the step", |v| v.base_input(true).map(|u| u[1]);
    "base_turn_rad_per_s", RADIANS_PER_SECOND, "u of an omnidirectional base's turning, the mean over the step", |v| v.base_input(true).map(|u| u[2]);
};

/// Bodies and forces on the physical plant. Missing on the others.
#[rustfmt::skip]
pub const INTERACTION: &[Quantity] = quantities! {
    "object_x_m", METRES, "the object's centre at the end of the step, world x", |v| v.physics().map(|p| p.object.position.x);
    "object_y_m", METRES, "the object's centre at the end of the step, world y", |v| v.physics().map(|p| p.object.position.y);
    "object_yaw_deg", DEGREES, "the object's heading at the end of the step", |v| v.physics().map(|p| p.object.yaw.to_degrees());
    "hand_x_m", METRES, "the human's hand at the end of the step, without sway, world x", |v| v.physics().map(|p| p.hand.position.x);
    "hand_y_m", METRES, "the human's hand at the end of the step, without sway, world y", |v| v.physics().map(|p| p.hand.position.y);
    "hand_yaw_deg", DEGREES, "the hand's heading at the end of the step", |v| v.physics().map(|p| p.hand.yaw.to_degrees());
    "torso_x_m", METRES, "the human's torso at the end of the step, world x", |v| v.physics().map(|p| p.torso.position.x);
    "torso_y_m", METRES, "the human's torso at the end of the step, world y", |v| v.physics().map(|p| p.torso.position.y);
    "torso_yaw_deg", DEGREES, "the torso's heading at the end of the step", |v| v.physics().map(|p| p.torso.yaw.to_degrees());
    "grip_force_n", NEWTONS, "root mean square of the robot's force on the object", |v| v.physics().map(|p| p.grip_force);
    "hand_force_n", NEWTONS, "root mean square of the human's force on the object", |v| v.physics().map(|p| p.hand_force);
    "grip_peak_force_n", NEWTONS, "largest force of the robot on the object", |v| v.seen().map(|s| s.grip.peak);
    "hand_peak_force_n", NEWTONS, "largest force of the human on the object", |v| v.seen().map(|s| s.hand_grip.peak);
    "peak_force_n", NEWTONS, "the larger of the two", |v| v.physics().map(|p| p.peak_force);
    "grip_mean_force_x_n", NEWTONS, "mean force of the robot on the object, world x", |v| v.seen().map(|s| s.grip.mean.force.x);
    "grip_mean_force_y_n", NEWTONS, "mean force of the robot on the object, world y", |v| v.seen().map(|s| s.grip.mean.force.y);
    "grip_mean_force_z_n", NEWTONS, "mean force of the robot on the object, world z", |v| v.seen().map(|s| s.grip.mean.force.z);
    "grip_mean_torque_x_nm", NEWTON_METRES, "mean torque of the robot on the object, world x", |v| v.seen().map(|s| s.grip.mean.torque.x);
    "grip_mean_torque_y_nm", NEWTON_METRES, "mean torque of the robot on the object, world y", |v| v.seen().map(|s| s.grip.mean.torque.y);
    "grip_mean_torque_z_nm", NEWTON_METRES, "mean torque of the robot on the object, world z", |v| v.seen().map(|s| s.grip.mean.torque.z);
    "hand_mean_force_x_n", NEWTONS, "mean force of the human on the object, world x", |v| v.seen().map(|s| s.hand_grip.mean.force.x);
    "hand_mean_force_y_n", NEWTONS, "mean force of the human on the object, world y", |v| v.seen().map(|s| s.hand_grip.mean.force.y);
    "hand_mean_force_z_n", NEWTONS, "mean force of the human on the object, world z", |v| v.seen().map(|s| s.hand_grip.mean.force.z);
    "hand_mean_torque_x_nm", NEWTON_METRES, "mean torque of the human on the object, world x", |v| v.seen().map(|s| s.hand_grip.mean.torque.x);
    "hand_mean_torque_y_nm", NEWTON_METRES, "mean torque of the human on the object, world y", |v| v.seen().map(|s| s.hand_grip.mean.torque.y);
    "hand_mean_torque_z_nm", NEWTON_METRES, "mean torque of the human on the object, world z", |v| v.seen().map(|s| s.hand_grip.mean.torque.z);
    "motive_force_n", NEWTONS, "root mean square of the sum of both forces along the object", |v| v.physics().map(|p| p.sharing.motive_force());
    "internal_force_n", NEWTONS, "root mean square of what cancels along the object: the lesser of the two forces where they are opposed", |v| v.physics().map(|p| p.sharing.internal_force());
    "grip_deflection_m", METRES, "largest deflection of the robot's grip", |v| v.physics().map(|p| p.deflection[0]);
    "hand_deflection_m", METRES, "largest deflection of the human's grip", |v| v.physics().map(|p| p.deflection[1]);
    "grip_force_above_10_hz_n", NEWTONS, "noise: root mean square of the robot's force above 10 Hz", |v| v.physics().map(|p| p.force_noise[0]);
    "hand_force_above_10_hz_n", NEWTONS, "noise: root mean square of the human's force above 10 Hz", |v| v.physics().map(|p| p.force_noise[1]);
    "effort_share", PLAIN, "the most that a motor of the arm exerted, as a share of its effort limit", |v| v.physics().map(|p| p.effort_share);
    "time_at_effort_limit_s", SECONDS, "how long a motor of the arm was at its effort limit in the step, the longest", |v| v.physics().map(|p| p.time_at_limit.max());
    "grip_work_j", JOULES, "work that the robot did on the object in the step", |v| v.physics().map(|p| p.work[0]);
    "hand_work_j", JOULES, "work that the human did on the object in the step", |v| v.physics().map(|p| p.work[1]);
    "grip_driving_work_j", JOULES, "the part of the robot's work that was done while its power was positive", |v| v.physics().map(|p| p.sharing.driving_work[0]);
    "hand_driving_work_j", JOULES, "the part of the human's work that was done while its power was positive", |v| v.physics().map(|p| p.sharing.driving_work[1]);
    "squared_jerk_m2_per_s5", SQUARED_JERK, "integral over the step of the square of the object's jerk", |v| v.physics().map(|p| p.squared_jerk);
    "obstacle_distance_m", METRES, "least distance of robot, object or human to an obstacle at the end of the step; missing without obstacles", |v| v.physics().map(|p| p.obstacle_distance);
    "human_distance_m", METRES, "distance between robot and human at the end of the step", |v| v.physics().map(|p| p.human_distance);
    "path_lead_m", METRES, "how far the leader's intended position is ahead of the object along the path at the end of the step", |v| v.physics().map(|p| p.path_lead);
    "contacts", Count, "pairs of parts that touched in the step", |v| v.seen().map(|s| s.contacts.len());
};

/// The options, one record of [`OPTION`] each.
pub const OPTIONS: &[Quantity] = quantities! {
    "options", List(|| headings(OPTION)), "every option as it is from where the team is at the beginning of the step", |v| options(v);
};

/// An option, evaluated from a position.
#[derive(Clone, Copy, Debug)]
pub struct OptionView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its remaining length and risk, and its costs.
    pub option: &'a OptionTick,
}

impl OptionView<'_> {
    /// The values of [`OPTION`].
    pub fn read(&self) -> Record {
        read(OPTION, self)
    }
}

type OfOption = Quantity<fn(&OptionView) -> Value>;

/// The quantities of an option.
#[rustfmt::skip]
pub const OPTION: &[OfOption] = quantities! {
    "name", Text, "name of the option", |v| v.name;
    "length_m", METRES, "D_o: length of the remaining path; missing where no path leads on", |v| v.option.remaining.length;
    "risk", PLAIN, "S_o: risk of the remaining openings, 0 to 1", |v| v.option.remaining.risk;
    "objective_cost_m", METRES, "J_o = D_o + c_r S_o, eq. (1)", |v| v.option.objective;
    "expected_subjective_cost", PLAIN, "J~_o of eq. (6): mean of the subjective cost over the robot's belief, cost units; missing while the human leads", |v| v.option.expected;
    "probability", PLAIN, "P_o: probability that the human prefers it, eq. (4), 0 to 1; missing where it was not evaluated", |v| v.option.probability;
    "misaligned", Flag, "omega_o, eq. (5): whether the team moves toward something other than this option's next opening", |v| v.option.misaligned;
};

/// The values of [`OPTION`] besides the name, in its order, for those who read them in every step: 0 where one
/// is missing, and 1 for a flag that is set.
pub fn option_numbers(option: &OptionTick) -> [f64; OPTION.len() - 1] {
    let OptionTick { remaining, objective, expected, probability, misaligned } = *option;
    let misaligned = f64::from(u8::from(misaligned));
    [remaining.length, remaining.risk, objective, expected, probability, misaligned]
        .map(|number| if number.is_finite() { number } else { 0.0 })
}

fn options(view: &View) -> Vec<Fields> {
    let options = view.tick().options.iter().enumerate();
    options.map(|(o, option)| fields(OPTION, &OptionView { name: view.option(o), option })).collect()
}

/// The joints of the arm, one record each; none without a robot.
pub const JOINTS: &[Quantity] = quantities! {
    "joints", List(|| headings(REVOLUTE.iter().chain(PRISMATIC))), "the joints of the arm, from the base on", |v| joints(v);
};

/// One joint of the arm in a planning step.
pub(super) struct JointView<'a> {
    joint: &'a ArmJoint,
    position: f64,
    rate: f64,
}

type OfJoint = Quantity<fn(&JointView) -> Value>;

/// The quantities of a revolute joint.
pub(super) const REVOLUTE: &[OfJoint] = quantities! {
    "name", Text, "name of the joint", |v| v.joint.name.as_str();
    "position_rad", RADIANS, "position of a revolute joint at the beginning of the step", |v| v.position;
    "rate_rad_per_s", RADIANS_PER_SECOND, "u of a revolute joint, the mean over the step", |v| v.rate;
};

/// The quantities of a prismatic joint.
pub(super) const PRISMATIC: &[OfJoint] = quantities! {
    "name", Text, "name of the joint", |v| v.joint.name.as_str();
    "position_m", METRES, "position of a prismatic joint at the beginning of the step", |v| v.position;
    "rate_m_per_s", METRES_PER_SECOND, "u of a prismatic joint, the mean over the step", |v| v.rate;
};

fn joints(view: &View) -> Vec<Fields> {
    let (Some(robot), Some(tick)) = (view.prepared.robot(), view.robot_tick()) else { return Vec::new() };
    let rates = robot.joint_rates(&tick.input);
    let joints = robot.joints.iter().enumerate().map(|(i, joint)| {
        let view = JointView { joint, position: tick.configuration.joints[i], rate: rates[i] };
        fields(if joint.motion == Motion::Revolute { REVOLUTE } else { PRISMATIC }, &view)
    });
    joints.collect()
}

fn solved(outcome: &SolveOutcome) -> &'static str {
    match outcome {
        SolveOutcome::Unconstrained => "unconstrained",
        SolveOutcome::Constrained { .. } => "constrained",
        SolveOutcome::Fallback(Failure::NotFinite) => "fallback: not finite",
        SolveOutcome::Fallback(Failure::NotSolved) => "fallback: not solved",
    }
}

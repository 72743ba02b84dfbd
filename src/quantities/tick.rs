//! The quantities of one control period.

use super::{Datum, Quantity, quantities};
use crate::control::{Failure, SolveOutcome};
use crate::coordination::OptionTick;
use crate::episode::{PhysicsTick, Preparation, RobotTick, Summary, Tick};
use crate::options::OptionSet;

/// A control period, with what its indices stand for.
#[derive(Clone, Copy, Debug)]
pub struct TickView<'a> {
    /// The period.
    pub tick: &'a Tick,
    /// The episode so far, with this period.
    pub summary: &'a Summary,
    /// The ways through the world.
    pub options: &'a OptionSet,
}

/// One option in a control period.
#[derive(Clone, Copy, Debug)]
pub struct OptionView<'a> {
    /// Its name.
    pub name: &'a str,
    /// How it is from where the team is.
    pub option: &'a OptionTick,
}

type OfTick = Quantity<fn(&TickView) -> Datum>;
type OfOption = Quantity<fn(&OptionView) -> Datum>;

impl TickView<'_> {
    fn option(&self, option: usize) -> &str {
        &self.options.options()[option].name
    }

    fn robot(&self) -> Option<&RobotTick> {
        self.tick.robot.as_ref()
    }

    fn preparation(&self) -> Option<Preparation> {
        self.robot()?.preparation
    }

    fn physics(&self) -> Option<&PhysicsTick> {
        self.robot()?.physics.as_ref()
    }
}

/// Every option as it is from where the team is at the beginning of the period.
pub const OPTION: &[OfOption] = quantities! { fn(&OptionView) -> Datum;
    "name" Text "name of the option" |v| v.name;
    "length_m" Number "D_o: length of what is left, m; missing where there is no way" |v| v.option.remaining.length;
    "risk" Number "S_o: risk of what is left, 0 to 1" |v| v.option.remaining.risk;
    "objective_cost_m" Number "J_o = D_o + c_r S_o, eq. (1), m" |v| v.option.objective;
    "expected_subjective_cost" Number "J~_o of eq. (6): the subjective cost's mean over the robot's belief, cost units; missing while the human leads" |v| v.option.expected;
    "probability" Number "P_o: probability that the human prefers it, eq. (4), 0 to 1; missing where it was not evaluated" |v| v.option.probability;
    "misaligned" Flag "omega_o, eq. (5): whether the team moves toward something else than this option's next opening" |v| v.option.misaligned;
};

/// Where the team is, who leads, and what they chose.
pub const COORDINATION: &[OfTick] = quantities! { fn(&TickView) -> Datum;
    "step" Count "k, from 0" |v| v.tick.step;
    "time_s" Number "simulated time at the beginning of the step, s" |v| v.tick.time;
    "x_m" Number "where the team is at the beginning of the step, world x, m" |v| v.tick.position.x;
    "y_m" Number "the same, world y, m" |v| v.tick.position.y;
    "heading_deg" Number "direction of travel, counter-clockwise from x, degrees" |v| v.tick.heading.to_degrees();
    "mode" Text "who leads: robot-led or human-led" |v| v.tick.mode.name();
    "stubbornness" Number "phi(k), eq. (5); the human takes the lead above 1" |v| v.tick.stubbornness;
    "discomfort" Number "g(k), eq. (5)" |v| v.tick.discomfort;
    "executed" Text "the option executed" |v| v.option(v.tick.executed);
    "executed_index" Count "its place among the options, from 0" |v| v.tick.executed;
    "preferred" Text "the option that this human would choose from here" |v| v.option(v.tick.preferred);
    "preferred_index" Count "its place among the options, from 0" |v| v.tick.preferred;
    "reverses_for" Text "the option for which the team reverses, to where there is room to turn onto it; mostly missing" |v| v.tick.reverses_for.map(|o| v.option(o));
};

/// What was decided and walked costs so far.
pub const COST: &[OfTick] = quantities! { fn(&TickView) -> Datum;
    "objective_cost_m" Number "J of the option executed, m" |v| v.tick.objective_cost;
    "accumulated_objective_cost_m" Number "sum of J up to and with this step, m" |v| v.tick.accumulated_cost;
    "walked_m" Number "way walked, m" |v| v.summary.walked;
    "accumulated_control_cost" Number "C so far: tracking + effort + pose" |v| v.summary.control.map(|c| c.cost());
    "accumulated_tracking_cost" Number "sum of ||x - s||_Q^2" |v| v.summary.control.map(|c| c.tracking);
    "accumulated_effort_cost" Number "sum of ||u||_R^2" |v| v.summary.control.map(|c| c.effort);
    "accumulated_pose_cost" Number "sum of kappa ||q* - q_c||^2" |v| v.summary.control.map(|c| c.pose);
    "robot_work_j" Number "work that the robot did on the object so far, J" |v| v.summary.interaction.map(|i| i.work[0]);
    "human_work_j" Number "work that the human did on the object so far, J" |v| v.summary.interaction.map(|i| i.work[1]);
};

/// What the robot decided, and how well it was followed.
pub const CONTROL: &[OfTick] = quantities! { fn(&TickView) -> Datum;
    "grasp_goal_x_m" Number "s: where the grasp should be at the beginning of the step, world x, m" |v| v.robot().map(|r| r.grasp_goal.position.x);
    "grasp_goal_y_m" Number "the same, world y, m" |v| v.robot().map(|r| r.grasp_goal.position.y);
    "grasp_goal_yaw_deg" Number "its heading, degrees" |v| v.robot().map(|r| r.grasp_goal.yaw.to_degrees());
    "base_x_m" Number "where the base is at the beginning of the step, world x, m" |v| v.robot().map(|r| r.configuration.base.position.x);
    "base_y_m" Number "the same, world y, m" |v| v.robot().map(|r| r.configuration.base.position.y);
    "base_yaw_deg" Number "its heading, degrees" |v| v.robot().map(|r| r.configuration.base.yaw.to_degrees());
    "base_clearance_m" Number "distance of the base to the nearest obstacle, m; missing without obstacles" |v| v.robot().map(|r| r.base_clearance);
    "tracked" Text "the option that the robot takes the human to be on; missing while it leads" |v| v.preparation().and_then(|p| p.tracked).map(|o| v.option(o));
    "pose_candidate" Count "the configuration that eq. (8) chose, 0 the present one; missing where it was not asked" |v| v.preparation().map(|p| p.candidate);
    "pose_candidates" Count "|Q|; missing where eq. (8) was not asked" |v| v.preparation().map(|p| p.candidates);
    "pose_constrained_problems" Count "problems of eq. (8) solved with limits; missing where it was not asked" |v| v.preparation().map(|p| p.constrained);
    "mpc_outcome" Text "how eq. (7) was solved: unconstrained, constrained, or fallback with the reason" |v| v.robot().map(|r| mpc_outcome(&r.outcome));
    "mpc_active_limits" Count "limits of joints, wheels and obstacles active in its solution" |v| v.robot().map(|r| active(&r.outcome)[0]);
    "mpc_active_guides" Count "bounds active in it that hold the base to its path; physical plant only" |v| v.robot().map(|r| active(&r.outcome)[1]);
    "least_singular_value" Number "least singular value of B(q*), m or rad for a unit input" |v| v.robot().map(|r| r.least_singular_value);
    "position_error_m" Number "distance between grasp and reference at the end of the step, m" |v| v.robot().map(|r| r.position_error);
    "orientation_error_deg" Number "angle between them, degrees" |v| v.robot().map(|r| r.orientation_error.to_degrees());
    "tracking_cost" Number "||x - s||_Q^2 at the end of the step" |v| v.robot().map(|r| r.tracking_cost);
    "effort_cost" Number "||u||_R^2" |v| v.robot().map(|r| r.control_effort);
    "pose_cost" Number "kappa ||q* - q_c||^2" |v| v.robot().map(|r| r.pose_cost);
    "left_rim_m_per_s" Number "u of the left wheel's rim, m/s" |v| v.robot().map(|r| r.input[0]);
    "right_rim_m_per_s" Number "u of the right wheel's rim, m/s" |v| v.robot().map(|r| r.input[1]);
};

/// Bodies and forces on the physical plant.
pub const INTERACTION: &[OfTick] = quantities! { fn(&TickView) -> Datum;
    "object_x_m" Number "the object's centre at the end of the step, world x, m" |v| v.physics().map(|p| p.object.position.x);
    "object_y_m" Number "the same, world y, m" |v| v.physics().map(|p| p.object.position.y);
    "object_yaw_deg" Number "its heading, degrees" |v| v.physics().map(|p| p.object.yaw.to_degrees());
    "hand_x_m" Number "the human's hand at the end of the step, without sway, world x, m" |v| v.physics().map(|p| p.hand.position.x);
    "hand_y_m" Number "the same, world y, m" |v| v.physics().map(|p| p.hand.position.y);
    "hand_yaw_deg" Number "its heading, degrees" |v| v.physics().map(|p| p.hand.yaw.to_degrees());
    "torso_x_m" Number "the human's torso at the end of the step, world x, m" |v| v.physics().map(|p| p.torso.position.x);
    "torso_y_m" Number "the same, world y, m" |v| v.physics().map(|p| p.torso.position.y);
    "torso_yaw_deg" Number "its heading, degrees" |v| v.physics().map(|p| p.torso.yaw.to_degrees());
    "grip_force_n" Number "root mean square of the robot's force on the object, N" |v| v.physics().map(|p| p.grip_force);
    "hand_force_n" Number "root mean square of the human's force on the object, N" |v| v.physics().map(|p| p.hand_force);
    "peak_force_n" Number "the larger of the two forces' peaks, N" |v| v.physics().map(|p| p.peak_force);
    "grip_deflection_m" Number "how far the robot's grip yielded at most, m" |v| v.physics().map(|p| p.deflection[0]);
    "hand_deflection_m" Number "how far the human's grip yielded at most, m" |v| v.physics().map(|p| p.deflection[1]);
    "grip_force_change_n" Number "root mean square of the robot's force change between two physics steps, N" |v| v.physics().map(|p| p.force_change[0]);
    "hand_force_change_n" Number "root mean square of the human's force change between two physics steps, N" |v| v.physics().map(|p| p.force_change[1]);
    "effort_share" Number "the most that a motor of the arm exerted, as a share of its effort limit" |v| v.physics().map(|p| p.effort_share);
    "grip_work_j" Number "work that the robot did on the object in the step, J" |v| v.physics().map(|p| p.work[0]);
    "hand_work_j" Number "work that the human did on the object in the step, J" |v| v.physics().map(|p| p.work[1]);
    "squared_jerk_m2_per_s5" Number "integral over the step of the square of the object's jerk, m^2/s^5" |v| v.physics().map(|p| p.squared_jerk);
    "obstacle_distance_m" Number "least distance of robot, object or human to an obstacle at the end of the step, m; missing without obstacles" |v| v.physics().map(|p| p.obstacle_distance);
    "human_distance_m" Number "distance between robot and human at the end of the step, m" |v| v.physics().map(|p| p.human_distance);
    "path_lead_m" Number "how far the leader's intended position is ahead of the object along the path, m" |v| v.physics().map(|p| p.path_lead);
};

fn mpc_outcome(outcome: &SolveOutcome) -> &'static str {
    match outcome {
        SolveOutcome::Unconstrained => "unconstrained",
        SolveOutcome::Constrained { .. } => "constrained",
        SolveOutcome::Fallback(Failure::NotFinite) => "fallback: not finite",
        SolveOutcome::Fallback(Failure::NotSolved) => "fallback: not solved",
    }
}

/// Active limits and guides.
fn active(outcome: &SolveOutcome) -> [usize; 2] {
    match outcome {
        SolveOutcome::Constrained { active, guides } => [*active, *guides],
        _ => [0, 0],
    }
}

//! The quantities of an episode as a whole.

use super::{
    ACCELERATION, JERK, JOULES, METRES, NEWTONS, PLAIN, Quantity, QuantityKind, SECONDS, SQUARED_JERK, View,
    quantities,
};
use crate::episode::{ControlSummary, InteractionSummary, Loss, MotionSummary, Outcome, Summary, Transition};
use crate::simulation::{Contact, Failure, Part};
use QuantityKind::{Count, Text};

impl View<'_> {
    fn summary(&self) -> &Summary {
        self.episode.summary()
    }

    fn seconds(&self, step: u64) -> f64 {
        step as f64 * self.prepared.scenario().settings.planning_step
    }

    fn transition(&self) -> Option<Transition> {
        self.summary().transition
    }

    fn control(&self) -> Option<&ControlSummary> {
        self.summary().control.as_ref()
    }

    fn motion(&self) -> Option<&MotionSummary> {
        self.summary().motion.as_ref()
    }

    /// The shortest option at the start as a share of the length walked, of a team that arrived.
    fn path_efficiency(&self) -> Option<f64> {
        let summary = self.summary();
        (self.outcome == Some(Outcome::Arrived)).then(|| summary.shortest / summary.walked)
    }

    fn interaction(&self) -> Option<&InteractionSummary> {
        self.summary().interaction.as_ref()
    }

    fn loss(&self) -> Option<Loss> {
        self.summary().loss
    }

    fn collision(&self) -> Option<&Contact> {
        self.summary().collision.as_ref()
    }

    fn touched(&self, side: usize) -> Option<&Part> {
        self.collision().map(|contact| &contact.between[side])
    }
}

/// The quantities of an episode: outcome, costs, forces, losses and collisions.
#[rustfmt::skip]
pub const EPISODE: &[Quantity] = quantities! {
    "outcome", Text, "arrived, out-of-time, no-way, collided, stuck, dropped, object-lost or non-finite; in recordings also interrupted (by the user)", |v| v.outcome.map_or("interrupted", Outcome::name);
    "steps", Count, "steps taken", |v| v.summary().steps;
    "time_s", SECONDS, "simulated time", |v| v.seconds(v.summary().steps);
    "walked_m", METRES, "length of the path walked", |v| v.summary().walked;
    "path_efficiency", PLAIN, "length of the shortest option at the start as a share of the length walked; missing unless the team arrived", |v| v.path_efficiency();
    "accumulated_objective_cost_m", METRES, "sum over the steps of J of the option executed", |v| v.summary().accumulated_cost;
    "final_stubbornness", PLAIN, "phi in the last step", |v| v.summary().human.stubbornness;
    "final_discomfort", PLAIN, "g in the last step", |v| v.summary().human.discomfort;
    "share_off_preference", PLAIN, "share of the steps off the option that this human preferred, 0 to 1", |v| v.summary().human.share_off_preference(v.summary().steps);
    "disagreement_time_s", SECONDS, "time in which another option than the one that this human preferred was executed", |v| v.seconds(v.summary().human.steps_off_preference);
    "overruled_time_s", SECONDS, "time in which the robot led although phi exceeded 1, as a policy may", |v| v.seconds(v.summary().human.steps_overruled);
    "accumulated_subjective_cost", PLAIN, "sum over the steps of J^ of the option executed, eq. (2), with this human's alpha and gamma; cost units; missing for humans without them", |v| v.summary().human.subjective_cost;
    "preference_change_count", Count, "how often the human's alpha and gamma changed", |v| v.summary().human.preference_changes;
    "preferred_option_switches", Count, "how often the option that the human preferred changed", |v| v.summary().human.preferred_option_switches;
    "preferred_at_start", Text, "the option that the human preferred in the first step", |v| v.option(v.summary().human.preferred_at_start);
    "first_option", Text, "the option executed first", |v| v.option(v.summary().first_option);
    "last_option", Text, "the option executed last", |v| v.option(v.summary().last_option);
    "option_change_count", Count, "how often the executed option changed", |v| v.summary().option_changes;
    "transition_step", Count, "k at which the human took the lead; missing if the human did not", |v| v.transition().map(|t| t.step);
    "transition_time_s", SECONDS, "time of that step", |v| v.transition().map(|t| v.seconds(t.step));
    "transition_x_m", METRES, "position of the team then, world x", |v| v.transition().map(|t| t.position.x);
    "transition_y_m", METRES, "position of the team then, world y", |v| v.transition().map(|t| t.position.y);
    "accumulated_control_cost", PLAIN, "C: tracking + effort + pose (Sec. V-C); missing without a robot", |v| v.control().map(ControlSummary::cost);
    "accumulated_tracking_cost", PLAIN, "sum of ||x - s||_Q^2", |v| v.control().map(|c| c.tracking);
    "accumulated_effort_cost", PLAIN, "sum of ||u||_R^2", |v| v.control().map(|c| c.effort);
    "accumulated_pose_cost", PLAIN, "sum of kappa ||q* - q_c||^2", |v| v.control().map(|c| c.pose);
    "position_error_rms_m", METRES, "root mean square distance between grasp and reference", |v| v.control().map(|c| c.error_rms(v.summary().steps));
    "largest_position_error_m", METRES, "largest distance between grasp and reference, which is on the planned path", |v| v.control().map(|c| c.largest_error);
    "constrained_steps", Count, "steps in which a limit of joints, wheels or obstacles was active", |v| v.control().map(|c| c.constrained_steps);
    "fallback_steps", Count, "steps without a solution of eq. (7)", |v| v.control().map(|c| c.fallback_steps);
    "pose_change_count", Count, "steps in which eq. (8) chose another configuration, in any of their control periods", |v| v.control().map(|c| c.pose_changes);
    "overlapping_steps", Count, "steps in which the base overlapped an obstacle", |v| v.control().map(|c| c.overlapping_steps);
    "least_base_clearance_m", METRES, "least distance between base and obstacles; missing without obstacles", |v| v.control().map(|c| c.least_clearance);
    "self_contact_steps", Count, "steps in which two links of the robot touched each other at the end of a control period, by more than a centimetre", |v| v.control().map(|c| c.self_contact_steps);
    "self_contact", Text, "the first two links that did; missing if none did", |v| v.links(v.control().and_then(|c| c.self_contact));
    "grasp_acceleration_mean_m_per_s2", ACCELERATION, "mean magnitude of the grasp's acceleration, by differences between the ends of planning steps; missing without a robot", |v| v.motion().map(|m| m.robot().mean_acceleration());
    "hand_acceleration_mean_m_per_s2", ACCELERATION, "mean magnitude of the acceleration of the human's hand without sway, of s where the human has no body, by differences between the ends of planning steps; missing without a robot", |v| v.motion().map(|m| m.human().mean_acceleration());
    "grasp_jerk_mean_m_per_s3", JERK, "mean magnitude of the grasp's jerk, by differences between the ends of planning steps; missing without a robot", |v| v.motion().map(|m| m.robot().mean_jerk());
    "hand_jerk_mean_m_per_s3", JERK, "mean magnitude of the jerk of the human's hand, by differences between the ends of planning steps; missing without a robot", |v| v.motion().map(|m| m.human().mean_jerk());
    "robot_idle_share", PLAIN, "share of the steps in which the grasp was slower in the mean than a tenth of the walking speed, 0 to 1; missing without a robot", |v| v.motion().map(|m| m.robot().idle_share());
    "human_idle_share", PLAIN, "share of the steps in which the human's hand was slower in the mean than a tenth of the walking speed, 0 to 1; missing without a robot", |v| v.motion().map(|m| m.human().idle_share());
    "concurrent_activity", PLAIN, "share of the steps in which neither the grasp nor the human's hand was slower than that, 0 to 1; missing without a robot", |v| v.motion().map(MotionSummary::concurrent_activity);
    "idle_time_s", SECONDS, "time in which both were slower than that; missing without a robot", |v| v.motion().map(|m| v.seconds(m.both_idle()));
    "hand_force_mean_n", NEWTONS, "mean of the human's force on the object; missing without physics", |v| v.interaction().map(InteractionSummary::mean_force);
    "hand_force_rms_n", NEWTONS, "root mean square of the human's force on the object", |v| v.interaction().map(InteractionSummary::rms_force);
    "peak_force_n", NEWTONS, "largest force in either grip", |v| v.interaction().map(|i| i.peak_force);
    "motive_force_rms_n", NEWTONS, "root mean square of the sum of both forces along the object", |v| v.interaction().map(|i| i.sharing.motive_force());
    "internal_force_rms_n", NEWTONS, "root mean square of what cancels along the object: the lesser of the two forces where they are opposed", |v| v.interaction().map(|i| i.sharing.internal_force());
    "human_force_share", PLAIN, "mean magnitude of the human's horizontal force as a share of that of both, 0 to 1", |v| v.interaction().and_then(|i| i.sharing.human_force_share());
    "robot_work_j", JOULES, "work that the robot did on the object", |v| v.interaction().map(|i| i.work[0]);
    "human_work_j", JOULES, "work that the human did on the object", |v| v.interaction().map(|i| i.work[1]);
    "robot_driving_work_j", JOULES, "the part of the robot's work that was done while its power was positive", |v| v.interaction().map(|i| i.sharing.driving_work[0]);
    "human_driving_work_j", JOULES, "the part of the human's work that was done while its power was positive", |v| v.interaction().map(|i| i.sharing.driving_work[1]);
    "human_work_share", PLAIN, "human_driving_work_j as a share of that of both, 0 to 1; missing if there was none", |v| v.interaction().and_then(|i| i.sharing.human_work_share());
    "squared_jerk_m2_per_s5", SQUARED_JERK, "integral of the square of the object's jerk", |v| v.interaction().map(|i| i.squared_jerk);
    "force_above_10_hz_rms_n", NEWTONS, "noise: root mean square of a grip's force above 10 Hz, the larger of the two grips'", |v| v.interaction().map(InteractionSummary::force_noise);
    "least_obstacle_distance_m", METRES, "least distance of robot, object or human to an obstacle at the end of a step; missing without obstacles", |v| v.interaction().and_then(|i| i.least_distances).map(|d| d[0]);
    "least_human_distance_m", METRES, "least distance between robot and human at the end of a step", |v| v.interaction().and_then(|i| i.least_distances).map(|d| d[1]);
    "largest_grip_deflection_m", METRES, "largest deflection of either grip", |v| v.interaction().map(|i| i.deflection);
    "largest_effort_share", PLAIN, "the most that a motor of the arm exerted, as a share of its effort limit", |v| v.interaction().map(|i| i.effort_share);
    "time_at_effort_limit_s", SECONDS, "how long a motor of the arm was at its effort limit, the longest", |v| v.interaction().map(|i| i.time_at_limit.max());
    "lost_by", Text, "robot or human: whose grip lost the object; missing if it was not lost", |v| v.loss().map(|l| l.by.name());
    "lost_at_step", Count, "k at which the object was lost", |v| v.loss().map(|l| l.step);
    "lost_distance_m", METRES, "deflection of that grip then; on the kinematic plant the distance of the grasp from its reference", |v| v.loss().map(|l| l.distance);
    "collision_of", Text, "robot, object or human: what touched an obstacle; missing if nothing did", |v| v.touched(0).map(|p| p.kind.name());
    "collision_part", Text, "the part that touched it", |v| v.touched(0).map(|p| p.name.as_str());
    "collision_with", Text, "obstacle", |v| v.touched(1).map(|p| p.kind.name());
    "collision_with_part", Text, "name of the obstacle", |v| v.touched(1).map(|p| p.name.as_str());
    "collision_x_m", METRES, "place of the contact, world x", |v| v.collision().map(|c| c.point.x);
    "collision_y_m", METRES, "place of the contact, world y", |v| v.collision().map(|c| c.point.y);
    "collision_z_m", METRES, "place of the contact, world z", |v| v.collision().map(|c| c.point.z);
    "collision_depth_m", METRES, "depth of the contact", |v| v.collision().map(|c| c.depth);
    "collision_force_n", NEWTONS, "largest normal force of the contact", |v| v.collision().map(|c| c.force);
    "failure", Text, "what broke, if anything did", |v| v.summary().failure.as_ref().map(failure);
};

fn failure(failure: &Failure) -> String {
    match failure {
        Failure::NonFinite { body } => format!("{body} stopped being a number"),
        Failure::Dropped => "the object fell".to_owned(),
    }
}

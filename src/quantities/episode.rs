//! The quantities of an episode that is over.

use super::{Datum, Quantity, quantities};
use crate::episode::{ControlSummary, InteractionSummary, Loss, Summary, Transition};
use crate::options::OptionSet;
use crate::simulation::{Contact, Failure, Part};

/// An episode that is over, with what its indices stand for.
#[derive(Clone, Copy, Debug)]
pub struct EpisodeView<'a> {
    /// What is known of it.
    pub summary: &'a Summary,
    /// The ways through the world.
    pub options: &'a OptionSet,
    /// The control period, s.
    pub period: f64,
}

type OfEpisode = Quantity<fn(&EpisodeView) -> Datum>;

impl EpisodeView<'_> {
    fn option(&self, option: usize) -> &str {
        &self.options.options()[option].name
    }

    fn seconds(&self, step: u64) -> f64 {
        step as f64 * self.period
    }

    fn transition(&self) -> Option<Transition> {
        self.summary.transition
    }

    fn control(&self) -> Option<&ControlSummary> {
        self.summary.control.as_ref()
    }

    fn interaction(&self) -> Option<&InteractionSummary> {
        self.summary.interaction.as_ref()
    }

    fn loss(&self) -> Option<Loss> {
        self.summary.loss
    }

    fn collision(&self) -> Option<&Contact> {
        self.summary.collision.as_ref()
    }

    fn touched(&self, side: usize) -> Option<&Part> {
        self.collision().map(|contact| &contact.between[side])
    }
}

/// How it ended, what it cost whom, and what went wrong.
pub const EPISODE: &[OfEpisode] = quantities! { fn(&EpisodeView) -> Datum;
    "outcome" Text "arrived, out-of-time, no-way, collided, stuck, dropped, object-lost or non-finite" |v| v.summary.outcome.name();
    "steps" Count "steps taken" |v| v.summary.steps;
    "time_s" Number "simulated time, s" |v| v.seconds(v.summary.steps);
    "walked_m" Number "way walked, m" |v| v.summary.walked;
    "first_option" Text "the option executed first" |v| v.option(v.summary.first_option);
    "last_option" Text "the option executed last" |v| v.option(v.summary.last_option);
    "option_change_count" Count "how often the executed option changed" |v| v.summary.changes;
    "transition_step" Count "k at which the human took the lead; missing if not" |v| v.transition().map(|t| t.step);
    "transition_time_s" Number "the same, s" |v| v.transition().map(|t| v.seconds(t.step));
    "transition_x_m" Number "where the team was then, world x, m" |v| v.transition().map(|t| t.position.x);
    "transition_y_m" Number "the same, world y, m" |v| v.transition().map(|t| t.position.y);
    "accumulated_objective_cost_m" Number "sum over the steps of J of the option executed, m" |v| v.summary.accumulated_cost;
    "accumulated_subjective_cost" Number "sum over the steps of J^ of the option executed, eq. (2), with this human's alpha and gamma; cost units" |v| v.summary.human.subjective_cost;
    "final_stubbornness" Number "phi in the last step" |v| v.summary.human.stubbornness;
    "final_discomfort" Number "g in the last step" |v| v.summary.human.discomfort;
    "share_off_preference" Number "share of the steps off the option that this human preferred, 0 to 1" |v| v.summary.human.share_off_preference(v.summary.steps);
    "preference_change_count" Count "how often the human's alpha and gamma changed" |v| v.summary.human.preference_changes;
    "preferred_option_switches" Count "how often the option that the human preferred changed" |v| v.summary.human.preference_switches;
    "accumulated_control_cost" Number "C: tracking + effort + pose (Sec. V-C)" |v| v.control().map(ControlSummary::cost);
    "accumulated_tracking_cost" Number "sum of ||x - s||_Q^2" |v| v.control().map(|c| c.tracking);
    "accumulated_effort_cost" Number "sum of ||u||_R^2" |v| v.control().map(|c| c.effort);
    "accumulated_pose_cost" Number "sum of kappa ||q* - q_c||^2" |v| v.control().map(|c| c.pose);
    "position_error_rms_m" Number "root mean square distance between grasp and reference, m" |v| v.control().map(|c| c.error_rms(v.summary.steps));
    "largest_position_error_m" Number "the largest such distance, m" |v| v.control().map(|c| c.largest_error);
    "constrained_steps" Count "steps in which a limit of joints, wheels or obstacles was active" |v| v.control().map(|c| c.constrained_steps);
    "fallback_steps" Count "steps without a solution of eq. (7)" |v| v.control().map(|c| c.fallback_steps);
    "pose_change_count" Count "steps in which eq. (8) chose another configuration" |v| v.control().map(|c| c.pose_changes);
    "overlapping_steps" Count "steps in which the base overlapped an obstacle" |v| v.control().map(|c| c.overlapping_steps);
    "least_base_clearance_m" Number "least distance between base and obstacles, m; missing without obstacles" |v| v.control().map(|c| c.least_clearance);
    "hand_force_mean_n" Number "mean of the human's force on the object, N" |v| v.interaction().map(InteractionSummary::mean_force);
    "hand_force_rms_n" Number "its root mean square, N" |v| v.interaction().map(InteractionSummary::rms_force);
    "peak_force_n" Number "largest force in either grip, N" |v| v.interaction().map(|i| i.peak_force);
    "robot_work_j" Number "work that the robot did on the object, J" |v| v.interaction().map(|i| i.work[0]);
    "human_work_j" Number "work that the human did on the object, J" |v| v.interaction().map(|i| i.work[1]);
    "squared_jerk_m2_per_s5" Number "integral of the square of the object's jerk, m^2/s^5" |v| v.interaction().map(|i| i.squared_jerk);
    "force_noise_rms_n" Number "root mean square of a grip's force change between two physics steps, N" |v| v.interaction().map(InteractionSummary::force_noise);
    "largest_grip_deflection_m" Number "the most that a grip yielded, m" |v| v.interaction().map(|i| i.deflection);
    "largest_effort_share" Number "the most that a motor of the arm exerted, as a share of its effort limit" |v| v.interaction().map(|i| i.effort_share);
    "lost_by" Text "robot or human, if the object was lost" |v| v.loss().map(|l| l.by.name());
    "lost_at_step" Count "k at which it was lost" |v| v.loss().map(|l| l.step);
    "lost_distance_m" Number "how far off the grasp was then, or its grip yielded, m" |v| v.loss().map(|l| l.distance);
    "collision_of" Text "robot, object or human, if one of them touched an obstacle" |v| v.touched(0).map(|p| p.party.name());
    "collision_part" Text "its part" |v| v.touched(0).map(|p| p.name.as_str());
    "collision_with" Text "obstacle" |v| v.touched(1).map(|p| p.party.name());
    "collision_with_part" Text "the obstacle's name" |v| v.touched(1).map(|p| p.name.as_str());
    "collision_x_m" Number "where, world x, m" |v| v.collision().map(|c| c.point.x);
    "collision_y_m" Number "where, world y, m" |v| v.collision().map(|c| c.point.y);
    "collision_z_m" Number "where, world z, m" |v| v.collision().map(|c| c.point.z);
    "collision_depth_m" Number "how deep, m" |v| v.collision().map(|c| c.depth);
    "collision_force_n" Number "with what force, N" |v| v.collision().map(|c| c.force);
    "failure" Text "what broke, if anything did" |v| v.summary.failure.as_ref().map(failure);
};

fn failure(failure: &Failure) -> String {
    match failure {
        Failure::NonFinite { body } => format!("{body} stopped being a number"),
        Failure::Dropped => "the object fell".to_owned(),
    }
}

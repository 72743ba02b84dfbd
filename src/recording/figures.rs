//! The JSON messages of a step. What is null here, as is what is no number, is left out of the message.

use super::encoder::Ending;
use crate::control::{Considered, Failure, SolveOutcome};
use crate::coordination::Mode;
use crate::episode::{Considerations, RobotTick, Summary, Tick};
use crate::options::OptionSet;
use crate::robot::{Configuration, Robot};
use crate::simulation::{Clearance, Forces, Observation};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Names that the options have.
#[derive(Clone, Copy)]
pub(super) struct Names<'a>(pub &'a OptionSet);

impl Names<'_> {
    pub fn option(&self, option: usize) -> &str {
        &self.0.options()[option].name
    }
}

pub(super) fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::RobotLed => "robot-led",
        Mode::HumanLed => "human-led",
    }
}

pub(super) fn options(tick: &Tick, names: Names) -> Value {
    let option = |(i, o): (usize, &crate::episode::OptionTick)| {
        json!({
            "name": names.option(i),
            "length_m": o.remaining.length,
            "risk": o.remaining.risk,
            "objective_m": o.objective,
            "expected_subjective": o.expected,
            "probability": o.probability,
            "misaligned": o.misaligned,
        })
    };
    json!({ "step": tick.step, "options": tick.options.iter().enumerate().map(option).collect::<Vec<_>>() })
}

pub(super) fn coordination(tick: &Tick, names: Names) -> Value {
    json!({
        "step": tick.step,
        "stubbornness": tick.stubbornness,
        "threshold": 1.0,
        "discomfort": tick.discomfort,
        "mode": mode_name(tick.mode),
        "executed": names.option(tick.executed),
        "executed_index": tick.executed,
        "preferred": names.option(tick.preferred),
        "preferred_index": tick.preferred,
        "steps_back_for": tick.steps_back_for.map(|option| names.option(option)),
        "x_m": tick.position.x,
        "y_m": tick.position.y,
        "heading_deg": tick.heading.to_degrees(),
    })
}

pub(super) fn control(step: u64, tick: &RobotTick, names: Names, robot: &Robot) -> Value {
    let preparation = tick.preparation;
    let (outcome, active, guides) = match tick.outcome {
        SolveOutcome::Unconstrained => ("unconstrained", 0, 0),
        SolveOutcome::Constrained { active, guides } => ("constrained", active, guides),
        SolveOutcome::Fallback(Failure::NotFinite) => ("fallback: not finite", 0, 0),
        SolveOutcome::Fallback(Failure::NotSolved) => ("fallback: not solved", 0, 0),
    };
    json!({
        "step": step,
        "position_error_m": tick.position_error,
        "orientation_error_deg": tick.orientation_error.to_degrees(),
        "tracking_cost": tick.tracking_cost,
        "control_effort": tick.control_effort,
        "pose_cost": tick.pose_cost,
        "tracked": preparation.and_then(|p| p.tracked).map(|o| names.option(o)),
        "pose_candidate": preparation.map(|p| p.candidate),
        "pose_candidates": preparation.map(|p| p.candidates),
        "pose_constrained_problems": preparation.map(|p| p.constrained),
        "mpc_outcome": outcome,
        "mpc_active_limits": active,
        "mpc_active_guides": guides,
        "least_singular_value": tick.least_singular_value,
        "base_clearance_m": tick.base_clearance,
        "rim_speeds_m_per_s": [tick.input[0], tick.input[1]],
        "joint_rates": (0..robot.joint_count()).map(|j| tick.input[2 + j]).collect::<Vec<_>>(),
    })
}

pub(super) fn preparation(tick: &Tick, decision: &Considerations, names: Names, robot: &Robot) -> Value {
    let prepared = tick.robot.and_then(|robot| robot.preparation);
    let is_led = prepared.is_some_and(|p| p.tracked.is_some());
    let reference = |(i, (s, weight)): (usize, (&crate::control::Reference, &f64))| {
        let option = if is_led { i } else { tick.executed };
        json!({ "name": names.option(option), "weight": weight, "s": s.as_slice() })
    };
    let references = decision.references.iter().zip(decision.weights).enumerate().map(reference);
    let configuration = |q: &Configuration| {
        let joints: Vec<f64> = (0..robot.joint_count()).map(|j| q.joints[j]).collect();
        json!({ "x_m": q.base.position.x, "y_m": q.base.position.y, "yaw_rad": q.base.yaw, "joints": joints })
    };
    let candidate = |Considered { candidate, floor, total }: Considered| json!({ "q": configuration(&candidate.configuration), "lower_bound": floor, "total": total });
    let considered = prepared.map(|_| decision.poses.considered().map(candidate).collect::<Vec<_>>());
    json!({
        "step": tick.step,
        "references": references.collect::<Vec<_>>(),
        "target": configuration(decision.target),
        "candidates": considered.unwrap_or_default(),
    })
}

pub(super) fn interaction(step: u64, seen: &Observation) -> Value {
    let near = &seen.clearances;
    let distance = |c: &Option<Clearance>| c.as_ref().map_or(f64::INFINITY, |c| c.distance);
    let obstacle = [&near.robot_obstacle, &near.object_obstacle, &near.human_obstacle];
    json!({
        "step": step,
        "grip": grip(&seen.grip),
        "hand": grip(&seen.hand_grip),
        "squared_jerk_m2_per_s5": seen.squared_jerk,
        "effort_share": seen.effort_share,
        "obstacle_distance_m": obstacle.into_iter().map(distance).fold(f64::INFINITY, f64::min),
        "human_distance_m": distance(&near.robot_human),
        "contacts": seen.contacts.len(),
    })
}

fn grip(forces: &Forces) -> Value {
    let axes = |v: &Vector3<f64>| json!({ "x": v.x, "y": v.y, "z": v.z });
    json!({
        "force_n": axes(&forces.mean.force),
        "torque_nm": axes(&forces.mean.torque),
        "rms_n": forces.rms,
        "peak_n": forces.peak,
        "work_j": forces.work,
        "stretch_m": forces.stretch,
    })
}

pub(super) fn cost(tick: &Tick, summary: &Summary) -> Value {
    let (control, work) = (summary.control.as_ref(), summary.interaction.as_ref().map(|i| i.work));
    json!({
        "step": tick.step,
        "objective_m": tick.objective_cost,
        "accumulated_objective_m": tick.accumulated_cost,
        "walked_m": summary.walked,
        "control": control.map(|c| c.cost()),
        "tracking": control.map(|c| c.tracking),
        "effort": control.map(|c| c.effort),
        "pose": control.map(|c| c.pose),
        "robot_work_j": work.map(|w| w[0]),
        "human_work_j": work.map(|w| w[1]),
    })
}

pub(super) fn outcome(summary: &Summary, ending: Ending, period: f64, names: Names) -> Value {
    let interaction = summary.interaction.as_ref();
    json!({
        "outcome": ending.name(),
        "steps": summary.steps,
        "time_s": summary.steps as f64 * period,
        "walked_m": summary.walked,
        "accumulated_objective_cost_m": summary.accumulated_cost,
        "first_option": names.option(summary.first_option),
        "last_option": names.option(summary.last_option),
        "changes": summary.changes,
        "transition_step": summary.transition.map(|t| t.step),
        "final_stubbornness": summary.human.stubbornness,
        "final_discomfort": summary.human.discomfort,
        "share_off_preference": summary.human.share_off_preference(summary.steps),
        "accumulated_subjective_cost": summary.human.subjective_cost,
        "lost_by": summary.loss.map(|loss| loss.by.name()),
        "lost_at_step": summary.loss.map(|loss| loss.step),
        "lost_distance_m": summary.loss.map(|loss| loss.distance),
        "control_cost": summary.control.map(|c| c.cost()),
        "position_error_rms_m": summary.control.map(|c| c.error_rms(summary.steps)),
        "hand_force_rms_n": interaction.map(|i| i.rms_force()),
        "peak_force_n": interaction.map(|i| i.peak_force),
    })
}

//! Tables of ticks: CSV or JSON lines, one line a tick, every key with its unit.

use super::output::{Failure, write_file};
use crate::control::{Failure as SolveFailure, SolveOutcome};
use crate::coordination::Mode;
use crate::episode::{PhysicsTick, RobotTick, Tick};
use crate::options::OptionSet;
use crate::robot::{ArmJoint, Motion};
use anyhow::{Context, Error};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A file to log ticks to; its ending says how.
#[derive(Clone, Debug)]
pub(super) struct File {
    path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Csv,
    JsonLines,
}

/// Reads the argument.
pub(super) fn file(text: &str) -> Result<File, String> {
    let path = PathBuf::from(text);
    let format = match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => Format::Csv,
        Some("jsonl") => Format::JsonLines,
        _ => return Err("the name must end in .csv or .jsonl".to_owned()),
    };
    Ok(File { path, format })
}

/// What indices in ticks stand for.
pub(super) struct Names<'a> {
    /// The options.
    pub options: &'a OptionSet,
    /// The arm's joints; none without a robot.
    pub joints: &'a [ArmJoint],
}

impl Names<'_> {
    fn option(&self, option: usize) -> &str {
        &self.options.options()[option].name
    }
}

impl File {
    /// Writes all ticks.
    pub fn write(&self, ticks: &[Tick], names: &Names) -> Result<(), Failure> {
        let text = match self.format {
            Format::Csv => csv(ticks, names).map_err(Failure::Output)?,
            Format::JsonLines => ticks.iter().map(|t| json_line(t, names).to_string() + "\n").collect(),
        };
        write_file(&self.path, &text)
    }
}

/// The values of a tick that do not belong to an option, in the order of the columns. NaN does not occur among them.
fn columns(tick: &Tick, names: &Names) -> Vec<(String, Value)> {
    let mode = match tick.mode {
        Mode::RobotLed => "robot-led",
        Mode::HumanLed => "human-led",
    };
    let columns = [
        ("step", json!(tick.step)),
        ("time_s", json!(tick.time)),
        ("x_m", json!(tick.position.x)),
        ("y_m", json!(tick.position.y)),
        ("heading_deg", json!(tick.heading.to_degrees())),
        ("mode", json!(mode)),
        ("stubbornness", json!(tick.stubbornness)),
        ("discomfort", json!(tick.discomfort)),
        ("executed", json!(names.option(tick.executed))),
        ("preferred", json!(names.option(tick.preferred))),
        ("steps_back_for", json!(tick.steps_back_for.map(|option| names.option(option)))),
        ("objective_cost_m", json!(tick.objective_cost)),
        ("accumulated_cost_m", json!(tick.accumulated_cost)),
    ];
    let common = columns.into_iter().map(|(key, value)| (key.to_owned(), value));
    common.chain(tick.robot.iter().flat_map(|robot| robot_columns(robot, names))).collect()
}

/// The values of the robot in a tick, in the order of the columns; null where there is none: what follows a human while the robot leads, and
/// the distance to obstacles where there are none.
fn robot_columns(robot: &RobotTick, names: &Names) -> Vec<(String, Value)> {
    let preparation = robot.preparation;
    let (base, goal) = (robot.configuration.base, robot.grasp_goal);
    let outcome = match robot.outcome {
        SolveOutcome::Unconstrained => "unconstrained",
        SolveOutcome::Constrained { .. } => "constrained",
        SolveOutcome::Fallback(SolveFailure::NotFinite) => "fallback: not finite",
        SolveOutcome::Fallback(SolveFailure::NotSolved) => "fallback: not solved",
    };
    let (active, guides) = match robot.outcome {
        SolveOutcome::Constrained { active, guides } => (active, guides),
        _ => (0, 0),
    };
    let fixed = [
        ("grasp_goal_x_m", json!(goal.position.x)),
        ("grasp_goal_y_m", json!(goal.position.y)),
        ("grasp_goal_yaw_deg", json!(goal.yaw.to_degrees())),
        ("base_x_m", json!(base.position.x)),
        ("base_y_m", json!(base.position.y)),
        ("base_yaw_deg", json!(base.yaw.to_degrees())),
        ("base_clearance_m", json!(robot.base_clearance)),
        ("tracked", json!(preparation.and_then(|p| p.tracked).map(|o| names.option(o)))),
        ("pose_candidate", json!(preparation.map(|p| p.candidate))),
        ("pose_candidates", json!(preparation.map(|p| p.candidates))),
        ("pose_constrained_problems", json!(preparation.map(|p| p.constrained))),
        ("mpc_outcome", json!(outcome)),
        ("mpc_active_limits", json!(active)),
        ("mpc_active_guides", json!(guides)),
        ("least_singular_value", json!(robot.least_singular_value)),
        ("position_error_m", json!(robot.position_error)),
        ("orientation_error_deg", json!(robot.orientation_error.to_degrees())),
        ("tracking_cost", json!(robot.tracking_cost)),
        ("control_effort", json!(robot.control_effort)),
        ("pose_cost", json!(robot.pose_cost)),
        ("left_rim_m_per_s", json!(robot.input[0])),
        ("right_rim_m_per_s", json!(robot.input[1])),
    ];
    let joints = names.joints.iter().enumerate().flat_map(|(i, joint)| {
        let (unit, name) = (if joint.motion == Motion::Revolute { "rad" } else { "m" }, &joint.name);
        [
            (format!("position_{unit}[{name}]"), json!(robot.configuration.joints[i])),
            (format!("rate_{unit}_per_s[{name}]"), json!(robot.input[i + 2])),
        ]
    });
    let physics = robot.physics.iter().flat_map(|physics| physics_columns(physics));
    let named = |(key, value): (&str, Value)| (key.to_owned(), value);
    fixed.into_iter().map(named).chain(joints).chain(physics.map(named)).collect()
}

/// The values of the physical plant in a tick, in the order of the columns; null for a distance where there is nothing to be near to.
fn physics_columns(physics: &PhysicsTick) -> [(&'static str, Value); 23] {
    let PhysicsTick { object, hand, torso, .. } = *physics;
    [
        ("object_x_m", json!(object.position.x)),
        ("object_y_m", json!(object.position.y)),
        ("object_yaw_deg", json!(object.yaw.to_degrees())),
        ("hand_x_m", json!(hand.position.x)),
        ("hand_y_m", json!(hand.position.y)),
        ("hand_yaw_deg", json!(hand.yaw.to_degrees())),
        ("torso_x_m", json!(torso.position.x)),
        ("torso_y_m", json!(torso.position.y)),
        ("torso_yaw_deg", json!(torso.yaw.to_degrees())),
        ("grip_force_n", json!(physics.grip_force)),
        ("hand_force_n", json!(physics.hand_force)),
        ("peak_force_n", json!(physics.peak_force)),
        ("grip_stretch_m", json!(physics.stretch[0])),
        ("hand_stretch_m", json!(physics.stretch[1])),
        ("grip_force_change_n", json!(physics.force_change[0])),
        ("hand_force_change_n", json!(physics.force_change[1])),
        ("effort_share", json!(physics.effort_share)),
        ("robot_work_j", json!(physics.work[0])),
        ("human_work_j", json!(physics.work[1])),
        ("squared_jerk_m2_per_s5", json!(physics.squared_jerk)),
        ("obstacle_distance_m", json!(physics.obstacle_distance)),
        ("human_distance_m", json!(physics.human_distance)),
        ("pace_m", json!(physics.pace)),
    ]
}

/// The values of one option in a tick, in the order of the columns; null where a value was not evaluated.
fn option_columns(tick: &Tick, option: usize) -> [(&'static str, Value); 6] {
    let o = &tick.options[option];
    [
        ("length_m", json!(o.remaining.length)),
        ("risk", json!(o.remaining.risk)),
        ("objective_m", json!(o.objective)),
        ("expected_subjective", json!(o.expected)),
        ("probability", json!(o.probability)),
        ("misaligned", json!(u8::from(o.misaligned))),
    ]
}

fn csv(ticks: &[Tick], names: &Names) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (i, tick) in ticks.iter().enumerate() {
        let common = columns(tick, names).into_iter();
        let options = (0..tick.options.len()).flat_map(|o| {
            let name = names.option(o);
            option_columns(tick, o).into_iter().map(move |(key, value)| (format!("{key}[{name}]"), value))
        });
        let (keys, values): (Vec<String>, Vec<Value>) = common.chain(options).unzip();
        if i == 0 {
            writer.write_record(&keys)?;
        }
        writer.write_record(values.iter().map(|value| match value {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }))?;
    }
    let bytes = writer.into_inner().context("CSV")?;
    String::from_utf8(bytes).context("CSV")
}

fn json_line(tick: &Tick, names: &Names) -> Value {
    let mut line: serde_json::Map<String, Value> = columns(tick, names).into_iter().collect();
    let options = (0..tick.options.len())
        .map(|o| {
            let values = option_columns(tick, o).into_iter().map(|(key, value)| (key.to_owned(), value));
            Value::Object([("name".to_owned(), json!(names.option(o)))].into_iter().chain(values).collect())
        })
        .collect();
    line.insert("options".to_owned(), Value::Array(options));
    Value::Object(line)
}

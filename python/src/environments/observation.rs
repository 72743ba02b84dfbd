//! Observations: their numbers, with names, units and bounds.

use super::rules::{Rules, Task};
use crate::partners::configuration_vector;
use cocarry::control::HORIZON;
use cocarry::coordination::Mode;
use cocarry::episode::Episode;
use cocarry::geometry::PlanarPose;
use cocarry::human::Stance;
use cocarry::math;
use cocarry::quantities::{OPTION, QuantityKind, option_numbers};
use cocarry::robot;
use cocarry::scenario::PreparedScenario;

/// The largest number in an observation.
const MAX_VALUE: f64 = 1e7;
/// The numbers of an observation of options that are not of a single option.
const COMMON: [&str; 3] = ["stubbornness", "human_leads", "human_takes_over"];
/// Points of the path ahead of a robot, one per planning step.
const AHEAD: usize = HORIZON;
/// The unit of shares and flags.
const PLAIN: &str = "1";

const FLAG: [f64; 2] = [0.0, 1.0];
const WIDE: [f64; 2] = [-MAX_VALUE, MAX_VALUE];

/// A number of an observation, or of an action.
#[derive(Clone, Debug)]
pub(super) struct Number {
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) bounds: [f64; 2],
}

impl Number {
    fn new(name: impl Into<String>, unit: &'static str, bounds: [f64; 2]) -> Self {
        Self { name: name.into(), unit, bounds }
    }

    fn wide(name: impl Into<String>, unit: &'static str) -> Self {
        Self::new(name, unit, WIDE)
    }
}

/// A pose on the floor.
fn planar(name: &str) -> impl Iterator<Item = Number> {
    [("x_m", "m"), ("y_m", "m"), ("yaw_rad", "rad")]
        .map(|(part, unit)| Number::wide(format!("{name}_{part}"), unit))
        .into_iter()
}

/// The joints of a robot: their positions.
fn joints(robot: &robot::Robot) -> impl Iterator<Item = Number> {
    robot.joints.iter().map(|joint| match joint.motion == robot::Motion::Prismatic {
        true => Number::wide(format!("joint_m[{}]", joint.name), "m"),
        false => Number::wide(format!("joint_rad[{}]", joint.name), "rad"),
    })
}

/// The inputs u of a robot, each called `key` with its unit.
pub(super) fn inputs(robot: &robot::Robot, key: &str) -> Vec<Number> {
    let one = |turns: bool, name: &str| {
        let (ending, unit) = if turns { ("rad_per_s", "rad/s") } else { ("m_per_s", "m/s") };
        Number::wide(format!("{key}_{ending}[{name}]"), unit)
    };
    let base: &[(bool, &str)] = match robot.drive.inputs() {
        2 => &[(false, "left rim"), (false, "right rim")],
        _ => &[(false, "base ahead"), (false, "base left"), (true, "base turning")],
    };
    let base = base.iter().map(|(turns, name)| one(*turns, name));
    let turns = |motion| motion == robot::Motion::Revolute;
    base.chain(robot.joints.iter().map(|joint| one(turns(joint.motion), &joint.name))).collect()
}

/// The velocity of the grasp's reference in the grasp's frame.
pub(super) fn velocity() -> Vec<Number> {
    let of = |name: &str, unit| Number::wide(name, unit);
    vec![of("ahead_m_per_s", "m/s"), of("left_m_per_s", "m/s"), of("turning_rad_per_s", "rad/s")]
}

impl Rules {
    /// The numbers of an observation.
    pub(super) fn numbers(&self) -> Vec<Number> {
        match (self.task, self.bases.first().and_then(|base| base.robot())) {
            (Task::Inputs | Task::Reference | Task::Residual, Some(robot)) => self.carrying_numbers(robot),
            _ => self.option_numbers(),
        }
    }

    fn option_numbers(&self) -> Vec<Number> {
        let mut numbers = Vec::new();
        for option in 0..self.options {
            for quantity in OPTION.iter().filter(|quantity| quantity.key != "name") {
                let is_share = ["risk", "probability", "misaligned"].contains(&quantity.key);
                let bounds = if is_share { FLAG } else { [0.0, MAX_VALUE] };
                let unit = match quantity.kind {
                    QuantityKind::Number(unit) if !unit.is_empty() => unit,
                    _ if quantity.key == "expected_subjective_cost" => "cost units",
                    _ => PLAIN,
                };
                numbers.push(Number::new(format!("{}[{option}]", quantity.key), unit, bounds));
            }
            numbers.push(Number::new(format!("executed[{option}]"), PLAIN, FLAG));
            if self.is_masked() {
                numbers.push(Number::new(format!("available[{option}]"), PLAIN, FLAG));
            }
        }
        numbers.push(Number::new(COMMON[0], PLAIN, [0.0, MAX_VALUE]));
        numbers.extend(COMMON[1..].iter().map(|name| Number::new(*name, PLAIN, FLAG)));
        numbers
    }

    fn carrying_numbers(&self, robot: &robot::Robot) -> Vec<Number> {
        let mut numbers: Vec<Number> = joints(robot).chain(inputs(robot, "last_input")).collect();
        numbers.extend(planar("goal"));
        for i in 1..=AHEAD {
            numbers.extend(["x_m", "y_m"].map(|part| Number::wide(format!("ahead_{part}[{i}]"), "m")));
        }
        numbers.extend(planar("base"));
        numbers.push(Number::wide("base_clearance_m", "m"));
        numbers.push(Number::new("human_leads", PLAIN, FLAG));
        numbers.extend(planar("object").chain(planar("hand")));
        numbers.extend([
            Number::wide("hand_force_x_n", "N"),
            Number::wide("hand_force_y_n", "N"),
            Number::wide("hand_torque_z_nm", "Nm"),
        ]);
        if self.ending.is_some() {
            numbers.push(Number::new("time_left", PLAIN, FLAG));
        }
        numbers
    }

    /// Observes an episode. `time_left`: the share of its steps that is left.
    pub(super) fn observe(
        &self,
        prepared: &PreparedScenario,
        episode: &Episode,
        time_left: f64,
        into: &mut [f64],
    ) {
        match self.task {
            Task::Options | Task::Both => self.observe_options(episode, into),
            Task::Inputs | Task::Reference | Task::Residual => {
                let (timed, numbers) = match self.ending {
                    Some(_) => into.split_last_mut().map_or((None, &mut [][..]), |(t, n)| (Some(t), n)),
                    None => (None, &mut *into),
                };
                self.observe_carrying(prepared, episode, numbers);
                if let Some(timed) = timed {
                    *timed = time_left;
                }
            }
        }
        for number in into {
            *number = if number.is_nan() { 0.0 } else { number.clamp(-MAX_VALUE, MAX_VALUE) };
        }
    }

    fn observe_options(&self, episode: &Episode, into: &mut [f64]) {
        let Some(view) = episode.robot_view() else { return };
        into.fill(0.0);
        let mut at = 0;
        let mut put = |number: f64| {
            into[at] = number;
            at += 1;
        };
        for (i, option) in view.evaluated.iter().enumerate() {
            option_numbers(option).into_iter().for_each(&mut put);
            put(f64::from(u8::from(view.executed == Some(i))));
            if self.is_masked() {
                put(1.0);
            }
        }
        let common = [
            view.stubbornness,
            f64::from(u8::from(view.mode == Mode::HumanLed)),
            f64::from(u8::from(view.stance == Stance::TakeOver)),
        ];
        let begin = into.len() - COMMON.len();
        into[begin..].copy_from_slice(&common);
    }

    fn observe_carrying(&self, prepared: &PreparedScenario, episode: &Episode, into: &mut [f64]) {
        let Some(view) = episode.robot_view() else { return };
        let (Some(configuration), Some(grasp)) = (view.configuration, view.grasp) else { return };
        let Some(model) = prepared.robot() else { return };
        let (joints, inputs) = (model.joint_count(), model.joint_count() + model.drive.inputs());
        let grasp = PlanarPose::from_above(&grasp);
        let robot = episode.tick().robot.as_ref();
        let mut numbers = Vec::with_capacity(into.len());
        let whole = configuration_vector(configuration, joints);
        numbers.extend(&whole[3..]);
        numbers.extend((0..inputs).map(|i| robot.map_or(0.0, |robot| robot.input[i])));
        let goal = episode.human().or(robot.map(|robot| robot.grasp_goal)).unwrap_or(grasp);
        numbers.extend(seen_from(&grasp, &goal));
        let settings = &prepared.scenario().settings;
        let per_step = settings.speed * settings.planning_step;
        for i in 1..=AHEAD {
            let along = (episode.along() + i as f64 * per_step).min(episode.path().length());
            let ahead = episode.path().point_at(along);
            let ahead =
                ahead.map_or([0.0; 3], |position| seen_from(&grasp, &PlanarPose { position, yaw: 0.0 }));
            numbers.extend(&ahead[..2]);
        }
        numbers.extend(seen_from(&grasp, &configuration.base));
        numbers.push(robot.map_or(0.0, |robot| robot.base_clearance.min(10.0)));
        numbers.push(f64::from(u8::from(view.mode == Mode::HumanLed)));
        match episode.observation() {
            None => numbers.extend([0.0; 9]),
            Some(seen) => {
                numbers.extend(seen_from(&grasp, &PlanarPose::from_above(&seen.object)));
                numbers.extend(seen_from(&grasp, &seen.hand_planar));
                let wrench = &seen.hand_grip.mean;
                let [x, y] = turned_into(&grasp, [wrench.force.x, wrench.force.y]);
                numbers.extend([x, y, wrench.torque.z]);
            }
        }
        into.copy_from_slice(&numbers);
    }
}

/// A vector in the axes of a frame on the floor.
pub(super) fn turned_into(frame: &PlanarPose, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = (math::sin(frame.yaw), math::cos(frame.yaw));
    [cos * x + sin * y, cos * y - sin * x]
}

/// A pose as x, y and yaw in the frame of another.
fn seen_from(frame: &PlanarPose, pose: &PlanarPose) -> [f64; 3] {
    let between = pose.position - frame.position;
    let [x, y] = turned_into(frame, [between.x, between.y]);
    let turn = pose.yaw - frame.yaw;
    [x, y, math::atan2(math::sin(turn), math::cos(turn))]
}

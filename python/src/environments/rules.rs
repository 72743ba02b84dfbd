//! What the lanes of an environment share: observations, and the decisions that actions stand for.

use crate::partners::configuration_vector;
use cocarry::control::HORIZON;
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, Outcome};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::human::Stance;
use cocarry::math;
use cocarry::policy::{Decision, Motion};
use cocarry::quantities::{OPTION, OptionView, Value};
use cocarry::robot::InputVector;
use cocarry::scenario::{GivenPerception, PreparedScenario};
use std::sync::Arc;

/// The largest number in an observation.
pub(super) const MAX_VALUE: f64 = 1e7;
/// The numbers of an observation of [`Task::Options`] that are not of a single option.
pub(super) const COMMON: [&str; 3] = ["stubbornness", "human_leads", "human_takes_over"];
/// The flag of the executed option, after the quantities of an option.
pub(super) const EXECUTED: &str = "executed";
/// Points of the path ahead in an observation of [`Task::Inputs`] and [`Task::Reference`], one per planning
/// step.
pub(super) const AHEAD: usize = HORIZON;

/// What the actions decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Task {
    /// The option on which the robot leads, or to follow.
    Options,
    /// That, and the human's option and response.
    Both,
    /// The inputs u.
    Inputs,
    /// The velocity of the reference of eq. (7).
    Reference,
}

/// When a lane that has ended begins anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Autoreset {
    /// In the next step, whose action is ignored.
    NextStep,
    /// In the same step.
    SameStep,
}

/// What all lanes share.
#[derive(Debug)]
pub(super) struct Rules {
    pub(super) task: Task,
    /// The scenarios to draw from, one for every world.
    pub(super) bases: Vec<Arc<PreparedScenario>>,
    pub(super) given: GivenPerception,
    /// The largest number of options of a world.
    pub(super) options: usize,
    pub(super) joints: usize,
    /// The number of inputs of the base.
    pub(super) base: usize,
    /// What an action of 1 stands for; none for options.
    pub(super) limits: Vec<f64>,
    /// Weights of J, J^ and C in the reward.
    pub(super) weights: [f64; 3],
    /// The number of steps after which an episode is truncated.
    pub(super) most_steps: Option<u64>,
    /// When a lane that has ended begins anew; `None`: it waits for its reset.
    pub(super) autoreset: Option<Autoreset>,
}

impl Rules {
    pub(super) fn size(&self) -> usize {
        match self.task {
            Task::Options | Task::Both => self.options * (OPTION.len() - 1 + 1) + COMMON.len(),
            Task::Inputs | Task::Reference => 2 * self.joints + self.base + 3 + 2 * AHEAD + 3 + 2 + 3 + 3 + 3,
        }
    }

    /// The names of the numbers of an observation, with their bounds.
    pub(super) fn layout(&self) -> Vec<(String, [f64; 2])> {
        let mut layout = Vec::with_capacity(self.size());
        let flag = [0.0, 1.0];
        match self.task {
            Task::Options | Task::Both => {
                for option in 0..self.options {
                    for quantity in OPTION.iter().filter(|quantity| quantity.key != "name") {
                        let is_share = ["risk", "probability", "misaligned"].contains(&quantity.key);
                        let bounds = if is_share { flag } else { [0.0, MAX_VALUE] };
                        layout.push((format!("{}[{option}]", quantity.key), bounds));
                    }
                    layout.push((format!("{EXECUTED}[{option}]"), flag));
                }
                layout.push((COMMON[0].to_owned(), [0.0, MAX_VALUE]));
                layout.extend(COMMON[1..].iter().map(|name| ((*name).to_owned(), flag)));
            }
            Task::Inputs | Task::Reference => {
                let wide = [-MAX_VALUE, MAX_VALUE];
                let mut add = |name: String, bounds| layout.push((name, bounds));
                (0..self.joints).for_each(|i| add(format!("joint[{i}]"), wide));
                (0..self.joints + self.base).for_each(|i| add(format!("last_input[{i}]"), wide));
                let planar = |name: &str| ["x_m", "y_m", "yaw_rad"].map(|part| format!("{name}_{part}"));
                planar("goal").into_iter().for_each(|name| add(name, wide));
                (1..=AHEAD).for_each(|i| {
                    ["x_m", "y_m"].iter().for_each(|part| add(format!("ahead_{part}[{i}]"), wide))
                });
                planar("base").into_iter().for_each(|name| add(name, wide));
                add("base_clearance_m".to_owned(), wide);
                add("human_leads".to_owned(), flag);
                planar("object").into_iter().for_each(|name| add(name, wide));
                planar("hand").into_iter().for_each(|name| add(name, wide));
                ["hand_force_x_n", "hand_force_y_n", "hand_torque_z_nm"]
                    .iter()
                    .for_each(|name| add((*name).to_owned(), wide));
            }
        }
        layout
    }

    pub(super) fn observe(&self, prepared: &PreparedScenario, episode: &Episode, into: &mut [f64]) {
        match self.task {
            Task::Options | Task::Both => self.observe_options(prepared, episode, into),
            Task::Inputs | Task::Reference => self.observe_carrying(prepared, episode, into),
        }
        for number in into {
            *number = if number.is_nan() { 0.0 } else { number.clamp(-MAX_VALUE, MAX_VALUE) };
        }
    }

    pub(super) fn observe_options(&self, prepared: &PreparedScenario, episode: &Episode, into: &mut [f64]) {
        let Some(view) = episode.robot_view() else { return };
        into.fill(0.0);
        let mut at = 0;
        let mut put = |number: f64| {
            into[at] = number;
            at += 1;
        };
        let named = prepared.options().options().iter().zip(view.evaluated).enumerate();
        for (i, (option, evaluated)) in named {
            let option = OptionView { name: &option.name, option: evaluated };
            for quantity in OPTION.iter().filter(|quantity| quantity.key != "name") {
                let value = (quantity.get)(&option);
                put(value.as_f64().unwrap_or_else(|| f64::from(u8::from(value == Value::Flag(true)))));
            }
            put(f64::from(u8::from(view.executed == Some(i))));
        }
        let common = [
            view.stubbornness,
            f64::from(u8::from(view.mode == Mode::HumanLed)),
            f64::from(u8::from(view.stance == Stance::TakeOver)),
        ];
        let begin = into.len() - COMMON.len();
        into[begin..].copy_from_slice(&common);
    }

    pub(super) fn observe_carrying(&self, prepared: &PreparedScenario, episode: &Episode, into: &mut [f64]) {
        let Some(view) = episode.robot_view() else { return };
        let (Some(configuration), Some(grasp)) = (view.configuration, view.grasp) else { return };
        let grasp = PlanarPose::from_above(&grasp);
        let robot = episode.tick().robot.as_ref();
        let mut numbers = Vec::with_capacity(into.len());
        let whole = configuration_vector(configuration, self.joints);
        numbers.extend(&whole[3..]);
        numbers.extend((0..self.joints + self.base).map(|i| robot.map_or(0.0, |robot| robot.input[i])));
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
                let (sin, cos) = (math::sin(grasp.yaw), math::cos(grasp.yaw));
                let (x, y) = (wrench.force.x, wrench.force.y);
                numbers.extend([cos * x + sin * y, cos * y - sin * x, wrench.torque.z]);
            }
        }
        into.copy_from_slice(&numbers);
    }

    /// Begins the next step and observes it; returns the outcome once the episode has ended. Where the human
    /// acts too, a copy looks ahead, since the human has not decided yet.
    pub(super) fn begin(
        &self,
        prepared: &PreparedScenario,
        episode: &mut Episode<'_>,
        into: &mut [f64],
    ) -> Option<Outcome> {
        if self.task == Task::Both {
            let mut ahead = episode.clone();
            let ended = ahead.begin_step();
            self.observe(prepared, &ahead, into);
            // asks nobody, and notes the outcome
            return ended.and_then(|_| episode.begin_step());
        }
        let ended = episode.begin_step();
        self.observe(prepared, episode, into);
        ended
    }

    /// The decision of an action.
    pub(super) fn decision(&self, episode: &mut Episode, action: &[f64]) -> Decision {
        if matches!(self.task, Task::Options | Task::Both) {
            let option = action[0] as usize;
            return if option >= self.options { Decision::follow() } else { Decision::lead(option) };
        }
        let grasp =
            episode.robot_view().and_then(|view| view.grasp).map(|pose| PlanarPose::from_above(&pose));
        let decision = episode.ask_policy();
        let bounded = |i: usize| action[i].clamp(-1.0, 1.0) * self.limits[i];
        match (self.task, grasp) {
            (Task::Reference, Some(grasp)) => {
                // a constant velocity in the grasp's frame
                let period = action[action.len() - 1];
                let (sin, cos) = (math::sin(grasp.yaw), math::cos(grasp.yaw));
                let (ahead, left, turn) = (bounded(0), bounded(1), bounded(2));
                let poses = std::array::from_fn(|i| {
                    let time = (i + 1) as f64 * period;
                    let (x, y) = (cos * ahead - sin * left, sin * ahead + cos * left);
                    let position = Point::new(grasp.position.x + x * time, grasp.position.y + y * time);
                    PlanarPose { position, yaw: grasp.yaw + turn * time }
                });
                decision.with_motion(Motion::Reference(poses))
            }
            _ => {
                let mut u = InputVector::zeros();
                (0..self.limits.len()).for_each(|i| u[i] = bounded(i));
                decision.with_motion(Motion::Inputs(u))
            }
        }
    }
}

/// A pose as x, y and yaw in the frame of another.
pub(super) fn seen_from(frame: &PlanarPose, pose: &PlanarPose) -> [f64; 3] {
    let between = pose.position - frame.position;
    let (sin, cos) = (math::sin(frame.yaw), math::cos(frame.yaw));
    let turn = pose.yaw - frame.yaw;
    [
        cos * between.x + sin * between.y,
        cos * between.y - sin * between.x,
        math::atan2(math::sin(turn), math::cos(turn)),
    ]
}

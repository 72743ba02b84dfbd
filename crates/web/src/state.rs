//! The state of an episode as numbers in the module's memory, by one table.

use crate::steering::Steering;
use cocarry::coordination::{Mode, OptionTick};
use cocarry::episode::{ControlSummary, Episode, Outcome, RobotTick};
use cocarry::geometry::{Pose, direction};
use cocarry::human::Stance;
use cocarry::scenario::PreparedScenario;
use cocarry::simulation::{Clearance, Observation, Wrench};
use cocarry_output::bodies::{self, Bodies};
use nalgebra::UnitQuaternion;
use serde_json::{Value, json};

/// All outcomes, in the order of their numbers.
pub const OUTCOMES: [Outcome; 8] = [
    Outcome::Arrived,
    Outcome::OutOfTime,
    Outcome::NoWay,
    Outcome::Collided,
    Outcome::Stuck,
    Outcome::Dropped,
    Outcome::ObjectLost,
    Outcome::NonFinite,
];

/// What the numbers are read from.
struct Seen<'a> {
    prepared: &'a PreparedScenario,
    episode: &'a Episode<'a>,
    outcome: Option<Outcome>,
    steering: &'a Steering,
    options: &'a [OptionTick],
    bodies: Option<Bodies>,
    links: Vec<Pose>,
}

/// How many numbers a field has.
#[derive(Clone, Copy)]
enum Count {
    /// So many.
    Numbers(usize),
    /// One for each option.
    Options,
    /// One for each joint of the arm.
    Joints,
    /// A pose for each link.
    Links,
}

/// A field of the state.
struct Field {
    name: &'static str,
    count: Count,
    unit: &'static str,
    about: &'static str,
    /// Writes its numbers in place of NaNs; leaves them where it does not apply.
    write: fn(&Seen, &mut [f64]),
}

macro_rules! fields {
    ($($name:literal, $count:expr, $unit:literal, $about:literal, $write:expr;)*) => {
        &[$(Field { name: $name, count: $count, unit: $unit, about: $about, write: $write }),*]
    };
}

const ONE: Count = Count::Numbers(1);
const POSE: Count = Count::Numbers(7);
const WRENCH: Count = Count::Numbers(6);

/// The table.
#[rustfmt::skip]
const FIELDS: &[Field] = fields! {
    "time", ONE, "s", "simulated time", |s, n| n[0] = s.time();
    "step", ONE, "", "planning steps begun: k + 1 of the present one", |s, n| n[0] = (s.episode.summary().steps + u64::from(s.is_within())) as f64;
    "period", ONE, "", "control periods done of the present planning step; 0 between planning steps", |s, n| n[0] = s.episode.periods()[0].into();
    "outcome", ONE, "", "index into `outcomes` of the catalogue; -1 while the episode goes on", |s, n| n[0] = s.outcome.and_then(|o| OUTCOMES.iter().position(|other| *other == o)).map_or(-1.0, |o| o as f64);
    "mode", ONE, "", "0 the robot leads, 1 the human leads", |s, n| n[0] = match s.mode() { Mode::RobotLed => 0.0, Mode::HumanLed => 1.0 };
    "stance", ONE, "", "of the human: 0 follows, 1 resists, 2 takes over", |s, n| put(n, s.stance().map(|stance| match stance { Stance::Follow => 0.0, Stance::Resist => 1.0, Stance::TakeOver => 2.0 }));
    "stubbornness", ONE, "", "phi(k), eq. (5); the human takes the lead above 1", |s, n| n[0] = s.human()[0];
    "discomfort", ONE, "", "g(k), eq. (5)", |s, n| n[0] = s.human()[1];
    "executed", ONE, "", "index of the executed option", |s, n| put(n, s.has_begun().then_some(s.episode.tick().executed as f64));
    "preferred", ONE, "", "index of the option that the human prefers now", |s, n| put(n, s.has_begun().then_some(s.episode.tick().preferred as f64));
    "reverses_for", ONE, "", "index of the option for which the team reverses", |s, n| put(n, s.episode.tick().reverses_for.map(|o| o as f64));
    "position", Count::Numbers(2), "m", "of the team", |s, n| n.copy_from_slice(s.episode.position().coords.as_slice());
    "heading", ONE, "rad", "direction of travel", |s, n| n[0] = s.episode.path().heading_at(s.episode.along()).unwrap_or(s.episode.tick().heading);
    "along", ONE, "m", "position along the path", |s, n| n[0] = s.episode.along();
    "path_length", ONE, "m", "length of the path", |s, n| n[0] = s.episode.path().length();
    "walked", ONE, "m", "length of the path walked, up to the last planning step", |s, n| n[0] = s.episode.summary().walked;
    "objective_cost", ONE, "m", "J of the executed option", |s, n| put(n, s.has_begun().then_some(s.episode.tick().objective_cost));
    "accumulated_objective_cost", ONE, "m", "sum over the planning steps", |s, n| n[0] = s.episode.summary().accumulated_cost;
    "accumulated_control_cost", ONE, "", "C so far", |s, n| put(n, s.episode.summary().control.as_ref().map(ControlSummary::cost));
    "position_error", ONE, "m", "distance between grasp and reference at the end of the last planning step", |s, n| put(n, s.robot().map(|r| r.position_error));
    "grasp_goal", Count::Numbers(3), "m, m, rad", "s: where the grasp should be at the beginning of the last planning step", |s, n| if let Some(r) = s.robot() { n.copy_from_slice(&[r.grasp_goal.position.x, r.grasp_goal.position.y, r.grasp_goal.yaw]) };
    "base", Count::Numbers(3), "m, m, rad", "the robot's base", |s, n| if let Some(q) = s.episode.configuration() { n.copy_from_slice(&[q.base.position.x, q.base.position.y, q.base.yaw]) };
    "hand_target", Count::Numbers(2), "m", "as set from outside", |s, n| if let Some(hand) = s.steering.now().hand { n.copy_from_slice(hand.coords.as_slice()) };
    "object", POSE, "m, -", "pose of the object's centre", |s, n| pose(n, s.bodies.map(|b| b.object));
    "object_twist", WRENCH, "m/s, rad/s", "velocity and angular velocity of the object", |s, n| if let Some(o) = s.seen() { n.copy_from_slice(&o.object_twist) };
    "hand", POSE, "m, -", "pose of the human's hand", |s, n| pose(n, s.bodies.map(|b| b.hand));
    "torso", POSE, "m, -", "pose of the human's torso", |s, n| pose(n, s.bodies.map(|b| b.torso));
    "backward", ONE, "", "whether the human walks backward: 0 or 1", |s, n| put(n, s.bodies.map(|b| s.is_backward(&b)));
    "grip_wrench", WRENCH, "N, Nm", "of the robot on the object, mean since the planning step began", |s, n| wrench(n, s.seen().map(|o| o.grip.mean));
    "hand_wrench", WRENCH, "N, Nm", "of the human on the object, mean since the planning step began", |s, n| wrench(n, s.seen().map(|o| o.hand_grip.mean));
    "grip_wrench_now", WRENCH, "N, Nm", "of the robot on the object, in the last physics step", |s, n| wrench(n, s.seen().map(|o| o.grip.last));
    "hand_wrench_now", WRENCH, "N, Nm", "of the human on the object, in the last physics step", |s, n| wrench(n, s.seen().map(|o| o.hand_grip.last));
    "peak_force", ONE, "N", "largest force in either grip since the planning step began", |s, n| put(n, s.seen().map(|o| o.grip.peak.max(o.hand_grip.peak)));
    "deflection", Count::Numbers(2), "m", "largest deflection of the robot's and of the human's grip since the planning step began", |s, n| if let Some(o) = s.seen() { n.copy_from_slice(&[o.grip.deflection, o.hand_grip.deflection]) };
    "obstacle_distance", ONE, "m", "least distance of robot, object or human to an obstacle", |s, n| put(n, s.seen().and_then(obstacle_distance));
    "human_distance", ONE, "m", "distance between robot and human", |s, n| put(n, s.seen().and_then(|o| distance(&o.clearances.robot_human)));
    "hand_limits", Count::Numbers(2), "m/s, m/s^2", "largest speed and acceleration of the hand", |s, n| if let Some(p) = s.prepared.scenario().plant.physics() { n.copy_from_slice(&[p.human.speed_limit, p.human.acceleration_limit]) };
    "option_length", Count::Options, "m", "D_o", |s, n| each(n, s.options, |o| o.remaining.length);
    "option_risk", Count::Options, "", "S_o", |s, n| each(n, s.options, |o| o.remaining.risk);
    "option_cost", Count::Options, "m", "J_o, eq. (1)", |s, n| each(n, s.options, |o| o.objective);
    "option_probability", Count::Options, "", "P_o, eq. (4)", |s, n| each(n, s.options, |o| o.probability);
    "option_expected_cost", Count::Options, "", "J~_o, eq. (6)", |s, n| each(n, s.options, |o| o.expected);
    "option_misaligned", Count::Options, "", "omega_o, eq. (5): 0 or 1", |s, n| each(n, s.options, |o| u8::from(o.misaligned).into());
    "joint_position", Count::Joints, "rad or m", "position of every joint of the arm", |s, n| if let Some(q) = s.episode.configuration() { each(n, q.joints.as_slice(), |q| *q) };
    "joint_rate", Count::Joints, "rad/s or m/s", "rate of every joint of the arm", |s, n| if let Some(o) = s.seen() { each(n, o.joint_rates.as_slice(), |q| *q) };
    "joint_effort", Count::Joints, "Nm or N", "effort of every joint of the arm", |s, n| if let Some(o) = s.seen() { each(n, o.joint_efforts.as_slice(), |q| *q) };
    "links", Count::Links, "m, -", "pose of every link, in the order of the robot's links", |s, n| for (part, link) in n.chunks_exact_mut(7).zip(&s.links) { pose(part, Some(*link)) };
};

impl<'a> Seen<'a> {
    /// Whether a planning step has begun and is not over.
    fn is_within(&self) -> bool {
        self.episode.periods() != [0; 2]
    }

    fn has_begun(&self) -> bool {
        self.episode.summary().steps > 0
    }

    fn time(&self) -> f64 {
        let settings = &self.prepared.scenario().settings;
        let begun = self.episode.summary().steps as f64 * settings.planning_step;
        begun + f64::from(self.episode.periods()[0]) * settings.control_period()
    }

    fn mode(&self) -> Mode {
        match self.has_begun() {
            true => self.episode.tick().mode,
            false => self.prepared.scenario().settings.method.policy().initial_mode(),
        }
    }

    fn stance(&self) -> Option<Stance> {
        let begun = self.episode.robot_view().map(|view| view.stance);
        begun.or(self.episode.decided().map(|(human, _)| human.stance))
    }

    /// phi and g.
    fn human(&self) -> [f64; 2] {
        let tick = self.episode.tick();
        let last = match self.has_begun() {
            true => [tick.stubbornness, tick.discomfort],
            false => [self.prepared.scenario().settings.coordination.initial_stubbornness, 0.0],
        };
        self.episode.robot_view().map_or(last, |view| [view.stubbornness, view.discomfort])
    }

    fn seen(&self) -> Option<&'a Observation> {
        self.episode.observation()
    }

    fn robot(&self) -> Option<&'a RobotTick> {
        self.episode.tick().robot.as_ref()
    }

    fn is_backward(&self, bodies: &Bodies) -> f64 {
        let facing = bodies.torso.rotation * nalgebra::Vector3::x();
        let heading = direction(self.episode.tick().heading);
        f64::from(u8::from(self.has_begun() && heading.dot(&facing.xy()) < 0.0))
    }
}

fn put(numbers: &mut [f64], value: Option<f64>) {
    numbers[0] = value.unwrap_or(f64::NAN);
}

fn each<T>(numbers: &mut [f64], of: &[T], value: impl Fn(&T) -> f64) {
    numbers.iter_mut().zip(of).for_each(|(number, of)| *number = value(of));
}

/// Position (m) and quaternion (x, y, z, w).
fn pose(numbers: &mut [f64], pose: Option<Pose>) {
    let Some(pose) = pose else { return };
    let (at, q) = (pose.translation.vector, UnitQuaternion::from_rotation_matrix(&pose.rotation));
    numbers.copy_from_slice(&[at.x, at.y, at.z, q.i, q.j, q.k, q.w]);
}

fn wrench(numbers: &mut [f64], wrench: Option<Wrench>) {
    let Some(Wrench { force, torque }) = wrench else { return };
    numbers[..3].copy_from_slice(force.as_slice());
    numbers[3..].copy_from_slice(torque.as_slice());
}

fn distance(clearance: &Option<Clearance>) -> Option<f64> {
    clearance.as_ref().map(|clearance| clearance.distance)
}

fn obstacle_distance(seen: &Observation) -> Option<f64> {
    let near = &seen.clearances;
    let all = [&near.robot_obstacle, &near.object_obstacle, &near.human_obstacle];
    all.into_iter().filter_map(distance).reduce(f64::min)
}

/// The options as they were evaluated last. `at_start` are those before the first step.
pub fn current_options<'a>(episode: &'a Episode, at_start: &'a [OptionTick]) -> &'a [OptionTick] {
    let last = if episode.summary().steps > 0 { &episode.tick().options[..] } else { at_start };
    episode.robot_view().map_or(last, |view| view.evaluated)
}

/// The places of the fields in the state of an episode.
pub struct StateLayout {
    options: usize,
    joints: usize,
    links: usize,
}

impl StateLayout {
    /// Those of the episodes of a scenario.
    pub fn of(prepared: &PreparedScenario) -> Self {
        let robot = prepared.robot();
        Self {
            options: prepared.options().options().len(),
            joints: robot.map_or(0, |robot| robot.joints.len()),
            links: robot.map_or(0, |robot| robot.links.len()),
        }
    }

    fn count(&self, field: &Field) -> usize {
        match field.count {
            Count::Numbers(count) => count,
            Count::Options => self.options,
            Count::Joints => self.joints,
            Count::Links => 7 * self.links,
        }
    }

    /// Length and fields, as JSON.
    pub fn describe(&self) -> Value {
        let mut offset = 0;
        let fields = FIELDS.iter().map(|field| {
            let (begin, count) = (offset, self.count(field));
            offset += count;
            let Field { name, unit, about, .. } = field;
            json!({ "name": name, "offset": begin, "count": count, "unit": unit, "about": about })
        });
        let fields: Vec<_> = fields.collect();
        json!({ "length": offset, "fields": fields })
    }
}

/// The state of an episode. Its address stays.
pub struct ShownState {
    layout: StateLayout,
    numbers: Box<[f64]>,
}

impl ShownState {
    /// All NaN.
    pub fn new(layout: StateLayout) -> Self {
        let length = FIELDS.iter().map(|field| layout.count(field)).sum();
        Self { layout, numbers: vec![f64::NAN; length].into() }
    }

    /// The numbers.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// The places of its fields.
    pub fn layout(&self) -> &StateLayout {
        &self.layout
    }

    /// Writes the present numbers. `at_start` are the options before the first step.
    pub fn write(
        &mut self,
        prepared: &PreparedScenario,
        episode: &Episode<'_>,
        outcome: Option<Outcome>,
        steering: &Steering,
        at_start: &[OptionTick],
    ) {
        let options = current_options(episode, at_start);
        let (bodies, links) = (Bodies::of(episode, prepared), bodies::link_poses(episode, prepared));
        let links = links.unwrap_or_default();
        let seen = Seen { prepared, episode, outcome, steering, options, bodies, links };
        self.numbers.fill(f64::NAN);
        let mut rest = &mut self.numbers[..];
        for field in FIELDS {
            let (own, others) = rest.split_at_mut(self.layout.count(field));
            rest = others;
            (field.write)(&seen, own);
        }
    }
}

/// The file `state.js`: the table for JavaScript.
pub fn javascript() -> String {
    let per = |count| match count {
        Count::Numbers(count) => count.to_string(),
        Count::Options => "\"options\"".to_owned(),
        Count::Joints => "\"joints\"".to_owned(),
        Count::Links => "\"links * 7\"".to_owned(),
    };
    let mut text = "// The fields of an episode's state, in their order. Written from the table in src/state.rs: see README.md.\n\
        export const FIELDS = [\n"
        .to_owned();
    for Field { name, count, unit, about, .. } in FIELDS {
        let (name, unit, about) = (json!(name), json!(unit), json!(about));
        text += &format!("  {{ name: {name}, count: {}, unit: {unit}, about: {about} }},\n", per(*count));
    }
    text + "];\n\n// The outcomes, in the order of their numbers.\nexport const OUTCOMES = "
        + &json!(OUTCOMES.map(Outcome::name)).to_string()
        + ";\n"
}

//! Every quantity by its key, against a value worked out by hand. Plant, controller, human and policy are
//! told what to do, so that no two quantities have the same value: to swap two of them fails here.

mod episodes;
mod others;
mod steps;

use cocarry::control::{Failure as MpcFailure, HORIZON, PoseOptimiser, Reference, SolveOutcome};
use cocarry::controller::{Controller, DecisionBasis, Way};
use cocarry::episode::{Episode, EpisodeSettings, Outcome};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::human::{Human, HumanDecision, HumanView, PreferenceChange, Stance};
use cocarry::learning;
use cocarry::math;
use cocarry::plant::{Command, HumanMotion, Plant, Preparation, Seen};
use cocarry::policy::{Decision, RobotPolicy, RobotView};
use cocarry::preference::{ChoiceDistribution, Perception};
use cocarry::quantities::{
    self, CONTROL, EPISODE, Fields, Heading, LEARNED, PREPARATION, Quantity, QuantityKind, TICK, View,
};
use cocarry::robot::{Configuration, InputJacobian, InputVector, JointVector, Robot};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{self, PreparedScenario, RobotSetup, Scenario};
use cocarry::simulation::{
    BodyKind, Clearance, Clearances, Contact, Failure, Forces, Observation, Part, PhysicsSettings, Sharing,
    Wrench,
};
use cocarry::world::World;
use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value, json};
use std::iter::repeat;

/// A wall across the way from (1, 0) to (1, 8), with two openings of 1 m: straight ahead, and 7 m to the
/// right.
pub const WORLD: &str = r#"
name = "Two openings"
robot_width_m = 0.5
start_m = [1.0, 0.0]
target_m = [1.0, 8.0]

[[obstacle]]
name = "left"
shape = "box"
center_m = [-4.5, 4.0]
size_m = [10.0, 0.2]
height_m = 1.0

[[obstacle]]
name = "middle"
shape = "box"
center_m = [4.5, 4.0]
size_m = [6.0, 0.2]
height_m = 1.0

[[obstacle]]
name = "right"
shape = "box"
center_m = [13.5, 4.0]
size_m = [10.0, 0.2]
height_m = 1.0

[[opening]]
name = "ahead"
between = ["left", "middle"]

[[opening]]
name = "aside"
between = ["middle", "right"]

[[option]]
name = "near"
openings = ["ahead"]

[[option]]
name = "far"
openings = ["aside"]
"#;

const STEPS: usize = 8;
/// The human leads from this step on.
const HANDOVER: u64 = 6;
/// The option that the human prefers in each step.
const PREFERRED: [usize; STEPS] = [1, 1, 0, 1, 1, 0, 0, 0];
const HUMAN: Perception = Perception { alpha: 0.8, gamma: 0.9 };
const STATE_WEIGHT: f64 = 500.0;
const INPUT_WEIGHT: f64 = 2.0;

/// What was seen at the end of step k - 1; k = 0: at the start.
fn observation(robot: &Robot, k: usize) -> Observation {
    let n = k as f64;
    let planar = |x: f64, y: f64, deg: f64| PlanarPose { position: Point::new(x, y), yaw: deg.to_radians() };
    let forces = |force: [f64; 3], torque: [f64; 3], peak: f64, rms: f64, rest: [f64; 3]| Forces {
        mean: Wrench { force: Vector3::from(force), torque: Vector3::from(torque) },
        last: Wrench::default(),
        peak,
        rms,
        noise: rest[0],
        work: rest[1],
        deflection: rest[2],
    };
    let part = |kind, name: &str| Part { kind, name: name.to_owned() };
    let distance =
        |distance: f64, one, other| Some(Clearance { distance, between: [part(one, "a"), part(other, "b")] });
    let contact = |one: (BodyKind, &str), other: (BodyKind, &str)| Contact {
        between: [part(one.0, one.1), part(other.0, other.1)],
        point: Point3::new(1.25, 3.75, 0.65),
        depth: 0.004,
        force: 17.0,
    };
    let touching = contact((BodyKind::Robot, "wrist"), (BodyKind::Human, "hand"));
    let against_wall = contact((BodyKind::Object, "beam"), (BodyKind::Obstacle, "middle"));
    let mut joints = robot.postures[0].joints;
    if k >= 4 {
        // the shoulder down and the elbow back: the hand is in the base's column
        let angles = [0.0, 80.0, 0.0, 125.0, 0.0, 30.0, 0.0_f64];
        joints.iter_mut().zip(angles).for_each(|(at, angle)| *at = angle.to_radians());
    }
    let base = if k == 5 { planar(2.0, 4.0, 88.0) } else { planar(1.2, -1.3, 88.0) };
    let height = robot.grasp_height;
    Observation {
        time: 0.2 * n,
        configuration: Configuration { base, joints },
        base_rates: Vector3::zeros(),
        joint_rates: JointVector::zeros(),
        joint_efforts: JointVector::zeros(),
        effort_share: 0.3 + 0.01 * n,
        // the second joint's motor is at its limit for the longest
        time_at_limit: JointVector::from_iterator(
            [0.001, 0.01].map(|time| time * n).into_iter().chain(repeat(0.0)),
        ),
        rolled: Vector3::zeros(),
        // 3 mm to the side of the goal and 4 mm ahead of it, turned by 2 degrees
        grasp: if k == 0 {
            planar(1.0, -0.6, 90.0).at_height(height)
        } else {
            planar(1.003, -0.6 + 0.036 + 0.004, 92.0).at_height(height)
        },
        object: planar(1.0, 0.01 * n, 91.0).at_height(height),
        object_twist: [0.0; 6],
        hand: planar(1.15, 0.62, 92.5).at_height(height),
        // it stands still in the last two steps
        hand_planar: planar(1.1, 0.59 + 0.03 * n.min(6.0), 92.0),
        torso: planar(1.2, 0.97 + 0.01 * n, 93.0).at_height(1.1),
        grip: forces(
            [1.0 + n, 2.0 + n, 3.0 + n],
            [0.1 + n, 0.2 + n, 0.3 + n],
            40.0 + n,
            20.0 + n,
            [0.5 + 0.01 * n, 1.5, 0.011 + 0.001 * n],
        ),
        hand_grip: forces(
            [-1.5 - n, -2.5 - n, -3.5 - n],
            [-0.4 - n, -0.5 - n, -0.6 - n],
            30.0 + 2.0 * n,
            10.0 + n,
            [0.25 + 0.01 * n, -0.5, 0.012 + 0.001 * n],
        ),
        sharing: Sharing {
            steps: 1.0,
            squared_parts: [33.0 + n, 22.0 + n].map(|force| force * force),
            level_force: [11.0 + n, 6.0 + n],
            driving_work: [2.5, 0.75],
        },
        squared_jerk: 7.0 + n,
        contacts: match k {
            3 => vec![touching.clone(), touching],
            STEPS => vec![touching.clone(), touching, against_wall],
            _ => Vec::new(),
        },
        clearances: Clearances {
            robot_obstacle: distance(0.9, BodyKind::Robot, BodyKind::Obstacle),
            object_obstacle: distance(0.8 - 0.01 * n, BodyKind::Object, BodyKind::Obstacle),
            human_obstacle: distance(0.85, BodyKind::Human, BodyKind::Obstacle),
            robot_human: distance(1.75 + 0.01 * n, BodyKind::Robot, BodyKind::Human),
        },
        failure: None,
    }
}

/// Shows one observation after the other.
#[derive(Clone, Debug)]
struct ToldPlant<'a> {
    robot: &'a Robot,
    k: usize,
    seen: Observation,
    /// What breaks in the first step.
    failure: Option<Failure>,
}

impl<'a> ToldPlant<'a> {
    fn new(robot: &'a Robot) -> Self {
        Self { robot, k: 0, seen: observation(robot, 0), failure: None }
    }
}

impl Plant for ToldPlant<'_> {
    fn observe(&self) -> Seen<'_> {
        let position = self.seen.object.translation.vector.xy().into();
        let (configuration, grasp) = (Some(&self.seen.configuration), Some(self.seen.grasp));
        Seen { position, configuration, grasp, human: None, bodies: Some(&self.seen) }
    }

    fn step(&mut self, _: &Command, _: &HumanMotion, _: f64) {
        self.k += 1;
        self.seen = Observation { failure: self.failure.clone(), ..observation(self.robot, self.k) };
    }

    fn save(&self) -> Saved {
        Saved::default()
    }

    fn restore(&mut self, _: &Saved) -> Result<(), RestoreError> {
        Ok(())
    }
}

/// Commands the same inputs in every step, with other outcomes of eqs. (7) and (8).
#[derive(Clone, Debug)]
struct ToldController {
    k: usize,
    references: [Reference; 2],
    target: Configuration,
    poses: PoseOptimiser,
}

impl ToldController {
    fn new() -> Self {
        let reference = |begin: f64| Reference::from_fn(|row, t| begin + row as f64 + 10.0 * t as f64);
        let base = PlanarPose { position: Point::new(5.5, 6.5), yaw: 0.75 };
        let target = Configuration { base, joints: JointVector::from_fn(|i, _| 0.5 + i as f64) };
        Self { k: 0, references: [reference(0.0), reference(100.0)], target, poses: PoseOptimiser::default() }
    }

    /// u: 1 cm/s, 2 cm/s, ...
    fn input() -> InputVector {
        InputVector::from_fn(|i, _| 0.01 * (i + 1) as f64)
    }
}

impl Controller for ToldController {
    fn command(&mut self, seen: &Seen<'_>, _: &Way<'_>, _: &ChoiceDistribution) -> Command {
        let k = self.k;
        self.k += 1;
        let outcome = match k {
            0..4 => SolveOutcome::Constrained { active: [3, 2, 1, 4][k] },
            4 => SolveOutcome::Fallback(MpcFailure::NotSolved),
            5 => SolveOutcome::Fallback(MpcFailure::NotFinite),
            _ => SolveOutcome::Unconstrained,
        };
        let preparation =
            |candidate| Preparation { tracked: Some(1), candidate, candidates: 15, constrained: 7 };
        let mut input_matrix = InputJacobian::zeros();
        [3.0, 2.0, 5.0, 0.125, 4.0, 6.0].iter().enumerate().for_each(|(i, s)| input_matrix[(i, i)] = *s);
        Command {
            outcome,
            input_matrix,
            preparation: [None, Some(preparation(4)), Some(preparation(5)), Some(preparation(6))]
                .into_iter()
                .nth(k)
                .unwrap_or((k == 6).then(|| preparation(0))),
            pose_cost: 0.75,
            ..Command::inputs(seen.configuration.expect("a robot"), Self::input())
        }
    }

    fn decision_basis(&self) -> Option<DecisionBasis<'_>> {
        let Self { references, target, poses, .. } = self;
        Some(DecisionBasis { references, weights: &[0.375, 0.625], target, poses })
    }
}

/// A human who prefers what is listed, and has other preferences from two steps on.
#[derive(Clone, Debug)]
struct ToldHuman([PreferenceChange; 2]);

impl Human for ToldHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let k = view.step as usize;
        HumanDecision {
            option: PREFERRED[k.min(STEPS - 1)],
            stance: Stance::Follow,
            stubbornness: 0.2 + 0.1 * k as f64,
            discomfort: 1.5 + k as f64,
            perception: Some(HUMAN),
            hand: None,
        }
    }

    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        self.0.iter().find(|change| change.step == step)
    }
}

#[derive(Clone, Debug)]
struct ToldPolicy;

impl RobotPolicy for ToldPolicy {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        if view.step < HANDOVER { Decision::lead(0) } else { Decision::follow() }
    }
}

fn setup(robot: &Robot) -> RobotSetup {
    let mut setup = RobotSetup::new(robot);
    (setup.control.state_weight, setup.control.input_weight) = (STATE_WEIGHT, INPUT_WEIGHT);
    setup
}

fn prepared(plant: scenario::Plant, settings: EpisodeSettings) -> PreparedScenario {
    let world = World::parse("two.toml", WORLD).unwrap_or_else(|e| panic!("{e}"));
    let scenario = Scenario { human: HUMAN, settings, ..Scenario::new(world.into(), plant) };
    scenario.prepare().unwrap_or_else(|e| panic!("{e}"))
}

fn told<'a>(prepared: &'a PreparedScenario, plant: ToldPlant<'a>) -> Episode<'a> {
    let change = |step| PreferenceChange { step, perception: HUMAN };
    let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
    let builder = builder.with_human(ToldHuman([change(2), change(5)])).with_policy(ToldPolicy);
    let builder = builder.with_controller(ToldController::new()).with_plant(|_| plant);
    builder.begin().unwrap_or_else(|e| panic!("{e}"))
}

/// The quantities of these tables, by their keys. Each is of the kind that its table says, or missing.
fn read(view: &View<'_>, tables: &[&[Quantity]]) -> Map<String, Value> {
    let values = tables.iter().copied().flatten().map(|quantity| {
        let value = (quantity.get)(view);
        assert!(is_of(&value, quantity.kind), "{}: {value:?}, not of {:?}", quantity.key, quantity.kind);
        (quantity.key.to_owned(), json!(value))
    });
    values.collect()
}

fn is_of(value: &quantities::Value, kind: QuantityKind) -> bool {
    use quantities::Value;
    let is_record = |fields: &Fields, headings: Vec<Heading>| {
        fields.iter().all(|(key, value)| {
            headings.iter().any(|heading| heading.name == *key && is_of(value, heading.kind))
        })
    };
    match (value, kind) {
        (Value::Missing, _)
        | (Value::Number(_), QuantityKind::Number(_))
        | (Value::Count(_), QuantityKind::Count)
        | (Value::Text(_), QuantityKind::Text)
        | (Value::Flag(_), QuantityKind::Flag)
        | (Value::Numbers(_), QuantityKind::Numbers) => true,
        (Value::Record(fields), QuantityKind::Record(headings)) => is_record(fields, headings()),
        (Value::List(records), QuantityKind::List(headings)) => {
            records.iter().all(|fields| is_record(fields, headings()))
        }
        _ => false,
    }
}

#[track_caller]
fn near(found: &Value, wanted: f64) {
    let number = found.as_f64().unwrap_or(f64::NAN);
    assert!((number - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{found}, not {wanted}");
}

#[track_caller]
fn numbers<'k>(record: &Map<String, Value>, wanted: impl IntoIterator<Item = (&'k str, f64)>) {
    within(1e-9, record, wanted);
}

/// Numbers that depend on where the team is on its path, which is found to a hundredth of a millimetre in a
/// step.
#[track_caller]
fn placed<'k>(record: &Map<String, Value>, wanted: impl IntoIterator<Item = (&'k str, f64)>) {
    within(1e-4, record, wanted);
}

#[track_caller]
fn within<'k>(share: f64, record: &Map<String, Value>, wanted: impl IntoIterator<Item = (&'k str, f64)>) {
    for (key, wanted) in wanted {
        let found = record[key].as_f64().unwrap_or(f64::NAN);
        assert!(
            (found - wanted).abs() < share * wanted.abs().max(1.0),
            "{key}: {}, not {wanted}",
            record[key]
        );
    }
}

#[track_caller]
fn words<'k>(record: &Map<String, Value>, wanted: impl IntoIterator<Item = (&'k str, &'k str)>) {
    for (key, wanted) in wanted {
        assert_eq!(record[key].as_str(), Some(wanted), "{key}");
    }
}

/// J^ of eq. (2) for the human at a distance D from B, through an opening of risk 1/2.
fn subjective(length: f64) -> f64 {
    let risk = math::exp(-math::pow(math::ln(2.0), HUMAN.gamma));
    math::pow(length, HUMAN.alpha) + 10.0 * risk
}

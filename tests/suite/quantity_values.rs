//! Every quantity by its key, against a value worked out by hand. Plant, controller, human and policy are told
//! what to do, so that no two quantities have the same value: to swap two of them fails here.

use crate::support::repository;
use cocarry::control::{Failure as MpcFailure, HORIZON, PoseOptimiser, Reference, SolveOutcome};
use cocarry::controller::{Controller, DecisionBasis, Way};
use cocarry::episode::{Episode, Outcome, Settings};
use cocarry::geometry::{PlanarPose, Point, Pose};
use cocarry::human::{Human, HumanDecision, HumanView, PreferenceChange, Stance};
use cocarry::learning;
use cocarry::math;
use cocarry::plant::{Command, HumanMotion, Plant, Preparation, Seen};
use cocarry::policy::{Decision, RobotPolicy, RobotView};
use cocarry::preference::{ChoiceDistribution, Perception};
use cocarry::quantities::{CONTROL, EPISODE, LEARNED, PREPARATION, TICK, View};
use cocarry::robot::{Configuration, InputJacobian, InputVector, JointVector, Robot};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{self, PreparedScenario, RobotSetup, Scenario};
use cocarry::simulation::{
    BodyKind, Clearance, Clearances, Contact, Failure, Forces, Observation, Part, PhysicsSettings, Wrench,
};
use cocarry::world::World;
use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value};

/// A wall across the way from (1, 0) to (1, 8), with two openings of 1 m: straight ahead, and 7 m to the right.
const WORLD: &str = r#"
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
    let distance = |distance: f64, one, other| {
        Some(Clearance { distance, between: [part(one, "a"), part(other, "b")] })
    };
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
        hand_planar: planar(1.1, 0.61 + 0.01 * n, 92.0),
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
        let preparation = |candidate| Preparation { tracked: Some(1), candidate, candidates: 15, constrained: 7 };
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

fn prepared(plant: scenario::Plant, settings: Settings) -> PreparedScenario {
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

/// The quantities of these tables, by their keys.
fn read(view: &View<'_>, tables: &[&[cocarry::quantities::Quantity]]) -> Map<String, Value> {
    let records = tables.iter().flat_map(|table| view.read(table));
    records.map(|(key, value)| (key.to_owned(), value)).collect()
}

#[track_caller]
fn near(found: &Value, wanted: f64) {
    let number = found.as_f64().unwrap_or(f64::NAN);
    assert!((number - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{found}, not {wanted}");
}

#[track_caller]
fn numbers<'k>(record: &Map<String, Value>, wanted: impl IntoIterator<Item = (&'k str, f64)>) {
    for (key, wanted) in wanted {
        let found = record[key].as_f64().unwrap_or(f64::NAN);
        assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{key}: {}, not {wanted}", record[key]);
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

#[test]
fn closed_form_every_quantity_of_a_step_with_bodies() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, Settings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    assert_eq!(episode.step(), None);
    let tick = read(&View::new(&prepared, &episode), &TICK);
    numbers(
        &tick,
        [
            ("step", 0.0),
            ("time_s", 0.0),
            ("x_m", 1.0),
            ("y_m", 0.0),
            ("heading_deg", 90.0),
            ("stubbornness", 0.2),
            ("stubbornness_threshold", 1.0),
            ("discomfort", 1.5),
            ("executed_index", 0.0),
            ("preferred_index", 1.0),
            // J = D + c_r S = 8 m + 10 m / 2
            ("objective_cost_m", 13.0),
            ("accumulated_objective_cost_m", 13.0),
            ("walked_m", 0.01),
            ("robot_work_j", 1.5),
            ("human_work_j", -0.5),
        ],
    );
    words(&tick, [("mode", "robot-led"), ("executed", "near"), ("preferred", "far")]);
    let turn = 2.0_f64.to_radians();
    let tracking = STATE_WEIGHT * (0.005 * 0.005 + turn * turn);
    let effort = INPUT_WEIGHT * 0.01 * 0.01 * (1..=11).map(|i| f64::from(i * i)).sum::<f64>();
    numbers(
        &tick,
        [
            // half the object's length behind its centre
            ("grasp_goal_x_m", 1.0),
            ("grasp_goal_y_m", -0.6),
            ("grasp_goal_yaw_deg", 90.0),
            ("base_x_m", 1.2),
            ("base_y_m", -1.3),
            ("base_yaw_deg", 88.0),
            // from a disc of half the base's width to the corner (1.5, 3.9) of the wall
            ("base_clearance_m", math::hypot(0.3, 5.2) - 0.25),
            ("mpc_active_limits", 3.0),
            ("least_singular_value", 0.125),
            ("position_error_m", 0.005),
            ("orientation_error_deg", 2.0),
            ("tracking_cost", tracking),
            ("effort_cost", effort),
            ("pose_cost", 0.75),
            ("accumulated_tracking_cost", tracking),
            ("accumulated_effort_cost", effort),
            ("accumulated_pose_cost", 0.75),
            ("accumulated_control_cost", tracking + effort + 0.75),
            ("left_rim_m_per_s", 0.01),
            ("right_rim_m_per_s", 0.02),
        ],
    );
    words(&tick, [("mpc_outcome", "constrained")]);
    for missing in ["reverses_for", "tracked", "pose_candidate", "pose_candidates", "self_contact"] {
        assert!(tick[missing].is_null(), "{missing}: {}", tick[missing]);
    }
    for missing in ["base_ahead_m_per_s", "base_left_m_per_s", "base_turn_rad_per_s"] {
        assert!(tick[missing].is_null(), "{missing} of wheels with rims");
    }
    numbers(
        &tick,
        [
            ("object_x_m", 1.0),
            ("object_y_m", 0.01),
            ("object_yaw_deg", 91.0),
            ("hand_x_m", 1.1),
            ("hand_y_m", 0.62),
            ("hand_yaw_deg", 92.0),
            ("torso_x_m", 1.2),
            ("torso_y_m", 0.98),
            ("torso_yaw_deg", 93.0),
            ("grip_force_n", 21.0),
            ("hand_force_n", 11.0),
            ("grip_peak_force_n", 41.0),
            ("hand_peak_force_n", 32.0),
            ("peak_force_n", 41.0),
            ("grip_mean_force_x_n", 2.0),
            ("grip_mean_force_y_n", 3.0),
            ("grip_mean_force_z_n", 4.0),
            ("grip_mean_torque_x_nm", 1.1),
            ("grip_mean_torque_y_nm", 1.2),
            ("grip_mean_torque_z_nm", 1.3),
            ("hand_mean_force_x_n", -2.5),
            ("hand_mean_force_y_n", -3.5),
            ("hand_mean_force_z_n", -4.5),
            ("hand_mean_torque_x_nm", -1.4),
            ("hand_mean_torque_y_nm", -1.5),
            ("hand_mean_torque_z_nm", -1.6),
            ("grip_deflection_m", 0.012),
            ("hand_deflection_m", 0.013),
            ("grip_force_above_10_hz_n", 0.51),
            ("hand_force_above_10_hz_n", 0.26),
            ("effort_share", 0.31),
            ("grip_work_j", 1.5),
            ("hand_work_j", -0.5),
            ("squared_jerk_m2_per_s5", 8.0),
            ("obstacle_distance_m", 0.79),
            ("human_distance_m", 1.76),
            // the leader has accelerated for a period, 0.9 m/s^2 * (0.2 s)^2, and the object has moved 1 cm
            ("path_lead_m", 0.026),
            ("contacts", 0.0),
        ],
    );
    let joints = tick["joints"].as_array().expect("joints");
    assert_eq!(joints.len(), 7);
    for (i, joint) in joints.iter().enumerate() {
        assert_eq!(joint["name"].as_str(), Some(robot.joints[i].name.as_str()));
        near(&joint["position_rad"], robot.postures[0].joints[i]);
        near(&joint["rate_rad_per_s"], 0.01 * (i + 3) as f64);
    }
}

#[test]
fn closed_form_every_quantity_of_an_option() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, Settings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    for _ in 0..2 {
        assert_eq!(episode.step(), None);
    }
    let tick = read(&View::new(&prepared, &episode), &TICK);
    let [near_option, far] = tick["options"].as_array().expect("options").as_slice() else { panic!("two") };
    // J~ over alpha from 0.55 to 0.95 and gamma from 0.5 to 1.1
    let length = 7.99;
    let distance =
        (math::pow(length, 0.95) - math::pow(length, 0.55)) / (0.4 * math::ln(length));
    let risk = |gamma: f64| math::exp(-math::pow(math::ln(2.0), gamma));
    let simpson = |i: u32| if i == 0 || i == 1000 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let risk = (0..=1000).map(|i| simpson(i) * risk(0.5 + 0.6 * f64::from(i) / 1000.0)).sum::<f64>() / 3000.0;
    let record = near_option.as_object().expect("a record");
    words(record, [("name", "near")]);
    numbers(
        record,
        [
            ("length_m", length),
            ("risk", 0.5),
            ("objective_cost_m", length + 5.0),
            ("expected_subjective_cost", distance + 10.0 * risk),
            // it is shorter at the same risk
            ("probability", 1.0),
        ],
    );
    assert_eq!((&record["misaligned"], &far["misaligned"]), (&Value::Bool(false), &Value::Bool(true)));
    assert_eq!((far["name"].as_str(), far["probability"].as_f64()), (Some("far"), Some(0.0)));
}

#[test]
fn closed_form_the_preparation_of_a_step() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, Settings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    for _ in 0..2 {
        assert_eq!(episode.step(), None);
    }
    let view = View::new(&prepared, &episode);
    let tick = read(&view, &[CONTROL]);
    words(&tick, [("tracked", "far")]);
    numbers(
        &tick,
        [
            ("pose_candidate", 4.0),
            ("pose_candidates", 15.0),
            ("pose_constrained_problems", 7.0),
            ("mpc_active_limits", 2.0),
        ],
    );
    let record = read(&view, &[PREPARATION]);
    for (i, (name, weight)) in [("near", 0.375), ("far", 0.625)].into_iter().enumerate() {
        let reference = record["references"][i].as_object().expect("a reference");
        words(reference, [("name", name)]);
        numbers(reference, [("weight", weight)]);
        let s = reference["s"].as_array().expect("s");
        assert_eq!(s.len(), 6 * HORIZON);
        near(&s[0], 100.0 * i as f64);
        near(&s[6 * 2 + 3], 100.0 * i as f64 + 23.0);
    }
    let target = record["target"].as_object().expect("a configuration");
    numbers(target, [("x_m", 5.5), ("y_m", 6.5), ("yaw_rad", 0.75)]);
    target["joints"].as_array().expect("joints").iter().enumerate().for_each(|(i, q)| near(q, 0.5 + i as f64));
    // at the end of the fourth step the arm touches the base
    for _ in 2..4 {
        assert_eq!(episode.step(), None);
    }
    let tick = read(&View::new(&prepared, &episode), &TICK);
    assert!(tick["self_contact"].as_str().is_some_and(|links| links.starts_with("base_link, ")), "{tick:?}");
    assert_eq!(tick["mpc_active_limits"], 4);
    episode.step();
    words(&read(&View::new(&prepared, &episode), &[CONTROL]), [("mpc_outcome", "fallback: not solved")]);
    episode.step();
    let tick = read(&View::new(&prepared, &episode), &TICK);
    words(&tick, [("mpc_outcome", "fallback: not finite")]);
    // the base's centre is 10 cm inside the wall
    near(&tick["base_clearance_m"], -0.1 - 0.25);
}

#[test]
fn closed_form_every_quantity_of_an_episode_with_bodies() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, Settings::default());
    let mut episode = told(&prepared, ToldPlant::new(&robot));
    let mut errors = Vec::new();
    let mut tracking = 0.0;
    while episode.step().is_none() {
        let robot = episode.tick().robot.expect("a robot");
        errors.push(robot.position_error);
        tracking += robot.tracking_cost;
    }
    let n = STEPS as f64;
    assert_eq!(errors.len(), STEPS);
    let record = read(&View::new(&prepared, &episode), &[EPISODE]);
    words(
        &record,
        [
            ("outcome", "collided"),
            ("preferred_at_start", "far"),
            ("first_option", "near"),
            ("last_option", "near"),
            ("collision_of", "object"),
            ("collision_part", "beam"),
            ("collision_with", "obstacle"),
            ("collision_with_part", "middle"),
        ],
    );
    let steps = || (0..STEPS).map(|k| k as f64);
    let mean_of_squares = |value: &dyn Fn(f64) -> f64| steps().map(|k| value(k + 1.0) * value(k + 1.0)).sum::<f64>() / n;
    let effort = n * INPUT_WEIGHT * 0.01 * 0.01 * (1..=11).map(|i| f64::from(i * i)).sum::<f64>();
    numbers(
        &record,
        [
            ("steps", n),
            ("time_s", 1.6),
            ("walked_m", 0.08),
            ("accumulated_objective_cost_m", steps().map(|k| 13.0 - 0.01 * k).sum()),
            ("final_stubbornness", 0.9),
            ("final_discomfort", 8.5),
            ("share_off_preference", 0.5),
            ("accumulated_subjective_cost", steps().map(|k| subjective(8.0 - 0.01 * k)).sum()),
            ("preference_change_count", 2.0),
            ("preferred_option_switches", 3.0),
            ("option_change_count", 0.0),
            ("transition_step", 6.0),
            ("transition_time_s", 1.2),
            ("transition_x_m", 1.0),
            ("transition_y_m", 0.06),
            ("accumulated_tracking_cost", tracking),
            ("accumulated_effort_cost", effort),
            ("accumulated_pose_cost", 6.0),
            ("accumulated_control_cost", tracking + effort + 6.0),
            ("position_error_rms_m", (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt()),
            ("largest_position_error_m", errors.iter().copied().fold(0.0, f64::max)),
            ("constrained_steps", 4.0),
            ("fallback_steps", 2.0),
            ("pose_change_count", 3.0),
            ("overlapping_steps", 1.0),
            ("least_base_clearance_m", -0.35),
            ("self_contact_steps", 5.0),
            ("hand_force_mean_n", 14.5),
            ("hand_force_rms_n", mean_of_squares(&|k| 10.0 + k).sqrt()),
            ("peak_force_n", 48.0),
            ("robot_work_j", 12.0),
            ("human_work_j", -4.0),
            ("squared_jerk_m2_per_s5", steps().map(|k| 8.0 + k).sum()),
            ("force_above_10_hz_rms_n", mean_of_squares(&|k| 0.5 + 0.01 * k).sqrt()),
            ("largest_grip_deflection_m", 0.02),
            ("largest_effort_share", 0.38),
            ("collision_x_m", 1.25),
            ("collision_y_m", 3.75),
            ("collision_z_m", 0.65),
            ("collision_depth_m", 0.004),
            ("collision_force_n", 17.0),
        ],
    );
    for missing in ["lost_by", "lost_at_step", "lost_distance_m", "failure"] {
        assert!(record[missing].is_null(), "{missing}: {}", record[missing]);
    }
    let contacts = read(&View::new(&prepared, &episode), &TICK)["contacts"].clone();
    assert_eq!(contacts, 3);
}

#[test]
fn closed_form_what_broke_is_named() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let prepared = prepared(plant, Settings::default());
    let not_finite = Failure::NonFinite { body: "torso".to_owned() };
    for (failure, outcome, said) in [
        (not_finite, Outcome::NonFinite, "torso stopped being a number"),
        (Failure::Dropped, Outcome::Dropped, "the object fell"),
    ] {
        let mut episode = told(&prepared, ToldPlant { failure: Some(failure), ..ToldPlant::new(&robot) });
        assert_eq!(episode.step(), None);
        assert_eq!(episode.step(), Some(outcome));
        let record = read(&View::new(&prepared, &episode), &[EPISODE]);
        words(&record, [("outcome", outcome.name()), ("failure", said)]);
    }
}

/// A human who leads changes the option at step 3: the executed option follows.
#[test]
fn closed_form_changes_of_the_executed_option_are_counted() {
    let mut scenario = prepared(scenario::Plant::Point, Settings::default()).scenario().clone();
    scenario.settings.method = "human-led".parse().unwrap_or_else(|e| panic!("{e}"));
    scenario.human_model = "scripted(0:near,3:far,5:near,6:far)".parse().unwrap_or_else(|e| panic!("{e}"));
    let prepared = scenario.prepare().unwrap_or_else(|e| panic!("{e}"));
    let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
    while episode.step().is_none() {}
    let record = read(&View::new(&prepared, &episode), &[EPISODE]);
    words(&record, [("outcome", "arrived"), ("first_option", "near"), ("last_option", "far")]);
    numbers(&record, [("option_change_count", 3.0), ("preferred_option_switches", 3.0)]);
    assert!(record["transition_step"].is_null() && record["accumulated_control_cost"].is_null());
}

/// The inputs of an omnidirectional base and of a lift.
#[test]
fn closed_form_inputs_have_the_names_of_their_drive_and_joints() {
    for (name, base) in [("omni-carrier", 3), ("porter", 2)] {
        let robot = Robot::load(&repository(&format!("assets/robots/{name}.toml")));
        let robot = robot.unwrap_or_else(|e| panic!("{e}"));
        let prepared = prepared(scenario::Plant::Kinematic { setup: setup(&robot) }, Settings::default());
        let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
        let mut episode =
            builder.with_controller(ToldController::new()).begin().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(episode.step(), None);
        let tick = read(&View::new(&prepared, &episode), &TICK);
        if base == 3 {
            numbers(
                &tick,
                [
                    ("base_ahead_m_per_s", 0.01),
                    ("base_left_m_per_s", 0.02),
                    ("base_turn_rad_per_s", 0.03),
                ],
            );
            assert!(tick["left_rim_m_per_s"].is_null() && tick["right_rim_m_per_s"].is_null());
        }
        let joints = tick["joints"].as_array().expect("joints");
        let mut lifts = 0;
        for (i, joint) in joints.iter().enumerate() {
            let (position, rate) = match joint.get("position_m") {
                Some(position) => (position, &joint["rate_m_per_s"]),
                None => (&joint["position_rad"], &joint["rate_rad_per_s"]),
            };
            lifts += usize::from(joint.get("position_m").is_some());
            near(position, robot.postures[0].joints[i]);
            near(rate, 0.01 * (base + i + 1) as f64);
        }
        assert_eq!(lifts, usize::from(name == "porter"), "{joints:?}");
    }
}

/// Before anything was seen of a human, what was learned is the prior: uniform in alpha and gamma, log-normal
/// in eta.
#[test]
fn closed_form_what_was_learned_of_nothing_is_the_prior() {
    let settings = Settings { learning: Some(learning::Settings::default()), ..Settings::default() };
    let prepared = prepared(scenario::Plant::Point, settings);
    let episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
    let learned = read(&View::new(&prepared, &episode), &[LEARNED]);
    let human = learned["human"].as_object().expect("what was learned");
    let pair = |key: &str, wanted: [f64; 2]| {
        let found = human[key].as_array().expect("two numbers");
        let found = found.iter().map(|value| value.as_f64().expect("a number"));
        for (found, wanted) in found.zip(wanted) {
            assert!((found - wanted).abs() < 1e-6 * wanted, "{key}: {found}, not {wanted}");
        }
    };
    let spread = 0.25;
    let mean = 10.5 * math::exp(spread / 2.0);
    numbers(
        human,
        [
            ("alpha_mean", 0.75),
            ("gamma_mean", 0.8),
            ("alpha_variance", 0.4 * 0.4 / 12.0),
            ("alpha_gamma_covariance", 0.0),
            ("gamma_variance", 0.6 * 0.6 / 12.0),
            ("information_nats", 0.0),
            ("region_density", 1.0),
        ],
    );
    for (key, wanted) in [("eta_mean", mean), ("eta_variance", mean * mean * (math::exp(spread) - 1.0))] {
        let found = human[key].as_f64().expect("a number");
        assert!((found - wanted).abs() < 1e-6 * wanted, "{key}: {found}, not {wanted}");
    }
    assert!(human["region_share"].as_f64().is_some_and(|share| (0.95..=1.0).contains(&share)), "{human:?}");
    pair("alpha_interval", [0.56, 0.94]);
    pair("gamma_interval", [0.515, 1.085]);
    pair("alpha_range", [0.55, 0.95]);
    pair("gamma_range", [0.5, 1.1]);
    // the normal distribution's 97.5 % point
    pair("eta_interval", [-1.0, 1.0].map(|sign| 10.5 * math::exp(sign * 1.959963984540054 * 0.5)));
    let density = human["density"].as_array().expect("a grid");
    assert!(density.len() == 32 * 32 && density.iter().all(|value| value == 1.0), "{density:?}");
}

/// `--sway A`: A to the side, half of it vertically.
#[test]
fn closed_form_the_vertical_sway_is_half_the_lateral_one() {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let plant = scenario::Plant::Rapier { setup: setup(&robot), physics: PhysicsSettings::default() };
    let mut scenario = prepared(plant, Settings::default()).scenario().clone();
    scenario::SWAY.set(&mut scenario, &scenario::Value::Number(0.034));
    let human = scenario.plant.physics().expect("bodies").human;
    assert_eq!((human.sway_lateral, human.sway_vertical), (0.034, 0.017));
}

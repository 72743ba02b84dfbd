//! The seams: policies, humans and plants of one's own, and the human models that scenarios know by name.

use crate::support::{cocarry, json, stderr, stdout};
use cocarry::control;
use cocarry::coordination::Mode;
use cocarry::episode::{Episode, EpisodeBuilder, EpisodeSettings, Outcome};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::human::{Human, HumanDecision, HumanView, ModelName, Participant, Stance};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::plant::{Command, HumanMotion, Plant, Seen};
use cocarry::policy::{Decision, Motion, RobotPolicy, RobotView};
use cocarry::preference::{Perception, subjective_cost};
use cocarry::robot::{InputVector, Robot};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{self, PreparedScenario, RobotSetup, Scenario, Snapshot};
use cocarry::simulation::PhysicsSettings;
use cocarry_studies::paper;
use nalgebra::center;

/// Eq. (6) as somebody outside the library would write it.
#[derive(Clone, Debug)]
struct OwnPolicy;

impl RobotPolicy for OwnPolicy {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        if view.mode == Mode::HumanLed || view.stance == Stance::TakeOver {
            return Decision::follow();
        }
        let phi = view.stubbornness;
        let mut best = (0, f64::INFINITY);
        for (option, seen) in view.evaluated.iter().enumerate() {
            let cost = (1.0 - phi) * seen.objective + phi * seen.expected;
            if cost < best.1 || (cost == best.1 && view.executed == Some(option)) {
                best = (option, cost);
            }
        }
        Decision::lead(best.0)
    }
}

fn setup() -> RobotSetup {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let posture = robot.postures[0].name.clone();
    RobotSetup { posture, control: control::ControlSettings::default(), robot: robot.into() }
}

fn prepared(plant: scenario::Plant, model: &str) -> PreparedScenario {
    let scenario = Scenario {
        seed: 3,
        world: paper::ENVIRONMENTS[3].world().unwrap_or_else(|e| panic!("{e}")).into(),
        human: paper::EXAMPLE_HUMAN,
        human_model: model.parse().unwrap_or_else(|e| panic!("{e}")),
        changes: Vec::new(),
        settings: EpisodeSettings::default(),
        plant,
    };
    scenario.prepare().unwrap_or_else(|e| panic!("{e}"))
}

fn ticks(mut episode: Episode) -> Vec<String> {
    let mut ticks = Vec::new();
    while episode.step().is_none() {
        ticks.push(format!("{:?}", episode.tick()));
    }
    ticks.push(format!("{:?}", episode.summary()));
    ticks
}

#[test]
fn a_policy_of_ones_own_that_is_eq_6_walks_like_mutual_on_every_plant() {
    for plant in [
        scenario::Plant::Point,
        scenario::Plant::Kinematic { setup: setup() },
        scenario::Plant::Rapier { setup: setup(), physics: PhysicsSettings::default() },
    ] {
        let name = plant.name();
        let prepared = prepared(plant, "preference");
        let builder = || prepared.builder().unwrap_or_else(|e| panic!("{e}"));
        let own = ticks(builder().with_policy(OwnPolicy).begin().expect("room"));
        assert!(own.iter().any(|tick| tick.contains("HumanLed")), "{name}: the human takes over");
        assert!(own == ticks(builder().begin().expect("room")), "{name}");
    }
}

/// Drives a robot by its inputs: it stands still.
#[derive(Clone, Debug)]
struct StandStill;

impl RobotPolicy for StandStill {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        Decision::lead(view.best_option()).with_motion(Motion::Inputs(InputVector::zeros()))
    }
}

/// Tracks poses of its own: where the grasp is already.
#[derive(Clone, Debug)]
struct StayThere;

impl RobotPolicy for StayThere {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        // no robot is there while the team lines up for the first lead
        let Some(grasp) = view.grasp else { return Decision::lead(view.best_option()) };
        let here = PlanarPose { position: grasp.translation.vector.xy().into(), yaw: 0.0 };
        let motion = Motion::Reference([here; control::HORIZON]);
        Decision::lead(view.best_option()).with_motion(motion)
    }
}

#[test]
fn a_policy_may_set_the_reference_or_the_inputs() {
    let prepared = prepared(scenario::Plant::Kinematic { setup: setup() }, "preference");
    let builder = || prepared.builder().unwrap_or_else(|e| panic!("{e}"));
    let mut still = builder().with_policy(StandStill).begin().expect("room").ignoring_loss();
    let mut stay = builder().with_policy(StayThere).begin().expect("room").ignoring_loss();
    let begin = *still.configuration().expect("a robot");
    for _ in 0..5 {
        assert_eq!(still.step(), None);
        assert_eq!(stay.step(), None);
    }
    let end = still.configuration().expect("a robot");
    assert!(
        (end.base.position - begin.base.position).norm() < 1e-12 && end.joints == begin.joints,
        "no motion"
    );
    let tracked = stay.tick().robot.expect("a robot");
    assert!(tracked.position_error > 0.3, "the human walks on: {}", tracked.position_error);
}

/// Eq. (6), with what it adds to the inputs of the built-in controller.
#[derive(Clone, Debug)]
struct Adds(InputVector);

impl RobotPolicy for Adds {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        OwnPolicy.decide(view).with_motion(Motion::Residual(self.0))
    }
}

#[test]
fn a_residual_is_added_to_the_built_in_controller_within_the_limits() {
    for plant in [
        scenario::Plant::Kinematic { setup: setup() },
        scenario::Plant::Rapier { setup: setup(), physics: PhysicsSettings::default() },
    ] {
        let name = plant.name();
        let prepared = prepared(plant, "preference");
        let builder = || prepared.builder().unwrap_or_else(|e| panic!("{e}"));
        let of = |added: InputVector| builder().with_policy(Adds(added)).begin().expect("room");
        assert!(
            ticks(of(InputVector::zeros())) == ticks(builder().begin().expect("room")),
            "{name}: nothing added"
        );

        let (mut small, mut built_in) = (of(InputVector::repeat(1e-3)), builder().begin().expect("room"));
        assert_eq!((built_in.begin_step(), small.begin_step()), (None, None));
        let told = built_in.controllers_command().expect("a robot");
        assert!(
            built_in.controllers_command().is_some_and(|again| again.input == told.input),
            "asking changes nothing"
        );
        assert_eq!((built_in.step(), small.step()), (None, None));
        let input = |episode: &Episode| episode.tick().robot.expect("a robot").input;
        assert_eq!(told.input, input(&built_in), "{name}: what it was about to do");
        let robot = prepared.robot().expect("a robot");
        let count = robot.drive.inputs() + robot.joint_count();
        let added = input(&small) - input(&built_in);
        assert!(added.iter().take(count).all(|added| (added - 1e-3).abs() < 1e-12), "{name}: {added}");

        let mut large = of(InputVector::repeat(1e3));
        assert_eq!(large.begin_step(), None);
        let rates = large.controllers_command().expect("a robot").rates;
        assert_eq!(large.step(), None);
        let total = rates + input(&large);
        let limits = robot.input_limits();
        assert!((0..count).all(|i| (total[i] - limits[i]).abs() < 1e-9), "{name}: {total}");
    }
}

/// Wants the last option, holds back for three steps, then takes over.
#[derive(Clone, Debug)]
struct Reluctant;

impl Human for Reluctant {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let stance = match view.step {
            0 => Stance::Follow,
            1..=3 => Stance::Resist,
            _ => Stance::TakeOver,
        };
        let option = view.prospects.len() - 1;
        HumanDecision { option, stance, stubbornness: 0.5, discomfort: 0.0, perception: None, hand: None }
    }
}

#[test]
fn a_human_of_ones_own_resists_and_takes_over() {
    let world = paper::ENVIRONMENTS[3].world().unwrap_or_else(|e| panic!("{e}"));
    let settings = EpisodeSettings::default();
    let options = OptionSet::new(&world, 10.0).unwrap_or_else(|e| panic!("{e}"));
    let builder = Episode::builder(&options, &settings, paper::EXAMPLE_HUMAN);
    let mut episode = builder.with_human(Reluctant).begin().expect("a point has room");
    let mut positions = Vec::new();
    while episode.step().is_none() {
        positions.push(episode.position());
    }
    assert!(positions[0] != options.begin().position && positions[1..4].iter().all(|p| *p == positions[0]));
    let summary = episode.summary();
    assert_eq!((summary.outcome, summary.last_option), (Outcome::Arrived, options.options().len() - 1));
    assert_eq!(summary.transition.map(|t| t.step), Some(4));
}

/// With bodies, a human who resists keeps the hand where it is. The robot feels it and stops; the team goes on
/// once the human leads.
#[test]
fn with_bodies_a_hand_that_resists_is_pulled_at() {
    let prepared = prepared(
        scenario::Plant::Rapier { setup: setup(), physics: PhysicsSettings::default() },
        "preference",
    );
    let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
    let mut episode = builder.with_human(Reluctant).begin().expect("room");
    let mut hands = Vec::new();
    let mut forces = Vec::new();
    while episode.step().is_none() {
        let physics = episode.tick().robot.and_then(|robot| robot.physics).expect("bodies");
        hands.push(physics.hand.position);
        forces.push(physics.hand_force);
    }
    let summary = episode.summary();
    assert_eq!(summary.outcome, Outcome::Arrived, "{:?}; forces {forces:?}", summary.loss);
    let moved = |from: usize, to: usize| (hands[to] - hands[from]).norm();
    assert!(moved(1, 3) < 0.02, "while resisting: {} m", moved(1, 3));
    assert!(moved(8, 12) > 0.1, "while leading: {} m", moved(8, 12));
    let most = forces[1..=3].iter().fold(0.0_f64, |most, force| most.max(*force));
    assert!(most > 5.0, "{most} N");
}

/// A plant of one's own: a team that walks at half speed.
#[derive(Clone, Debug)]
struct Slow(Point);

impl Plant for Slow {
    fn observe(&self) -> Seen<'_> {
        Seen { position: self.0, configuration: None, grasp: None, human: None, bodies: None }
    }

    fn step(&mut self, _: &Command, human: &HumanMotion, _: f64) {
        self.0 = center(&self.0, &human.hand.expect("a point walks its path").position);
    }

    fn save(&self) -> Saved {
        Saved::of(&self.0)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.0 = saved.read("plant")?;
        Ok(())
    }
}

#[test]
fn a_plant_of_ones_own_moves_the_team() {
    let world = paper::ENVIRONMENTS[3].world().unwrap_or_else(|e| panic!("{e}"));
    let settings = EpisodeSettings::default();
    let options = OptionSet::new(&world, 10.0).unwrap_or_else(|e| panic!("{e}"));
    let builder = || Episode::builder(&options, &settings, paper::EXAMPLE_HUMAN);
    let steps = |builder: EpisodeBuilder| {
        let mut episode = builder.begin().expect("a point has room");
        while episode.step().is_none() {}
        assert_eq!(episode.summary().outcome, Outcome::Arrived);
        episode.summary().steps
    };
    let (point, slow) = (steps(builder()), steps(builder().with_plant(|start| Slow(start.pose.position))));
    assert!(slow > point + point / 2, "{point} steps, {slow} at half speed");
}

/// Frequencies of the first choice over seeds against exp(-beta J^) / sum, eq. (2).
#[test]
fn closed_form_boltzmann_choices_have_boltzmann_frequencies() {
    let world = paper::ENVIRONMENTS[3].world().unwrap_or_else(|e| panic!("{e}"));
    let options = OptionSet::new(&world, 10.0).unwrap_or_else(|e| panic!("{e}"));
    let prospects = cocarry::episode::prospects(&options, &options.begin());
    let perception = Perception { alpha: 0.75, gamma: 0.8 };
    let model: ModelName = "boltzmann(0.7)".parse().unwrap_or_else(|e| panic!("{e}"));
    let mut counts = vec![0.0; prospects.len()];
    let seeds = 4000;
    for seed in 0..seeds {
        let participant = Participant {
            perception,
            changes: &[],
            stubbornness: EpisodeSettings::default().coordination,
            seed,
            options: &options,
        };
        let mut human = model.make(&participant).unwrap_or_else(|e| panic!("{e}"));
        let view = HumanView {
            step: 0,
            time: 0.0,
            planning_step: EpisodeSettings::default().planning_step,
            position: options.begin().position,
            options: &options,
            progress: &options.begin(),
            prospects: &prospects,
            evaluated: &[],
            risk_weight: 10.0,
            executed: None,
            mode: Mode::HumanLed,
            hand: None,
            wrench: None,
        };
        counts[human.decide(&view).option] += 1.0 / seeds as f64;
    }
    let weights: Vec<f64> =
        prospects.iter().map(|p| math::exp(-0.7 * subjective_cost(*p, 10.0, perception))).collect();
    let sum: f64 = weights.iter().sum();
    for (count, weight) in counts.iter().zip(&weights) {
        let p = weight / sum;
        let sigma = (p * (1.0 - p) / seeds as f64).sqrt();
        assert!((count - p).abs() < 4.0 * sigma + 1e-9, "{counts:?} against {weights:?} / {sum}");
    }
}

#[test]
fn a_human_of_any_model_is_in_scenarios_and_snapshots() {
    for model in ["boltzmann(0.5)", "scripted(0:2,30:1)", "cvar(0.3)", "cumulative-prospect(0.88,0.69)"] {
        let prepared = prepared(scenario::Plant::Point, model);
        let text = prepared.scenario().text().unwrap_or_else(|e| panic!("{e}"));
        assert!(text.contains(&format!("human_model = \"{model}\"")), "{text}");
        assert_eq!(&Scenario::parse(&text).unwrap_or_else(|e| panic!("{e}")), prepared.scenario());
        let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
        for _ in 0..25 {
            assert_eq!(episode.step(), None);
        }
        let bytes = prepared.snapshot(&episode).bytes().unwrap_or_else(|e| panic!("{e}"));
        let snapshot = Snapshot::parse("x.snapshot", &bytes).unwrap_or_else(|e| panic!("{e}"));
        let again = prepared.resume(snapshot.state).unwrap_or_else(|e| panic!("{e}"));
        assert!(ticks(again) == ticks(episode), "{model}");
    }
}

#[test]
fn the_command_line_takes_human_models() {
    let run =
        |model: &str| json(&["run", "--plant", "point", "--method", "human-led", "--human", model, "--json"]);
    assert_eq!(run("scripted(0:2,30:1)")["last_option"], "1");
    assert_eq!(run("scripted(0:2)")["last_option"], "2");
    // who is rational enough chooses like eq. (3)
    assert_eq!(run("boltzmann(1000)")["first_option"], run("preference")["first_option"]);
    for (model, said) in [
        ("robot", "must be one of \"preference\", \"boltzmann(RATIONALITY)\""),
        ("boltzmann", "did you mean `boltzmann(RATIONALITY)`?"),
        ("boltzmann(-1)", "a number greater than 0"),
        ("scripted(5:1)", "the first at step 0"),
        ("scripted(0:9)", "unknown option `9`"),
        ("preference(1)", "no arguments"),
        ("cvar(0)", "TAIL above 0 to 1"),
        ("cvar(0.3,0.4)", "expected cvar(TAIL), for example cvar(0.5)"),
        ("cumulative-prospect(0.88)", "EXPONENT from 0.5 to 1, WEIGHTING from 0.28 to 1"),
        ("expected-risk(1)", "no arguments"),
    ] {
        let output = cocarry(&["run", "--plant", "point", "--human", model]);
        let error = stderr(&output);
        assert!(output.status.code() == Some(2) && error.contains(said), "{model}: {error}");
    }
}

#[test]
fn humans_of_other_perceptions_prefer_their_own_least_cost() {
    let options = json(&["world", "environment-1", "--json"]);
    let numbers = |key: &str| -> Vec<f64> {
        let options = options["options"].as_array().unwrap().iter();
        options.map(|option| option[key].as_f64().unwrap()).collect()
    };
    let (lengths, risks) = (numbers("length_m"), numbers("risk"));
    let least = |cost: &dyn Fn(f64, f64) -> f64| {
        let costs: Vec<f64> = lengths.iter().zip(&risks).map(|(d, s)| cost(*d, *s)).collect();
        (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).map(|o| (o + 1).to_string())
    };
    let weight = |s: f64| s.sqrt() / math::pow(s.sqrt() + (1.0 - s).sqrt(), 2.0);
    let prospect =
        |d: f64, s: f64| weight(s) * math::pow(d + 40.0, 0.6) + (1.0 - weight(s)) * math::pow(d, 0.6);
    let wanted = [
        ("expected-risk", least(&|d, s| d + 40.0 * s)),
        ("cvar(0.1)", least(&|d, s| d + 40.0 * f64::min(1.0, s / 0.1))),
        ("cvar(0.9)", least(&|d, s| d + 40.0 * f64::min(1.0, s / 0.9))),
        ("cumulative-prospect(0.6,0.5)", least(&prospect)),
    ];
    for (model, option) in &wanted {
        let run =
            ["run", "environment-1", "--plant", "point", "--method", "human-led", "--risk-weight", "40"];
        let summary = json(&[&run[..], &["--human", model, "--json"]].concat());
        assert_eq!(summary["first_option"].as_str(), option.as_deref(), "{model}: {wanted:?}");
        // without alpha and gamma there is no subjective cost
        assert!(summary["accumulated_subjective_cost"].is_null(), "{model}");
        let told = stdout(&cocarry(&[&run[..], &["--human", model]].concat()));
        assert!(told.contains("did not prefer") && !told.contains("subjective"), "{told}");
    }
    // the models do not all agree
    assert!(wanted.iter().any(|(_, option)| *option != wanted[0].1), "{wanted:?}");
}

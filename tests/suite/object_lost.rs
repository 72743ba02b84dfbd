//! Episodes in which the object is lost, and teams that walk as slowly as their robot.

use crate::support::{cocarry, repository, stderr};
use cocarry::control;
use cocarry::episode::{
    Episode, EpisodeBuilder, EpisodeSettings, LOSS_DISTANCE_M, Manipulator, Outcome, Summary,
};
use cocarry::geometry::{Point, direction};
use cocarry::human::{Human, HumanDecision, HumanView, Stance};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::{Decision, Method, Motion, RobotPolicy, RobotView};
use cocarry::robot::{InputVector, Robot};
use cocarry::simulation::{BodyKind, PhysicsSettings};
use cocarry_studies::paper;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The carrier with wheels that drive so fast at most (m/s), as a robot file in `folder`.
fn carrier_that_drives(speed: f64, folder: &Path) -> PathBuf {
    let read = |name: &str| std::fs::read_to_string(repository("assets/robots").join(name)).expect("text");
    let (urdf, text) = (read("carrier.urdf"), read("carrier.toml"));
    let limit = "velocity=\"17.4\"";
    assert_eq!(urdf.matches(limit).count(), 2, "both wheels");
    let slow = urdf.replace(limit, &format!("velocity=\"{}\"", speed / 0.06));
    std::fs::write(folder.join("carrier.urdf"), slow).expect("a file");
    let file = folder.join("carrier.toml");
    std::fs::write(&file, text).expect("a file");
    file
}

fn run(robot: &Path, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let robot = robot.to_str().expect("UTF-8");
    let output = cocarry(&[&["run", "environment-1", "--robot", robot, "--json"], arguments].concat());
    let told = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stderr(&output)));
    (output.status.code(), told, stderr(&output))
}

/// v with v (1 + 2.4 track / 2) = 0.8 * 0.26 m/s, for the 2.4 rad that the object turns in a metre of a bend.
#[test]
fn a_team_walks_as_fast_as_a_slow_robot_can() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let robot = carrier_that_drives(0.26, folder.path());
    let track = Robot::built_in().expect("the robot").drive.track;
    let speed = 0.8 * 0.26 / (1.0 + 1.2 * track);
    let words = format!(
        "its wheels drive 0.260 m/s at most (their limit velocity of 4.33 rad/s times their radius of 0.06 m), with a reserve for bends: the team walks at {speed:.3} m/s instead of 0.5 m/s"
    );
    for plant in ["kinematic", "rapier"] {
        let (code, told, said) = run(&robot, &["--plant", plant]);
        assert_eq!((code, &told["outcome"]), (Some(0), &Value::from("arrived")), "{plant}: {said}");
        assert!((told["speed_m_per_s"].as_f64().expect("a speed") - speed).abs() < 1e-12, "{told}");
        assert!(told["warnings"][0].as_str().is_some_and(|warning| warning.contains(&words)), "{told}");
        assert!(said.contains(&words), "told at load: {said}");
        assert!(told["largest_position_error_m"].as_f64().expect("an error") < 0.1, "{told}");
    }
    // a team that is slower anyway is not told
    let (code, _, said) = run(&robot, &["--plant", "kinematic", "--speed", "0.1"]);
    assert_eq!((code, said.as_str()), (Some(0), ""));
}

/// Drives back at full speed, whatever the human does.
#[derive(Clone, Debug)]
struct BackAway;

impl RobotPolicy for BackAway {
    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let mut input = InputVector::zeros();
        input[0] = -0.5;
        input[1] = -0.5;
        Decision::lead(view.best_option()).with_motion(Motion::Inputs(input))
    }
}

/// Stays where they are.
#[derive(Clone, Debug)]
struct Stubborn;

impl Human for Stubborn {
    fn decide(&mut self, _: &HumanView<'_>) -> HumanDecision {
        HumanDecision {
            option: 0,
            stance: Stance::Resist,
            stubbornness: 0.5,
            discomfort: 0.0,
            perception: None,
            hand: None,
        }
    }
}

/// What came of an episode of the built-in robot in one of the paper's environments, on the physical plant, and
/// the peak force of its last step, N.
fn carried(
    environment: usize,
    settings: &EpisodeSettings,
    team: impl for<'a> FnOnce(EpisodeBuilder<'a>) -> EpisodeBuilder<'a>,
) -> (Summary, f64) {
    let world = paper::ENVIRONMENTS[environment].world().expect("a built-in world");
    let robot = Robot::built_in().expect("the robot");
    let options = OptionSet::new(&world, 10.0).expect("its options");
    let obstacles = control::RobotObstacles::new(&world);
    let manipulator = Manipulator {
        robot: &robot,
        posture: robot.postures[0].joints,
        control: control::ControlSettings::default(),
        obstacles: &obstacles,
    };
    let episode = Episode::builder(&options, settings, paper::EXAMPLE_HUMAN);
    let episode = episode.with_physics(manipulator, &world, &PhysicsSettings::default(), 1);
    let mut episode = team(episode).begin().expect("room to start");
    while episode.step().is_none() {}
    let physics = episode.tick().robot.and_then(|robot| robot.physics).expect("bodies");
    (episode.summary().clone(), physics.peak_force)
}

/// The hand, the softer grip with 1200 N/m, yields first.
#[test]
fn a_robot_that_backs_away_from_a_human_who_resists_loses_the_object() {
    let (summary, peak_force) =
        carried(0, &EpisodeSettings::default(), |team| team.with_policy(BackAway).with_human(Stubborn));
    assert_eq!(summary.outcome, Outcome::ObjectLost);
    let loss = summary.loss.expect("a loss");
    assert_eq!(loss.by, BodyKind::Human);
    assert!(loss.distance > LOSS_DISTANCE_M && loss.distance < 0.25, "{} m", loss.distance);
    assert!(loss.step < 10 && loss.step + 1 == summary.steps, "step {}", loss.step);
    assert!(peak_force > 100.0, "{peak_force} N");
}

/// Leads, and steers the hand to and fro by 29 degrees, whatever path is planned.
#[derive(Clone, Debug, Default)]
struct Steering {
    target: Option<Point>,
}

impl Human for Steering {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let mut decision = HumanDecision { stance: Stance::TakeOver, ..HumanDecision::following(2) };
        let Some(hand) = view.hand else { return decision };
        let target = self.target.get_or_insert(hand.translation.vector.xy().into());
        let yaw = -1.0 + 0.5 * math::sin(view.time * std::f64::consts::TAU / 8.0);
        *target += direction(yaw) * (0.2 * 0.3 * (view.time / 2.0).min(1.0));
        decision.hand = Some(*target);
        decision
    }
}

/// The distance to the planned path is a figure, not a loss: both grips hold the object.
#[test]
fn a_hand_that_leaves_the_planned_path_loses_nothing() {
    let settings =
        EpisodeSettings { method: Method::HUMAN_LED, tick_limit: Some(60), ..EpisodeSettings::default() };
    let (summary, _) = carried(3, &settings, |team| team.with_human(Steering::default()));
    let (control, interaction) = (summary.control.expect("a robot"), summary.interaction.expect("bodies"));
    assert_eq!((summary.outcome, summary.loss), (Outcome::OutOfTime, None));
    assert!(
        !summary.has_lost_object() && interaction.deflection < LOSS_DISTANCE_M,
        "{}",
        interaction.deflection
    );
    assert!(control.largest_error > LOSS_DISTANCE_M, "{} m from the path", control.largest_error);
}

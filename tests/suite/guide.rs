//! The guide of the base with bodies, and the parts of C that it decides.

use crate::support::{cocarry, json, load, repository, stderr};
use cocarry::control::{self, RobotObstacles};
use cocarry::episode::{Episode, EpisodeSettings, Manipulator, Outcome, Summary, Tick};
use cocarry::geometry::{Point, Pose};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::robot::{Robot, pose_difference};
use cocarry::simulation::PhysicsSettings;
use cocarry::world::World;
use cocarry_studies::paper::EXAMPLE_HUMAN;

/// Every tick of an episode that the human leads, with the pose of the grasp at its end where there are bodies.
fn led(
    (world, options): &(World, OptionSet),
    control: control::ControlSettings,
    has_bodies: bool,
) -> (Summary, Vec<(Tick, Option<Pose>)>) {
    let robot = Robot::built_in().expect("the built-in robot");
    let obstacles = RobotObstacles::new(world);
    let settings = EpisodeSettings { method: Method::HUMAN_LED, ..EpisodeSettings::default() };
    let manipulator =
        Manipulator { robot: &robot, posture: robot.postures[0].joints, control, obstacles: &obstacles };
    let physics = PhysicsSettings::default();
    let steady = PhysicsSettings { human: physics.human.steady(), ..physics };
    let builder = Episode::builder(options, &settings, EXAMPLE_HUMAN);
    let mut episode = match has_bodies {
        true => builder.with_physics(manipulator, world, &steady, 1).begin().expect("room"),
        false => builder.with_robot(manipulator).begin().expect("room").ignoring_loss(),
    };
    let mut ticks = Vec::new();
    while episode.step().is_none() {
        ticks.push((episode.tick().clone(), episode.observation().map(|seen| seen.grasp)));
    }
    (episode.summary().clone(), ticks)
}

/// The inputs of the base are the first two: R = I.
#[test]
fn closed_form_tracking_wheels_arm_and_pose_are_c() {
    let world = load(&repository("worlds/environment-3.toml"));
    for has_bodies in [false, true] {
        let (summary, ticks) = led(&world, control::ControlSettings::default(), has_bodies);
        let control = summary.control.expect("a robot");
        let [mut wheels, mut arm] = [0.0; 2];
        for robot in ticks.iter().filter_map(|(tick, _)| tick.robot) {
            let squares = robot.input.map(math::squared);
            wheels += squares[0] + squares[1];
            arm += squares.iter().skip(2).sum::<f64>();
            assert!((robot.wheel_cost - squares[0] - squares[1]).abs() < 1e-12);
        }
        assert!((control.wheels - wheels).abs() < 1e-9 * wheels, "{} {wheels}", control.wheels);
        assert!((control.arm() - arm).abs() < 1e-9 * arm, "{} {arm}", control.arm());
        let parts = control.tracking + control.wheels + control.arm() + control.pose;
        assert!((parts - control.cost()).abs() < 1e-9 * parts, "{parts} {}", control.cost());
        assert!(wheels > 1.0 && arm > 1.0, "{wheels} {arm}");
    }
}

/// A straight way without obstacles. A human who does not wait gains 0.18 m/s a step, up to 0.5 m/s, and the
/// grasp is half the object, 0.6 m, behind its middle, at the height of 0.7 m.
#[test]
fn closed_form_the_intended_walk_on_a_straight_way() {
    let text = "name = \"free\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [8, 0]\n";
    let world = World::parse("free", text).expect("a world");
    let options = OptionSet::new(&world, 10.0).expect("an option");
    let (summary, ticks) = led(&(world, options), control::ControlSettings::default(), true);
    assert_eq!(summary.outcome, Outcome::Arrived);
    let [mut walked, mut speed, mut waits] = [0.0f64; 3];
    for (tick, grasp) in &ticks[..60] {
        speed = (speed + 0.18).min(0.5);
        walked += 0.2 * speed;
        let intended = Pose::translation(walked - 0.6, 0.0, 0.7);
        let robot = tick.robot.expect("a robot");
        let expected = 1000.0 * pose_difference(&intended, &grasp.expect("bodies")).norm_squared();
        let off = (robot.intended_cost - expected).abs();
        assert!(off < 1e-6 * expected.max(1.0), "step {}: {} {expected}", tick.step, robot.intended_cost);
        waits += expected - robot.tracking_cost;
    }
    // the human who is reported elsewhere waits for the robot
    assert!(waits > 1.0, "{waits}");
    let control = summary.control.expect("a robot");
    let more = control.intended_cost() - control.cost();
    let tracked = control.intended_tracking - control.tracking;
    assert!((more - tracked).abs() < 1e-9 && tracked >= waits - 1.0, "{more} {tracked} {waits}");
}

/// A point on the path waits for nobody: the two walks are one.
#[test]
fn closed_form_on_the_kinematic_plant_the_intended_walk_is_the_reference() {
    let world = load(&repository("worlds/environment-1.toml"));
    let (summary, _) = led(&world, control::ControlSettings::default(), false);
    let control = summary.control.expect("a robot");
    assert_eq!(control.intended_tracking.to_bits(), control.tracking.to_bits());
}

/// The base is off its guide the more, the less that costs; a width holds it there.
#[test]
fn property_the_guide_decides_how_far_the_base_is_from_its_path() {
    let world = load(&repository("worlds/environment-4.toml"));
    let default = control::ControlSettings::default();
    let base = |control: control::ControlSettings| -> Vec<Point> {
        let (_, ticks) = led(&world, control, true);
        ticks.iter().filter_map(|(tick, _)| Some(tick.robot?.configuration.base.position)).collect()
    };
    let guided = base(default);
    let off = |control| {
        let pairs = base(control).into_iter().zip(guided.clone()).take(60);
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let [dear, cheap, free] =
        [1000.0, 10.0, 0.0].map(|price| off(control::ControlSettings { guide_price: price, ..default }));
    let narrow = off(control::ControlSettings { guide_price: 0.0, guide_width: 0.05, ..default });
    assert!(dear < 0.1 && dear < cheap && cheap <= free, "{dear} {cheap} {free}");
    assert!(free > 0.2 && narrow < 0.5 * free, "{narrow} {free}");
}

#[test]
fn a_guide_is_a_setting_of_bodies() {
    let run = ["run", "environment-4", "--seed", "1", "--json"];
    let told = |more: &[&str]| {
        let mut told = json(&[&run[..], more].concat());
        told.as_object_mut().expect("an object").remove("scenario");
        told
    };
    let default = told(&[]);
    assert_eq!(default["outcome"], "arrived");
    assert_eq!(told(&["--guide-price", "10000"]), default);
    assert_eq!(told(&["--guide-width", "1000000"]), default);
    assert_ne!(told(&["--guide-price", "1000"]), default);
    for (flag, value) in [("--guide-price", "-1"), ("--guide-price", "nan"), ("--guide-width", "0")] {
        let output = cocarry(&["run", "environment-4", flag, value]);
        assert_eq!(output.status.code(), Some(2), "{flag} {value}");
        assert!(stderr(&output).contains(flag), "{}", stderr(&output));
    }
}

/// The free base is the kinematic plant's, and with the default price the team is that of the other studies.
#[test]
fn the_study_of_guides_tells_what_each_of_them_does() {
    let little = ["reproduce", "guide", "--episodes", "1", "--worlds", "2", "--json"];
    let told = json(&[&little[..], &["--prices", "10000,0"]].concat());
    let rows = told["rows"].as_array().expect("rows");
    assert_eq!(rows[0]["guide"], serde_json::json!({ "kind": "price", "price": 10000.0 }));
    assert_eq!([&rows[0]["episodes"], &rows[0]["arrived"]], [32, 32]);
    let found = json(&["reproduce", "cycles", "--plant", "rapier", "--worlds", "2", "--json"]);
    assert_eq!(rows[0]["worlds"]["arrived"], found["findings"]["arrived"]);
    let cost = |row: &serde_json::Value, method: usize| {
        let parts = row["parts"][method].as_array().expect("parts");
        parts.iter().map(|part| part.as_f64().expect("a number")).sum::<f64>()
    };
    // what the guide costs no longer holds the base: it rolls less far, and the arm reaches
    assert!(rows.len() == 2 && cost(&rows[1], 1) < cost(&rows[0], 1), "{rows:?}");
    for (prices, said) in [("-1", "-1"), ("10,cheap", "cheap"), ("nan", "nan")] {
        let output = cocarry(&[&little[..], &[&format!("--prices={prices}")]].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{prices}");
        assert!(error.contains(said) && error.contains("a number from 0 to 1000000"), "{error}");
    }
}

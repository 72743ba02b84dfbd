//! A scenario as text is the scenario: the episode is the same to the last bit, and what is wrong in it is
//! named.

use crate::support::repository;
use cocarry::Error;
use cocarry::control;
use cocarry::episode::{Episode, EpisodeSettings, PreferenceChange};
use cocarry::policy::Method;
use cocarry::preference::{Belief, Marginal, Perception, Predictor, WeightedSample};
use cocarry::robot::Robot;
use cocarry::scenario::{GivenWorld, Plant, PlantKind, RobotSetup, Scenario, WorldText};
use cocarry::simulation::PhysicsSettings;
use cocarry::world::World;
use proptest::prelude::*;

fn carrier() -> RobotSetup {
    let robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let posture = robot.postures[1].name.clone();
    RobotSetup { posture, control: control::ControlSettings::default(), robot: robot.into() }
}

/// A scenario in one of the worlds, its human and belief with numbers that have no short decimal form.
fn scenario(plant: Plant) -> Scenario {
    let file = "worlds/environment-4.toml".to_owned();
    let text = std::fs::read_to_string(repository(&file)).unwrap_or_else(|e| panic!("{e}"));
    let alpha = Marginal::truncated_normal(0.1 + 0.2 + 0.4, 1.0 / 7.0, 0.55, 0.95);
    let belief = Belief::Independent {
        alpha: alpha.unwrap_or_else(|e| panic!("{e}")),
        gamma: Marginal::uniform(0.5, 1.1 / 3.0 * 3.0).unwrap_or_else(|e| panic!("{e}")),
    };
    let predictor = Predictor::new(belief, 31.0 / 3.0).unwrap_or_else(|e| panic!("{e}"));
    Scenario {
        seed: u64::MAX,
        world: WorldText { file, text }.into(),
        human: Perception { alpha: 2.241 / 3.0, gamma: 0.765 },
        changes: Vec::new(),
        human_model: Default::default(),
        settings: EpisodeSettings { predictor, tick_limit: Some(1000), ..EpisodeSettings::default() },
        plant,
    }
}

fn plants() -> [Plant; 3] {
    let physics = PhysicsSettings::default();
    [Plant::Point, Plant::Kinematic { setup: carrier() }, Plant::Rapier { setup: carrier(), physics }]
}

/// An episode to the last bit. As text: what was not evaluated is NaN.
fn bits(scenario: Scenario) -> String {
    let prepared = scenario.prepare().unwrap_or_else(|e| panic!("{e}"));
    let mut episode: Episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
    let mut bits = String::new();
    while episode.step().is_none() {
        bits += &format!("{:?}\n", episode.tick());
    }
    bits + &format!("{:?}", episode.summary())
}

fn parsed(text: &str) -> Scenario {
    Scenario::parse(text).unwrap_or_else(|e| panic!("{}", chain(e)))
}

/// An error with its causes, as the program prints it.
fn chain(error: Error) -> String {
    format!("{:#}", anyhow::Error::from(error))
}

#[test]
fn a_scenario_read_back_is_the_same_episode() {
    for plant in plants() {
        let (name, scenario) = (plant.name(), scenario(plant));
        let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
        let toml = parsed(&text);
        assert!(toml == scenario, "{name}:\n{text}");
        let json = serde_json::to_string(&scenario).expect("JSON");
        let json: Scenario = serde_json::from_str(&json).expect("a scenario");
        assert!(json == scenario, "{name}: {json:?}");
        let expected = bits(scenario);
        assert!(expected.lines().count() > 100, "{name}: an episode");
        assert!(bits(toml) == expected, "{name}: the episodes differ");
    }
}

/// Positive, of any magnitude, to the last bit.
fn parameter() -> impl Strategy<Value = f64> {
    (proptest::num::f64::POSITIVE | proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL)
        .prop_map(|x: f64| if x.abs() > 10.0 { 1.0 / x.abs() } else { x.abs() })
}

#[test]
fn property_preference_changes_are_read_back_to_the_last_bit() {
    let of = scenario(Plant::Point);
    let plain = of.text().unwrap_or_else(|e| panic!("{e}"));
    assert!(!plain.contains("change"), "nothing is written where there are none:\n{plain}");
    let change = (any::<u64>(), parameter(), parameter())
        .prop_map(|(step, alpha, gamma)| PreferenceChange { step, perception: Perception { alpha, gamma } });
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    runner
        .run(&proptest::collection::vec(change, 0..6), |changes| {
            let scenario = Scenario { changes, ..of.clone() };
            let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
            prop_assert_eq!(text.matches("[[change]]").count(), scenario.changes.len());
            prop_assert!(parsed(&text) == scenario, "{}", text);
            prop_assert_eq!(parsed(&text).text().unwrap_or_else(|e| panic!("{e}")), text);
            Ok(())
        })
        .unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn what_is_wrong_in_a_change_is_named() {
    let change = |step, alpha, gamma| PreferenceChange { step, perception: Perception { alpha, gamma } };
    let changes = vec![change(12, 0.6, 0.7), change(40, 0.25, 0.75)];
    let valid = Scenario { changes, ..scenario(Plant::Point) }.text().unwrap_or_else(|e| panic!("{e}"));
    parsed(&valid);
    let cases: [(&str, &str, &[&str]); 9] = [
        ("alpha = 0.25", "alpha = 0", &["change 2, at step 40: alpha = 0", "greater than 0"]),
        ("gamma = 0.75", "gamma = nan", &["change 2, at step 40: gamma = NaN", "greater than 0"]),
        ("gamma = 0.75", "gamma = inf", &["change 2, at step 40: gamma = inf", "greater than 0"]),
        ("alpha = 0.25", "alpha = -1", &["change 2, at step 40: alpha = -1", "greater than 0"]),
        ("step = 40", "step = -40", &["-40", "u64"]),
        ("step = 40", "step = 4.5", &["4.5", "u64"]),
        ("step = 40", "", &["missing field `step`"]),
        ("step = 40", "step = 40\nbeta = 1", &["beta", "gamma"]),
        ("step = 40", "time_s = 40", &["time_s", "step"]),
    ];
    for (from, to, said) in cases {
        assert_eq!(valid.matches(from).count(), 1, "{from}:\n{valid}");
        let error = chain(Scenario::parse(&valid.replace(from, to)).map(|_| ()).expect_err(to));
        for part in said {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
    }
}

#[test]
fn samples_keep_their_weights_to_the_last_bit() {
    let weights = [3.0, 1.0, 1.0 / 3.0, 7e5, 0.1];
    for n in 1..=weights.len() {
        let sample = |(i, weight): (usize, &f64)| WeightedSample {
            perception: Perception { alpha: 0.6 + 0.03 * i as f64, gamma: 0.8 },
            weight: *weight,
        };
        let samples = weights[..n].iter().enumerate().map(sample).collect();
        let belief = Belief::samples(samples).unwrap_or_else(|e| panic!("{e}"));
        let predictor = Predictor::new(belief, 10.0).unwrap_or_else(|e| panic!("{e}"));
        let settings = EpisodeSettings { predictor, method: Method::HUMAN_LED, ..EpisodeSettings::default() };
        let scenario = Scenario { settings, ..scenario(Plant::Point) };
        let text = scenario.text().unwrap_or_else(|e| panic!("{e}"));
        assert!(parsed(&text) == scenario, "{text}");
    }
}

#[test]
fn weights_written_by_hand_need_not_sum_to_one() {
    let belief =
        "samples = [{ alpha = 0.6, gamma = 0.7, weight = 3 }, { alpha = 0.8, gamma = 0.9, weight = 1 }]";
    let text = scenario(Plant::Point).text().unwrap_or_else(|e| panic!("{e}"));
    let (before, after) = text.split_once("[settings.predictor.belief.independent]").expect("a belief");
    let after = &after[after.find("\n[").expect("a table")..];
    let read = parsed(&format!("{before}[settings.predictor.belief]\n{belief}\n{after}"));
    let Belief::Samples(set) = read.settings.predictor.belief() else { panic!("{read:?}") };
    assert_eq!(set.samples()[0].weight, 0.75);
}

/// Files that were read before may be gone, meshes too.
#[test]
fn a_scenario_needs_no_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("six.toml");
    for name in ["six.toml", "six.urdf"] {
        let text =
            std::fs::read_to_string(repository("tests/fixtures/robots").join(name)).expect("a fixture");
        let mesh = "<geometry><mesh filename=\"package://gone/wheel.stl\"/></geometry>";
        let text = text.replacen("<collision>", &format!("<visual>{mesh}</visual>\n<collision>"), 1);
        std::fs::write(folder.path().join(name), text).expect("a copy");
    }
    let meshes = folder.path().join("gone");
    std::fs::create_dir(&meshes).expect("a folder");
    std::fs::write(meshes.join("wheel.stl"), "solid").expect("a mesh");
    let robot = Robot::load(&file).unwrap_or_else(|e| panic!("{e}"));
    assert!(robot.texts.urdf.contains("package://gone"), "the fixture has no <collision>");
    drop(folder);
    assert!(Robot::load(&file).is_err());
    let posture = robot.postures[0].name.clone();
    let carrier = RobotSetup { posture, robot: robot.texts.into(), ..carrier() };
    let physics = PhysicsSettings::default();
    // its base moves beside the object's path, for which the openings of the paper's worlds are too narrow
    let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
    let world = World::parse("w.toml", text).unwrap_or_else(|e| panic!("{e}"));
    for plant in [Plant::Kinematic { setup: carrier.clone() }, Plant::Rapier { setup: carrier, physics }] {
        let wide = Scenario { world: GivenWorld::from(world.clone()), ..scenario(plant) };
        let prepared = wide.prepare().unwrap_or_else(|e| panic!("{}", chain(e)));
        let mut episode = prepared.episode().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(episode.step(), None);
    }
}

/// A robot and a world whose texts have become unreadable are those that were parsed before.
#[test]
fn a_world_and_a_robot_are_parsed_once() {
    let mut robot = Robot::built_in().unwrap_or_else(|e| panic!("{e}"));
    let mut world = World::load(&repository("worlds/environment-4.toml")).unwrap_or_else(|e| panic!("{e}"));
    let (names, posture) = (world.openings.len(), robot.postures[0].name.clone());
    for text in [&mut robot.texts.text, &mut robot.texts.urdf, &mut world.text] {
        "neither TOML nor XML".clone_into(text);
    }
    for kind in PlantKind::ALL {
        let scenario = Scenario::new(world.clone().into(), Plant::new(kind, RobotSetup::new(&robot)));
        // what was drawn before, and what is prepared after, share the options
        let options = scenario.world.options(scenario.settings.predictor.risk_weight());
        let prepared = scenario.clone().prepare().unwrap_or_else(|e| panic!("{}", chain(e)));
        assert!(std::ptr::eq(&*options.expect("options"), prepared.options()));
        assert_eq!(prepared.world().openings.len(), names);
        assert_eq!(prepared.robot().is_some(), kind != PlantKind::Point);
        let other = prepared.prepare(Scenario { seed: 1, ..scenario }).unwrap_or_else(|e| panic!("{e}"));
        for prepared in [prepared, other] {
            assert_eq!(prepared.episode().unwrap_or_else(|e| panic!("{e}")).step(), None);
        }
    }
    // from the texts alone, there is nothing
    let setup = RobotSetup { posture, robot: robot.texts.into(), ..carrier() };
    let error = Scenario::new(world.into(), Plant::Kinematic { setup }).prepare().map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("not a valid robot file"), "{error}");
}

/// The paths of all numbers in a table.
fn numbers(value: &toml::Value, path: &[String], found: &mut Vec<Vec<String>>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                numbers(value, &[path, std::slice::from_ref(key)].concat(), found);
            }
        }
        toml::Value::Float(_) | toml::Value::Integer(_) => found.push(path.to_vec()),
        _ => {}
    }
}

#[test]
fn every_number_is_checked_and_named() {
    let physics = PhysicsSettings::default();
    let scenario = Scenario { seed: 1, ..scenario(Plant::Rapier { setup: carrier(), physics }) };
    let valid: toml::Value = toml::Value::try_from(&scenario).expect("a table");
    let mut paths = Vec::new();
    numbers(&valid, &[], &mut paths);
    assert!(paths.len() >= 20, "{paths:?}");
    for path in paths {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            let mut spoiled = valid.clone();
            let entry = path.iter().try_fold(&mut spoiled, |table, key| table.get_mut(key)).expect("there");
            *entry = toml::Value::Float(bad);
            let text = toml::to_string(&spoiled).expect("TOML");
            let error = chain(Scenario::parse(&text).map(|_| ()).expect_err(&path.join(".")));
            let key = path.last().expect("a key");
            // eq. (1) names its weight in words
            let key = if key == "risk_weight_m" { "risk weight c_r" } else { key.as_str() };
            let value = if bad.is_nan() { "nan".to_owned() } else { bad.to_string() };
            assert!(error.contains(key) && error.to_lowercase().contains(&value), "{path:?} {bad}: {error}");
        }
    }
}

#[test]
fn what_else_is_wrong_is_named() {
    let valid = scenario(Plant::Kinematic { setup: carrier() }).text().unwrap_or_else(|e| panic!("{e}"));
    let cases: [(&str, &str, &[&str]); 8] = [
        ("method = \"mutual\"", "method = \"mutal\"", &["mutal", "without-model"]),
        ("tick_limit = 1000", "tick_limt = 1000", &["tick_limt", "tick_limit"]),
        ("gamma = 0.765", "", &["gamma"]),
        ("criterion = \"expected\"", "criterion = \"best\"", &["best", "manipulability"]),
        ("gamma = \"uniform(0.5,1.1)\"", "gamma = \"uniform(0.5,-1.1)\"", &["-1.1", "gamma"]),
        ("posture = \"elbow-out\"", "posture = \"elbow\"", &["\"elbow\"", "carrier", "`elbow-out`"]),
        ("robot_width_m", "robot_girth_m", &["worlds/environment-4.toml", "robot_girth_m"]),
        ("base_link = ", "base_lnk = ", &["carrier", "base_lnk"]),
    ];
    for (from, to, said) in cases {
        assert!(valid.contains(from), "{from}:\n{valid}");
        let read = Scenario::parse(&valid.replacen(from, to, 1)).and_then(Scenario::prepare);
        let error = chain(read.map(|_| ()).expect_err(to));
        for part in said {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
    }
}

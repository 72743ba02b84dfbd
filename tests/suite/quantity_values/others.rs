//! Inputs of other bases and joints, what was learned, and the sway.

use super::*;
use crate::support::repository;

/// The inputs of an omnidirectional base and of a lift.
#[test]
fn closed_form_inputs_have_the_names_of_their_drive_and_joints() {
    for (name, base) in [("omni-carrier", 3), ("porter", 2)] {
        let robot = Robot::load(&repository(&format!("assets/robots/{name}.toml")));
        let robot = robot.unwrap_or_else(|e| panic!("{e}"));
        let prepared =
            prepared(scenario::Plant::Kinematic { setup: setup(&robot) }, EpisodeSettings::default());
        let builder = prepared.builder().unwrap_or_else(|e| panic!("{e}"));
        let mut episode =
            builder.with_controller(ToldController::new()).begin().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(episode.step(), None);
        let tick = read(&View::new(&prepared, &episode), &TICK);
        if base == 3 {
            numbers(
                &tick,
                [("base_ahead_m_per_s", 0.01), ("base_left_m_per_s", 0.02), ("base_turn_rad_per_s", 0.03)],
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
    let settings = EpisodeSettings {
        learning: Some(learning::LearningSettings::default()),
        ..EpisodeSettings::default()
    };
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
    let mut scenario = prepared(plant, EpisodeSettings::default()).scenario().clone();
    scenario::SWAY.set(&mut scenario, &scenario::Value::Number(0.034));
    let human = scenario.plant.physics().expect("bodies").human;
    assert_eq!((human.sway_lateral, human.sway_vertical), (0.034, 0.017));
}

//! Rooms with equal ways: the probability of a tie is shared, and a belief with lapses or a rationality does
//! not hang on a tenth of a millimetre.

use crate::support::{cocarry, json, load, stderr};
use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor};
use cocarry::scenario::Scenario;
use cocarry::world::{BUILT_IN_WORLDS, World};
use cocarry_studies::paper::cycles::random_world;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;
use std::path::PathBuf;

/// One post in the middle of a corridor, a little to the left of it, in a room turned by an angle.
fn corridor(half_width: f64, left_m: f64, turned_deg: f64) -> String {
    let turn = |x: f64, y: f64| {
        let (sin, cos) = cocarry::math::sin_cos(turned_deg.to_radians());
        format!("[{:?}, {:?}]", x * cos - y * sin, x * sin + y * cos)
    };
    let wall = |name: &str, y: f64| {
        format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = {}\nsize_m = [12.0, 0.1]\nyaw_deg = {turned_deg:?}\nheight_m = 2.0\n",
            turn(0.0, y)
        )
    };
    let way = |name: &str| {
        format!(
            "[[opening]]\nname = \"{name}\"\nbetween = [\"post\", \"{name} wall\"]\n[[option]]\nname = \"{name}\"\nopenings = [\"{name}\"]\n"
        )
    };
    format!(
        "name = \"corridor\"\nrobot_width_m = 0.33\nstart_m = {}\ntarget_m = {}\n\
         [[obstacle]]\nname = \"post\"\nshape = \"cylinder\"\ncenter_m = {}\nradius_m = 0.15\nheight_m = 1.0\n{}{}{}{}",
        turn(-2.2, 0.0),
        turn(2.5, 0.0),
        turn(0.0, left_m),
        wall("left wall", half_width + 0.05),
        wall("right wall", -half_width - 0.05),
        way("left"),
        way("right"),
    )
}

fn probabilities(text: &str, predictor: &Predictor) -> Vec<f64> {
    let world = World::parse("room.toml", text).unwrap_or_else(|e| panic!("{e}"));
    let set = OptionSet::new(&world, predictor.risk_weight()).unwrap_or_else(|e| panic!("{e}"));
    let mut choice = ChoiceDistribution::default();
    predictor.clone().predict(&prospects(&set, &set.begin()), &mut choice);
    choice.probabilities().to_vec()
}

fn with(lapse_rate: f64, rationality: Option<f64>) -> Predictor {
    let mut predictor = Predictor::default();
    predictor.set_lapse_rate(lapse_rate).unwrap();
    predictor.set_rationality(rationality).unwrap();
    predictor
}

#[test]
fn issue_a_symmetric_room_had_one_way_only() {
    for (half_width, turned_deg) in [(1.41, 0.0), (1.41, 90.0), (0.9, 30.0), (1.2, -77.0), (0.8, 200.0)] {
        let room = corridor(half_width, 0.0, turned_deg);
        for predictor in [with(0.0, None), with(0.1, None), with(0.0, Some(2.0))] {
            for p in probabilities(&room, &predictor) {
                assert!((p - 0.5).abs() < 1e-6, "{half_width} m, {turned_deg} deg: {p}");
            }
        }
    }
}

#[test]
fn beside_a_tie_lapses_bound_the_belief_and_a_rationality_makes_it_continuous() {
    for left_m in [-1e-4, 1e-4] {
        let room = corridor(1.41, left_m, 0.0);
        let nearer = usize::from(left_m > 0.0);
        assert_eq!(probabilities(&room, &with(0.0, None))[nearer], 1.0);
        assert!((probabilities(&room, &with(0.1, None))[nearer] - 0.95).abs() < 1e-12);
        let graded = probabilities(&room, &with(0.0, Some(2.0)));
        assert!(graded[nearer] > 0.5 && graded[nearer] < 0.5005, "{graded:?}");
    }
}

/// The same world in a mirror.
fn mirrored(text: &str) -> String {
    let mut world: toml::Table = text.parse().expect("TOML");
    let negate = |value: &mut toml::Value| match value {
        toml::Value::Float(y) => *y = -*y,
        toml::Value::Integer(y) => *y = -*y,
        other => panic!("{other}"),
    };
    for key in ["start_m", "target_m"] {
        negate(&mut world[key][1]);
    }
    for obstacle in world["obstacle"].as_array_mut().expect("obstacles") {
        let obstacle = obstacle.as_table_mut().expect("a table");
        if let Some(center) = obstacle.get_mut("center_m") {
            negate(&mut center[1]);
        }
        if let Some(yaw) = obstacle.get_mut("yaw_deg") {
            negate(yaw);
        }
        if let Some(vertices) = obstacle.get_mut("vertices_m").and_then(|v| v.as_array_mut()) {
            vertices.iter_mut().for_each(|vertex| negate(&mut vertex[1]));
            vertices.reverse();
        }
    }
    world.to_string()
}

#[test]
fn property_a_mirrored_room_has_the_same_probabilities() {
    let sorted = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all
    };
    let random = (0..40).map(|seed| random_world(&mut ChaCha8Rng::seed_from_u64(seed)));
    let built_in = BUILT_IN_WORLDS.iter().map(|world| world.text.to_owned());
    let mut compared = 0;
    for text in built_in.chain(random) {
        let world = World::parse("room.toml", &text);
        if world.is_ok_and(|world| OptionSet::new(&world, 10.0).is_ok()) {
            for predictor in [with(0.0, None), with(0.1, None), with(0.0, Some(2.0))] {
                let [first, second] =
                    [text.clone(), mirrored(&text)].map(|t| sorted(probabilities(&t, &predictor)));
                let apart = first.iter().zip(&second).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(first.len() == second.len() && apart < 1e-4, "{first:?}\n{second:?}\n{text}");
                compared += 1;
            }
        }
    }
    assert!(compared > 60, "{compared}");
}

fn room() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.toml");
    std::fs::write(&file, corridor(1.41, 0.0, 0.0)).unwrap();
    (folder, file)
}

#[test]
fn a_human_beside_a_tie_becomes_stubborn_with_a_belief_that_is_continuous() {
    let (_folder, file) = room();
    let run = |extra: &[&str]| -> Value {
        let arguments =
            ["run", file.to_str().unwrap(), "--plant", "point", "--human", "boltzmann(2)", "--eta", "2"];
        json(&[&arguments, extra, &["--json"]].concat())
    };
    // one step beyond the tie, the paper's belief is certain that everybody wants the way that the robot leads
    assert!(run(&[])["transition_step"].is_null());
    let step = run(&["--belief-rationality", "2"])["transition_step"].as_u64().expect("a transition");
    assert!((10..20).contains(&step), "{step}");
}

#[test]
fn lapses_and_rationality_are_settings_of_the_belief() {
    let (_folder, file) = room();
    let name = file.to_str().unwrap();
    let of = |extra: &[&str]| {
        json(&[&["world", name, "--json"], extra].concat())["options"][0]["probability"].clone()
    };
    assert_eq!(of(&["--belief-lapse", "0.2"]), 0.5);
    let text = |extra: &[&str]| {
        let (_, set) = load(&file);
        assert_eq!(set.options().len(), 2);
        let snapshot = file.with_extension("snapshot");
        let snapshot = snapshot.to_str().unwrap();
        let arguments = ["run", name, "--plant", "point", "--save-at", "0", snapshot, "--overwrite"];
        let output = cocarry(&[&arguments, extra].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        cocarry::scenario::Snapshot::load(snapshot.as_ref()).unwrap().scenario.text().unwrap()
    };
    let plain = text(&[]);
    assert!(!plain.contains("lapse_rate") && !plain.contains("rationality"), "{plain}");
    let both = text(&["--belief-lapse", "0.2", "--belief-rationality", "3"]);
    assert!(both.contains("lapse_rate = 0.2") && both.contains("rationality = 3.0"), "{both}");
    // a robot that learns assumes the same lapses of what it sees, and its own rate without them
    let learns = |extra: &[&str]| {
        let scenario = Scenario::parse(&text(&[&["--belief", "learn"], extra].concat())).unwrap();
        scenario.settings.learning.map(|learning| learning.lapse_rate)
    };
    assert_eq!(learns(&["--belief-lapse", "0.2"]), Some(0.2));
    assert_eq!(learns(&["--belief-lapse", "0"]), Some(0.02));
    for (arguments, said) in [
        (["--belief-lapse", "0.6"].as_slice(), "must be a number from 0 to 0.5"),
        (&["--belief-rationality", "0"], "must be a number greater than 0 and at most 1000"),
        (&["--belief", "learn", "--belief-rationality", "2"], "settings.predictor.rationality"),
    ] {
        let output = cocarry(&[&["run", name], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    }
}

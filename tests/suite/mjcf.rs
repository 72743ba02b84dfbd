//! Scenarios written for MuJoCo, and motor logs. `tests/mujoco/check` has MuJoCo's word on them.

use crate::support::{repository, stderr, stdout};
use resvg::usvg::roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Output};

fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cocarry")).args(arguments).current_dir(folder).output().unwrap()
}

/// What a command prints, which must succeed.
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = run_in(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// What a command says of its input, which must be refused; it leaves no file.
fn refused(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = run_in(folder.path(), arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{arguments:?}");
    stderr(&output)
}

fn named<'d, 'i>(document: &'d Document<'i>, tag: &str, name: &str) -> Node<'d, 'i> {
    let mut all = document.descendants();
    let is_it = |node: &Node| node.has_tag_name(tag) && node.attribute("name") == Some(name);
    all.find(is_it).unwrap_or_else(|| panic!("no {tag} {name}"))
}

fn numbers(node: &Node, key: &str) -> Vec<f64> {
    let text = node.attribute(key).unwrap_or_else(|| panic!("no {key}"));
    text.split_whitespace().map(|number| number.parse().expect("a number")).collect()
}

/// The number of positions that a file's joints have.
fn positions(document: &Document) -> usize {
    let joints = document.descendants().filter(|node| node.has_tag_name("joint"));
    let kinds = joints.filter_map(|joint| joint.attribute("type"));
    kinds.map(|kind| if kind == "ball" { 4 } else { 1 }).sum()
}

#[test]
fn closed_form_a_scene_has_the_bodies_motors_and_grips_of_the_plant() {
    let folder = tempfile::tempdir().unwrap();
    let told = succeeds(folder.path(), &["export", "environment-4", "--mjcf", "scene.xml"]);
    assert!(told.starts_with("wrote scene.xml\n") && told.contains("the human's motion"), "{told}");
    let text = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    let document = Document::parse(&text).expect("well-formed");
    // base, seven joints of the arm; object, hand, torso
    assert_eq!(document.descendants().filter(|node| node.has_tag_name("body")).count(), 8 + 3);
    let base = named(&document, "body", "robot/base_link");
    let inertial = base.children().find(|node| node.has_tag_name("inertial")).unwrap();
    assert!((numbers(&inertial, "mass")[0] - 83.0).abs() < 1e-9);
    // effort limit 0.3 s of stiffness; 1/50 s of it is damping
    let motor = named(&document, "general", "robot/shoulder_lift_joint");
    let [limit] = numbers(&motor, "forcerange")[1..] else { panic!("a limit") };
    assert_eq!(numbers(&motor, "gainprm"), [300.0 * limit.min(200.0)]);
    assert_eq!(numbers(&motor, "biasprm"), [0.0, -300.0 * limit.min(200.0), -6.0 * limit.min(200.0)]);
    // 1e5 (1 + dt) at 100 Hz
    assert_eq!(numbers(&named(&document, "general", "base_x"), "gainprm"), [101_000.0]);
    // half of 4 kg, critical damping
    let grip = numbers(&named(&document, "general", "gripper_z"), "biasprm");
    assert!((grip[0] - 2.0 * 9.81).abs() < 1e-12 && grip[1] == -20_000.0 && (grip[2] + 400.0).abs() < 1e-12);
    // rapier's spring about an axis is half as stiff as its coefficient for a multibody
    assert_eq!(numbers(&named(&document, "joint", "grip_turn"), "stiffness"), [500.0]);
    let hand = numbers(&named(&document, "general", "hand_yaw"), "biasprm");
    assert_eq!(hand[1], -10.0);
    let start = named(&document, "key", "start");
    assert_eq!(numbers(&start, "qpos").len(), positions(&document));
    assert_eq!(numbers(&start, "ctrl").len(), 3 + 7 + 6 + 3);
    let obstacles = document.descendants().filter_map(|node| node.attribute("name"));
    let obstacles: BTreeSet<&str> = obstacles.filter(|name| name.starts_with("obstacle/")).collect();
    assert!(obstacles.contains("obstacle/wall-1") || obstacles.len() > 1, "{obstacles:?}");
}

/// Base: object, torso, hand, obstacles; arm: torso, hand, obstacles; object: base, torso, obstacles.
#[test]
fn closed_form_the_same_pairs_of_bodies_touch() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["export", "environment-1", "--mjcf", "scene.xml"]);
    let text = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    let document = Document::parse(&text).unwrap();
    let classes =
        document.descendants().filter(|node| node.has_tag_name("default") && node.has_attribute("class"));
    let bits: BTreeMap<&str, [u32; 2]> = classes
        .map(|class| {
            let geom = class.children().find(|node| node.has_tag_name("geom")).unwrap();
            let bits = ["contype", "conaffinity"].map(|key| geom.attribute(key).unwrap().parse().unwrap());
            (class.attribute("class").unwrap(), bits)
        })
        .collect();
    let pairs = ["base object", "base torso", "base hand", "base obstacle", "arm torso", "arm hand"];
    let pairs: BTreeSet<_> =
        pairs.into_iter().chain(["arm obstacle", "object torso", "object obstacle"]).collect();
    for (a, [of_a, by_a]) in &bits {
        for (b, [of_b, by_b]) in &bits {
            let touch = of_a & by_b != 0 || of_b & by_a != 0;
            let is_pair = pairs.contains(&*format!("{a} {b}")) || pairs.contains(&*format!("{b} {a}"));
            let is_human = ["torso", "hand"].contains(a) || ["torso", "hand"].contains(b);
            let at_rest = is_human && (*a == "obstacle" || *b == "obstacle");
            assert_eq!(touch, is_pair || at_rest, "{a} {b}");
        }
    }
}

#[test]
fn hostile_names_stay_names() {
    let folder = tempfile::tempdir().unwrap();
    let name = "--><x a='\\\"'>&amp;";
    let world = format!(
        "name = \"{name}\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n\
         [[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [3, 4]\nsize_m = [1, 1]\nheight_m = 1.0\n\
         [[obstacle]]\nname = \"hull\"\nshape = \"polygon\"\nvertices_m = [[3, -4], [4, -4], [4, -5]]\nheight_m = 1.0\n"
    );
    std::fs::write(folder.path().join("w.toml"), world).unwrap();
    succeeds(folder.path(), &["export", "w.toml", "--mjcf", "scene.xml"]);
    let text = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    let document = Document::parse(&text).expect("well-formed");
    let plain = name.replace('\\', "");
    assert_eq!(document.root_element().attribute("model"), Some(&*plain));
    named(&document, "geom", &format!("obstacle/{plain}"));
    assert_eq!(numbers(&named(&document, "mesh", "hull 0"), "vertex").len() % 3, 0);
    assert!(!document.descendants().any(|node| node.has_tag_name("x")));
}

#[test]
fn files_are_written_together_and_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let export = ["export", "environment-1", "--mjcf", "scene.xml", "--motors", "motors.csv"];
    let short = [&export[..], &["--max-steps", "3", "--seed", "2"]].concat();
    let told = succeeds(folder.path(), &short);
    assert!(told.contains("wrote motors.csv: 60 physics steps; the episode ended: out-of-time\n"), "{told}");
    let text = std::fs::read_to_string(folder.path().join("motors.csv")).unwrap();
    let mut rows = text.lines();
    let columns: Vec<&str> = rows.next().unwrap().split(',').collect();
    let scene = std::fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    let document = Document::parse(&scene).unwrap();
    let actuators = document.descendants().filter(|node| node.has_tag_name("general"));
    let actuators: Vec<&str> = actuators.filter_map(|node| node.attribute("name")).collect();
    // the gripper's take no control
    assert_eq!(columns[1..=16], actuators[..16]);
    let row: Vec<f64> = rows.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!((columns.len(), row.len(), row[0]), (50, 50, 0.01));
    let last: Vec<f64> = rows.next_back().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let column = |name: &str| last[columns.iter().position(|column| *column == name).unwrap()];
    let lift = column("gripper_force_z_n") + column("hand_force_z_n");
    assert!((lift - 4.0 * 9.81).abs() < 1.0, "{lift} N");

    let again = run_in(folder.path(), &short);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("scene.xml: exists already"), "{}", stderr(&again));
    std::fs::remove_file(folder.path().join("scene.xml")).unwrap();
    assert_eq!(run_in(folder.path(), &short).status.code(), Some(2));
    assert!(!folder.path().join("scene.xml").exists());
    succeeds(folder.path(), &[&short[..], &["--overwrite"]].concat());
    assert_eq!(std::fs::read_to_string(folder.path().join("motors.csv")).unwrap(), text);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn what_has_no_scene_is_refused() {
    let mjcf = |more: &[&str]| refused(&[&["export", "environment-1", "--mjcf", "scene.xml"], more].concat());
    for (more, said) in [
        (&["--plant", "kinematic"][..], "use --plant rapier"),
        (&["--robot", "none.toml"], "none.toml"),
        (&["--posture", "none"], "it has `elbow-up`"),
        (&["--gripper-stiffness", "1"], "from 1000 to 200000"),
        (&["--motors", "motors.txt"], "expected the extension .csv"),
        (&["--output", "folder"], "cannot be used with"),
    ] {
        let told = mjcf(more);
        assert!(told.contains(said), "{more:?}: {told}");
    }
    let world = repository("worlds/environment-1.toml");
    for (arguments, said) in [
        (&["export", "environment-1", "--seed", "3"][..], "--mjcf <FILE>"),
        (&["export", "environment-1", "--motors", "motors.csv"], "--mjcf <FILE>"),
        (&["export", world.to_str().unwrap()], "needs --mjcf FILE.xml"),
        (&["export", "environment-1", "--mjcf", "scene.txt"], "expected the extension .xml"),
        (&["export", "missing.toml", "--mjcf", "scene.xml"], "missing.toml"),
        (&["export", "h1", "--mjcf", "scene.xml"], "h1"),
    ] {
        let told = refused(arguments);
        assert!(told.contains(said), "{arguments:?}: {told}");
    }
}

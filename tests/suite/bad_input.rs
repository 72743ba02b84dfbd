//! One case a fault: a valid file or command line with one thing spoiled. The program must say what is wrong,
//! with names and numbers, and end with 2.

use crate::support::{cocarry, repository, stderr};
use std::path::Path;

/// A world that is valid as it stands.
const VALID: &str = r#"name = "valid"
robot_width_m = 0.5
start_m = [0.0, 0.0]
target_m = [6.0, 0.0]

[object]
shape = "board"
size_m = [1.6, 0.6, 0.04]
mass_kg = 6.0

[[obstacle]]
name = "lower"
shape = "box"
center_m = [3.0, -5.5]
size_m = [0.2, 10.0]
height_m = 1.0

[[obstacle]]
name = "upper"
shape = "box"
center_m = [3.0, 5.5]
size_m = [0.2, 10.0]
height_m = 1.0

[[obstacle]]
name = "pillar"
shape = "cylinder"
center_m = [10.0, 5.0]
radius_m = 0.5
height_m = 1.0

[[obstacle]]
name = "crate"
shape = "polygon"
vertices_m = [[10.0, -5.0], [11.0, -5.0], [11.0, -4.0]]
height_m = 1.0

[[opening]]
name = "gap"
between = ["lower", "upper"]

[[option]]
name = "straight"
openings = ["gap"]
"#;

fn check(folder: &Path, text: &str, said: &[&str]) {
    let file = folder.join("spoiled.toml");
    std::fs::write(&file, text).expect("a temporary file");
    for command in ["world", "run"] {
        let output = cocarry(&[command, file.to_str().expect("UTF-8")]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{command}: {error}");
        assert!(output.stdout.is_empty(), "{command} printed something");
        assert!(error.starts_with("error: ") && !error.contains("panicked"), "{error}");
        for part in ["spoiled.toml"].iter().chain(said) {
            assert!(error.contains(part), "{part:?} is missing from: {error}");
        }
    }
}

/// Replaces the one place where `from` stands.
fn spoil(from: &str, to: &str, said: &[&str]) {
    assert_eq!(VALID.matches(from).count(), 1, "{from:?}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    check(folder.path(), &VALID.replace(from, to), said);
}

#[test]
fn the_world_that_is_spoiled_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("valid.toml");
    std::fs::write(&file, VALID).unwrap();
    let output = cocarry(&["world", file.to_str().unwrap()]);
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn a_missing_file() {
    let output = cocarry(&["world", "worlds/no-such-world.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let error = stderr(&output);
    assert!(error.contains("worlds/no-such-world.toml") && error.contains("environment-1"), "{error}");
    assert_eq!(error.matches("no such world").count(), 1, "{error}");
}

#[test]
fn a_folder_instead_of_a_file() {
    let output = cocarry(&["run", "worlds"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("worlds: cannot be read: "), "{}", stderr(&output));
}

#[test]
fn a_file_that_is_not_toml() {
    spoil("robot_width_m = 0.5", "robot_width_m = = 0.5", &["line 2"]);
}

#[test]
fn an_unknown_key() {
    spoil("robot_width_m = 0.5", "robot_width_m = 0.5\nrobot_colour = 3", &["robot_colour", "robot_width_m"]);
}

#[test]
fn a_missing_key() {
    spoil("robot_width_m = 0.5\n", "", &["robot_width_m"]);
}

#[test]
fn a_word_where_a_number_belongs() {
    spoil("radius_m = 0.5", "radius_m = \"wide\"", &["radius_m", "string"]);
}

#[test]
fn a_point_with_three_numbers() {
    spoil("start_m = [0.0, 0.0]", "start_m = [0.0, 0.0, 0.0]", &["start_m", "line 3"]);
}

#[test]
fn a_robot_without_width() {
    spoil("robot_width_m = 0.5", "robot_width_m = 0.0", &[":2:", "robot_width_m = 0", "0.001"]);
}

#[test]
fn a_negative_size() {
    spoil("radius_m = 0.5", "radius_m = -0.5", &["`pillar`", "radius_m = -0.5", ":25:"]);
}

#[test]
fn a_size_that_is_not_a_number() {
    let said = ["`lower`", "size_m[1] = NaN", ":11:"];
    spoil(
        "center_m = [3.0, -5.5]\nsize_m = [0.2, 10.0]",
        "center_m = [3.0, -5.5]\nsize_m = [0.2, nan]",
        &said,
    );
}

#[test]
fn a_coordinate_out_of_reach() {
    spoil("target_m = [6.0, 0.0]", "target_m = [inf, 0.0]", &["target_m[0] = inf", ":4:"]);
}

#[test]
fn an_object_without_mass() {
    spoil("mass_kg = 6.0", "mass_kg = 0.0", &[":9:", "object", "mass_kg = 0", "0.1 to 40"]);
    spoil("mass_kg = 6.0\n", "", &["mass_kg"]);
    spoil("mass_kg = 6.0", "mass_kg = nan", &["mass_kg = NaN"]);
}

#[test]
fn an_object_of_the_wrong_size() {
    let size = "size_m = [1.6, 0.6, 0.04]";
    spoil(size, "size_m = [0.2, 0.6, 0.04]", &[":8:", "object", "size_m[0] = 0.2", "0.3 to 4"]);
    spoil(size, "size_m = [1.6, 1.6, 0.04]", &[":8:", "size_m[1] = 1.6", "0.02 to 1"]);
    spoil(size, "size_m = [1.6, 0.6, inf]", &[":8:", "size_m[2] = inf", "0.02 to 1"]);
    spoil(size, "size_m = [1.6, 0.6]", &["size_m", "three values, found 2"]);
}

#[test]
fn an_object_of_an_unknown_shape() {
    spoil("shape = \"board\"", "shape = \"sofa\"", &["sofa", "beam", "box", "board"]);
    spoil("shape = \"board\"", "shape = \"board\"\ncolour = 1", &["colour", "mass_kg"]);
}

#[test]
fn an_unknown_shape() {
    spoil("shape = \"cylinder\"", "shape = \"sphere\"", &["sphere", "cylinder", "polygon"]);
}

#[test]
fn a_shape_without_its_size() {
    spoil("radius_m = 0.5\n", "", &["`pillar`", "a cylinder needs radius_m"]);
}

#[test]
fn a_shape_with_another_shapes_size() {
    spoil("radius_m = 0.5", "radius_m = 0.5\nsize_m = [1, 1]", &["`pillar`", "a cylinder takes no size_m"]);
}

#[test]
fn a_polygon_whose_outline_crosses_itself() {
    let star = "vertices_m = [[10, -5], [12, -4], [10, -3], [11.5, -5.5], [11.5, -2.5]]";
    spoil(
        "vertices_m = [[10.0, -5.0], [11.0, -5.0], [11.0, -4.0]]",
        star,
        &["`crate`", "crosses or touches"],
    );
}

#[test]
fn a_polygon_with_all_corners_on_a_line() {
    let flat = "vertices_m = [[10, -5], [12, -5], [11, -5], [10, -5]]";
    spoil("vertices_m = [[10.0, -5.0], [11.0, -5.0], [11.0, -4.0]]", flat, &["`crate`", "on one line"]);
}

#[test]
fn a_polygon_with_two_corners() {
    let line = "vertices_m = [[10.0, -5.0], [11.0, -5.0]]";
    spoil("vertices_m = [[10.0, -5.0], [11.0, -5.0], [11.0, -4.0]]", line, &["`crate`", "2 corners"]);
}

#[test]
fn two_obstacles_of_one_name() {
    spoil("name = \"upper\"", "name = \"lower\"", &["obstacle `lower`", "duplicate name", ":18:"]);
}

#[test]
fn an_opening_at_an_unknown_obstacle() {
    let said = ["opening `gap`", "unknown obstacle `uper`", "`upper`"];
    spoil("between = [\"lower\", \"upper\"]", "between = [\"lower\", \"uper\"]", &said);
}

#[test]
fn an_opening_between_an_obstacle_and_itself() {
    let said = ["opening `gap`", "`lower` twice"];
    spoil("between = [\"lower\", \"upper\"]", "between = [\"lower\", \"lower\"]", &said);
}

#[test]
fn an_unknown_opening() {
    spoil(
        "openings = [\"gap\"]",
        "openings = [\"gape\"]",
        &["option `straight`", "unknown opening `gape`", "`gap`"],
    );
}

#[test]
fn an_impassable_opening() {
    let said = ["opening `gap`", "`lower`", "`upper`", "0.4000 m", "0.5 m", "impassable"];
    spoil("center_m = [3.0, 5.5]", "center_m = [3.0, 4.9]", &said);
}

#[test]
fn an_opening_with_an_obstacle_in_it() {
    let said = ["opening `gap`", "`pillar`", "0.3000 m"];
    spoil("center_m = [10.0, 5.0]\nradius_m = 0.5", "center_m = [3.4, 0.0]\nradius_m = 0.1", &said);
}

#[test]
fn a_start_inside_an_obstacle() {
    let said = ["start_m", "(3, 2)", "`upper`", "inside", ":3:"];
    spoil("start_m = [0.0, 0.0]", "start_m = [3.0, 2.0]", &said);
}

#[test]
fn a_target_too_near_to_an_obstacle() {
    let said = ["target_m", "(3.3, 2)", "0.2000 m", "`upper`", "0.25 m"];
    spoil("target_m = [6.0, 0.0]", "target_m = [3.3, 2.0]", &said);
}

#[test]
fn a_target_that_cannot_be_reached() {
    let wall = |name: &str, x: f64, y: f64, sx: f64, sy: f64| {
        format!(
            "\n[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [{x}, {y}]\nsize_m = [{sx}, {sy}]\nheight_m = 1.0\n"
        )
    };
    let open = &VALID[..VALID.find("[[opening]]").unwrap()];
    let closed = open.to_owned()
        + &wall("west", 5.0, 0.0, 0.1, 2.0)
        + &wall("east", 7.0, 0.0, 0.1, 2.0)
        + &wall("north", 6.0, 1.0, 2.1, 0.1)
        + &wall("south", 6.2, -1.0, 1.6, 0.1);
    let folder = tempfile::tempdir().unwrap();
    check(folder.path(), &closed, &["(6, 0)", "cannot be reached", "`west`", "`south`", "0.35"]);
}

#[test]
fn an_option_that_is_not_walkable() {
    let text = std::fs::read_to_string(repository("worlds/environment-1.toml")).unwrap();
    let spoiled = text.replace("openings = [\"xi3\"]", "openings = [\"xi4\"]");
    assert_ne!(text, spoiled);
    let folder = tempfile::tempdir().unwrap();
    check(folder.path(), &spoiled, &["option `4`", "from the start to opening `xi4`", "0.25 m"]);
}

#[test]
fn an_option_limit_of_nothing() {
    let text = std::fs::read_to_string(repository("worlds/free-form.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let spoiled = text.replace("option_limit = 8", "option_limit = 0");
    check(folder.path(), &spoiled, &["option_limit = 0", "1 to 64"]);
}

#[test]
fn numbers_on_the_command_line() {
    let cases: [(&[&str], &str); 13] = [
        (&["run", "--alpha", "70"], "at most 10"),
        (&["world", "environment-1", "--risk-weight", "1e300"], "from 0 to 1000000"),
        (&["run", "--eta", "0"], "greater than 0"),
        (&["run", "--eta", "nan"], "greater than 0"),
        (&["run", "--alpha", "-1"], "--alpha"),
        (&["run", "--gamma", "inf"], "greater than 0"),
        (&["run", "--initial-stubbornness", "1.5"], "at most 1"),
        (&["run", "--seed", "first"], "--seed"),
        (&["run", "--belief-alpha", "uniform(0.9,0.5)"], "0.9"),
        (&["run", "--belief-alpha", "uniform(1e-308,1e308)"], "0 < lower < upper <= 10"),
        (&["run", "--belief-gamma", "normal(1,1,0.5,10.5)"], "0 < lower < upper <= 10"),
        (&["run", "--ticks", "ticks.txt"], ".csv or .jsonl"),
        (&["reproduce", "h2", "--threads", "0"], "--threads"),
    ];
    for (arguments, said) in cases {
        let output = cocarry(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn samples_that_are_wrong_are_named_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("samples.csv");
    let cases = [
        ("alpha,gamma\n0.7,high\n", "line: 2"),
        ("alpha,delta\n0.7,0.8\n", "gamma"),
        ("alpha,gamma\n0.7,0.8\n0.7,-0.8\n", "-0.8"),
        ("alpha,gamma\n0.7,0.8\n1e308,0.8\n", "alpha and gamma at most 10"),
        ("alpha,gamma\n", "samples.csv"),
    ];
    for (text, said) in cases {
        std::fs::write(&file, text).unwrap();
        let output = cocarry(&["run", "--belief-samples", file.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{text:?}");
        let error = stderr(&output);
        assert!(error.contains("samples.csv") && error.contains(said), "{text:?}: {error}");
    }
}

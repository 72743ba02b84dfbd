//! One case a fault in a robot file: a valid robot with one thing spoiled. The error must say what is wrong,
//! with names and numbers.

use crate::spoiled_robot::{Files, TOML, URDF, check, toml, urdf};
use crate::support::random_configuration;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

#[test]
fn the_robot_that_is_spoiled_is_valid() {
    for name in [TOML, URDF] {
        let files = Files::new();
        let robot = files.load(name).expect("a valid robot");
        let file = &robot.texts.file;
        assert!(file.ends_with("carrier.toml"), "{file}");
    }
    // older versions of xacro leave their namespace behind, and all leave comments
    let left = "<robot name=\"carrier\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><!-- <xacro:wheel r=\"${r}\"/> -->";
    Files::new().with(URDF, "<robot name=\"carrier\">", left).load(TOML).expect("a valid robot");
}

#[test]
fn files_that_are_missing_or_of_another_kind() {
    let files = Files::new();
    check(files.load_as_is("none.toml"), &["none.toml: cannot be read: No such file"]);
    check(files.load_as_is("none.urdf"), &["none.toml: cannot be read"]);
    check(files.load_as_is("carrier.yaml"), &["carrier.yaml", ".toml", ".urdf"]);
    check(files.load_as_is(""), &[".toml", ".urdf"]);
    std::fs::create_dir(files.folder.path().join("folder.toml")).expect("a folder");
    check(files.load_as_is("folder.toml"), &["folder.toml: cannot be read: "]);
}

#[test]
fn a_robot_file_that_names_a_missing_urdf() {
    let files = Files::new().with(TOML, "urdf = \"carrier.urdf\"", "urdf = \"other.urdf\"");
    files.says(&["other.urdf: cannot be read: No such file"]);
    let here = ["carrier.toml:2: urdf = \"other.urdf\"", "carrier.urdf, which was asked for"];
    check(files.load(URDF), &here);
}

#[test]
fn a_urdf_without_a_robot_file() {
    let files = Files::new();
    std::fs::write(files.folder.path().join("alone.urdf"), &files.urdf).expect("a file");
    let said = ["alone.urdf: needs a robot file next to it", "alone.toml", "grasp_frame", "[[posture]]"];
    check(files.load_as_is("alone.urdf"), &said);
}

#[test]
fn xacros() {
    let hint = ["robot.urdf.xacro: a xacro, not a URDF", "xacro ", "robot.urdf.xacro > ", "robot.urdf`"];
    check(Files::new().load("robot.urdf.xacro"), &hint);
    let named = Files::new().with(TOML, "urdf = \"carrier.urdf\"", "urdf = \"robot.urdf.xacro\"");
    named.says(&hint);
    let property = "<robot name=\"carrier\"><xacro:property name=\"r\" value=\"0.06\"/>";
    urdf(
        "<robot name=\"carrier\">",
        property,
        &["a xacro, not a URDF", "carrier.urdf > ", "carrier.expanded.urdf"],
    );
    urdf(
        "<box size=\"0.09 0.13 0.07\"/></geometry>\n      <material",
        "<box size=\"${w} 0.13 0.07\"/></geometry>\n      <material",
        &["a xacro, not a URDF"],
    );
}

#[test]
fn files_that_are_not_what_they_should_be() {
    toml("base_width_m = 0.5", "base_width_m = = 0.5", &["not a valid robot file: ", "line 7"]);
    toml(
        "base_width_m = 0.5",
        "base_width_m = 0.5\ncolour = 1",
        &["not a valid robot file", "colour", "grasp_frame"],
    );
    toml("base_width_m = 0.5", "base_width_m = \"wide\"", &["line 7", "string"]);
    toml("base_width_m = 0.5\n", "", &["base_width_m"]);
    urdf("velocity=\"1.256\"", "velocity=1.256", &["not a valid URDF: "]);
    let empty = "<robot name=\"r\"/>".to_owned();
    Files { urdf: empty, ..Files::new() }.says(&["carrier.urdf: robot: missing links"]);
    let within = |text: String| format!("<robot>{text}</robot>");
    let deep = within("<a>".repeat(100_000) + &"</a>".repeat(100_000));
    Files { urdf: deep, ..Files::new() }.says(&["depth of its elements = 65", "at most 64"]);
    // quotes that hide the nesting from those who do not parse
    let quoted = within("<a b=\"/>\">".repeat(30_000) + &"</a>".repeat(30_000));
    Files { urdf: quoted, ..Files::new() }.says(&["depth of its elements = 65", "at most 64"]);
    let wide = format!("<robot name=\"r\">{}</robot>", "<link/>".repeat(50_000));
    Files { urdf: wide, ..Files::new() }.says(&["number of its elements = 50001", "at most 50000"]);
    // the parser copies all namespaces into every element
    let spaces: String = (0..20_000).map(|i| format!(" xmlns:n{i}=\"n{i}\"")).collect();
    let spaces = format!("<robot name=\"r\"{spaces}>{}</robot>", "<link/>".repeat(20_000));
    Files { urdf: spaces, ..Files::new() }.says(&["number of a tag's attributes = 20001", "at most 64"]);
    let element: String = (0..50).map(|i| format!(" xmlns:n{i}=\"n{i}\"")).collect();
    let spaces = within(format!("<a{element}/>").repeat(21));
    Files { urdf: spaces, ..Files::new() }.says(&["number of its namespaces = 1050", "at most 1000"]);
    // every shape is known by its link's name
    let named =
        within(format!("<link name=\"{}\">{}</link>", "n".repeat(1_000_000), "<visual/>".repeat(20_000)));
    Files { urdf: named, ..Files::new() }.says(&[":1: link: link name has 1000000 bytes", "at most 4096"]);
}

#[test]
fn names_that_nothing_has() {
    let base = ["base_link: unknown link `bass_link`", ":3:", "`base_link`, ", "and 5 more"];
    toml("base_link = \"base_link\"", "base_link = \"bass_link\"", &base);
    toml("= \"grasp_link\"", "= \"grip\"", &["grasp_frame: unknown link `grip`", ":4:"]);
    toml("= \"left_wheel_joint\"", "= \"left_wheel\"", &["left_wheel: unknown joint `left_wheel`", ":5:"]);
    toml("= \"right_wheel_joint\"", "= \"wheel\"", &["right_wheel: unknown joint `wheel`", ":6:"]);
}

#[test]
fn numbers_of_the_robot_file() {
    for (value, said) in
        [("0.0", "= 0;"), ("-1.0", "= -1;"), ("11.0", "= 11;"), ("nan", "= NaN;"), ("inf", "= inf;")]
    {
        let said = [":7: robot: base_width_m", said, "greater than 0 and at most 10"];
        toml("base_width_m = 0.5", &format!("base_width_m = {value}"), &said);
    }
    toml("grasp_height_m = 0.7", "grasp_height_m = 3.5", &[":8:", "grasp_height_m = 3.5", "from 0 to 3"]);
    let radius = "grasp_height_m = 0.7\nwheel_radius_m = 0.0";
    toml("grasp_height_m = 0.7", radius, &[":9:", "wheel_radius_m = 0", "greater than 0"]);
    let elbow = ["posture `elbow-up`", ":17:", "elbow_flex_joint = NaN", "(degrees)"];
    toml("elbow_flex_joint = 95.527315", "elbow_flex_joint = nan", &elbow);
    toml("elbow_flex_joint = 95.527315", "elbow_flex_joint = 1e300", &["elbow_flex_joint = 1", "3600"]);
}

/// Every fault has its line, the key and what is expected.
#[test]
fn footprints_that_are_no_outline_of_a_base() {
    let corner = "[0.3, 0.2]";
    let many = format!("[{}]", [corner; 65].join(", "));
    for (value, said) in [
        ("\"colision\"", ["base_footprint = \"colision\"", "it must be \"collision\", or a list of corners"]),
        ("0.5", ["base_footprint = 0.5", "[[x, y], ...] in metres"]),
        ("[[0.3, 0.2], [0.3, -0.2]]", ["base_footprint has 2 corners", "3 to 64"]),
        (many.as_str(), ["base_footprint has 65 corners", "3 to 64"]),
        ("[[0.3, 0.2], [0.3, -0.2], [0.3]]", ["base_footprint[2] = [0.3]", "a corner [x, y] in metres"]),
        (
            "[[0.3, 0.2], [0.3, -0.2], [-0.3, \"0\"]]",
            ["base_footprint[2] = [-0.3, \"0\"]", "a corner [x, y]"],
        ),
        ("[0.3, 0.2, 0.4]", ["base_footprint[0] = 0.3", "a corner [x, y] in metres"]),
        ("[[0.3, 0.2], [0.3, nan], [-0.3, 0]]", ["base_footprint[1][1] = NaN", "from -10 to 10 (metres)"]),
        ("[[0.3, 0.2], [0.3, -0.2], [-inf, 0]]", ["base_footprint[2][0] = -inf", "from -10 to 10 (metres)"]),
        ("[[0.3, 0.2], [30, -0.2], [-0.3, 0]]", ["base_footprint[1][0] = 30", "from -10 to 10 (metres)"]),
        (
            "[[-0.3, 0], [0, 0.001], [0.3, 0]]",
            ["is 0.0010 m across where it is narrowest", "at least 0.01 m"],
        ),
        ("[[0, 0], [0, 0], [0, 0]]", ["is 0.0000 m across where it is narrowest", "at least 0.01 m"]),
        (
            "[[0.1, 0.2], [0.1, -0.2], [0.6, 0]]",
            ["from x = 0.100 to 0.600 and y = -0.200 to 0.200 m", "the middle of the drive (0, 0) inside"],
        ),
    ] {
        let given = format!("base_width_m = 0.5\nbase_footprint = {value}");
        toml("base_width_m = 0.5", &given, &[&[":8: robot: "], said.as_slice()].concat());
    }
    let bare = Files::new().without_base_shapes();
    let given = "base_width_m = 0.5\nbase_footprint = \"collision\"";
    bare.with(TOML, "base_width_m = 0.5", given).says(&[
        ":8: robot: base_footprint = \"collision\"",
        "`base_link` has no collision shape",
        "corners [[x, y], ...] in metres",
    ]);
}

#[test]
fn postures_that_are_not_complete() {
    toml("name = \"elbow-out\"", "name = \"elbow-up\"", &["posture `elbow-up`", "duplicate name", ":23:"]);
    toml(
        "elbow_flex_joint = 95.527315\n",
        "",
        &["posture `elbow-up`", "missing `elbow_flex_joint`", "angles_deg"],
    );
    let unknown = ["`elbow-up`", "`elbow_flex`", "`elbow_flex_joint`"];
    toml("elbow_flex_joint = 95.527315", "elbow_flex = 95.5", &unknown);
    let slides = "[posture.positions_m]\nwrist_flex_joint = -1.0\n#";
    let unit = ["`elbow-up`", "`wrist_flex_joint` is revolute", "angles_deg"];
    toml("wrist_flex_joint = -61.556035", slides, &unit);
    let mut files = Files::new();
    files.toml.truncate(files.toml.find("# The arm in").expect("the first posture"));
    files.says(&["carrier.toml: robot: missing a [[posture]]"]);
}

#[test]
fn postures_that_do_not_hold_the_object_as_they_must() {
    let far = ["`elbow-up`", "tilted by 45.53 deg", "grasp_height_m = 0.7 m", "would have to move", "0.2"];
    toml("elbow_flex_joint = 95.527315", "elbow_flex_joint = 50.0", &far);
    let high =
        ["`elbow-up`", "0.7000 m above the floor", "grasp_height_m = 2.9 m", "no angles near the given ones"];
    toml("grasp_height_m = 0.7", "grasp_height_m = 2.9", &high);
    let heading = ["`elbow-up`", "turned by 30.00 deg"];
    toml("shoulder_pan_joint = 0.0", "shoulder_pan_joint = 30.0", &heading);
    let limit = [
        "carrier.toml:11: posture `elbow-up`",
        "`elbow_flex_joint` would have to be at 1.667",
        "from -2.251 to 1.5",
    ];
    Files::new()
        .with(URDF, "lower=\"-2.251\" upper=\"2.251\"", "lower=\"-2.251\" upper=\"1.5\"")
        .says(&limit);
}

#[test]
fn joints_that_are_held() {
    let hold = |entry: &str, said: &[&str]| {
        toml("# The arm in the", &format!("[hold]\n{entry}\n# The arm in the"), said);
    };
    hold("elbow = { angle_deg = 1 }", &[":11: hold `elbow`: unknown moving joint", "`elbow_flex_joint`"]);
    hold("left_wheel_joint = { angle_deg = 1 }", &["unknown moving joint", "`left_wheel_joint`"]);
    let beyond = ["hold `elbow_flex_joint`", "angle_deg = 150", "from -128.97", "to 128.97"];
    hold("elbow_flex_joint = { angle_deg = 150 }", &beyond);
    hold("elbow_flex_joint = { angle_deg = nan }", &["angle_deg = NaN"]);
    let unit = ["`elbow_flex_joint` is revolute; give its position as angle_deg"];
    hold("elbow_flex_joint = { position_m = 1 }", &unit);
    hold("elbow_flex_joint = {}", &unit);
    hold("elbow_flex_joint = { angle_deg = 1, position_m = 1 }", &unit);
    hold("elbow_flex_joint = { angle_rad = 1 }", &["not a valid robot file", "angle_rad"]);
    let mimic = "<mimic joint=\"elbow_flex_joint\"/><axis xyz=\"0 1 0\"/>";
    Files::new()
        .within("name=\"wrist_flex_joint\"", "<axis xyz=\"0 1 0\"/>", mimic)
        .with(TOML, "# The arm in the", "[hold]\nwrist_flex_joint = { angle_deg = 1 }\n# The arm in the")
        .says(&["carrier.toml:11: hold `wrist_flex_joint`", "mimics `elbow_flex_joint`"]);
}

/// Whatever stands in the two files, they make a robot or are refused.
#[test]
fn property_no_bytes_and_no_numbers_make_a_robot_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let values =
        ["0", "-1", "1e-9", "0.06", "1.5", "-0.2", "3.2", "1e5", "nan", "inf", "-inf", "1e300", "1e-300"];
    let (mut robots, mut refused) = (0, 0);
    for case in 0..400 {
        let mut files = Files::new();
        let text = if case % 4 == 0 { &mut files.toml } else { &mut files.urdf };
        if case % 2 == 0 {
            let mut bytes = std::mem::take(text).into_bytes();
            let at = rng.random_range(0..bytes.len());
            bytes[at] = rng.random_range(0..128);
            *text = String::from_utf8(bytes).expect("ASCII");
        } else {
            let spots = number_spots(text);
            let (from, to) = spots[rng.random_range(0..spots.len())];
            text.replace_range(from..to, values[rng.random_range(0..values.len())]);
        }
        match files.load(TOML) {
            Err(error) => {
                assert!(error.contains("carrier."), "{error}");
                refused += 1;
            }
            Ok(robot) => {
                let q = random_configuration(&robot, &mut rng);
                assert!(robot.kinematics(&q).jacobian.iter().all(|x| x.is_finite()));
                assert!(
                    robot.link_poses(&q).iter().all(|p| p.translation.vector.iter().all(|x| x.is_finite()))
                );
                robots += 1;
            }
        }
    }
    assert!(robots > 50 && refused > 50, "{robots} robots, {refused} refused");
}

/// From where to where numbers stand.
fn number_spots(text: &str) -> Vec<(usize, usize)> {
    let is_digit = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let starts = text.match_indices(['"', ' ']).map(|(at, _)| at + 1);
    starts
        .filter(|&at| text[at..].starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        .map(|at| (at, at + text[at..].find(|c| !is_digit(c)).unwrap_or(0)))
        .filter(|(from, to)| to > from)
        .collect()
}

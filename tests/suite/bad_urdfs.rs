//! One case a fault in a URDF: a valid robot with one thing spoiled. The error must say what is wrong, with
//! names and numbers.

use crate::spoiled_robot::{Files, TOML, URDF, item, toml, urdf};

#[test]
fn links_that_are_not_one_tree() {
    let duplicate = ["link `torso_link`", "duplicate name", "every link"];
    urdf("<link name=\"grasp_link\"/>", "<link name=\"grasp_link\"/><link name=\"torso_link\"/>", &duplicate);
    let duplicate = ["joint `torso_joint`", "duplicate name", "every joint"];
    urdf("<joint name=\"gripper_joint\"", "<joint name=\"torso_joint\"", &duplicate);
    item(
        "torso_joint",
        "parent link=\"base_link\"",
        "parent link=\"bass_link\"",
        &["unknown link `bass_link`", "`base_link`"],
    );
    let parents = ["link `torso_link`", "two joints, `torso_joint` and `gripper_joint`"];
    item("gripper_joint", "child link=\"gripper_link\"", "child link=\"torso_link\"", &parents);
    let lost = "<link name=\"grasp_link\"/><link name=\"lost\"/>";
    urdf("<link name=\"grasp_link\"/>", lost, &["link `lost`: has no parent, like `base_link`"]);
    let circle = "<link name=\"a\"/><link name=\"b\"/>
        <joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>
        <joint name=\"ba\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint>
        <link name=\"grasp_link\"/>";
    urdf("<link name=\"grasp_link\"/>", circle, &["link `a`: is its own ancestor"]);
}

#[test]
fn grasps_that_are_not_at_the_end_of_an_arm() {
    let grasp = "grasp_frame = \"grasp_link\"";
    toml(grasp, "grasp_frame = \"base_link\"", &[":4: link `base_link`: is the base link itself"]);
    toml(grasp, "grasp_frame = \"torso_link\"", &[":4: link `torso_link`", "no joint", "`base_link` moves"]);
    let base = "base_link = \"torso_link\"";
    Files::new()
        .with(TOML, "base_link = \"base_link\"", base)
        .within("name=\"left_wheel_joint\"", "parent link=\"base_link\"", "parent link=\"torso_link\"")
        .within("name=\"right_wheel_joint\"", "parent link=\"base_link\"", "parent link=\"torso_link\"")
        .with(TOML, grasp, "grasp_frame = \"front_caster_link\"")
        .says(&["link `front_caster_link`: does not descend from `torso_link`: its root is `base_link`"]);
}

#[test]
fn arms_with_too_many_joints() {
    let turns = "type=\"continuous\"><axis xyz=\"0 0 1\"/><limit effort=\"1\" velocity=\"1\"/>";
    Files::new()
        .within("name=\"torso_joint\"", "type=\"fixed\">", turns)
        .within("name=\"grasp_joint\"", "type=\"fixed\">", turns)
        .says(&["carrier.toml:4: link `grasp_link`", "9 joints", "more than 8", "[hold]", "`torso_joint`"]);
    // with those that mimic
    let mut links = String::new();
    for i in 0..10 {
        let (parent, child) = (i, i + 1);
        let parent = if i == 0 { "wrist_roll_link".to_owned() } else { format!("extra_{parent}") };
        links += &format!(
            "<link name=\"extra_{child}\"/><joint name=\"turn_{child}\" {turns}<parent link=\"{parent}\"/><child link=\"extra_{child}\"/><mimic joint=\"wrist_roll_joint\"/></joint>",
        );
    }
    Files::new()
        .within("name=\"grasp_joint\"", "wrist_roll_link", "extra_10")
        .with(URDF, "</robot>", &(links + "</robot>"))
        .says(&["link `grasp_link`", "17 joints move", "mimic", "more than 16"]);
}

#[test]
fn joints_that_an_arm_cannot_have() {
    for kind in ["floating", "planar", "spherical"] {
        item("elbow_flex_joint", "revolute", kind, &["is", kind, "revolute, continuous, prismatic or fixed"]);
    }
    let axis = ["length of axis xyz = 0", "greater than 0"];
    item("elbow_flex_joint", "xyz=\"0 1 0\"", "xyz=\"0 0 0\"", &axis);
}

#[test]
fn limits() {
    let elbow = "<limit lower=\"-2.251\" upper=\"2.251\" effort=\"66.18\" velocity=\"1.521\"/>";
    item("elbow_flex_joint", elbow, "", &["missing <limit>", "lower, upper and velocity"]);
    item("elbow_flex_joint", "lower=\"-2.251\"", "lower=\"3\"", &["invalid limits: lower 3", "upper 2.251"]);
    item("elbow_flex_joint", "lower=\"-2.251\"", "lower=\"2.251\"", &["invalid limits: lower 2.251"]);
    item("elbow_flex_joint", "velocity=\"1.521\"", "velocity=\"-1\"", &["limit velocity = -1", "at least 0"]);
    item("elbow_flex_joint", "effort=\"66.18\"", "effort=\"-5\"", &["limit effort = -5", "at least 0"]);
    item("elbow_flex_joint", "effort=\"66.18\"", "effort=\"NaN\"", &["limit effort = NaN"]);
    let robot = Files::new().within("name=\"elbow_flex_joint\"", "effort=\"66.18\"", "").load(TOML);
    assert_eq!(robot.expect("a valid robot").joints[3].effort_limit, f64::INFINITY);
}

#[test]
fn mimics() {
    let mimic = |who: &str| format!("type=\"revolute\"><mimic joint=\"{who}\"/>");
    let elbow = "elbow_flex_joint";
    item(
        elbow,
        "type=\"revolute\">",
        &mimic("elbow"),
        &["unknown joint to mimic `elbow`", "`shoulder_pan_joint`"],
    );
    item(
        elbow,
        "type=\"revolute\">",
        &mimic(elbow),
        &["mimics itself", "`elbow_flex_joint` follows `elbow_flex_joint`"],
    );
    Files::new()
        .within("name=\"elbow_flex_joint\"", "type=\"revolute\">", &mimic("wrist_flex_joint"))
        .within("name=\"wrist_flex_joint\"", "type=\"revolute\">", &mimic(elbow))
        .says(&["mimics itself", "`wrist_flex_joint` follows `elbow_flex_joint`"]);
    let wild = "type=\"revolute\"><mimic joint=\"wrist_flex_joint\" multiplier=\"nan\"/>";
    item(elbow, "type=\"revolute\">", wild, &["mimic multiplier = NaN"]);
    // the elbow stands where its master at 0 puts it, beyond its limits
    let still = "type=\"revolute\"><mimic joint=\"left_finger_joint\" offset=\"3\"/>";
    let said = ["position that it mimics", "= 3;", "from -2.251 to 2.251"];
    item(elbow, "type=\"revolute\">", still, &said);
    // the elbow would have to be within its limits while the wrist is within its own
    let apart = "type=\"revolute\"><mimic joint=\"wrist_flex_joint\" offset=\"10\"/>";
    let said = ["joint `wrist_flex_joint`, which `elbow_flex_joint` mimics", "invalid limits"];
    item(elbow, "type=\"revolute\">", apart, &said);
}

#[test]
fn wheels_that_do_not_fit() {
    let left = |from: &str, to: &str, said: &[&str]| {
        item("left_wheel_joint", from, to, &[&["not a wheel"], said].concat());
    };
    left("\"continuous\"", "\"fixed\"", &["is fixed", "continuous"]);
    left(
        "type=\"continuous\">",
        "type=\"continuous\"><mimic joint=\"right_wheel_joint\"/>",
        &["mimics `right_wheel_joint`"],
    );
    left(
        "parent link=\"base_link\"",
        "parent link=\"elbow_flex_link\"",
        &["`base_link` through", "which is revolute"],
    );
    left("axis xyz=\"0 1 0\"", "axis xyz=\"0.002 1 0\"", &["(0.0020, 1.0000, 0.0000)", "base's y"]);
    left("velocity=\"17.4\"", "velocity=\"0\"", &["limit velocity = 0", "greater than 0"]);
    left(
        "origin xyz=\"0 0.187 0.06\"",
        "origin xyz=\"0 -0.187 0.06\"",
        &["y = -0.1870 m", "left", "positive"],
    );
    let elsewhere =
        ["`left_wheel_joint`: not a wheel", "does not descend from `torso_link`; its root is `base_link`"];
    let files = Files::new().with(TOML, "base_link = \"base_link\"", "base_link = \"torso_link\"");
    files.says(&elsewhere);
    let arm = ["joint `left_wheel_joint`: not a wheel", "the grasp, `grasp_link`, descends from it"];
    Files::new()
        .within("name=\"torso_joint\"", "parent link=\"base_link\"", "parent link=\"left_wheel_link\"")
        .says(&arm);
    let right = |from: &str, to: &str, said: &[&str]| {
        item("right_wheel_joint", from, to, &[&["not a wheel"], said].concat());
    };
    let origin = "origin xyz=\"0 -0.187 0.06\"";
    right(origin, "origin xyz=\"0.002 -0.187 0.06\"", &["x in the base", "0.002", "same"]);
    right(origin, "origin xyz=\"0 -0.19 0.06\"", &["distance from the middle", "0.19", "0.187"]);
    right(origin, "origin xyz=\"0 -0.187 0.07\"", &["z in the base", "0.07", "0.06", "`left_wheel_joint`"]);
    right(origin, "origin xyz=\"0 0.187 0.06\"", &["y = 0.1870 m", "right", "negative"]);
    right("velocity=\"17.4\"", "velocity=\"17\"", &["limit velocity", "17.4", "same"]);
    let one = Files::new().with(TOML, "\"right_wheel_joint\"", "\"left_wheel_joint\"");
    one.says(&["joint `left_wheel_joint`", "right"]);
}

#[test]
fn wheels_that_cannot_be_measured() {
    let shape = "<cylinder radius=\"0.06\" length=\"0.04\"/>";
    let wheel = |changes: &[(&str, &str)]| {
        let mut files = Files::new();
        for (from, to) in changes {
            let start = files.urdf.find("<link name=\"left_wheel_link\">").expect("the wheel");
            let end = start + files.urdf[start..].find("</link>").expect("its end");
            let changed = files.urdf[start..end].replace(from, to);
            assert_ne!(changed, files.urdf[start..end], "{from}");
            files.urdf.replace_range(start..end, &changed);
        }
        files
    };
    let boxed = [(shape, "<box size=\"0.12 0.04 0.12\"/>")];
    let said = ["carrier.urdf:46: joint `left_wheel_joint`", "no cylinder or sphere", "wheel_radius_m"];
    wheel(&boxed).says(&said);
    let given = |files: Files, radius: &str| {
        files.with(TOML, "base_width_m = 0.5", &format!("base_width_m = 0.5\nwheel_radius_m = {radius}"))
    };
    assert!(given(wheel(&boxed), "0.06").load(TOML).is_ok());
    given(Files::new(), "0.07").says(&["radius is 0.06 m", "wheel_radius_m = 0.07", "10 %"]);
    let robot = given(Files::new(), "0.0605").load(TOML).expect("a valid robot");
    assert_eq!(robot.drive.wheel_radius, 0.0605);
    wheel(&[(shape, "<cylinder radius=\"0.05\" length=\"0.04\"/>")]).says(&[
        "radius (m) is 0.06",
        "0.05",
        "same",
    ]);
    let ball = [(shape, "<sphere radius=\"0.06\"/>")];
    assert!(wheel(&ball).load(TOML).is_ok());
    let turned = [("rpy=\"1.5707963267948966 0 0\"", "rpy=\"1.5 0 0\"")];
    wheel(&turned).says(&["its cylinder is 0.0000 m or 4.06 deg off"]);
    let off_axis = [("xyz=\"0 0 0\" rpy", "xyz=\"0.01 0 0\" rpy")];
    wheel(&off_axis).says(&["its cylinder is 0.0100 m or 0.00 deg off"]);
    // along its axis a wheel's middle may lie anywhere, if the other's does as well
    let inward = [("xyz=\"0 0 0\" rpy", "xyz=\"0 0.02 0\" rpy")];
    wheel(&inward).says(&["`right_wheel_joint`", "distance from the middle", "0.187", "0.207"]);
}

#[test]
fn numbers_that_cannot_be() {
    item("elbow_flex_joint", "xyz=\"0.133 0 0\"", "xyz=\"0.133 nan 0\"", &["origin xyz[1] = NaN"]);
    item(
        "elbow_flex_joint",
        "xyz=\"0.133 0 0\"",
        "xyz=\"0.133 0 0\" rpy=\"0 0 inf\"",
        &["origin rpy[2] = inf"],
    );
    item(
        "elbow_flex_joint",
        "xyz=\"0.133 0 0\"",
        "xyz=\"1e9 0 0\"",
        &["origin xyz[0] = 1000000000", "1000000"],
    );
    item("elbow_flex_joint", "lower=\"-2.251\"", "lower=\"nan\"", &["limit lower = NaN"]);
    item("elbow_flex_link", "mass value=\"2.1\"", "mass value=\"inf\"", &["mass = inf"]);
    item("elbow_flex_link", "mass value=\"2.1\"", "mass value=\"-2.1\"", &["mass = -2.1", "from 0"]);
    item("elbow_flex_link", "ixy=\"0\"", "ixy=\"nan\"", &["ixy = NaN"]);
    item(
        "elbow_flex_link",
        "ixy=\"0\"",
        "ixy=\"1\"",
        &["least principal moment of inertia = -0.9", "at least 0"],
    );
    item("elbow_flex_link", "length=\"0.2\"", "length=\"-1\"", &["visual 1: length = -1", "greater than 0"]);
    item(
        "gripper_link",
        "box size=\"0.09 0.13 0.07\"",
        "box size=\"0.09 -1 0.07\"",
        &["box size = -1", "greater than 0"],
    );
    // nothing at all is a frame, not a fault
    let none = Files::new()
        .within("name=\"gripper_link\"", "mass value=\"1.3\"", "mass value=\"0\"")
        .within("name=\"gripper_link\"", "ixx=\"0.00236167\"", "ixx=\"0\"")
        .within("name=\"gripper_link\"", "iyy=\"0.00140833\"", "iyy=\"0\"")
        .within("name=\"gripper_link\"", "izz=\"0.00270833\"", "izz=\"0\"")
        .load(TOML)
        .expect("a valid robot");
    assert!(none.links.iter().any(|l| l.name == "gripper_link" && l.inertial.is_none()));
}

#[test]
fn meshes_that_are_not_there() {
    for (mesh, looked) in [
        ("palm.stl", "palm.stl`"),
        ("package://demo_robot/palm.stl", "folders `demo_robot` at or above"),
        ("package://palm.stl", "package `palm.stl`"),
        ("file:///no/such/palm.stl", "`/no/such/palm.stl`"),
        ("https://example.org/palm.stl", "palm.stl`"),
    ] {
        let mesh_instead = format!("<mesh filename=\"{mesh}\"/>");
        let files =
            Files::new().within("name=\"gripper_link\"", "<box size=\"0.09 0.13 0.07\"/>", &mesh_instead);
        let robot = files.load(TOML).unwrap_or_else(|e| panic!("{e}"));
        let said = robot.warnings.iter().map(ToString::to_string).collect::<String>();
        for part in [&format!("the first of them `{mesh}`"), "searched for", looked] {
            assert!(said.contains(part), "{part} in {said}");
        }
    }
}

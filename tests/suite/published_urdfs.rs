//! URDFs as other people write them and other parsers read them: they are read with a note, or refused with the
//! link or joint, its line and what to do.

use crate::spoiled_robot::{Files, TOML, URDF, check, item, urdf};
use crate::support::{cocarry, stderr, stdout};
use cocarry::robot::{Draft, DraftRequest, DriveKind, Robot};
use std::path::Path;

fn said(robot: &Robot) -> String {
    robot.warnings.iter().map(|note| format!("{note}\n")).collect()
}

/// The robot, whose notes must contain all of these.
#[track_caller]
fn notes(files: &Files, parts: &[&str]) -> Robot {
    let robot = files.load(TOML).unwrap_or_else(|e| panic!("{e}"));
    let said = said(&robot);
    for part in parts {
        assert!(said.contains(part), "{part:?} is missing from: {said}");
    }
    robot
}

/// The carrier without a note.
fn plain() -> Robot {
    let robot = notes(&Files::new(), &[]);
    assert!(robot.warnings.is_empty(), "{}", said(&robot));
    robot
}

/// Arm, links, shapes and masses of two robots are equal.
#[track_caller]
fn are_equal(a: &Robot, b: &Robot) {
    assert_eq!(a.joints, b.joints);
    assert_eq!(a.links, b.links);
}

/// The line of the first `text` in the carrier's URDF.
fn line(text: &str) -> usize {
    let urdf = Files::new().urdf;
    1 + urdf[..urdf.find(text).expect("the text")].matches('\n').count()
}

#[test]
fn what_is_no_urdf_is_named_with_what_to_do() {
    let files = Files::new();
    let of = |bytes: &[u8], said: &[&str]| {
        let _ = files.load(TOML);
        let path = files.folder.path().join(URDF);
        std::fs::write(&path, bytes).expect("a file");
        check(files.load_as_is(TOML), &[&["carrier.urdf: is "], said].concat());
        let draft = Draft::new(&path, URDF, "d.toml", &DraftRequest::default()).expect_err("no URDF");
        assert!(draft.to_string().contains(said[0]), "{draft}");
    };
    of(b"<sdf version='1.6'><model name='m'/></sdf>", &["an SDF of Gazebo, not a URDF", "the URDF or xacro"]);
    of(b"<mujoco model='m'/>", &["an MJCF of MuJoCo, not a URDF", "convert it"]);
    of(b"<robot name='r'><group name='arm'><link name='a'/></group></robot>", &["an SRDF of MoveIt"]);
    of(b"#usda 1.0\n", &["a USD, not a URDF", "Isaac Sim"]);
    of(b"PXR-USDC\0\0", &["a USD, not a URDF"]);
    of(b"<!DOCTYPE html>\n<html><br><br></html>", &["a web page (HTML)", "fetch the file itself"]);
    of(
        b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
        &["a Git LFS pointer", "`git lfs pull`"],
    );
    of(b"", &["empty"]);
    of(b"<?xml version='1.0'?>\n", &["empty"]);
    of(b"PK\x03\x04", &["a zip archive", "unpack it"]);
    of(b"<launch><node/></launch>", &["a launch file of ROS"]);
    of(b"<model name='m'/>", &["not a URDF: its first element is <model>; expected <robot>"]);
    // by its name, too
    std::fs::write(files.folder.path().join("a.sdf"), "<sdf/>").expect("a file");
    check(files.load_as_is("a.sdf"), &["a.sdf: is an SDF of Gazebo", "expected a robot file (.toml)"]);
}

#[test]
fn a_file_that_was_cut_is_named_with_the_place() {
    let whole = Files::new().urdf;
    let cut = |at: usize, said: &[&str]| {
        let files = Files { urdf: whole[..at].to_owned(), ..Files::new() };
        files.says(&[&["the file ends here, before </robot>: it was cut"], said].concat());
    };
    let joint = whole.find("<joint name=\"elbow_flex_joint\"").expect("the joint");
    let place =
        format!("carrier.urdf:{}: joint `elbow_flex_joint`: ", line("<joint name=\"elbow_flex_joint\"") + 2);
    let within = joint + whole[joint..].find("<child").expect("its child") + 10;
    cut(within, &[&place]);
    cut(joint, &["carrier.urdf:"]);
    cut(whole.rfind("</robot>").expect("its end"), &["carrier.urdf:"]);
    cut(whole.find("<!-- The drive").expect("a comment") + 8, &["carrier.urdf:"]);
}

#[test]
fn texts_are_read_in_the_encoding_that_they_declare() {
    let plain = plain();
    let files = Files::new();
    let _ = files.load(TOML);
    let path = files.folder.path().join(URDF);
    let declared = |encoding: &str, name: &str| {
        let declaration = format!("<?xml version=\"1.0\" encoding=\"{encoding}\"?>");
        let text = files.urdf.replacen("<?xml version=\"1.0\"?>", &declaration, 1);
        text.replacen("name=\"carrier\"", &format!("name=\"{name}\""), 1)
    };
    let units = |text: String| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let bytes = |text: String| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    for bytes in [
        [vec![0xff, 0xfe], units(declared("UTF-16", "carrier é 机"))].concat(),
        units(declared("utf-16", "carrier")),
        bytes(declared("ISO-8859-1", "carrier é")),
        bytes(declared("windows-1252", "carrier é")),
        bytes(declared("GB2312", "carrier")),
        declared("UTF-8", "carrier 机").into_bytes(),
    ] {
        std::fs::write(&path, bytes).expect("a file");
        let robot = files.load_as_is(TOML).unwrap_or_else(|e| panic!("{e}"));
        are_equal(&robot, &plain);
        assert!(robot.warnings.is_empty(), "{}", said(&robot));
        // what a recording keeps is read again
        are_equal(&Robot::parse(&robot.texts).expect("a robot"), &plain);
    }
    // comments in another encoding than the declared one are common: two bytes of GB2312
    for encoding in ["UTF-8", "GB2312", "klingon"] {
        std::fs::write(&path, bytes(declared(encoding, "carrier \u{bb}\u{fa}"))).expect("a file");
        let robot = files.load_as_is(TOML).unwrap_or_else(|e| panic!("{e}"));
        are_equal(&robot, &plain);
        assert!(said(&robot).contains("what could not be read became U+FFFD"), "{}", said(&robot));
    }
}

/// The order of elements means nothing.
#[test]
fn shapes_may_stand_on_both_sides_of_the_inertial() {
    let shape = "<geometry><box size=\".1 .1 .1\"/></geometry>";
    let [visual, collision] = ["visual", "collision"].map(|kind| format!("<{kind}>{shape}</{kind}>"));
    let robots =
        [format!("{visual}{collision}@"), format!("{collision}@{visual}"), format!("@{visual}{collision}")]
            .map(|order| {
                let mut files = Files::new();
                let start = files.urdf.find("<link name=\"gripper_link\">").expect("the link") + 26;
                let end = start + files.urdf[start..].find("<visual>").expect("its shapes");
                let inertial = files.urdf[start..end].to_owned();
                files.urdf.replace_range(start..end, &order.replace('@', &inertial));
                let robot = files.load(TOML).unwrap_or_else(|e| panic!("{e}"));
                let link = robot.links.iter().find(|link| link.name == "gripper_link").expect("the link");
                assert_eq!((link.visuals.len(), link.inertial.is_some()), (2, true));
                robot
            });
    assert_eq!(robots[0].links.len(), robots[1].links.len());
    assert!(robots.iter().all(|robot| robot.warnings.is_empty()));
}

#[test]
fn of_elements_that_are_repeated_the_first_counts() {
    let plain = plain();
    let elbow = "<limit lower=\"-2.251\" upper=\"2.251\" effort=\"66.18\" velocity=\"1.521\"/>";
    let again = format!("{elbow}<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>");
    let place = format!("joint `elbow_flex_joint` (line {})", line(elbow));
    let files = Files::new().within("name=\"elbow_flex_joint\"", elbow, &again);
    let told = format!("{place}: has more than one <limit>; the first counts");
    are_equal(&notes(&files, &[&told]), &plain);
    let origin = "<origin xyz=\"0.133 0 0\"/>";
    let again = format!("{origin}<origin xyz=\"0.2 0 0\"/>");
    let files = Files::new().within("name=\"elbow_flex_joint\"", origin, &again);
    are_equal(&notes(&files, &["joint `elbow_flex_joint`", "more than one <origin>"]), &plain);
    let shapes = "<box size=\"0.09 0.13 0.07\"/>";
    let files =
        Files::new().within("name=\"gripper_link\"", shapes, &format!("{shapes}<sphere radius=\"1\"/>"));
    are_equal(&notes(&files, &["link `gripper_link`, visual 1", "more than one shape"]), &plain);
}

/// A first limit without a range locks its joint, as in other programs.
#[test]
fn a_joint_with_limits_of_0_stays_there() {
    let files = Files::new().within("name=\"upperarm_roll_joint\"", "continuous", "revolute");
    let _ = files.load(TOML);
    let path = files.folder.path().join(URDF);
    let draft = Draft::new(&path, URDF, "d.toml", &DraftRequest::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(draft.robot.joint_count(), 6);
    let said = said(&draft.robot);
    assert!(
        said.contains("joints of the arm have limits of 0, and stay there: `upperarm_roll_joint`"),
        "{said}"
    );
}

#[test]
fn shapes_without_a_size_are_left_out() {
    let plain = plain();
    let count = |robot: &Robot| {
        let link = robot.links.iter().find(|link| link.name == "grasp_link").expect("the link");
        link.visuals.len() + link.collisions.len()
    };
    for shape in [
        "<visual/>",
        "<visual><geometry/></visual>",
        "<collision><geometry><box size=\"0 0 0\"/></geometry></collision>",
        "<collision><geometry><cylinder radius=\"0\" length=\"0.1\"/></geometry></collision>",
        "<visual><geometry><sphere radius=\"0\"/></geometry></visual>",
        "<visual><geometry><plane normal=\"0 0 1\"/></geometry></visual>",
    ] {
        let link = format!("<link name=\"grasp_link\">{shape}</link>");
        let files = Files::new().with(URDF, "<link name=\"grasp_link\"/>", &link);
        let robot = notes(&files, &["shapes without a size are left out: link `grasp_link`, "]);
        assert_eq!(count(&robot), 0, "{shape}");
        are_equal(&robot, &plain);
    }
}

#[test]
fn a_mass_without_an_inertia_has_that_of_a_ball() {
    let inertia =
        "<inertia ixx=\"0.00236167\" ixy=\"0\" ixz=\"0\" iyy=\"0.00140833\" iyz=\"0\" izz=\"0.00270833\"/>";
    let robot = notes(
        &Files::new().within("name=\"gripper_link\"", inertia, ""),
        &["link `gripper_link`", "a mass without an inertia; a ball of 1000 kg/m^3"],
    );
    let link = robot.links.iter().find(|link| link.name == "gripper_link").expect("the link");
    let body = link.inertial.expect("a body");
    // 1.3 kg of water: a ball of 6.77 cm radius
    let radius = cocarry::math::pow(3.0 * body.mass / (4.0 * std::f64::consts::PI * 1000.0), 1.0 / 3.0);
    assert!((body.inertia[(0, 0)] - 0.4 * body.mass * radius * radius).abs() < 1e-12);
    assert!((radius - 0.0677).abs() < 1e-4);
    let mass = "<mass value=\"1.3\"/>";
    let robot = notes(
        &Files::new().within("name=\"gripper_link\"", mass, ""),
        &["link `gripper_link`", "without a mass, which is left out"],
    );
    assert!(robot.links.iter().any(|link| link.name == "gripper_link" && link.inertial.is_none()));
}

/// In kg mm^2, as some programs export it.
#[test]
fn an_inertia_in_other_units_is_told_with_its_density() {
    for inertia in ["2361.67", "2361670"] {
        let files =
            Files::new().within("name=\"gripper_link\"", "ixx=\"0.00236167\"", &format!("ixx=\"{inertia}\""));
        let robot =
            notes(&files, &["link `gripper_link`: 1.3 kg with an inertia of 2.362e", "kg/m^3", "kg mm^2"]);
        let link = robot.links.iter().find(|link| link.name == "gripper_link").expect("the link");
        assert!(link.inertial.expect("a body").inertia.amax() < 0.01);
    }
    item("gripper_link", "ixx=\"0.00236167\"", "ixx=\"inf\"", &["ixx = inf"]);
}

#[test]
fn joints_without_a_rate_limit_get_one_that_the_robot_file_may_set() {
    let roll = "<limit effort=\"29.35\" velocity=\"1.571\"/>";
    let without = |limit: &str| Files::new().within("name=\"forearm_roll_joint\"", roll, limit);
    let rate = |robot: &Robot| {
        robot.joints.iter().find(|joint| joint.name == "forearm_roll_joint").expect("the joint").rate_limit
    };
    for limit in [
        "",
        "<limit effort=\"29.35\"/>",
        "<limit effort=\"29.35\" velocity=\"0\"/>",
        "<limit effort=\"1\" velocity=\"1e16\"/>",
    ] {
        let told = "joints of the arm have no limit velocity in the URDF and move at 1 rad/s at most (arm_rate_limit_rad_s in the robot file): `forearm_roll_joint`";
        assert_eq!(rate(&notes(&without(limit), &[told])), 1.0);
    }
    let given = |files: Files, value: &str| {
        files.with(TOML, "base_width_m = 0.5", &format!("base_width_m = 0.5\narm_rate_limit_rad_s = {value}"))
    };
    assert_eq!(rate(&notes(&given(without(""), "2.5"), &["move at 2.5 rad/s at most"])), 2.5);
    let idle = notes(&given(Files::new(), "2.5"), &["arm_rate_limit_rad_s changes nothing"]);
    assert_eq!(rate(&idle), 1.571);
    given(without(""), "0.0").says(&[":8: robot: arm_rate_limit_rad_s = 0", "greater than 0"]);
    let elbow = Files::new().within("name=\"elbow_flex_joint\"", "velocity=\"1.521\"", "velocity=\"0\"");
    notes(&elbow, &["move at 1 rad/s at most", "`elbow_flex_joint`"]);
}

/// What nobody uses is told and refuses nothing; the same of a joint that is used is refused.
#[test]
fn values_that_nobody_uses_refuse_nothing() {
    let caster = |joint: &str| {
        let link = "<link name=\"idle\"/><joint name=\"idle_joint\" type=\"@\">"
            .replace('@', joint.split('|').next().unwrap_or(""));
        format!(
            "{link}<parent link=\"base_link\"/><child link=\"idle\"/>{}</joint></robot>",
            joint.split('|').nth(1).unwrap_or("")
        )
    };
    for joint in [
        "continuous|<limit effort=\"-1\" velocity=\"fast\"/>",
        "revolute|<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>",
        "revolute|<axis xyz=\"0 0 0\"/><limit lower=\"nan\" upper=\"1\" effort=\"1\" velocity=\"-1\"/>",
    ] {
        let robot = notes(
            &Files::new().with(URDF, "</robot>", &caster(joint)),
            &["joint `idle_joint`", "nothing uses it"],
        );
        assert_eq!(robot.joints, plain().joints);
    }
    for joint in [
        "fixed|<axis xyz=\"0 0\"/><limit lower=\"a\"/>",
        "floating|<limit effort=\"x\"/>",
        "continuous|<limit lower=\"1e16\" upper=\"-1e16\" effort=\"1\" velocity=\"1\"/>",
    ] {
        let robot = notes(&Files::new().with(URDF, "</robot>", &caster(joint)), &[]);
        assert!(robot.warnings.is_empty(), "{joint}: {}", said(&robot));
    }
    // limits of 1e16 are none
    let free = "lower=\"-1e16\" upper=\"1e16\"";
    let elbow = Files::new().within("name=\"elbow_flex_joint\"", "lower=\"-2.251\" upper=\"2.251\"", free);
    let robot = notes(&elbow, &["have no lower and upper limit, and move freely: `elbow_flex_joint`"]);
    assert_eq!([robot.joints[3].lower, robot.joints[3].upper], [f64::NEG_INFINITY, f64::INFINITY]);
    // a colour is only seen
    let colour = Files::new().with(URDF, "rgba=\"0.92 0.92 0.9 1\"", "rgba=\"235 235 230 1\"");
    notes(&colour, &["material `white`", "has no colour", "4 numbers from 0 to 1"]);
}

#[test]
fn errors_name_the_link_or_joint_and_its_line() {
    let place = |name: &str| format!("carrier.urdf:{}: ", line(&format!("name=\"{name}\"")));
    let elbow = place("elbow_flex_joint");
    item("elbow_flex_joint", "lower=\"-2.251\"", "lower=\"3\"", &[&elbow, "invalid limits"]);
    item("elbow_flex_joint", "velocity=\"1.521\"", "velocity=\"-1\"", &[&elbow, "limit velocity = -1"]);
    item(
        "elbow_flex_joint",
        "velocity=\"1.521\"",
        "velocity=\"1,5\"",
        &["limit velocity = \"1,5\"; it must be a number"],
    );
    item(
        "elbow_flex_joint",
        "xyz=\"0.133 0 0\"",
        "xyz=\"0.133 0\"",
        &["origin xyz = \"0.133 0\"; it must be 3 numbers, separated by spaces"],
    );
    item(
        "elbow_flex_joint",
        "revolute",
        "revolut",
        &[&elbow, "unknown type `revolut`", "did you mean `revolute`?"],
    );
    item("elbow_flex_joint", "<child link=\"elbow_flex_link\"/>", "", &[&elbow, "missing <child>"]);
    item(
        "elbow_flex_link",
        "mass value=\"2.1\"",
        "mass value=\"-2.1\"",
        &[&place("elbow_flex_link"), "mass = -2.1"],
    );
    let visual = line("name=\"elbow_flex_link\"");
    let urdf = Files::new().urdf;
    let at = urdf.lines().skip(visual).position(|text| text.contains("<visual>")).expect("its shape");
    let visual = format!("carrier.urdf:{}: link `elbow_flex_link`, visual 1: ", visual + at + 1);
    item("elbow_flex_link", "length=\"0.2\"", "length=\"-1\"", &[&visual, "length = -1"]);
    // what is no XML
    let elbow = "<joint name=\"elbow_flex_joint\" type=\"revolute\">";
    let spoiled = elbow.replace("type=", "type");
    crate::spoiled_robot::urdf(
        elbow,
        &spoiled,
        &[&format!("carrier.urdf:{}: joint `elbow_flex_joint`: not a valid URDF", line(elbow))],
    );
}

#[test]
fn names_that_a_urdf_does_not_have_are_told() {
    let told = |from: &str, to: &str, parts: &[&str]| {
        notes(&Files::new().within("name=\"elbow_flex_joint\"", from, to), parts);
    };
    told(
        "xyz=\"0.133 0 0\"",
        "xyz=\"0.133 0 0\" rpy_deg=\"0 0 0\"",
        &["joint `elbow_flex_joint` (line ", "an attribute `rpy_deg` of <origin>", "did you mean `rpy`?"],
    );
    told("effort=\"66.18\"", "effort=\"66.18\" velocty=\"1\"", &["did you mean `velocity`?"]);
    told("<axis", "<limits lower=\"0\"/><axis", &["an element <limits>", "did you mean <limit>?"]);
    // other programs use these
    told("<axis", "<dynamics damping=\"1\"/><safety_controller k_velocity=\"1\"/><axis", &[]);
    let urdf =
        Files::new().with(URDF, "</robot>", "<gazebo reference=\"base_link\"/><transmission/></robot>");
    assert!(notes(&urdf, &[]).warnings.is_empty());
}

/// Parsers that know no namespaces, and none of the rules about comments, read all of these.
#[test]
fn xml_that_is_not_strict_is_read() {
    let plain = plain();
    for (from, to) in [
        ("<?xml version=\"1.0\"?>", "<!-- first --><?xml version=\"1.0\"?>"),
        ("<?xml version=\"1.0\"?>", "<?xml version=\"1.0\"?><!-- a -- b --- -->"),
        ("<?xml version=\"1.0\"?>", "<?xml version=\"1.0\"?><!DOCTYPE robot>"),
        ("</robot>", "<controller:arm joint=\"a\"/></robot>"),
        ("<robot name=\"carrier\">", "<robot xmlns=\"http://drake.mit.edu\" name=\"carrier\">"),
        ("<robot name=\"carrier\">", "<robot>"),
    ] {
        let robot = notes(&Files::new().with(URDF, from, to), &[]);
        are_equal(&robot, &plain);
        assert!(robot.warnings.is_empty(), "{to}: {}", said(&robot));
    }
    let entity = "<?xml version=\"1.0\"?><!DOCTYPE r [<!ENTITY b \"c\">]>";
    urdf("<?xml version=\"1.0\"?>", entity, &["a document type declaration with definitions"]);
}

/// Values that are hardly meant, each with its likely cause.
#[test]
fn values_in_other_units_are_told() {
    let link = |from: &str, to: &str, parts: &[&str]| {
        notes(&Files::new().within("name=\"elbow_flex_link\"", from, to), parts);
    };
    link(
        "mass value=\"2.1\"",
        "mass value=\"2100\"",
        &["mass that is hardly meant: `elbow_flex_link` (2100 kg)", "kg, not g"],
    );
    link(
        "radius=\"0.05\" length=\"0.2\"",
        "radius=\"50\" length=\"200\"",
        &["`elbow_flex_link` (100 x 100 x 200 m)", "in mm"],
    );
    link("izz=\"", "izz=\"1", &["an inertia that no body has", "`elbow_flex_link`"]);
    let joint = |from: &str, to: &str, parts: &[&str]| {
        notes(&Files::new().within("name=\"elbow_flex_joint\"", from, to), parts);
    };
    joint(
        "lower=\"-2.251\" upper=\"2.251\"",
        "lower=\"-129\" upper=\"129\"",
        &["`elbow_flex_joint` (129 rad)", "rad, not degrees"],
    );
    joint(
        "effort=\"66.18\"",
        "effort=\"0\"",
        &["have no limit effort in the URDF, or 0", "`elbow_flex_joint`"],
    );
}

/// A box of 2 as an OBJ file, in the folder of the files.
fn write_cube(folder: &Path, name: &str) {
    let corner = |i: usize| [0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1 } else { 1 });
    let mut text = String::new();
    (0..8).map(corner).for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    for [a, b, c, d] in [[1, 2, 4, 3], [5, 6, 8, 7], [1, 2, 6, 5], [3, 4, 8, 7], [1, 3, 7, 5], [2, 4, 8, 6]] {
        text += &format!("f {a} {b} {c} {d}\n");
    }
    std::fs::create_dir_all(folder.join(name).parent().expect("a folder")).expect("folders");
    std::fs::write(folder.join(name), text).expect("a file");
}

/// The carrier whose gripper collides as a mesh, and is drawn as it.
fn with_mesh(mesh: &str, scale: &str) -> Files {
    let shape = "<box size=\"0.09 0.13 0.07\"/>";
    let mesh = format!("<mesh filename=\"{mesh}\" scale=\"{scale}\"/>");
    let mut files = Files::new();
    let start = files.urdf.find("<link name=\"gripper_link\">").expect("the link");
    let end = start + files.urdf[start..].find("</link>").expect("its end");
    let link = files.urdf[start..end].replace(shape, &mesh);
    files.urdf.replace_range(start..end, &link);
    files
}

const SMALL: &str = "0.03 0.03 0.03";

#[test]
fn meshes_are_found_by_names_that_others_write() {
    for (name, written) in [
        ("spa ce.obj", "spa%20ce.obj"),
        ("spa ce.obj", "package://demo/spa%20ce.obj"),
        ("meshes/cube.obj", "meshes\\cube.obj"),
        ("meshes/cube.obj", "Meshes/Cube.OBJ"),
        ("demo/meshes/cube.obj", "model://demo/meshes/cube.obj"),
        ("demo/meshes/cube.obj", "package://Demo/meshes/CUBE.obj"),
    ] {
        let files = with_mesh(written, SMALL);
        let folder = files.folder.path();
        write_cube(folder, name);
        if written.starts_with("package://demo/spa") {
            write_cube(folder, &format!("demo/{name}"));
        }
        let robot = notes(&files, &["collision meshes of 1 links collide as their convex hulls"]);
        assert!(!said(&robot).contains("missing"), "{written}: {}", said(&robot));
        let is_other = !written.starts_with("model://");
        assert_eq!(
            said(&robot).contains(&format!("the mesh `{written}` is read from")),
            is_other,
            "{written}: {}",
            said(&robot)
        );
    }
    // two that are alike are none; a name that is nearly right is suggested
    let files = with_mesh("cube.obj", SMALL);
    write_cube(files.folder.path(), "Cube.obj");
    write_cube(files.folder.path(), "CUBE.obj");
    notes(&files, &["1 mesh to draw is missing"]);
    let files = with_mesh("cubes.obj", SMALL);
    write_cube(files.folder.path(), "cube.obj");
    notes(&files, &["has no shape: searched for", "cube.obj`?", "did you mean"]);
    let files = with_mesh("cube.obj", SMALL);
    std::fs::write(files.folder.path().join("cube.obj"), "version https://git-lfs.github.com/spec/v1\n")
        .expect("a file");
    notes(&files, &["cube.obj is a Git LFS pointer", "`git lfs pull`"]);
    let files = with_mesh("cube.glb", SMALL);
    std::fs::write(files.folder.path().join("cube.glb"), "glTF").expect("a file");
    notes(&files, &["1 mesh to draw is missing", "expected STL, OBJ or COLLADA"]);
}

#[test]
fn scales_that_are_hardly_meant_are_told_with_the_size() {
    let of = |scale: &str, parts: &[&str]| {
        let files = with_mesh("cube.obj", scale);
        write_cube(files.folder.path(), "cube.obj");
        notes(&files, parts)
    };
    of(
        "0.03",
        &["link `gripper_link`, visual 1", "a scale of one number, 0.03, which is taken for all axes"],
    );
    of(
        "0.03 0.03 0",
        &[
            "link `gripper_link`: its mesh `cube.obj` is flattened by its scale 0.03 0.03 0, to 0.06 x 0.06 x 0 m",
        ],
    );
    of(
        "10 10 10",
        &[
            "links with shapes of more than 5 m: `gripper_link` (20 x 20 x 20 m)",
            "scale=\"0.001 0.001 0.001\"",
        ],
    );
    of("1e-6 1e-6 1e-6", &["0.000002 x 0.000002 x 0.000002 m large", "scaled twice"]);
    let robot = of(SMALL, &[]);
    assert_eq!(robot.warnings.len(), 1, "{}", said(&robot));
}

/// A collision mesh that is missing is left out of the pages, with a note.
#[test]
fn a_missing_collision_mesh_is_left_out_of_pages() {
    let mut files = with_mesh("nowhere.stl", "1");
    let start = files.urdf.find("<link name=\"gripper_link\">").expect("the link");
    let from = start + files.urdf[start..].find("<visual>").expect("a shape");
    let to = start + files.urdf[start..].find("</visual>").expect("its end") + 9;
    files.urdf.replace_range(from..to, "");
    let _ = files.load(TOML);
    let path = |name: &str| files.folder.path().join(name).display().to_string();
    for arguments in [
        &["robot", "check", &path(TOML), "--render", &path("a.html")][..],
        &["run", "environment-1", "--max-steps", "2", "--robot", &path(TOML), "--render", &path("b.html")],
    ] {
        let output = cocarry(arguments);
        let said = stdout(&output) + &stderr(&output);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
        assert!(said.contains("gripper_link"), "{said}");
    }
    assert!(std::fs::read_to_string(path("a.html")).expect("a page").contains("gripper_link"));
    assert!(Path::new(&path("b.html")).exists());
}

/// The front wheels hang on one rocker.
#[test]
fn wheels_that_share_a_rocker_are_held_by_it_once() {
    let (parent, other) = ("parent link=\"base_link\"", "parent link=\"rocker\"");
    let rear = |side: &str, y: &str| {
        format!(
            "<link name=\"rear_{side}\"><visual><origin rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder radius=\"0.06\" \
             length=\"0.04\"/></geometry></visual></link><joint name=\"rear_{side}_wheel_joint\" type=\"continuous\">\
             <parent link=\"base_link\"/><child link=\"rear_{side}\"/><origin xyz=\"-0.2 {y} 0.06\"/>\
             <axis xyz=\"0 1 0\"/><limit velocity=\"17.4\" effort=\"8.85\"/></joint>"
        )
    };
    let rocker = "<link name=\"rocker\"/><joint name=\"rocker_joint\" type=\"revolute\"><parent link=\"base_link\"/>\
         <child link=\"rocker\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>";
    let added = format!("{}{}{rocker}</robot>", rear("left", "0.187"), rear("right", "-0.187"));
    let files = Files::new()
        .within("name=\"left_wheel_joint\"", parent, other)
        .within("name=\"right_wheel_joint\"", parent, other)
        .with(URDF, "</robot>", &added);
    let _ = files.load(TOML);
    let path = files.folder.path().join(URDF);
    let request = DraftRequest { drive: Some(DriveKind::SkidSteer), ..DraftRequest::default() };
    let draft = Draft::new(&path, URDF, "d.toml", &request).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(draft.text.matches("\"rocker_joint\" = ").count(), 1, "{}", draft.text);
}

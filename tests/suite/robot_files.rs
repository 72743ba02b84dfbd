//! Robot files for URDFs as they are published: checked, drafted, with meshes that collide.

use crate::spoiled_robot::{Files, TOML, URDF};
use crate::support::{cocarry, stderr, stdout};
use cocarry::robot::{Draft, DraftRequest, Robot, Shape, WarningKind};
use cocarry::world::World;

fn said(robot: &Robot) -> String {
    robot.warnings.iter().map(|note| format!("{note}\n")).collect()
}

fn loaded(files: &Files) -> Robot {
    files.load(TOML).unwrap_or_else(|e| panic!("{e}"))
}

/// A box around the origin as a binary STL.
fn stl([x, y, z]: [f32; 3]) -> Vec<u8> {
    let corner =
        |i: usize| [(0, x), (1, y), (2, z)].map(|(bit, s)| if i >> bit & 1 == 0 { -s } else { s } / 2.0);
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<[usize; 3]> =
        faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let normal = [0.0_f32; 3];
        let numbers = normal.into_iter().chain(triangle.into_iter().flat_map(corner));
        numbers.for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

/// The collision box of the carrier's base, replaced by a mesh.
fn base_of_mesh(mesh: &str) -> Files {
    let files = Files::new();
    let start = files.urdf.find("<link name=\"base_link\">").expect("the base");
    let start = start + files.urdf[start..].find("<collision>").expect("a collision shape");
    let end = start + files.urdf[start..].find("</collision>").expect("its end");
    let old = files.urdf[start..end].to_owned();
    let from = old.find("<geometry>").expect("a shape");
    let until = old.find("</geometry>").expect("its end");
    let new = format!("{}<geometry><mesh filename=\"{mesh}\"/>{}", &old[..from], &old[until..]);
    files.within("<link name=\"base_link\">", &old, &new)
}

#[test]
fn all_faults_are_told_at_once() {
    let files = Files::new()
        .with(TOML, "base_width_m = 0.5", "base_width_m = -1")
        .with(TOML, "grasp_frame = \"grasp_link\"", "grasp_frame = \"grasp\"")
        .with(TOML, "left_wheel = \"left_wheel_joint\"", "left_wheel = \"left\"");
    let _ = files.load(TOML);
    let file = files.folder.path().join(TOML);
    let faults = Robot::check(&file).expect_err("three faults");
    let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
    assert_eq!(faults.len(), 3, "{faults:?}");
    for (fault, part) in
        faults.iter().zip(["base_width_m = -1", "unknown link `grasp`", "unknown joint `left`"])
    {
        assert!(fault.contains(part), "{fault}");
    }
    let output = cocarry(&["robot", "check", &file.display().to_string()]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2));
    assert!(faults.iter().all(|fault| text.contains(fault.as_str())) && text.contains("3 faults"), "{text}");
}

#[test]
fn a_valid_robot_is_described_within_80_columns() {
    let files = Files::new();
    let _ = files.load(TOML);
    let output = cocarry(&["robot", "check", &files.folder.path().join(TOML).display().to_string()]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for part in ["differential", "1.04 m/s", "7 joints", "elbow_flex_joint", "elbow-out"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    // the first line has the files' names
    let longest = text.lines().skip(1).map(|line| line.chars().count()).max().unwrap_or(0);
    assert!(longest <= 110, "{longest}");
}

#[test]
fn expressions_in_comments_and_texts_are_no_xacro() {
    let note = "<robot name=\"carrier\"><!-- ${prefix}wheel <xacro:macro/> -->\
                <gazebo><robotNamespace>/${ns}</robotNamespace></gazebo>";
    loaded(&Files::new().with(URDF, "<robot name=\"carrier\">", note));
}

#[test]
fn meshes_are_found_in_the_packages_that_a_robot_file_names() {
    let files = base_of_mesh("package://far_description/meshes/base.stl");
    let elsewhere = tempfile::tempdir().expect("a folder");
    let meshes = elsewhere.path().join("far_description/meshes");
    std::fs::create_dir_all(&meshes).expect("folders");
    std::fs::write(meshes.join("base.stl"), stl([0.4, 0.4, 0.3])).expect("a file");
    assert!(said(&loaded(&files)).contains("packages"), "where else to search");
    for folder in [elsewhere.path().to_owned(), elsewhere.path().join("far_description")] {
        let packages = format!("base_width_m = 0.5\npackages = [\"{}\"]", folder.display());
        let files = base_of_mesh("package://far_description/meshes/base.stl");
        let robot = loaded(&files.with(TOML, "base_width_m = 0.5", &packages));
        assert_eq!(said(&robot), "collision meshes of 1 links collide as their convex hulls: `base_link`\n");
    }
}

/// A mesh collides as its hull; a robot built from texts alone, as for a replay, has the same.
#[test]
fn a_collision_mesh_is_its_hull_with_and_without_its_file() {
    let files = base_of_mesh("base.stl");
    std::fs::write(files.folder.path().join("base.stl"), stl([0.4, 0.3, 0.2])).expect("a file");
    let robot = loaded(&files);
    let hull = |robot: &Robot| {
        let base = robot.links.iter().find(|l| l.name == "base_link").expect("the base");
        let hulls = base.collisions.iter().filter_map(|c| match &c.shape {
            Shape::Mesh { hull, .. } => Some(hull.clone()),
            _ => None,
        });
        hulls.collect::<Vec<_>>().concat()
    };
    let vertices = hull(&robot);
    assert_eq!(vertices.len(), 8);
    assert!(vertices.iter().all(|v| (v.abs() - nalgebra::Vector3::new(0.2, 0.15, 0.1)).amax() < 1e-6));
    let saved = serde_json::to_string(&robot.texts).expect("JSON");
    let texts = serde_json::from_str(&saved).expect("the texts");
    drop(files);
    let again = Robot::parse(&texts).expect("a robot");
    assert_eq!(hull(&again), vertices);
}

/// A mesh that fills little of its hull collides as its parts, with and without its file.
#[test]
fn a_hollow_collision_mesh_is_its_parts() {
    let files = base_of_mesh("base.obj");
    // two legs of 40 cm by 2 cm, at right angles
    let corners = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.02], [0.02, 0.02], [0.02, 0.4], [0.0, 0.4]];
    let mut obj = String::new();
    for z in [0.0, 0.2] {
        corners.iter().for_each(|[x, y]| obj += &format!("v {} {} {z}\n", x - 0.2, y - 0.2));
    }
    for i in 0..6 {
        let next = (i + 1) % 6;
        obj += &format!("f {} {} {} {}\n", i + 1, next + 1, next + 7, i + 7);
    }
    for [a, b, c] in [[1, 2, 3], [1, 3, 4], [1, 4, 5], [1, 5, 6]] {
        obj += &format!("f {c} {b} {a}\nf {} {} {}\n", a + 6, b + 6, c + 6);
    }
    std::fs::write(files.folder.path().join("base.obj"), obj).expect("a file");
    let robot = loaded(&files);
    let hulls = |robot: &Robot| {
        let base = robot.links.iter().find(|l| l.name == "base_link").expect("the base");
        let hulls = base.collisions.iter().filter_map(|c| match &c.shape {
            Shape::Mesh { hull, .. } => Some(hull.clone()),
            _ => None,
        });
        hulls.collect::<Vec<_>>()
    };
    let parts = hulls(&robot);
    let told = format!("and collides as {} convex parts", parts.len());
    assert!(parts.len() >= 2 && said(&robot).contains(&told), "{told}: {}", said(&robot));
    assert!(!said(&robot).contains("collide as their convex hulls"), "{}", said(&robot));
    // each part is one leg, or a piece of one: 2 cm and the cubes that it is made of
    let is_thin = |part: &Vec<nalgebra::Vector3<f64>>| (0..2).any(|i| part.iter().all(|v| v[i] < -0.16));
    assert!(parts.iter().all(is_thin), "{parts:?}");
    let saved = serde_json::to_string(&robot.texts).expect("JSON");
    drop(files);
    let again = Robot::parse(&serde_json::from_str(&saved).expect("the texts")).expect("a robot");
    assert_eq!(hulls(&again), parts);
}

/// Nothing goes through obstacles unsaid: where a mesh is missing, something stands in for it.
#[test]
fn a_missing_collision_mesh_leaves_no_ghost() {
    let robot = loaded(&base_of_mesh("nowhere.stl"));
    let kinds: Vec<WarningKind> = robot.warnings.iter().map(|warning| warning.kind()).collect();
    assert_eq!(kinds, [WarningKind::MissingShape, WarningKind::MissingBaseShape], "{}", said(&robot));
    let base = &robot.links[robot.base_link];
    let footprint = base.collisions.iter().find_map(|c| match c.shape {
        Shape::Cylinder { radius, .. } => Some(radius),
        _ => None,
    });
    assert_eq!(footprint, Some(0.25));
}

#[test]
fn the_grasp_may_be_given_in_the_frame_of_the_tool() {
    let plain = loaded(&Files::new());
    let given =
        "grasp_frame = \"grasp_link\"\ngrasp_xyz_m = [0.0, 0.0, 0.0]\ngrasp_rpy_deg = [0.0, 0.0, 0.0]";
    let same = loaded(&Files::new().with(TOML, "grasp_frame = \"grasp_link\"", given));
    let q = plain.postures[0].joints;
    assert!(
        (plain.drive_from_grasp(&q).inverse() * same.drive_from_grasp(&q)).translation.vector.norm() < 1e-12
    );
    let ahead = given.replace("xyz_m = [0.0,", "xyz_m = [0.05,");
    let ahead = loaded(&Files::new().with(TOML, "grasp_frame = \"grasp_link\"", &ahead));
    let by = (plain.drive_from_grasp(&q).inverse() * ahead.drive_from_grasp(&q)).translation.vector;
    assert!((by - nalgebra::Vector3::new(0.05, 0.0, 0.0)).norm() < 1e-12, "{by}");
    let bad = given.replace("rpy_deg = [0.0,", "rpy_deg = [nan,");
    Files::new().with(TOML, "grasp_frame = \"grasp_link\"", &bad).says(&["grasp_rpy_deg[0] = NaN", "360"]);
}

#[test]
fn wheels_are_calibrated_by_the_robot_file() {
    let keys = "base_width_m = 0.5\nwheel_separation_m = 0.38\nwheel_rate_limit_rad_s = 10";
    let robot = loaded(&Files::new().with(TOML, "base_width_m = 0.5", keys));
    assert_eq!(robot.drive.track, 0.38);
    assert!((robot.drive.rim_speed_limit - 0.6).abs() < 1e-12);
    assert!(said(&robot).contains("wheel_separation_m = 0.38 replaces 0.3740 m"), "{}", said(&robot));
    let far = keys.replace("0.38", "0.5");
    Files::new().with(TOML, "base_width_m = 0.5", &far).says(&["0.3740 m apart", "wheel_separation_m = 0.5"]);
}

#[test]
fn an_inertia_that_no_body_has_matters_on_its_body_only() {
    let spoiled = Files::new().within("name=\"left_wheel_link\"", "ixy=\"0\"", "ixy=\"0.005\"");
    let robot = loaded(&spoiled);
    assert!(said(&robot).contains("link `left_wheel_link`: inertia that no body has"), "{}", said(&robot));
}

#[test]
fn a_robot_file_is_drafted_from_the_urdf_alone() {
    let files = Files::new();
    let _ = files.load(TOML);
    let urdf = files.folder.path().join(URDF);
    let request = DraftRequest::default();
    let draft = Draft::new(&urdf, URDF, "drafted.toml", &request).unwrap_or_else(|e| panic!("{e}"));
    let robot = &draft.robot;
    assert_eq!(robot.links[robot.base_link].name, "base_link");
    assert_eq!(
        robot.wheels.iter().map(|wheel| robot.links[wheel.link].name.as_str()).collect::<Vec<_>>(),
        ["left_wheel_link", "right_wheel_link"]
    );
    assert_eq!((robot.joint_count(), robot.grasp_height), (7, 0.7));
    assert!(!robot.postures.is_empty());
    for posture in &robot.postures {
        let grasp = robot.drive_from_grasp(&posture.joints);
        assert!(grasp.translation.y.abs() < 1e-5 && (grasp.translation.z - 0.7).abs() < 1e-9);
        assert!(
            (grasp.rotation.matrix() - nalgebra::Matrix3::identity()).amax() < 1e-9
                && robot.is_within_limits(&posture.joints)
        );
    }
    let again = Draft::new(&urdf, URDF, "drafted.toml", &request).expect("the same");
    assert_eq!(again.text, draft.text);
    let file = files.folder.path().join("mine.toml").display().to_string();
    let output = cocarry(&["robot", "init", &urdf.display().to_string(), "-o", &file]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(std::fs::read_to_string(&file).expect("the file"), draft.text);
    let run = cocarry(&["run", "environment-1", "--robot", &file, "--seed", "1"]);
    assert_eq!(run.status.code(), Some(0), "{}{}", stdout(&run), stderr(&run));
    let twice = cocarry(&["robot", "init", &urdf.display().to_string(), "-o", &file]);
    assert_eq!(twice.status.code(), Some(2), "an existing file is kept");
}

#[test]
fn a_base_that_cannot_be_expressed_is_refused_by_name() {
    let refused = |files: Files, parts: &[&str]| {
        let _ = files.load(TOML);
        let urdf = files.folder.path().join(URDF);
        let error =
            Draft::new(&urdf, URDF, "d.toml", &DraftRequest::default()).expect_err("refused").to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    };
    let fixed = Files::new().with(
        URDF,
        "<joint name=\"left_wheel_joint\" type=\"continuous\">",
        "<joint name=\"left_wheel_joint\" type=\"fixed\">",
    );
    refused(fixed, &["no pair of driven wheels", "`left_wheel_joint` is fixed"]);
    let wheel = |side: &str, y: &str| {
        format!(
            "<link name=\"rear_{side}\"/><joint name=\"rear_{side}_joint\" type=\"continuous\">\
             <parent link=\"base_link\"/><child link=\"rear_{side}\"/><origin xyz=\"-0.3 {y} 0.06\"/>\
             <axis xyz=\"0 1 0\"/><limit velocity=\"17\" effort=\"6\"/></joint></robot>"
        )
    };
    let two = format!("{}{}", wheel("left", "0.187").trim_end_matches("</robot>"), wheel("right", "-0.187"));
    refused(Files::new().with(URDF, "</robot>", &two), &["4 wheels", "skid-steer", "`rear_left_joint`"]);
}

/// Suspensions, as TIAGo's, stay where they are at rest.
#[test]
fn a_drafted_robot_holds_its_suspension() {
    let of = |side: &str| {
        format!(
            "<link name=\"{side}_spring\"/><joint name=\"{side}_spring_joint\" type=\"prismatic\">\
             <parent link=\"base_link\"/><child link=\"{side}_spring\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-0.005\" upper=\"0.005\" velocity=\"1\" effort=\"100\"/></joint>"
        )
    };
    let on = |files: Files, side: &str| {
        let child = format!("<child link=\"{side}_wheel_link\"/>");
        let (fixed, sprung) = ["base_link", &format!("{side}_spring")]
            .map(|parent| format!("<parent link=\"{parent}\"/>\n    {child}"))
            .into();
        files.with(URDF, &fixed, &sprung)
    };
    let files = on(on(Files::new(), "left"), "right");
    let files = files.with(URDF, "</robot>", &format!("{}{}</robot>", of("left"), of("right")));
    files.says(&["left_wheel_joint", "is connected to `base_link` through `left_spring_joint`"]);
    let urdf = files.folder.path().join(URDF);
    let draft = Draft::new(&urdf, URDF, "d.toml", &DraftRequest::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(draft.text.contains("[hold]\n\"left_spring_joint\" = { position_m = 0 }"), "{}", draft.text);
    assert!((draft.robot.drive.track - 0.374).abs() < 1e-12);
}

/// The world is planned for the robot, not for the narrower one of its file: openings that are too narrow are
/// none, and the others have a higher risk.
#[test]
fn a_base_wider_than_the_world_is_for_takes_the_place_of_its_width() {
    let files = Files::new().with(TOML, "base_width_m = 0.5", "base_width_m = 0.6");
    let _ = files.load(TOML);
    let file = files.folder.path().join(TOML).display().to_string();
    let output = cocarry(&["run", "environment-1", "--plant", "kinematic", "--robot", &file]);
    let said = stderr(&output);
    assert!(
        said.contains("is 0.60 m wide (base_width_m), more than robot_width_m of environment-1"),
        "{said}"
    );
    let text = include_str!("../../worlds/environment-1.toml");
    let [given, wide] = [0.5, 0.6].map(|width| World::parse_for("w.toml", text, width).unwrap());
    assert_eq!((given.robot_width, given.is_widened), (0.5, false));
    assert_eq!((wide.robot_width, wide.is_widened), (0.6, true));
    for (given, wide) in given.openings.iter().zip(&wide.openings) {
        assert!(wide.risk(0.6) > given.risk(0.5), "{}", given.name);
    }
    // openings of 0.56 m are too narrow for 0.6 m: at the outset, not half-way through
    let narrow = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-5, 0]\ntarget_m = [5, 0]\n";
    let wall = |name: &str, y: f64| {
        format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [0, {y}]\nsize_m = [0.1, 8]\nheight_m = 1\n"
        )
    };
    let narrow = format!("{narrow}{}{}", wall("left", 4.28), wall("right", -4.28));
    let openings = |width| World::parse_for("w.toml", &narrow, width).unwrap().openings.len();
    assert_eq!([openings(0.5), openings(0.6)], [1, 0]);
}

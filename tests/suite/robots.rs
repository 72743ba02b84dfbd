//! Robots as they are loaded: where their links are, how they move.

use crate::support::{random_configuration, repository};
use cocarry::geometry::{PlanarPose, Point, Pose};
use cocarry::math;
use cocarry::robot::{
    BaseInput, Configuration, InputVector, JointKind, JointVector, MAX_INPUTS, Motion, Robot, Shape,
    pose_difference,
};
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::Path;

const AT_ORIGIN: PlanarPose = PlanarPose { position: Point::new(0.0, 0.0), yaw: 0.0 };

fn carrier() -> Robot {
    Robot::built_in().unwrap_or_else(|e| panic!("{e}"))
}

fn load(path: &Path) -> Robot {
    Robot::load(path).unwrap_or_else(|e| panic!("{e}"))
}

fn six() -> Robot {
    load(&repository("tests/fixtures/robots/six.toml"))
}

/// The carrier with `from` replaced by `to` in its URDF, and of its postures only the first.
fn altered(changes: &[(&str, &str)]) -> Robot {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let read = |name: &str| std::fs::read_to_string(repository("assets/robots").join(name)).expect("text");
    let mut urdf = read("carrier.urdf");
    let mut text = read("carrier.toml");
    text.truncate(text.find("# The same grasp").expect("the second posture"));
    for (from, to) in changes {
        assert_eq!(urdf.matches(from).count() + text.matches(from).count(), 1, "{from}");
        urdf = urdf.replace(from, to);
        text = text.replace(from, to);
    }
    std::fs::write(folder.path().join("carrier.urdf"), urdf).expect("a file");
    std::fs::write(folder.path().join("carrier.toml"), text).expect("a file");
    load(&folder.path().join("carrier.urdf"))
}

/// Mimics in the arm: one slides with a joint that itself mimics, and follows it backwards.
/// Its torso slides and its forearm turns as other joints do; the torso's own effort limit is 1 N.
pub fn carrier_that_mimics() -> Robot {
    altered(&[
        (
            "<joint name=\"torso_joint\" type=\"fixed\">",
            "<joint name=\"torso_joint\" type=\"prismatic\"><axis xyz=\"0 0.6 0.8\"/>
             <limit lower=\"-0.2\" upper=\"0.2\" effort=\"1\" velocity=\"0.1\"/>
             <mimic joint=\"forearm_roll_joint\" multiplier=\"-0.04\"/>",
        ),
        (
            "<joint name=\"forearm_roll_joint\" type=\"continuous\">",
            "<joint name=\"forearm_roll_joint\" type=\"continuous\">
             <mimic joint=\"wrist_roll_joint\" multiplier=\"0.3\" offset=\"0.02\"/>",
        ),
        ("forearm_roll_joint = 0.0\n", ""),
    ])
}

/// With a mast beside the arm, which turns with the elbow: by `ratio` times its angle, which is 96 degrees at
/// the start.
pub fn carrier_with_mast(ratio: f64) -> Robot {
    let mast = format!(
        "<link name=\"mast\"><inertial><origin xyz=\"0 0 0.1\"/><mass value=\"0.5\"/>
         <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>
         <joint name=\"mast_joint\" type=\"revolute\"><parent link=\"base_link\"/><child link=\"mast\"/>
         <origin xyz=\"-0.1 0 0.3\"/><axis xyz=\"0 1 0\"/><limit lower=\"-6\" upper=\"6\" effort=\"10\" velocity=\"3\"/>
         <mimic joint=\"elbow_flex_joint\" multiplier=\"{ratio}\" offset=\"0.1\"/></joint></robot>"
    );
    altered(&[("</robot>", &mast)])
}

fn start(robot: &Robot) -> Configuration {
    Configuration { base: AT_ORIGIN, joints: robot.postures[0].joints }
}

#[test]
fn the_carrier_is_as_its_files_say() {
    let robot = carrier();
    assert_eq!(
        (robot.name.as_str(), robot.texts.file.as_str(), robot.joint_count()),
        ("Carrier", "carrier", 7)
    );
    assert!((robot.drive.track - 0.374).abs() < 1e-12 && (robot.drive.wheel_radius - 0.06).abs() < 1e-12);
    assert!((robot.drive.rim_speed_limit - 17.4 * 0.06).abs() < 1e-12);
    assert_eq!(robot.drive.base_radius, 0.25);
    let lift = &robot.joints[1];
    assert_eq!((lift.name.as_str(), lift.motion), ("shoulder_lift_joint", Motion::Revolute));
    assert_eq!([lift.lower, lift.upper, lift.rate_limit, lift.effort_limit], [-1.221, 1.518, 1.454, 131.76]);
    assert_eq!(robot.joints[2].upper, f64::INFINITY);
    let mass: f64 = robot.links.iter().filter_map(|l| l.inertial).map(|i| i.mass).sum();
    assert!(
        (mass - (70.0 + 13.0 + 2.6 + 2.7 + 2.3 + 2.1 + 1.7 + 1.7 + 0.14 + 1.5)).abs() < 1e-9,
        "{mass} kg"
    );
    for link in robot.links.iter().filter(|l| l.name != "grasp_link") {
        assert!(link.inertial.is_some() && !link.visuals.is_empty() && !link.collisions.is_empty());
        assert!(link.visuals.iter().all(|v| v.color.is_some()), "{}", link.name);
    }
    for (i, link) in robot.links.iter().enumerate() {
        assert!(link.parent.is_none_or(|p| p < i), "{} comes before its parent", link.name);
    }
}

/// Solids of the mass and the shape that the links have.
#[test]
fn closed_form_the_carrier_has_the_inertia_of_its_shapes() {
    for link in &carrier().links {
        let Some(inertial) = link.inertial else { continue };
        let geometry = &link.collisions[0];
        let along = |a: f64, across: f64| Vector3::new(across, across, a);
        let moments = inertial.mass
            * match &geometry.shape {
                Shape::Box { size } => {
                    let s = size.component_mul(size) / 12.0;
                    Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y)
                }
                Shape::Cylinder { radius: r, length: l } => along(r * r / 2.0, (3.0 * r * r + l * l) / 12.0),
                Shape::Sphere { radius: r } => Vector3::repeat(0.4 * r * r),
                other => panic!("{other:?}"),
            };
        let turn = geometry.link_from_shape.rotation.matrix();
        let expected = turn * nalgebra::Matrix3::from_diagonal(&moments) * turn.transpose();
        assert!((inertial.inertia - expected).amax() < 1e-5 * expected.amax(), "{}", link.name);
        let offset = inertial.center.translation.vector - geometry.link_from_shape.translation.vector;
        assert_eq!(offset.norm(), 0.0, "{}", link.name);
    }
}

/// In the upright plane: the sum of the lengths along the pitch that the joints add up to.
#[test]
fn closed_form_the_grasp_of_a_planar_arm() {
    let robot = carrier();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..50 {
        let mut q = Configuration { base: AT_ORIGIN, joints: Default::default() };
        let [lift, elbow, wrist] = [1, 3, 5].map(|i| {
            q.joints[i] = rng.random_range(-1.2..1.2);
            q.joints[i]
        });
        let (mut x, mut z, mut pitch) = (0.033 + 0.117, 0.726 + 0.060, 0.0);
        for (turn, length) in [(lift, 0.219 + 0.133), (elbow, 0.197 + 0.1245), (wrist, 0.1385 + 0.16645)] {
            pitch += turn;
            x += length * math::cos(pitch);
            z -= length * math::sin(pitch);
        }
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), pitch);
        let expected = Pose::from_parts(Vector3::new(x, 0.0, z).into(), turn);
        assert!(pose_difference(&expected, &robot.grasp_pose(&q)).norm() < 1e-12);
    }
}

#[test]
fn closed_form_both_postures_hold_the_grasp_at_one_pose() {
    let robot = carrier();
    let expected = Vector3::new(0.033 + 0.117 + 0.75, 0.0, 0.7);
    for name in ["elbow-up", "elbow-out"] {
        let joints = robot.posture(name).expect("a posture").joints;
        let grasp = robot.grasp_pose(&Configuration { base: AT_ORIGIN, joints });
        assert!((grasp.translation.vector - expected).norm() < 2e-8, "{name}: {grasp}");
        assert!((grasp.translation.vector.z - 0.7).abs() < 1e-12);
        assert!(grasp.rotation.angle() < 1e-12, "{name}: {grasp}");
    }
    // the elbow: in the plane and above; then level with the line from shoulder to wrist, on the left
    let elbow = |name: &str| {
        let joints = robot.posture(name).expect("a posture").joints;
        let poses = robot.link_poses(&Configuration { base: AT_ORIGIN, joints });
        let at = |link: &str| {
            let i = robot.links.iter().position(|l| l.name == link).expect("a link");
            poses[i].translation.vector
        };
        let [shoulder, elbow, wrist] = ["shoulder_lift_link", "elbow_flex_link", "wrist_flex_link"].map(at);
        let line = (wrist - shoulder).normalize();
        let across = elbow - shoulder;
        let across = (across - line * line.dot(&across)).normalize();
        let up = (Vector3::z() - line * line.z).normalize();
        (across.dot(&up), across.y)
    };
    let (up, left) = elbow("elbow-up");
    assert!((up - 1.0).abs() < 1e-12 && left.abs() < 1e-12);
    let (up, left) = elbow("elbow-out");
    assert!(up.abs() < 1e-7 && left > 0.9, "{up} {left}");
}

/// The Jacobian against the pose after a short input to either side, wheels included.
/// The whole-body Jacobian against central differences of the grasp's pose.
pub fn assert_the_jacobian_is_the_slope_of_the_pose(robot: &Robot) {
    let h = 1e-5;
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..200 {
        let q = random_configuration(robot, &mut rng);
        let kinematics = robot.kinematics(&q);
        assert!(pose_difference(&kinematics.grasp, &robot.grasp_pose(&q)).norm() < 1e-12);
        for column in 0..MAX_INPUTS {
            let mut input = InputVector::zeros();
            if column < robot.drive.inputs() + robot.joint_count() {
                input[column] = 1.0;
            }
            let [ahead, back] = [h, -h].map(|s| robot.grasp_pose(&robot.advance(&q, &(input * s), 1.0)));
            let slope = pose_difference(&ahead, &back) / (2.0 * h);
            let error = (slope - kinematics.jacobian.column(column)).norm();
            assert!(error < 1e-6, "{}: column {column}: off by {error}", robot.name);
        }
    }
}

#[test]
fn property_the_jacobian_is_the_slope_of_the_pose() {
    for robot in [carrier(), six(), carrier_that_mimics()] {
        assert_the_jacobian_is_the_slope_of_the_pose(&robot);
    }
}

#[test]
fn property_a_roll_is_many_short_ones() {
    let drive = carrier().drive;
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for case in 0..40 {
        let base = PlanarPose { position: Point::new(1.0, -2.0), yaw: rng.random_range(-3.0..3.0) };
        let left: f64 = rng.random_range(-0.5..0.5);
        // straight, all but straight, and any turn
        let right = match case % 4 {
            0 => left,
            1 => left + 1e-5 * rng.random_range(-1.0..1.0),
            _ => rng.random_range(-0.5..0.5),
        };
        let rolled = drive.roll(&base, &BaseInput::new(left, right, 0.0));
        let steps = 20_000;
        let (length, turn) =
            ((left + right) / 2.0 / f64::from(steps), (right - left) / drive.track / f64::from(steps));
        let (mut x, mut y, mut yaw) = (base.position.x, base.position.y, base.yaw);
        for _ in 0..steps {
            // the heading in the middle of the step
            x += length * math::cos(yaw + turn / 2.0);
            y += length * math::sin(yaw + turn / 2.0);
            yaw += turn;
        }
        assert!((rolled.position - Point::new(x, y)).norm() < 1e-8, "{left} {right}");
        assert!(math::sin(rolled.yaw - yaw).abs() < 1e-9 && rolled.yaw.abs() <= std::f64::consts::PI);
    }
}

#[test]
fn property_link_poses_end_at_the_grasp() {
    for robot in [carrier(), six(), carrier_that_mimics()] {
        let mut rng = ChaCha8Rng::seed_from_u64(13);
        for _ in 0..100 {
            let q = random_configuration(&robot, &mut rng);
            let poses = robot.link_poses(&q);
            assert_eq!(poses.len(), robot.links.len());
            let difference = pose_difference(&poses[robot.grasp_link], &robot.grasp_pose(&q));
            assert!(difference.norm() < 1e-12, "{}: {}", robot.name, difference.norm());
            // wheels stand on the floor, on either side of the drive's origin
            for (wheel, side) in robot.wheels.iter().map(|wheel| wheel.link).zip([0.5, -0.5]) {
                let axle = q.base.at_height(robot.drive.wheel_radius);
                let middle = axle * nalgebra::Point3::new(0.0, side * robot.drive.track, 0.0);
                let at = poses[wheel].translation.vector;
                assert!((at - middle.coords).norm() < 1e-12, "{}: {at} {middle}", robot.name);
            }
        }
    }
}

/// The fixture's grasp by multiplying out what its URDF says, lift included.
#[test]
fn closed_form_the_other_robot_multiplied_out() {
    let robot = six();
    assert_eq!(robot.joint_count(), 6);
    let link = |name: &str| robot.links.iter().position(|l| l.name == name).expect("a link");
    let poses = robot.link_poses(&start(&robot));
    let pose = |xyz: [f64; 3], [r, p, y]: [f64; 3]| {
        Pose::from_parts(Vector3::from(xyz).into(), Rotation3::from_euler_angles(r, p, y))
    };
    // the floor is a wheel's radius below the axle, the drive 0.05 m ahead of the base's origin
    let base = pose([-0.05, 0.0, 0.02 + 0.0855], [0.0; 3]);
    assert!(pose_difference(&poses[robot.base_link], &base).norm() < 1e-12);
    let mount = base
        * pose([0.1, 0.03, 0.2], [0.0, 0.05, 0.2])
        * pose([0.0, 0.0, 0.1], [0.0; 3])
        * pose([0.02, -0.01, 0.08], [0.04, -0.05, -0.3]);
    assert!(pose_difference(&poses[link("mount_link")], &mount).norm() < 1e-12);
    let footprint = base * pose([0.03, -0.02, 0.11], [0.0, 0.0, 0.4]).inverse();
    assert!(pose_difference(&poses[link("footprint")], &footprint).norm() < 1e-12);
    // at 0 the thumb mimics the finger: 0.002 m along -y
    let thumb = poses[link("hand_link")]
        * pose([0.02, -0.01, 0.0], [0.0, 0.0, -0.1])
        * pose([0.0, -0.002, 0.0], [0.0; 3]);
    assert!(pose_difference(&poses[link("thumb_link")], &thumb).norm() < 1e-12);
    assert!((robot.grasp_pose(&start(&robot)).translation.z - 0.6).abs() < 1e-12);
    assert_eq!(robot.drive.wheel_radius, 0.0855);
    assert!((robot.drive.track - 0.4).abs() < 1e-12);
}

/// A robot whose joints mimic stands as the one without does at the positions that this comes to, and keeps
/// their limits.
#[test]
fn closed_form_mimics_follow_with_ratio_and_offset() {
    let (robot, plain) = (carrier_that_mimics(), carrier());
    assert_eq!(robot.joint_count(), 6);
    assert!(robot.joints.iter().all(|j| j.name != "forearm_roll_joint"));
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    for _ in 0..50 {
        let q = random_configuration(&robot, &mut rng);
        let roll = q.joints[5];
        let forearm = 0.3 * roll + 0.02;
        let mut joints = q.joints;
        joints[6] = roll;
        joints[5] = q.joints[4];
        joints[4] = forearm;
        let straight = Configuration { joints, ..q };
        let slide = q.base.at_height(0.0).rotation * Vector3::new(0.0, 0.6, 0.8) * (-0.04 * forearm);
        let expected = nalgebra::Translation3::from(slide) * plain.grasp_pose(&straight);
        assert!(pose_difference(&robot.grasp_pose(&q), &expected).norm() < 1e-12);
    }
    // the torso slides by at most 0.2 m, at 0.1 m/s; the forearm by 1.571 rad/s
    let wrist = &robot.joints[5];
    let most = (0.2 / 0.04 - 0.02) / 0.3;
    assert!((wrist.upper - most).abs() < 1e-9 && (wrist.lower + (0.2 / 0.04 + 0.02) / 0.3).abs() < 1e-9);
    assert!((wrist.rate_limit - 2.268_f64.min(1.571 / 0.3).min(0.1 / 0.012)).abs() < 1e-12);
}

#[test]
fn a_joint_that_mimics_one_outside_the_arm_stays_where_that_one_at_0_puts_it() {
    let robot = altered(&[(
        "<joint name=\"torso_joint\" type=\"fixed\">",
        "<joint name=\"torso_joint\" type=\"prismatic\"><axis xyz=\"0 0 1\"/>
             <limit lower=\"0\" upper=\"0.4\" effort=\"400\" velocity=\"0.1\"/>
             <mimic joint=\"left_finger_joint\" offset=\"0.01\"/>",
    )]);
    assert_eq!(robot.joint_count(), 7);
    let q = Configuration { base: AT_ORIGIN, joints: carrier().postures[0].joints };
    assert!((robot.grasp_pose(&q).translation.z - 0.71).abs() < 1e-12);
    let torso = robot.links.iter().find(|l| l.name == "torso_link").and_then(|l| l.joint.as_ref());
    assert!(torso.is_some_and(|j| j.kind == JointKind::Prismatic && j.coupling.joint.is_none()));
}

#[test]
fn a_posture_is_closed_without_moving_the_grasp_sideways() {
    let exact = carrier();
    let robot = altered(&[("elbow_flex_joint = 95.527315", "elbow_flex_joint = 93.0")]);
    let mut given = JointVector::zeros();
    for (i, angle) in [(1, -33.97128), (3, 93.0), (5, -61.556035)] {
        given[i] = f64::to_radians(angle);
    }
    let before = exact.grasp_pose(&Configuration { base: AT_ORIGIN, joints: given });
    let after = robot.grasp_pose(&start(&robot));
    assert!((before.translation.vector.xy() - after.translation.vector.xy()).norm() < 1e-12);
    assert!((before.translation.z - 0.7).abs() > 0.005 && (after.translation.z - 0.7).abs() < 1e-12);
    assert!(after.rotation.angle() < 1e-12 && before.rotation.angle() > 0.02);
}

#[test]
fn meshes_are_found_beside_the_urdf_and_in_packages() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let robots = folder.path().join("demo_robot/robots");
    for sub in ["demo_robot/robots", "demo_robot/meshes", "other_package/meshes"] {
        std::fs::create_dir_all(folder.path().join(sub)).expect("a folder");
    }
    for mesh in ["demo_robot/meshes/body.stl", "demo_robot/robots/near.stl", "other_package/meshes/far.stl"] {
        std::fs::write(folder.path().join(mesh), "solid").expect("a file");
    }
    let read = |name: &str| std::fs::read_to_string(repository("assets/robots").join(name)).expect("text");
    std::fs::write(robots.join("carrier.toml"), read("carrier.toml")).expect("a file");
    let names = [
        "package://demo_robot/meshes/body.stl",
        "near.stl",
        "package://other_package/meshes/far.stl",
        &format!("file://{}", folder.path().join("demo_robot/meshes/body.stl").display()),
    ];
    for mesh in names {
        let shape = format!("<mesh filename=\"{mesh}\" scale=\"1 -2 1\"/>");
        let urdf = read("carrier.urdf").replace("<box size=\"0.16 0.3 0.66\"/>", &shape);
        std::fs::write(robots.join("carrier.urdf"), urdf).expect("a file");
        let robot = load(&robots.join("carrier.toml"));
        let torso = robot.links.iter().find(|l| l.name == "torso_link").expect("the torso");
        let Shape::Mesh { file, scale, .. } = &torso.visuals[0].shape else { panic!("{torso:?}") };
        assert!(file.is_file() && scale.y == -2.0, "{}", file.display());
        assert_eq!(file.file_name(), Path::new(mesh).file_name());
    }
}

/// The points that obstacles are kept off: where the links' frames are, and how these move.
#[test]
fn property_the_arms_points_and_their_jacobians_agree_with_finite_differences() {
    let six = Robot::load(&repository("tests/fixtures/robots/six.toml")).unwrap_or_else(|e| panic!("{e}"));
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for robot in [Robot::built_in().unwrap_or_else(|e| panic!("{e}")), six] {
        for _ in 0..50 {
            let q = random_configuration(&robot, &mut rng);
            let points = |q: &Configuration| {
                let mut found = Vec::new();
                robot.arm_points(q, 0.1, |point, jacobian| found.push((point, *jacobian)));
                found
            };
            let here = points(&q);
            let grasp = robot.grasp_pose(&q).translation.vector;
            assert!((here.last().expect("the grasp").0 - grasp).norm() < 1e-12);
            assert!(here.windows(2).all(|pair| (pair[1].0 - pair[0].0).norm() < 0.1 + 1e-12));
            assert!(here.len() <= robot.arm_point_count(0.1));
            for input in 0..robot.joint_count() + 2 {
                let mut u = InputVector::zeros();
                u[input] = 1.0;
                let step = 1e-6;
                let (ahead, behind) = (robot.advance(&q, &u, step), robot.advance(&q, &-u, step));
                for ((here, ahead), behind) in here.iter().zip(points(&ahead)).zip(points(&behind)) {
                    let slope = (ahead.0 - behind.0) / (2.0 * step);
                    assert!((slope - here.1.column(input)).norm() < 1e-6, "input {input}");
                }
            }
        }
    }
}

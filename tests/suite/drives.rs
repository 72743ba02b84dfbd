//! Drives: bases on two wheels, bases that skid, and bases that move in any direction, as robot files give
//! them, in B(q), on both plants, in the program and in recordings.

use crate::robots::assert_the_jacobian_is_the_slope_of_the_pose;
use crate::spoiled_robot::{Files, TOML, URDF};
use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::geometry::{PlanarPose, Point, direction, left_of, wrap_angle};
use cocarry::robot::{BaseInput, Draft, DraftRequest, DriveKind, InputVector, Robot};
use cocarry::simulation::{HumanCommand, PhysicalPlant, PhysicsSettings};
use cocarry::team::slow_drive;
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const OMNI: &str = "assets/robots/omni-carrier.toml";
const TWO_WHEELS: &str = "left_wheel = \"left_wheel_joint\"\nright_wheel = \"right_wheel_joint\"";
const LIMITS: &str = "base_speed_limit_m_s = 1\nbase_turn_limit_rad_s = 2";

fn omni() -> Robot {
    Robot::load(&repository(OMNI)).unwrap_or_else(|e| panic!("{e}"))
}

/// The carrier with two more wheels behind, which its robot file does not mention.
fn four_wheels(kind: &str) -> Files {
    let wheel = |side: &str, y: &str| {
        format!(
            "<link name=\"rear_{side}_{kind}\"><collision><origin rpy=\"1.5707963267948966 0 0\"/><geometry>\
             <cylinder radius=\"0.06\" length=\"0.04\"/></geometry></collision></link>\
             <joint name=\"rear_{side}_joint\" type=\"continuous\"><parent link=\"base_link\"/>\
             <child link=\"rear_{side}_{kind}\"/><origin xyz=\"-0.3 {y} 0.06\"/><axis xyz=\"0 1 0\"/>\
             <limit velocity=\"17.4\" effort=\"8.85\"/></joint>"
        )
    };
    let both = format!("{}{}</robot>", wheel("left", "0.187"), wheel("right", "-0.187"));
    Files::new().with(URDF, "</robot>", &both)
}

fn skid_steer() -> Files {
    four_wheels("wheel").with(
        TOML,
        TWO_WHEELS,
        "drive = \"skid-steer\"\nleft_wheels = [\"left_wheel_joint\", \"rear_left_joint\"]\n\
         right_wheels = [\"right_wheel_joint\", \"rear_right_joint\"]",
    )
}

fn loaded(files: &Files) -> Robot {
    files.load(TOML).unwrap_or_else(|e| panic!("{e}"))
}

/// B(q) against the pose after a short input to either side.
#[test]
fn property_the_jacobian_of_every_drive_is_the_slope_of_the_pose() {
    for robot in [omni(), loaded(&skid_steer())] {
        let inputs = robot.drive.inputs() + robot.joint_count();
        assert_eq!(inputs, if robot.drive.is_omnidirectional() { 10 } else { 9 });
        assert_the_jacobian_is_the_slope_of_the_pose(&robot);
    }
}

/// Where an omnidirectional base comes to, against many short steps.
#[test]
fn property_a_roll_in_any_direction_is_many_short_ones() {
    let drive = omni().drive;
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for case in 0..30 {
        let base = PlanarPose { position: Point::new(1.0, -2.0), yaw: rng.random_range(-3.0..3.0) };
        let turn = if case % 3 == 0 { 1e-5 } else { rng.random_range(-1.5..1.5) };
        let by = BaseInput::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5), turn);
        let rolled = drive.roll(&base, &by);
        let steps = 20_000;
        let (mut at, mut yaw, step) = (base.position, base.yaw, by / f64::from(steps));
        for _ in 0..steps {
            let ahead = direction(yaw + step.z / 2.0);
            at += ahead * step.x + left_of(ahead) * step.y;
            yaw += step.z;
        }
        assert!((rolled.position - at).norm() < 1e-8 && wrap_angle(rolled.yaw - yaw).abs() < 1e-9, "{by}");
    }
}

/// Mecanum wheels turn by the textbook's inverse kinematics, (vx -+ vy -+ (lx + ly) w) / r: to the side the
/// front left wheel turns backward and the rear left one forward.
#[test]
fn closed_form_mecanum_wheels_turn_as_the_base_moves() {
    let robot = omni();
    let names: Vec<_> = robot.wheels.iter().map(|w| robot.links[w.link].name.as_str()).collect();
    assert_eq!(
        names,
        ["front_left_wheel_link", "front_right_wheel_link", "rear_left_wheel_link", "rear_right_wheel_link"]
    );
    let (r, l) = (0.06, 0.14 + 0.16);
    let (vx, vy, w) = (0.4, 0.3, -0.7);
    let rates = robot.drive.rolling(&BaseInput::new(vx, vy, w));
    let expected =
        [vx - vy - l * w, vx + vy + l * w, vx + vy - l * w, vx - vy + l * w].map(|speed| speed / r);
    for ((wheel, expected), name) in robot.wheels.iter().zip(expected).zip(names) {
        assert!((wheel.of(&rates) - expected).abs() < 1e-12, "{name}: {} {expected}", wheel.of(&rates));
    }
}

#[test]
fn a_base_that_skids_turns_as_if_its_wheels_were_farther_apart() {
    let robot = loaded(&skid_steer());
    assert_eq!(robot.drive.kind, DriveKind::SkidSteer);
    assert!((robot.drive.track - 1.5 * 0.374).abs() < 1e-12, "{}", robot.drive.track);
    assert_eq!(robot.wheels.iter().map(|w| w.spin.x != 0.0).collect::<Vec<_>>(), [true, true, false, false]);
    // its origin is in the middle of its wheels
    assert!((robot.drive_from_base().translation.x - 0.15).abs() < 1e-12);
    let wider = skid_steer().with(TOML, "drive =", "wheel_separation_multiplier = 1.875\ndrive =");
    assert!((loaded(&wider).drive.track - 1.875 * 0.374).abs() < 1e-12);
    // the same rims turn it by the ratio of the tracks
    let rims = BaseInput::new(-0.1, 0.1, 0.0);
    let turned = robot.drive.roll(&PlanarPose { position: Point::origin(), yaw: 0.0 }, &rims).yaw;
    assert!((turned - 0.2 / (1.5 * 0.374)).abs() < 1e-12, "{turned}");
}

/// On the physical plant, a base moves as its inputs say: to the side while it turns, and on the wider track.
#[test]
fn bodies_move_as_their_drives_say() {
    let world =
        World::parse("w.toml", "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n")
            .unwrap();
    let settings = PhysicsSettings::default();
    let start = PlanarPose { position: Point::origin(), yaw: 0.0 };
    for (robot, input) in
        [(omni(), [0.1, 0.15, 0.1]), (omni(), [0.0, -0.2, 0.0]), (loaded(&skid_steer()), [0.08, 0.14, 0.0])]
    {
        let mut plant =
            PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &start, &settings, 7).unwrap();
        let before = plant.observe();
        let mut rates = InputVector::zeros();
        rates.fixed_rows_mut::<3>(0).copy_from(&BaseInput::from(input));
        let mut expected = before.configuration.base;
        let mut seen = before;
        for _ in 0..10 {
            seen = plant.step(&rates, &HumanCommand::Follow, 0.2);
            expected = robot.drive.roll(&expected, &(BaseInput::from(input) * 0.2));
        }
        let reached = seen.configuration.base;
        let off = (reached.position - expected.position).norm();
        assert!(off < 0.02, "{}: {off} m off", robot.name);
        assert!(wrap_angle(reached.yaw - expected.yaw).abs() < 0.02, "{}", robot.name);
        let off = (seen.base_rates - BaseInput::from(input)).amax();
        assert!(off < 0.02, "{}: rates {}", robot.name, seen.base_rates);
        // what has rolled is what the wheels turn by
        let per = if robot.drive.is_omnidirectional() { 1.0 } else { robot.drive.wheel_radius };
        let off = (seen.rolled * per - BaseInput::from(input) * 2.0).amax();
        assert!(off < 0.03, "{}: {} rolled", robot.name, seen.rolled);
    }
}

/// From robot file to outcome: both plants arrive, name no rims, and resume and record with the same bits.
#[test]
fn an_omnidirectional_robot_carries() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    for (plant, seed) in [("kinematic", "1"), ("rapier", "2")] {
        let run = ["run", "environment-1", "--robot", OMNI, "--plant", plant, "--seed", seed];
        let (snapshot, ticks) = (path(&format!("{plant}.snapshot")), path(&format!("{plant}.csv")));
        let whole = json(&[&run[..], &["--json", "--save-at", "15", &snapshot, "--ticks", &ticks]].concat());
        assert_eq!(whole["outcome"], "arrived", "{whole}");
        assert!(whole["position_error_rms_m"].as_f64().unwrap() < 0.03, "{whole}");
        let text = std::fs::read_to_string(&ticks).expect("ticks");
        let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let head = rows.next().expect("a head");
        let column = |name: &str| head.iter().position(|h| *h == name).expect("a column");
        let (left, sideways) = (column("left_rim_m_per_s"), column("base_left_m_per_s"));
        let rows: Vec<_> = rows.collect();
        assert!(rows.iter().all(|row| row[left].is_empty()), "{plant}");
        let moved = rows.iter().map(|row| row[sideways].parse::<f64>().expect("a number").abs());
        assert!(moved.fold(0.0, f64::max) > 0.01, "{plant}: never to the side");
        let resumed = json(&["run", "--resume", &snapshot, "--json"]);
        for key in ["control_cost", "steps", "position_error_rms_m"] {
            assert_eq!(resumed[key], whole[key], "{plant}: {key}");
        }
        let recording = path(&format!("{plant}.mcap"));
        assert_eq!(
            cocarry(&[&run[..], &["--record", &recording]].concat()).status.code(),
            Some(0),
            "{plant}"
        );
        let replayed = cocarry(&["replay", &recording]);
        assert_eq!(replayed.status.code(), Some(0), "{plant}: {}{}", stdout(&replayed), stderr(&replayed));
    }
}

#[test]
fn a_base_is_never_driven_as_something_else() {
    let sides = "drive = \"skid-steer\"\nleft_wheels = [\"left_wheel_joint\"]\nright_wheels = [";
    let free = |keys: &str| format!("drive = \"omnidirectional\"\n{keys}");
    four_wheels("wheel").says(&[
        "carrier.urdf",
        "other wheels that may be driven: `rear_left_joint`, `rear_right_joint`",
        "\"skid-steer\"",
    ]);
    for drive in ["", "drive = \"differential\"\n", "drive = \"skid-steer\"\n"] {
        let wheels = match drive.contains("skid") {
            true => "left_wheels = [\"left_wheel_joint\"]\nright_wheels = [\"right_wheel_joint\"]",
            false => TWO_WHEELS,
        };
        four_wheels("mecanum_wheel").with(TOML, TWO_WHEELS, &format!("{drive}{wheels}")).says(&[
            "this base has mecanum or omnidirectional wheels: `rear_left_joint`",
            "write drive = \"omnidirectional\"",
        ]);
    }
    let said = format!("drive = \"differential\"\n{TWO_WHEELS}");
    assert_eq!(loaded(&four_wheels("wheel").with(TOML, TWO_WHEELS, &said)).wheels.len(), 2);
    for (keys, parts) in [
        (
            "drive = \"tracked\"\n".to_owned(),
            vec!["carrier.toml:", "unknown variant `tracked`", "`skid-steer`"],
        ),
        ("drive = \"differential\"".to_owned(), vec!["left_wheel: a differential drive needs it"]),
        (format!("{sides}\"right_wheel_joint\", \"x\"]"), vec!["right_wheels", "unknown joint `x`"]),
        (
            format!("{sides}\"right_wheel_joint\", \"right_wheel_joint\"]"),
            vec!["`right_wheel_joint` in right_wheels", "duplicate"],
        ),
        (
            format!("{sides}\"right_wheel_joint\"]\nwheel_separation_multiplier = 0.5"),
            vec!["wheel_separation_multiplier = 0.5", "from 1 to 5"],
        ),
        (free("base_speed_limit_m_s = 1"), vec!["base_turn_limit_rad_s: an omnidirectional drive needs it"]),
        (
            free("base_speed_limit_m_s = 0\nbase_turn_limit_rad_s = 2"),
            vec!["base_speed_limit_m_s = 0", "greater than 0"],
        ),
        (
            free(&format!("{LIMITS}\nleft_wheel = \"left_wheel_joint\"")),
            vec!["left_wheel does not apply to drive = \"omnidirectional\"", "base_speed_limit_m_s"],
        ),
        (
            free(&format!("{LIMITS}\nmecanum_wheels = [\"left_wheel_joint\"]\nomni_wheels = []")),
            vec!["mecanum_wheels or omni_wheels, not both"],
        ),
        (
            format!("{TWO_WHEELS}\nbase_speed_limit_m_s = 1"),
            vec!["base_speed_limit_m_s does not apply to drive = \"differential\""],
        ),
    ] {
        Files::new().with(TOML, TWO_WHEELS, &keys).says(&parts);
    }
    // a slow base is told without wheels that it does not name
    let slow = free("base_speed_limit_m_s = 0.3\nbase_turn_limit_rad_s = 2");
    let slow = loaded(&Files::new().with(TOML, TWO_WHEELS, &slow));
    let warning = slow_drive(&slow, &slow.postures[0].joints, 0.5, true).expect("slow").to_string();
    assert!(warning.contains("base drives 0.300 m/s at most (base_speed_limit_m_s)"), "{warning}");
}

#[test]
fn drafts_ask_for_the_drive_where_names_do_not_tell() {
    let draft = |files: &Files, drive, wheels: Option<[&str; 2]>| {
        let _ = files.load(TOML);
        let wheels = wheels.map(|names| names.map(str::to_owned));
        let request = DraftRequest { drive, wheels, ..DraftRequest::default() };
        Draft::new(&files.folder.path().join(URDF), URDF, "d.toml", &request)
    };
    let said = |files: &Files, drive, wheels| draft(files, drive, wheels).expect_err("refused").to_string();
    let named = Some(["left_wheel_joint", "right_wheel_joint"]);
    let four = four_wheels("wheel");
    for wheels in [None, named] {
        let said = said(&four, None, wheels);
        assert!(said.contains("4 wheels could be driven") && said.contains("--drive skid-steer"), "{said}");
    }
    let two = draft(&four, Some(DriveKind::Differential), named).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(two.robot.drive.kind, DriveKind::Differential);
    let skids = draft(&four, Some(DriveKind::SkidSteer), None).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(skids.robot.drive.kind, DriveKind::SkidSteer);
    assert!(
        skids.text.contains("left_wheels = [\"left_wheel_joint\", \"rear_left_joint\"]"),
        "{}",
        skids.text
    );
    let mecanum = four_wheels("mecanum_wheel");
    let free = draft(&mecanum, None, None).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(free.robot.drive.kind, DriveKind::Omnidirectional);
    assert_eq!(free.robot.wheels.len(), 4);
    assert!(free.assumed.iter().any(|line| line.contains("mecanum")), "{:?}", free.assumed);
    // and who says otherwise is not believed
    let said = said(&mecanum, Some(DriveKind::Differential), named);
    assert!(said.contains("mecanum or omnidirectional wheels"), "{said}");
}

#[test]
fn robot_check_tells_the_drive() {
    let output = cocarry(&["robot", "check", OMNI]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(said.contains("drive  omnidirectional: up to 1.04 m/s along x and y, and 2.00 rad/s"), "{said}");
    let checked = json(&["robot", "check", OMNI, "--json"]);
    assert_eq!(checked["drive"]["kind"], "omnidirectional");
    assert_eq!(checked["drive"]["wheels"][1]["joint"], "front_right_wheel_joint");
    let spin = checked["drive"]["wheels"][0]["spin"][1].as_f64().expect("a number");
    assert!((spin + 1.0 / 0.06).abs() < 1e-9, "{spin}");
}

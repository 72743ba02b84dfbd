//! The physical plant: what it does is what mechanics says, within stated errors, and the same bits every
//! time.

mod accuracy;
mod collisions;
mod repeatability;

use crate::support::repository;
use cocarry::geometry::{PlanarPose, Point, Pose, angle_of, direction, left_of, wrap_angle};
use cocarry::math;
use cocarry::robot::{Configuration, InputVector, JointVector, Robot, pose_difference};
use cocarry::simulation::{
    BodyKind, Failure, HumanCommand, HumanSettings, Observation, PhysicalPlant, PhysicsSettings,
};
use cocarry::world::World;
use nalgebra::{SMatrix, SVector, Vector3};
use std::f64::consts::FRAC_PI_2;

const PERIOD: f64 = 0.2;
const AT_ORIGIN: PlanarPose = PlanarPose { position: Point::new(0.0, 0.0), yaw: 0.0 };
const GRAVITY: f64 = 9.81;
/// A wall across the way, at WALL (m).
const WALL: &str = "[[obstacle]]\nname = \"wall\"\nshape = \"box\"\ncenter_m = [WALL, 0]\nsize_m = [0.2, 3]\nheight_m = 1.2\n";

fn carrier() -> Robot {
    Robot::built_in().unwrap_or_else(|e| panic!("{e}"))
}

/// A world without obstacles but for those of `more`.
fn world(more: &str) -> World {
    let text = format!("name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n{more}");
    World::parse("w.toml", &text).unwrap_or_else(|e| panic!("{e}"))
}

fn steady() -> PhysicsSettings {
    let settings = PhysicsSettings::default();
    PhysicsSettings { human: settings.human.steady(), ..settings }
}

fn plant(robot: &Robot, world: &World, settings: &PhysicsSettings) -> PhysicalPlant {
    PhysicalPlant::new(world, robot, &robot.postures[0].joints, &AT_ORIGIN, settings, 7)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Both rims at a speed (m/s) and a turning rate (rad/s) of the base.
fn wheels(robot: &Robot, speed: f64, turn: f64) -> InputVector {
    let mut rates = InputVector::zeros();
    rates[0] = speed - turn * robot.drive.track / 2.0;
    rates[1] = speed + turn * robot.drive.track / 2.0;
    rates
}

/// The way around a corner: straight, a quarter turn to the left on a circle of 1 m, straight.
fn corner(along: f64) -> Point {
    let angle = (along - 1.6).clamp(0.0, FRAC_PI_2);
    let bend = Point::new(along.min(1.6) + math::sin(angle), 1.0 - math::cos(angle));
    bend + direction(angle) * (along - 1.6 - FRAC_PI_2).max(0.0)
}

/// The object's centre on that way, its ends heading along the way too: 0.5 m/s after a second, 0.5 rad/s in
/// the bend.
fn around_a_corner(time: f64) -> PlanarPose {
    let along = if time < 1.0 { 0.25 * time * time } else { 0.25 + 0.5 * (time - 1.0) };
    let [rear, front] = [corner(along - 0.6), corner(along + 0.6)];
    PlanarPose { position: corner(along), yaw: angle_of(front - rear) }
}

/// The grasp of an object whose centre is at `center`.
fn grasp_of(robot: &Robot, center: &PlanarPose, reach: f64) -> Pose {
    let rear = PlanarPose { position: center.position - direction(center.yaw) * reach, ..*center };
    rear.at_height(robot.grasp_height)
}

/// Rates that carry the object on around the corner from `time` (s): what the way asks for and half of the
/// error, by least squares over wheels and joints.
fn around(robot: &Robot, seen: &Observation, time: f64, reach: f64) -> InputVector {
    let at = robot.kinematics(&seen.configuration);
    let [now, next] = [time, time + PERIOD].map(|t| grasp_of(robot, &around_a_corner(t), reach));
    let twist = (pose_difference(&next, &now) + pose_difference(&now, &at.grasp) * 0.5) / PERIOD;
    let gram = at.jacobian * at.jacobian.transpose() + SMatrix::<f64, 6, 6>::identity() * 1e-4;
    at.jacobian.transpose() * gram.cholesky().expect("positive").solve(&twist)
}

fn horizontal(force: &Vector3<f64>) -> f64 {
    force.xy().norm()
}

fn assert_links_agree(robot: &Robot, plant: &PhysicalPlant, most: f64) {
    let configuration: Configuration = plant.observe().configuration;
    let expected = robot.link_poses(&configuration);
    for ((link, expected), found) in robot.links.iter().zip(expected).zip(plant.link_poses()) {
        let off = pose_difference(&expected, &found).norm();
        assert!(off < most, "{}: {} is off by {off}", robot.name, link.name);
    }
    let grasp = pose_difference(&robot.grasp_pose(&configuration), &plant.observe().grasp).norm();
    assert!(grasp < most, "{}: the grasp is off by {grasp}", robot.name);
}

fn robots() -> Vec<Robot> {
    let six = repository("tests/fixtures/robots/six.toml");
    let six = six.is_file().then(|| Robot::load(&six).unwrap_or_else(|e| panic!("{e}")));
    [Some(carrier()), six].into_iter().flatten().collect()
}

#[test]
fn closed_form_links_are_where_the_kinematics_say() {
    for robot in robots() {
        let mut plant = plant(&robot, &world(""), &PhysicsSettings::default());
        assert_links_agree(&robot, &plant, 1e-6);
        for tick in 0..10 {
            let mut rates = wheels(&robot, 0.3, 0.2);
            for i in 0..robot.joint_count() {
                rates[2 + i] = 0.15 * math::sin(f64::from(tick) + i as f64);
            }
            plant.step(&rates, &HumanCommand::Follow, PERIOD);
        }
        assert_links_agree(&robot, &plant, 1e-6);
    }
}

/// Joints that mimic others stay with them, and the motors of the others bear their load: at rest, the
/// efforts are what the Jacobian makes of the grip's force.
#[test]
fn closed_form_mimicking_joints_stay_with_the_joints_that_bear_their_load() {
    let robot = crate::robots::carrier_that_mimics();
    let mut plant = plant(&robot, &world(""), &steady());
    assert_links_agree(&robot, &plant, 1e-6);
    for tick in 0..40 {
        let mut rates = wheels(&robot, 0.3, 0.4 * math::sin(f64::from(tick) / 4.0));
        rates[2 + robot.joint_count() - 1] = 0.5 * math::sin(f64::from(tick) / 3.0);
        let seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
        assert_eq!(seen.failure, None);
        assert_links_agree(&robot, &plant, 2e-3);
    }
    for _ in 0..50 {
        plant.step(&InputVector::zeros(), &HumanCommand::Follow, PERIOD);
    }
    let seen = plant.observe();
    let [force, torque] = [seen.grip.mean.force, seen.grip.mean.torque];
    let wrench = SVector::<f64, 6>::from_iterator(force.iter().chain(&torque).copied());
    let expected = robot.kinematics(&seen.configuration).jacobian.transpose() * wrench;
    for i in 0..robot.joint_count() {
        let (name, off) = (&robot.joints[i].name, seen.joint_efforts[i] - expected[2 + i]);
        assert!(off.abs() < 0.05, "{name}: {} and not {} Nm", seen.joint_efforts[i], expected[2 + i]);
    }
}

/// A gear begins where its joint is: nothing jumps in the first steps.
#[test]
fn closed_form_a_joint_that_mimics_one_away_from_zero_begins_at_rest() {
    for ratio in [-2.0, -0.5, 0.5, 1.0, 2.0] {
        let robot = crate::robots::carrier_with_mast(ratio);
        let mut plant = plant(&robot, &world(""), &steady());
        for tick in 0..20 {
            let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, PERIOD);
            assert_eq!(seen.failure, None);
            assert!(
                seen.grip.peak < 25.0 && seen.grip.deflection < 0.002,
                "{ratio}, {tick}: {:?}",
                seen.grip
            );
        }
        assert_links_agree(&robot, &plant, 2e-3);
    }
}

#[test]
fn closed_form_at_rest_the_grips_share_the_weight() {
    for robot in robots() {
        let world = world("");
        let mut plant = plant(&robot, &world, &steady());
        let weight = world.object.mass * GRAVITY;
        let mut settled = None;
        for tick in 0..50 {
            let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, PERIOD);
            assert_eq!(seen.failure, None);
            if tick < 10 {
                continue;
            }
            let [grip, hand] = [&seen.grip, &seen.hand_grip];
            let name = &robot.name;
            assert!(
                (grip.mean.force + hand.mean.force - Vector3::z() * weight).norm() < 1e-3,
                "{name}: {grip:?}"
            );
            assert!((grip.mean.force.z - weight / 2.0).abs() < 1.0, "{name}: {grip:?}");
            assert!(
                grip.deflection < 0.005 && hand.deflection < 0.005,
                "{name}: {} {}",
                grip.deflection,
                hand.deflection
            );
            assert!(grip.noise < 0.01 && hand.noise < 0.01, "{name}: {grip:?}");
            let from = *settled.get_or_insert(seen.object);
            let drift = pose_difference(&seen.object, &from).norm();
            assert!(drift < 1e-4, "{name}: {drift}");
            assert!((seen.object.translation.z - robot.grasp_height).abs() < 2e-3, "{name}: {}", seen.object);
        }
    }
}

/// Mass times the change of velocity is what the two grips and gravity did.
#[test]
fn closed_form_newton_and_euler_hold_for_the_object() {
    let robot = carrier();
    let world = world("");
    let mut plant = plant(&robot, &world, &PhysicsSettings::default());
    let object = world.object;
    let mut before = plant.observe();
    let (mut squares, mut moments, mut pulled, mut ticks) = (0.0, 0.0, 0.0_f64, 0.0);
    for _ in 0..40 {
        let seen = plant.step(&wheels(&robot, 0.4, 0.15), &HumanCommand::Follow, PERIOD);
        let [was, is] = [&before, &seen].map(|o| Vector3::from_column_slice(&o.object_twist[..3]));
        let force = seen.grip.mean.force + seen.hand_grip.mean.force;
        let residual = (is - was) * (object.mass / PERIOD) - force + Vector3::z() * (object.mass * GRAVITY);
        squares += residual.norm_squared();
        // about the upright axis: the beam stays level, its moment of inertia is the same all the time
        let [x, y, _] = object.size;
        let inertia = object.mass * (x * x + y * y) / 12.0;
        let axis = (seen.object.rotation * Vector3::x() + before.object.rotation * Vector3::x()).normalize();
        let lever = axis * (x / 2.0);
        let moment = lever.cross(&(seen.hand_grip.mean.force - seen.grip.mean.force))
            + seen.grip.mean.torque
            + seen.hand_grip.mean.torque;
        moments +=
            math::squared(inertia * (seen.object_twist[5] - before.object_twist[5]) / PERIOD - moment.z);
        pulled = pulled.max(horizontal(&seen.hand_grip.mean.force));
        ticks += 1.0;
        before = seen;
    }
    let (rms, turning) = (f64::sqrt(squares / ticks), f64::sqrt(moments / ticks));
    assert!(rms < 1e-9, "{rms} N");
    assert!(turning < 0.05, "{turning} Nm");
    assert!(pulled > 1.0);
}

#[test]
fn the_base_goes_as_told_and_never_sideways() {
    let robot = carrier();
    let mut plant = plant(&robot, &world(""), &PhysicsSettings::default());
    let drive = |plant: &mut PhysicalPlant, ticks: usize, speed: f64, turn: f64| {
        (0..ticks).map(|_| plant.step(&wheels(&robot, speed, turn), &HumanCommand::Follow, PERIOD)).last()
    };
    let start = plant.observe().configuration.base;
    drive(&mut plant, 20, 0.5, 0.0);
    let seen = drive(&mut plant, 5, 0.0, 0.0).expect("steps");
    let base = seen.configuration.base;
    let gone = base.position - start.position;
    assert!((gone.x - 2.0).abs() < 0.01 && gone.y.abs() < 1e-3, "{gone:?}");
    assert!(base.yaw.abs() < 0.01, "{}", base.yaw);
    // the wheels have rolled that far
    for angle in seen.rolled.iter().take(2) {
        assert!((angle * robot.drive.wheel_radius - gone.x).abs() < 0.01, "{angle}");
    }
    let start = base;
    drive(&mut plant, 20, 0.0, 0.4);
    let base = drive(&mut plant, 5, 0.0, 0.0).expect("steps").configuration.base;
    assert!((wrap_angle(base.yaw - start.yaw) - 1.6).abs() < 0.01, "{}", base.yaw - start.yaw);
    assert!((base.position - start.position).norm() < 2e-3);
    // on an arc, against the heading in the middle of each tick
    let (mut slip, mut walked) = (0.0, 0.0);
    let mut before = base;
    for _ in 0..25 {
        let seen = plant.step(&wheels(&robot, 0.4, -0.25), &HumanCommand::Follow, PERIOD);
        let base = seen.configuration.base;
        let middle = before.yaw + wrap_angle(base.yaw - before.yaw) / 2.0;
        slip += (base.position - before.position).dot(&left_of(direction(middle)));
        walked += (base.position - before.position).norm();
        before = base;
    }
    assert!(slip.abs() < 1e-3 * walked, "{slip} m of {walked} m");
}

/// The arm moves through its null space, so that nothing pulls at the object, as it does when it prepares a
/// pose.
#[test]
fn joints_track_their_rates_and_keep_their_limits() {
    let robot = carrier();
    let mut plant = plant(&robot, &world(""), &PhysicsSettings::default());
    let mut seen = plant.observe();
    let mut wanted = robot.postures[0].joints;
    let (mut before, mut moved) = (SVector::<f64, 7>::zeros(), 0.0);
    for tick in 0..25 {
        let arm = robot.kinematics(&seen.configuration).jacobian.fixed_columns::<7>(2).into_owned();
        let eigen = (arm.transpose() * arm).symmetric_eigen();
        let mut null = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        // from tick to tick the same way
        let forward = if tick == 0 { null[2] } else { null.dot(&before) };
        null *= 0.3 * forward.signum();
        before = null;
        let mut rates = InputVector::zeros();
        rates.fixed_rows_mut::<7>(2).copy_from(&null);
        let step = rates.fixed_rows::<8>(2) * PERIOD;
        wanted += step;
        moved += step.norm();
        seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
        let off = (seen.configuration.joints - wanted).amax();
        assert!(off < 0.01, "tick {tick}: {off} rad, efforts {}", seen.joint_efforts.transpose());
        let grasp = seen.grasp.translation.vector - plant_start(&robot);
        assert!(grasp.norm() < 0.02, "tick {tick}: {grasp}");
    }
    assert!(moved > 1.4, "{moved} rad");
    // far more than it can do
    let mut most = [0.0_f64; 2];
    for _ in 0..5 {
        let mut rates = wheels(&robot, 9.0, 0.0);
        rates[7] = -50.0;
        let seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
        most = [most[0].max(seen.base_rates[0]), most[1].max(seen.joint_rates[5].abs())];
        for (joint, effort) in robot.joints.iter().zip(seen.joint_efforts.iter()) {
            assert!(effort.abs() <= joint.effort_limit * (1.0 + 1e-5), "{}: {effort}", joint.name);
        }
        let lower = robot.joints[5].lower;
        assert!(seen.configuration.joints[5] > lower - 0.01, "{}", seen.configuration.joints[5]);
    }
    assert!(most[0] <= robot.drive.rim_speed_limit + 1e-3 && most[0] > 1.0, "{most:?}");
    assert!(most[1] <= robot.joints[5].rate_limit * 1.02, "{most:?}");
}

/// Where the grasp is at the start, m.
fn plant_start(robot: &Robot) -> Vector3<f64> {
    Vector3::new(-0.6, 0.0, robot.grasp_height)
}

/// 20 kg at its end are more than a wrist of half the effort can hold up: what it cannot hangs on the hand,
/// which gives way.
#[test]
fn an_object_that_is_too_heavy_sinks() {
    let mut robot = carrier();
    robot.joints[5].effort_limit *= 0.5;
    let name = robot.joints[5].name.clone();
    let mut joints = robot.links.iter_mut().filter_map(|link| link.joint.as_mut());
    joints.find(|joint| joint.name == name).expect("the wrist").limits.effort *= 0.5;
    let heavy = world("[object]\nsize_m = [1.2, 0.1, 0.1]\nmass_kg = 40.0\n");
    let mut plant = plant(&robot, &heavy, &steady());
    let wrist = &robot.joints[5];
    let (mut last, mut most) = (plant.observe(), 0.0_f64);
    let mut at_limit = JointVector::zeros();
    for _ in 0..15 {
        last = plant.step(&InputVector::zeros(), &HumanCommand::Follow, PERIOD);
        most = most.max(last.joint_efforts[5].abs());
        assert!(last.effort_share <= 1.0 + 1e-5, "{}", last.effort_share);
        at_limit += last.time_at_limit;
    }
    assert!(most > 0.95 * wrist.effort_limit && most <= wrist.effort_limit * (1.0 + 1e-5), "{most}");
    // which motor, and how long
    assert!(
        at_limit[5] > 1.0 && at_limit.iter().enumerate().all(|(i, time)| i == 5 || *time < 0.2),
        "{at_limit}"
    );
    assert!(last.object.translation.z < 0.68, "{}", last.object);
    let more = last.hand_grip.mean.force.z - 20.0 * 9.81;
    assert!(more > 20.0, "{more} N");
}

#[test]
fn a_human_who_follows_around_a_corner_feels_little() {
    let robot = carrier();
    let world = world("");
    let reach = world.object.size[0] / 2.0;
    let mut plant = plant(&robot, &world, &PhysicsSettings::default());
    let mut seen = plant.observe();
    let (mut deflection, mut forces, mut off) = ([0.0_f64; 2], vec![], 0.0_f64);
    for tick in 1..=45 {
        let goal = around_a_corner(f64::from(tick) * PERIOD);
        let rates = around(&robot, &seen, f64::from(tick - 1) * PERIOD, reach);
        seen = plant.step(&rates, &HumanCommand::Follow, PERIOD);
        assert_eq!(seen.failure, None);
        deflection = [deflection[0].max(seen.grip.deflection), deflection[1].max(seen.hand_grip.deflection)];
        forces.push(horizontal(&seen.hand_grip.mean.force));
        off = off.max((seen.object.translation.vector.xy() - goal.position.coords).norm());
    }
    let mean = forces.iter().sum::<f64>() / forces.len() as f64;
    assert!(deflection[0] < 0.002 && deflection[1] < 0.02, "{deflection:?}");
    assert!(mean < 6.0, "{mean} N");
    assert!(off < 0.03, "{off} m");
}

#[test]
fn a_human_who_walks_leads_around_a_corner() {
    let robot = carrier();
    let world = world("");
    let reach = world.object.size[0] / 2.0;
    let mut plant = plant(&robot, &world, &PhysicsSettings::default());
    let mut seen = plant.observe();
    let mut deflection = [0.0_f64; 2];
    for tick in 1..=45 {
        let goal = around_a_corner(f64::from(tick) * PERIOD);
        let hand = PlanarPose { position: goal.position + direction(goal.yaw) * reach, ..goal };
        let rates = around(&robot, &seen, f64::from(tick - 1) * PERIOD, reach);
        seen = plant.step(&rates, &HumanCommand::Walk { hand }, PERIOD);
        deflection = [deflection[0].max(seen.grip.deflection), deflection[1].max(seen.hand_grip.deflection)];
        if tick > 8 {
            assert!((seen.hand_planar.position - hand.position).norm() < 0.02, "tick {tick}");
        }
    }
    assert!(deflection[0] < 0.002 && deflection[1] < 0.02, "{deflection:?}");
}

/// The force with which a standing human pulls is each grip's stiffness times its deflection.
#[test]
fn closed_form_grips_yield_as_stiff_as_they_are_set() {
    let robot = carrier();
    let world = world("");
    let hand = Point::new(world.object.size[0] / 2.0 + 0.006, 0.0);
    let hand = HumanCommand::Walk { hand: PlanarPose { position: hand, yaw: 0.0 } };
    for (gripper, held) in [(20_000.0, 1200.0), (5000.0, 1200.0), (20_000.0, 4000.0)] {
        let human = HumanSettings { hand_stiffness: held, ..steady().human };
        let mut plant =
            plant(&robot, &world, &PhysicsSettings { gripper_stiffness: gripper, human, ..steady() });
        let mut seen = plant.observe();
        for _ in 0..15 {
            seen = plant.step(&InputVector::zeros(), &hand, PERIOD);
        }
        for (grip, stiffness) in [(&seen.grip, gripper), (&seen.hand_grip, held)] {
            let (force, expected) = (horizontal(&grip.last.force), stiffness * grip.deflection);
            assert!(force > 4.0 && (force / expected - 1.0).abs() < 0.05, "{force} N, {expected} N");
        }
    }
}

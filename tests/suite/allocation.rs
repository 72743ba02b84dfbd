//! A control tick allocates nothing once it is warm.

use crate::support::{load, repository};
use cocarry::control::{self, RobotObstacles, SolveOutcome};
use cocarry::episode::{Episode, EpisodeSettings, Manipulator};
use cocarry::geometry::{Footprint, Point};
use cocarry::learning;
use cocarry::policy::Method;
use cocarry::robot::Robot;
use cocarry_studies::paper::EXAMPLE_HUMAN;

/// Ticks after which every buffer has had what it needs.
const WARM: u64 = 60;

#[test]
fn a_warm_control_tick_allocates_nothing() {
    let (free, limited) = count(1.0, |_| ());
    assert!(free > 100, "{free} ticks without an active limit");
    let slow = count(0.15, |_| ());
    assert!(limited + slow.1 > 50, "{} ticks with active limits", limited + slow.1);
}

/// A base of 0.9 m by 0.5 m, whose corners have half-planes of their own.
#[test]
fn a_warm_control_tick_of_a_long_base_allocates_nothing() {
    let corners = [(-0.45, -0.25), (0.45, -0.25), (0.45, 0.25), (-0.45, 0.25)];
    let corners = corners.map(|(x, y)| Point::new(x, y)).to_vec();
    let (_, limited) = count(1.0, |robot| {
        robot.footprint = Footprint::Polygon(corners.clone());
        robot.drive.base_radius = 0.52;
    });
    assert!(limited > 10, "{limited} ticks with active limits");
}

#[test]
fn a_warm_tick_of_a_robot_that_learns_allocates_nothing() {
    let robot = Robot::built_in().expect("the built-in robot");
    let (world, options) = load(&repository("worlds/environment-4.toml"));
    let obstacles = RobotObstacles::new(&world);
    let control = control::ControlSettings::default();
    let manipulator =
        Manipulator { robot: &robot, posture: robot.postures[0].joints, control, obstacles: &obstacles };
    let learning =
        Some(learning::LearningSettings { look_steps: 3, ..learning::LearningSettings::default() });
    let settings = EpisodeSettings { method: Method::HUMAN_LED, learning, ..EpisodeSettings::default() };
    let mut episode =
        Episode::builder(&options, &settings, EXAMPLE_HUMAN).with_robot(manipulator).begin().expect("room");
    let mut sightings = 0;
    loop {
        let before = episode.learner().map_or(0, |learner| learner.perception().size());
        let mut ended = false;
        let allocated = allocation_counter::measure(|| ended = episode.step().is_some());
        if ended {
            break;
        }
        let step = episode.tick().step;
        if step > WARM {
            assert_eq!(allocated.count_total, 0, "step {step}");
            sightings += usize::from(episode.learner().is_some_and(|l| l.perception().size() != before));
        }
    }
    assert!(sightings > 5, "{sightings} sightings that changed the belief");
}

/// Runs episodes of the built-in robot `with` a change, whose joints have this share of their speed, and
/// asserts that no warm tick allocates. How many of these had no limit active, and how many had.
fn count(share: f64, with: impl Fn(&mut Robot)) -> (usize, usize) {
    let mut robot = Robot::built_in().expect("the built-in robot");
    with(&mut robot);
    for joint in &mut robot.joints {
        joint.rate_limit *= share;
    }
    let (world, options) = load(&repository("worlds/environment-4.toml"));
    let obstacles = RobotObstacles::new(&world);
    let (mut free, mut limited) = (0, 0);
    for method in [Method::HUMAN_LED, Method::ROBOT_LED] {
        let settings = EpisodeSettings { method, ..EpisodeSettings::default() };
        let posture = robot.postures[0].joints;
        let control = control::ControlSettings::default();
        let manipulator = Manipulator { robot: &robot, posture, control, obstacles: &obstacles };
        let mut episode = Episode::builder(&options, &settings, EXAMPLE_HUMAN)
            .with_robot(manipulator)
            .begin()
            .expect("room");
        loop {
            let mut ended = false;
            let allocated = allocation_counter::measure(|| ended = episode.step().is_some());
            if ended {
                break;
            }
            let tick = episode.tick();
            if tick.step <= WARM {
                continue;
            }
            assert_eq!(allocated.count_total, 0, "{method:?}, speed {share}, step {}", tick.step);
            let robot = tick.robot.expect("a robot");
            let in_pose = robot.preparation.is_some_and(|p| p.constrained > 0);
            match in_pose || robot.outcome != SolveOutcome::Unconstrained {
                true => limited += 1,
                false => free += 1,
            }
        }
    }
    (free, limited)
}

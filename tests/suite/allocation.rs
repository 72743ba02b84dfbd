//! A control tick allocates nothing once it is warm.

use crate::support::{load, repository};
use cocarry::control::{self, RobotObstacles, SolveOutcome};
use cocarry::coordination::Method;
use cocarry::episode::{Episode, Manipulator, Settings};
use cocarry::experiments::paper::EXAMPLE_HUMAN;
use cocarry::robot::Robot;

/// Ticks after which every buffer has had what it needs.
const WARM: u64 = 60;

#[test]
fn a_warm_control_tick_allocates_nothing() {
    let robot = Robot::built_in().expect("the built-in robot");
    let (world, options) = load(&repository("worlds/environment-4.toml"));
    let obstacles = RobotObstacles::new(&world);
    for method in [Method::HumanLed, Method::RobotLed] {
        let settings = Settings { method, ..Settings::default() };
        let posture = robot.postures[0].joints;
        let control = control::Settings::default();
        let manipulator = Manipulator { robot: &robot, posture, control, obstacles: &obstacles };
        let mut episode = Episode::new(&options, &settings, EXAMPLE_HUMAN).with_robot(manipulator);
        let mut looked_at = 0;
        loop {
            let mut ended = false;
            let allocated = allocation_counter::measure(|| ended = episode.step().is_some());
            if ended {
                break;
            }
            let tick = episode.tick();
            let robot = tick.robot.expect("a robot");
            let free = robot.outcome == SolveOutcome::Unconstrained
                && robot.preparation.is_none_or(|p| p.constrained == 0);
            if tick.step > WARM && free {
                assert_eq!(allocated.count_total, 0, "{method:?}, step {}", tick.step);
                looked_at += 1;
            }
        }
        assert!(looked_at > 30, "{method:?}: {looked_at} ticks");
    }
}

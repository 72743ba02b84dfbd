//! The pace of a team: its speed, its travel along a path, and how it slows.

use super::object_room::MAX_TURN_RAD_PER_M;
use crate::geometry::{PlanarPose, wrap_angle};
use crate::options::turned;
use crate::robot::{Drive, JointVector, Robot, SlowDrive};
use serde::{Deserialize, Serialize};

/// Acceleration of the team, m/s^2.
pub(crate) const TEAM_ACCELERATION: f64 = 0.9;
/// Speed at which position errors are corrected, as a multiple of the walking speed.
const CATCH_UP_FACTOR: f64 = 1.5;
/// Speed of a reversing team, m/s.
const REVERSING_SPEED: f64 = 0.35;
/// A team slows before a bend on which the object would turn faster than this (rad/s), by the square of the
/// ratio, but not below a share of its speed. Behind the object the base has to go round the same bend, and
/// the arm has to make up for both.
const BEND_RATE: f64 = 0.85;
const BEND_LEAST_SHARE: f64 = 0.2;
/// Distance (m) between the places where the object's turning is looked at, and their number.
const BEND_STEP_M: f64 = 0.1;
const BEND_STEPS: u32 = 4;

/// The share of a drive's largest speed that carrying takes at most, in bends; the rest is for catching up.
const DRIVE_SHARE: f64 = 0.8;

/// No team walks more slowly for its robot, m/s: one that is slower still stays behind.
const MIN_SPEED: f64 = 0.05;

/// The largest walking speed of a team whose robot starts in a posture, m/s: at it, the drive goes round bends
/// with this share of its largest speed.
fn walking_speed(robot: &Robot, joints: &JointVector, share: f64) -> f64 {
    let Drive { rim_speed_limit, track, .. } = robot.drive;
    let most = share * rim_speed_limit;
    // the outer rim is so far from the grasp's path
    let lever = if robot.drive.is_omnidirectional() { 0.0 } else { track / 2.0 };
    let lever = lever + robot.kept_offset(joints).abs();
    // the object turns by so much in a metre, but the team slows where that is faster than the rate
    (most / (1.0 + lever * MAX_TURN_RAD_PER_M)).max(most - lever * BEND_RATE).max(MIN_SPEED)
}

/// A warning if the drive of a robot that starts in a posture is too slow for a team that walks at `speed`
/// (m/s): with bodies if nothing would be left for catching up, without them if the drive itself cannot go
/// round bends.
pub fn slow_drive(robot: &Robot, joints: &JointVector, speed: f64, has_bodies: bool) -> Option<SlowDrive> {
    let walked = walking_speed(robot, joints, DRIVE_SHARE);
    let most = if has_bodies { walked } else { walking_speed(robot, joints, 1.0) };
    let Drive { rim_speed_limit: limit, wheel_radius, .. } = robot.drive;
    (most < speed).then(|| SlowDrive {
        robot: robot.name.clone(),
        limit,
        wheel_radius: if robot.drive.is_omnidirectional() { 0.0 } else { wheel_radius },
        offset: robot.kept_offset(joints).abs(),
        speed,
        walked,
    })
}

/// The team's walking parameters, which the robot knows.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Planning step, s.
    pub step: f64,
    /// Control period, s.
    pub period: f64,
    /// Walking speed, m/s.
    pub speed: f64,
    /// Largest yaw rate of the human, rad/s.
    pub yaw_rate: f64,
}

/// The direction of travel along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Travel {
    /// Toward the path's end.
    #[default]
    Forward,
    /// Toward a place with room to turn. The leader announces the reversal.
    Backward,
}

impl Pace {
    /// One step of the object's pose from `at` toward `goal`, as fast as it can be carried there.
    pub(super) fn toward(&self, at: &PlanarPose, goal: &PlanarPose) -> PlanarPose {
        let way = goal.position - at.position;
        let most = CATCH_UP_FACTOR * self.speed * self.period;
        let share = if way.norm() > most { most / way.norm() } else { 1.0 };
        PlanarPose {
            position: at.position + way * share,
            yaw: turned(at.yaw, goal.yaw, self.yaw_rate * self.period),
        }
    }
}

impl Travel {
    /// Target speed of the team, m/s; negative when reversing.
    pub(super) fn speed(self, pace: &Pace) -> f64 {
        match self {
            Self::Forward => pace.speed,
            Self::Backward => -REVERSING_SPEED,
        }
    }

    /// The share of its speed that a team keeps before a bend, from the object's pose at distances (m) ahead.
    /// A reversing team is slow enough.
    pub(super) fn share_on_bend(self, pace: &Pace, pose: impl Fn(f64) -> PlanarPose) -> f64 {
        if self == Self::Backward {
            return 1.0;
        }
        let mut yaw = pose(0.0).yaw;
        let turns = (1..=BEND_STEPS).map(|i| {
            let before = std::mem::replace(&mut yaw, pose(BEND_STEP_M * f64::from(i)).yaw);
            wrap_angle(yaw - before).abs()
        });
        let rate = turns.fold(0.0, f64::max) / BEND_STEP_M * pace.speed;
        let ratio = BEND_RATE / rate;
        (ratio * ratio).clamp(BEND_LEAST_SHARE, 1.0)
    }

    /// Speed after one period of a team that has the speed `speed`, at most this `share` of the target speed,
    /// m/s; negative when reversing.
    pub(super) fn speed_after(self, speed: f64, share: f64, pace: &Pace) -> f64 {
        let change = TEAM_ACCELERATION * pace.period;
        match self {
            Self::Forward => (speed + change).min(pace.speed * share),
            Self::Backward => (speed - change).max(-REVERSING_SPEED * share),
        }
    }
}

/// The share of a speed that remains at a value: 1 up to the first limit, 0 at the second, but no less than
/// `least`.
pub(super) fn share([slower, stop]: [f64; 2], value: f64, least: f64) -> f64 {
    ((stop - value) / (stop - slower)).clamp(least, 1.0)
}

//! Path following of an omnidirectional base: it moves along the path in any direction, and turns so that the
//! grasp stays ahead of it.

use crate::geometry::{PlanarPose, Vector, angle_of, wrap_angle};
use crate::robot::{BaseInput, BaseTwist, Drive};
use nalgebra::Rotation2;

/// Look-ahead distances along the path, m. A base that need not turn first can look out less far than one
/// that does, and cuts corners less.
pub(super) const LOOK_AHEADS_M: [f64; 2] = [0.45, 0.3];

/// A base's view of its path in a step.
pub(super) struct Sight {
    /// From the base to the point ahead on the path; when reversing, from the point behind to the base, m.
    pub goal: Vector,
    /// Wanted speed along the path, m/s; negative when reversing.
    pub speed: f64,
    /// From the base to the grasp at the end of the step, m.
    pub to_grasp: Vector,
    /// Bearing of the grasp from straight ahead, rad, which the base keeps.
    pub bearing: f64,
    /// Gain of turning toward the grasp, 1/s, and largest turning rate, rad/s.
    pub turning: [f64; 2],
    /// Largest acceleration along each axis, m/s^2.
    pub acceleration: f64,
}

impl Sight {
    /// The input after a step from `last`, within the limits of the drive.
    pub fn input(&self, drive: &Drive, at: &PlanarPose, last: &BaseInput, period: f64) -> BaseInput {
        let Self { goal, speed, to_grasp, bearing, turning: [gain, most], acceleration } = *self;
        let velocity = goal.try_normalize(1e-3).unwrap_or_default() * speed;
        let turn = match to_grasp.norm() > 1e-3 {
            true => gain * wrap_angle(angle_of(to_grasp) - bearing - at.yaw),
            false => 0.0,
        };
        let most = most.min(drive.turn_rate_limit);
        let velocity = Rotation2::new(-at.yaw) * velocity;
        let mut input = drive.input(&BaseTwist { velocity, turn: turn.clamp(-most, most) });
        let fastest = input.x.abs().max(input.y.abs());
        if fastest > drive.rim_speed_limit {
            let scale = drive.rim_speed_limit / fastest;
            (input.x, input.y) = (input.x * scale, input.y * scale);
        }
        let change = drive.accelerations(acceleration) * period;
        BaseInput::from_fn(|i, _| input[i].clamp(last[i] - change[i], last[i] + change[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{DIFFERENTIAL, Follower, RobotObstacles};
    use crate::geometry::{Footprint, Point, direction, nearest_on_segment};
    use crate::robot::DriveKind;
    use crate::world::World;

    const DRIVE: Drive = Drive { kind: DriveKind::Omnidirectional, track: 0.0, ..DIFFERENTIAL };
    const DISC: Footprint = Footprint::Disc { center: Point::new(0.0, 0.0), radius: DRIVE.base_radius };
    const PERIOD: f64 = 0.2;

    /// The path of a grasp that goes round a corner of `angle` (rad) and is `walked` (m) past it.
    fn corner(angle: f64, walked: f64) -> Vec<Point> {
        let point = |along: f64| Point::from(direction(if along < 0.0 { 0.0 } else { angle }) * along);
        (0..50).rev().map(|i| point(walked - Follower::STEP * f64::from(i))).collect()
    }

    fn far_away() -> RobotObstacles {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-9, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"far\"\n\
                    shape = \"box\"\ncenter_m = [0, 50]\nsize_m = [1, 1]\nheight_m = 1\n";
        RobotObstacles::new(&World::parse("w.toml", text).unwrap())
    }

    /// Forward and backward, round corners, with a grasp ahead and to the side: the base stays on the path at
    /// its distance, and the grasp at its bearing.
    #[test]
    fn a_base_keeps_to_its_path_its_distance_and_its_bearing() {
        let obstacles = far_away();
        for (angle, bearing, speed) in
            [(0.0, 0.0, 0.5), (0.8, 0.0, 0.5), (-1.5, 0.3, 0.5), (0.6, -0.2, -0.3), (-0.9, 0.0, -0.3)]
        {
            let begin = if speed > 0.0 { -1.0 } else { 1.8 };
            let start = corner(angle, begin - 0.8)[49];
            let yaw = if speed > 0.0 { -bearing } else { angle - bearing };
            let mut base = PlanarPose { position: start, yaw };
            let mut input = BaseInput::zeros();
            for tick in 0..60 {
                let walked = begin + speed * PERIOD * f64::from(tick);
                let way = corner(angle, walked);
                let speeds = [speed; 2];
                let (rim_acceleration, distance) = (1.2, 0.8);
                let obstacles = &obstacles;
                let follower = Follower {
                    way: &way,
                    speeds,
                    acceleration: 0.9,
                    rim_acceleration,
                    distance,
                    bearing,
                    footprint: &DISC,
                    obstacles,
                };
                let before = input;
                input = follower.inputs(&DRIVE, &base, input, PERIOD)[0];
                let change = DRIVE.accelerations(rim_acceleration) * PERIOD;
                for i in 0..3 {
                    assert!((input[i] - before[i]).abs() <= change[i] + 1e-12 && input[i].abs() <= 1.3);
                }
                base = DRIVE.roll(&base, &(input * PERIOD));
                let off =
                    |w: &[Point]| (base.position - nearest_on_segment(base.position, w[0], w[1])).norm();
                let off = way.windows(2).map(off).fold(f64::INFINITY, f64::min);
                // on the sharpest corner at full speed; a team slows before a bend
                assert!(off < 0.15, "{angle} {speed}: {off} m off the way after {tick} steps");
            }
            let way = corner(angle, begin + speed * PERIOD * 59.0);
            let to_grasp = way[49] - base.position;
            let behind = to_grasp.norm();
            assert!((behind - 0.8).abs() < 0.15, "{angle} {speed}: {behind} m behind");
            let off = wrap_angle(angle_of(to_grasp) - bearing - base.yaw);
            assert!(off.abs() < 0.05, "{angle} {speed}: the grasp is {off} rad off its bearing");
        }
    }
}

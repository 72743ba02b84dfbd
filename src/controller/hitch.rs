//! The base of a robot whose grasp has poses to go through and no path: it follows them like a trailer.

use crate::control::{BaseInputs, HORIZON};
use crate::geometry::{PlanarPose, Point, Vector, direction, left_of, wrap_angle};
use crate::robot::{BaseInput, BaseTwist, Drive};

/// Gain of the distance between the two points, 1/s.
const HITCH_GAIN: f64 = 1.0;
/// The periods over which the velocity of the hitch is the mean: the base does not follow what is faster.
const SMOOTHING: usize = 3;
/// Angle of the object to the base (rad) beyond which the base turns toward the object; the gain, 1/s; and
/// the largest rate, rad/s.
const FOLD_LIMIT_RAD: f64 = 0.6;
const FOLD_GAIN: f64 = 2.0;
const FOLD_RATE_LIMIT: f64 = 0.8;
/// Largest rate at which the base turns, rad/s.
const TURN_RATE_LIMIT: f64 = 1.3;

/// The hitch between base and object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hitch {
    /// The hitch on the base, m: ahead of the base in the direction of `bearing`, and to the left.
    ahead: f64,
    left: f64,
    /// The hitch on the object: distance behind the grasp, m.
    behind: f64,
    /// Angle of the grasp from straight ahead of the base, rad; 0 on a differential base.
    bearing: f64,
    /// Acceleration of the rims that the base plans with, m/s^2.
    rim_acceleration: f64,
}

impl Hitch {
    /// The hitch at `ahead` (m) of the base and at `left` (m), both in the direction of `bearing` (rad), and
    /// `behind` (m) the grasp on the object's line.
    pub fn new([ahead, left, bearing]: [f64; 3], behind: f64, rim_acceleration: f64) -> Self {
        Self { ahead, left, behind, bearing, rim_acceleration }
    }

    /// Inputs with which the base follows a grasp that goes from `grasp` through `poses`, one per `period`
    /// (s). The velocity of the hitch is that of a point ahead of the base, so it gives the base's speed and
    /// turning rate. `last` is the present input.
    pub fn inputs(
        &self,
        drive: &Drive,
        base: &PlanarPose,
        last: BaseInput,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        period: f64,
    ) -> BaseInputs {
        let on_object = |t: usize| {
            let pose = if t == 0 { grasp } else { &poses[t - 1] };
            (pose.position - direction(pose.yaw) * self.behind, pose.yaw)
        };
        let (mut at, mut last) = (*base, last);
        std::array::from_fn(|t| {
            let (here, yaw) = on_object(t);
            let from = t.min(HORIZON - SMOOTHING);
            let way = on_object(from + SMOOTHING).0 - on_object(from).0;
            let velocity = way / (SMOOTHING as f64 * period) + (here - self.on_base(&at)) * HITCH_GAIN;
            last = self.input(drive, &at, last, velocity, yaw, period);
            at = drive.roll(&at, &(last * period));
            last
        })
    }

    fn heading(&self, base: &PlanarPose) -> Vector {
        direction(base.yaw + self.bearing)
    }

    /// The hitch on the base, m, world frame.
    fn on_base(&self, base: &PlanarPose) -> Point {
        let ahead = self.heading(base);
        base.position + ahead * self.ahead + left_of(ahead) * self.left
    }

    /// The input after a period from `last` that gives the hitch this `velocity` (m/s), within the drive's
    /// limits. `yaw` is the object's, rad.
    fn input(
        &self,
        drive: &Drive,
        base: &PlanarPose,
        last: BaseInput,
        velocity: Vector,
        yaw: f64,
        period: f64,
    ) -> BaseInput {
        let ahead = self.heading(base);
        let folded = wrap_angle(yaw - base.yaw - self.bearing);
        let excess = folded - folded.clamp(-FOLD_LIMIT_RAD, FOLD_LIMIT_RAD);
        let most = if drive.is_omnidirectional() {
            TURN_RATE_LIMIT.min(drive.turn_rate_limit)
        } else {
            TURN_RATE_LIMIT
        };
        let unfolding = (FOLD_GAIN * excess).clamp(-FOLD_RATE_LIMIT, FOLD_RATE_LIMIT);
        let turn = (velocity.dot(&left_of(ahead)) / self.ahead + unfolding).clamp(-most, most);
        let speed = velocity.dot(&ahead) + turn * self.left;
        let velocity = nalgebra::Rotation2::new(self.bearing) * Vector::new(speed, 0.0);
        let input = drive.input(&BaseTwist { velocity, turn });
        let fastest = input.x.abs().max(input.y.abs());
        let scale = if fastest > drive.rim_speed_limit { drive.rim_speed_limit / fastest } else { 1.0 };
        let change = drive.accelerations(self.rim_acceleration) * period;
        BaseInput::from_fn(|i, _| (input[i] * scale).clamp(last[i] - change[i], last[i] + change[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::robot::Robot;
    use nalgebra::Complex;
    use std::f64::consts::FRAC_PI_2;

    /// Drives a base for half a minute behind a grasp that goes at 0.5 m/s and turns at this rate (rad/s).
    /// Returns the distance between the two points of the hitch (m), and the base's speed (m/s) and turning
    /// rate (rad/s).
    fn towed(drive: &Drive, rate: f64) -> [f64; 3] {
        const PERIOD: f64 = 0.2;
        let hitch = Hitch::new([0.45, 0.0, 0.0], 0.3, 1.2);
        let begin = PlanarPose { position: Point::new(0.75, 0.0), yaw: 0.0 };
        let next = |pose: PlanarPose| {
            let yaw = pose.yaw + rate * PERIOD;
            PlanarPose {
                position: pose.position + direction(pose.yaw + rate * PERIOD / 2.0) * (0.5 * PERIOD),
                yaw,
            }
        };
        let (mut base, mut input, mut grasp) =
            (PlanarPose { position: Point::origin(), ..begin }, BaseInput::zeros(), begin);
        let mut before = base;
        for _ in 0..150 {
            let mut ahead = grasp;
            let poses = std::array::from_fn(|_| {
                ahead = next(ahead);
                ahead
            });
            input = hitch.inputs(drive, &base, input, (&grasp, &poses), PERIOD)[0];
            before = base;
            (base, grasp) = (drive.roll(&base, &(input * PERIOD)), next(grasp));
        }
        let on_object = grasp.position - direction(grasp.yaw) * hitch.behind;
        let speed = (base.position - before.position).norm() / PERIOD;
        [(on_object - hitch.on_base(&base)).norm(), speed, wrap_angle(base.yaw - before.yaw) / PERIOD]
    }

    /// The grasp goes round a circle of 2 m at the rate w, so that the hitch on the object, b behind it, is at
    /// p = sqrt(2^2 + b^2) from the middle. The law of the hitch on the base, at h from the middle (complex
    /// numbers), is i w h = V + G (p - h), where V = i w p (sin(m) / m) e^(i m) is the mean velocity of the
    /// next periods and m half the angle in them. The base, a behind its hitch, goes at w sqrt(|h|^2 - a^2).
    #[test]
    fn closed_form_a_base_follows_as_a_trailer() {
        let drive = Robot::built_in().unwrap().drive;
        let [apart, speed, turn] = towed(&drive, 0.0);
        assert!(apart < 1e-3 && (speed - 0.5).abs() < 1e-3 && turn.abs() < 1e-9, "{apart} {speed} {turn}");
        for rate in [0.25, -0.25] {
            let [apart, speed, turn] = towed(&drive, rate);
            let (w, p, half) = (0.25, 4.09_f64.sqrt(), 0.25 * SMOOTHING as f64 * 0.2 / 2.0);
            let mean = Complex::from_polar(w * math::sin(half) / half, half + FRAC_PI_2);
            let h = (mean + HITCH_GAIN) * p / Complex::new(HITCH_GAIN, w);
            let expected = [(h - p).norm(), w * (h.norm_sqr() - 0.45 * 0.45).sqrt(), rate];
            for (found, expected) in [apart, speed, turn].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
            }
        }
    }
}

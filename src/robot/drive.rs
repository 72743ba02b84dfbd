//! The drive of a base: its inputs, their limits, and the motion that they make.

use crate::geometry::{PlanarPose, Vector, direction, left_of, wrap_angle};
use crate::math;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The largest number of inputs of a base.
pub const MAX_BASE_INPUTS: usize = 3;

/// The base's part of the input u. Two driven sides: rim speeds left and right, m/s, and 0. Omnidirectional:
/// velocity ahead and to the left, m/s, and turning rate, rad/s.
pub type BaseInput = Vector3<f64>;

/// The kinds of drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriveKind {
    /// Two driven wheels on one axle, which roll without slipping.
    Differential,
    /// Driven wheels one behind the other on either side, which skid in turns. It moves like a differential
    /// drive with a wider track.
    SkidSteer,
    /// Mecanum wheels, omnidirectional wheels or powered casters: the base moves in any direction and turns
    /// at the same time.
    Omnidirectional,
}

impl DriveKind {
    /// Its word in robot files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Differential => "differential",
            Self::SkidSteer => "skid-steer",
            Self::Omnidirectional => "omnidirectional",
        }
    }
}

/// The drive of a base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Its kind.
    pub kind: DriveKind,
    /// Distance between the wheels' centres, m. Skid-steer: the effective track. Omnidirectional: 0.
    pub track: f64,
    /// Radius of the wheels, m; 0 for an omnidirectional base whose robot file names no wheels.
    pub wheel_radius: f64,
    /// Largest rim speed, m/s. Omnidirectional: largest speed along x and along y.
    pub rim_speed_limit: f64,
    /// Largest turning rate, rad/s.
    pub turn_rate_limit: f64,
    /// The largest distance of the base's outline from the drive's origin, m.
    pub base_radius: f64,
}

/// The motion that an input of a base makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseTwist {
    /// Velocity in the base's axes: ahead and to the left, m/s.
    pub velocity: Vector,
    /// Turning rate, rad/s.
    pub turn: f64,
}

impl Drive {
    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        if self.is_omnidirectional() { 3 } else { 2 }
    }

    /// Whether the base moves in any direction.
    pub fn is_omnidirectional(&self) -> bool {
        self.kind == DriveKind::Omnidirectional
    }

    /// The largest magnitude of each input.
    pub fn limits(&self) -> BaseInput {
        let speed = self.rim_speed_limit;
        BaseInput::new(speed, speed, if self.is_omnidirectional() { self.turn_rate_limit } else { 0.0 })
    }

    /// The largest change of each input per second, for rims (or a base, along each axis) of this
    /// `acceleration` (m/s^2). An omnidirectional base turns as if its wheels were on its edge.
    pub fn accelerations(&self, acceleration: f64) -> BaseInput {
        let turning = if self.is_omnidirectional() { acceleration / self.base_radius } else { 0.0 };
        BaseInput::new(acceleration, acceleration, turning)
    }

    /// The motion of an input.
    pub fn twist(&self, input: &BaseInput) -> BaseTwist {
        if self.is_omnidirectional() {
            return BaseTwist { velocity: Vector::new(input.x, input.y), turn: input.z };
        }
        let [left, right] = [input.x, input.y];
        BaseTwist { velocity: Vector::new((left + right) / 2.0, 0.0), turn: (right - left) / self.track }
    }

    /// The input of a motion. Two driven sides make no velocity to the left.
    pub fn input(&self, twist: &BaseTwist) -> BaseInput {
        let BaseTwist { velocity, turn } = *twist;
        if self.is_omnidirectional() {
            return BaseInput::new(velocity.x, velocity.y, turn);
        }
        let [left, right] = [-0.5, 0.5].map(|side| velocity.x + side * self.track * turn);
        BaseInput::new(left, right, 0.0)
    }

    /// The pose of the base after it has rolled this far at constant rates: an input times its duration. The
    /// base moves on an exact arc.
    pub fn roll(&self, base: &PlanarPose, by: &BaseInput) -> PlanarPose {
        let BaseTwist { velocity: way, turn } = self.twist(by);
        let half = turn / 2.0;
        // the chord of the arc: its ratio to the arc length is sin(half) / half
        let ratio = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { math::sin(half) / half };
        let ahead = direction(base.yaw + half);
        let mut position = base.position + ahead * (way.x * ratio);
        if self.is_omnidirectional() {
            position += left_of(ahead) * (way.y * ratio);
        }
        PlanarPose { position, yaw: wrap_angle(base.yaw + turn) }
    }

    /// The rolling rates for an input: of the left and the right wheels, rad/s; omnidirectional: the input
    /// itself. See [`Wheel::spin`].
    pub fn rolling(&self, input: &BaseInput) -> BaseInput {
        if self.is_omnidirectional() {
            return *input;
        }
        BaseInput::new(input.x / self.wheel_radius, input.y / self.wheel_radius, 0.0)
    }
}

/// A driven wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// Its link: index into [`Robot::links`](super::Robot::links).
    pub link: usize,
    /// Its angle (rad) is the sum of these times what has rolled: the angles of the left and the right
    /// wheels, or the distances of an omnidirectional base ahead and to the left, m, and the angle that it has
    /// turned.
    pub spin: BaseInput,
}

impl Wheel {
    /// Its angle, rad, or its rate, rad/s, from what has rolled or rolls ([`Drive::rolling`]).
    pub fn of(&self, rolled: &BaseInput) -> f64 {
        let parts = self.spin.iter().zip(rolled.iter()).filter(|(spin, _)| **spin != 0.0);
        parts.map(|(spin, by)| spin * by).reduce(|a, b| a + b).unwrap_or(0.0)
    }
}

/// A warning: the drive is too slow for the team's walking speed, so that the team walks more slowly.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "robot `{robot}`: its {what}, with a reserve for bends{aside}: the team walks at {walked:.3} m/s instead of {speed} m/s",
    what = self.what(),
    aside = self.lateral_offset()
)]
pub struct SlowDrive {
    /// Name of the robot.
    pub robot: String,
    /// Largest rim speed, or speed of an omnidirectional base, m/s.
    pub limit: f64,
    /// Radius of its wheels, m; 0 for an omnidirectional base.
    pub wheel_radius: f64,
    /// Distance of the base from the grasp's path, m.
    pub offset: f64,
    /// Walking speed of the team if the drive were faster, m/s.
    pub speed: f64,
    /// Walking speed of the team with this robot, m/s.
    pub walked: f64,
}

impl SlowDrive {
    fn lateral_offset(&self) -> String {
        match self.offset {
            0.0 => String::new(),
            offset => format!(
                ", in which the base moves with a lateral offset of {offset:.2} m from the grasp's path"
            ),
        }
    }

    fn what(&self) -> String {
        let Self { limit, wheel_radius, .. } = self;
        if *wheel_radius == 0.0 {
            return format!("base drives {limit:.3} m/s at most (base_speed_limit_m_s)");
        }
        format!(
            "wheels drive {limit:.3} m/s at most (their limit velocity of {:.2} rad/s times their radius of {wheel_radius} m)",
            limit / wheel_radius
        )
    }
}

/// Rows of numbers whose last one came later: written without it where it is 0, as before there was one, and
/// read with and without it.
pub(crate) mod without_last {
    use nalgebra::SVector;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer, const N: usize>(row: &SVector<f64, N>, to: S) -> Result<S::Ok, S::Error> {
        // 0 and not -0
        let is_short = row[N - 1].to_bits() == 0;
        row.as_slice()[..if is_short { N - 1 } else { N }].serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        from: D,
    ) -> Result<SVector<f64, N>, D::Error> {
        let read = Vec::<f64>::deserialize(from)?;
        if read.len() != N && read.len() != N - 1 {
            return Err(D::Error::custom(format!("{} numbers in place of {} or {N}", read.len(), N - 1)));
        }
        Ok(SVector::from_fn(|i, _| read.get(i).copied().unwrap_or(0.0)))
    }
}

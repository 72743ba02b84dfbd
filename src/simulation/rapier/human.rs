//! The simulated human's hand and torso. The human walks in the plane; the sway of the gait is added.

use super::HumanSettings;
use crate::geometry::{PlanarPose, Pose, Vector, direction, left_of, wrap_angle};
use crate::math;
use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The human's command for a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HumanCommand {
    /// The human leads and walks such that the hand reaches its target at the end of the period, within its
    /// limits.
    Walk {
        /// Target of the hand.
        hand: PlanarPose,
    },
    /// The human follows: the hand moves with the object's front end.
    Follow,
}

/// A walking human slows down where the grip yields by more than the first (m), and stops at the second.
const UNCOMFORTABLE_DEFLECTION_M: [f64; 2] = [0.012, 0.03];
/// Gains of the position error, 1/s, and of the velocity error, 1/s. Together they do not overshoot.
const POSITION_GAIN: f64 = 6.0;
const VELOCITY_GAIN: f64 = 40.0;
/// Gain of the body's heading, 1/s, and limit of its yaw rate, rad/s.
const BODY_GAIN: f64 = 10.0;
const BODY_TURN_LIMIT: f64 = 4.0;
/// Limits of the yaw rate, rad/s, and of its change, rad/s^2.
const TURN_LIMIT: f64 = 2.0;
const TURN_ACCELERATION_LIMIT: f64 = 8.0;
/// Time constant with which a following human adopts the robot's velocity, s.
const ADOPTION_TIME: f64 = 0.05;
/// Speed (m/s) at which the gait reaches its full sway, and the time constant (s) of changes of the sway.
const STRIDING_SPEED: f64 = 0.4;
const SWAY_TIME: f64 = 0.3;
/// Largest relative deviation of a sway from the mean.
const SWAY_VARIATION: f64 = 0.2;

/// The object's state as the human senses it.
pub(super) struct SensedObject {
    /// Pose of its front end.
    pub end: PlanarPose,
    /// The velocity with which the robot's gripper would move it, m/s and rad/s. The object's own velocity is
    /// partly caused by the hand, so a human who followed that would follow their own motion.
    pub velocity: Vector,
    pub yaw_rate: f64,
}

/// The human's hand.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Walker {
    settings: HumanSettings,
    /// Pose of the hand without its sway, its velocity (m/s) and its yaw rate (rad/s).
    at: PlanarPose,
    velocity: Vector,
    yaw_rate: f64,
    /// None while the human follows.
    #[serde(rename = "pace")]
    walk: Option<Walk>,
    /// The robot's velocity and yaw rate as the follower has adopted them.
    led: (Vector, f64),
    /// Heading of the body, and the heading that it turns to; none: the hand's. rad.
    facing: f64,
    turns_to: Option<f64>,
    sway: Sway,
}

/// The straight line that a walking human's hand follows during a control period.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Walk {
    at: PlanarPose,
    velocity: Vector,
    yaw_rate: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sway {
    /// Phase of the lateral sway, rad.
    phase: f64,
    /// Present lateral and vertical amplitudes, m, and those that they tend to at full walking speed.
    size: [f64; 2],
    drawn: [f64; 2],
    generator: ChaCha8Rng,
}

impl Walker {
    pub fn new(at: PlanarPose, settings: HumanSettings, seed: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let phase = generator.random_range(0.0..TAU);
        let drawn = [settings.sway_lateral, settings.sway_vertical];
        let sway = Sway { phase, size: [0.0; 2], drawn, generator };
        Self {
            settings,
            at,
            velocity: Vector::zeros(),
            yaw_rate: 0.0,
            walk: None,
            led: (Vector::zeros(), 0.0),
            facing: at.yaw,
            turns_to: None,
            sway,
        }
    }

    /// Pose of the hand without its sway.
    pub fn planar(&self) -> PlanarPose {
        self.at
    }

    /// Pose of the hand that carries at `height` (m): level, x ahead.
    pub fn hand(&self, height: f64) -> Pose {
        let (sin, cos) = (math::sin(self.sway.phase), math::cos(2.0 * self.sway.phase));
        let [side, up] = [self.sway.size[0] * sin, self.sway.size[1] * cos];
        let position = self.at.position + left_of(direction(self.at.yaw)) * side;
        PlanarPose { position, yaw: self.at.yaw }.at_height(height + up)
    }

    /// Pose of the middle of the torso, `ahead` of the hand and `height` above the floor (m).
    pub fn torso(&self, ahead: f64, height: f64) -> Pose {
        let position = self.at.position + direction(self.facing) * ahead;
        Pose::from_parts(
            Vector3::new(position.x, position.y, height).into(),
            Rotation3::from_axis_angle(&Vector3::z_axis(), self.facing),
        )
    }

    /// Sets the heading (rad) that the body turns to; the body walks ahead of the hand in this direction.
    /// `None`: the hand's heading.
    pub fn face(&mut self, yaw: Option<f64>) {
        self.turns_to = yaw;
    }

    /// Begins a control period (s).
    pub fn begin(&mut self, command: &HumanCommand, period: f64) {
        match *command {
            HumanCommand::Follow => self.walk = None,
            HumanCommand::Walk { hand } => {
                let from = self.walk.map_or(self.at, |p| p.at);
                let velocity = limited((hand.position - from.position) / period, self.settings.speed_limit);
                let yaw_rate = (wrap_angle(hand.yaw - from.yaw) / period).clamp(-TURN_LIMIT, TURN_LIMIT);
                self.walk = Some(Walk { at: from, velocity, yaw_rate });
                self.led = (self.velocity, self.yaw_rate);
            }
        }
    }

    /// Moves the human by one physics step of `dt` seconds.
    pub fn step(&mut self, sensed: &SensedObject, dt: f64) {
        let (goal, velocity, yaw_rate) = match &mut self.walk {
            Some(walk) => {
                // only a pulling human is held back
                let pull = walk.at.position - sensed.end.position;
                let deflection = if pull.dot(&walk.velocity) > 0.0 { pull.norm() } else { 0.0 };
                let [slower, stop] = UNCOMFORTABLE_DEFLECTION_M;
                let share = ((stop - deflection) / (stop - slower)).clamp(0.0, 1.0);
                walk.at.position += walk.velocity * (share * dt);
                walk.at.yaw += walk.yaw_rate * share * dt;
                (walk.at, walk.velocity * share, walk.yaw_rate * share)
            }
            None => {
                // of what was sensed a step ago, so that the delay is the time constant whatever the step
                let share = (dt / ADOPTION_TIME).min(1.0);
                self.led.0 += (sensed.velocity - self.led.0) * share;
                self.led.1 += (sensed.yaw_rate - self.led.1) * share;
                (sensed.end, self.led.0, self.led.1)
            }
        };
        self.approach(goal, velocity, yaw_rate, dt);
        let turn = wrap_angle(self.turns_to.unwrap_or(self.at.yaw) - self.facing);
        self.facing += (turn * BODY_GAIN).clamp(-BODY_TURN_LIMIT, BODY_TURN_LIMIT) * dt;
        self.sway.step(&self.settings, self.velocity.norm(), dt);
    }

    /// Moves the hand toward a moving `goal`, within the limits.
    fn approach(&mut self, goal: PlanarPose, velocity: Vector, yaw_rate: f64, dt: f64) {
        let HumanSettings { speed_limit, acceleration_limit, .. } = self.settings;
        let error = goal.position - self.at.position;
        let distance = error.norm();
        // no faster than the hand can brake
        let gain =
            if distance > 0.0 { POSITION_GAIN.min((acceleration_limit / distance).sqrt()) } else { 0.0 };
        let wanted = limited(velocity + error * gain, speed_limit);
        self.velocity += limited((wanted - self.velocity) * VELOCITY_GAIN, acceleration_limit) * dt;
        self.at.position += self.velocity * dt;

        let error = wrap_angle(goal.yaw - self.at.yaw);
        let wanted = (yaw_rate + POSITION_GAIN * error).clamp(-TURN_LIMIT, TURN_LIMIT);
        let change = VELOCITY_GAIN * (wanted - self.yaw_rate);
        self.yaw_rate += change.clamp(-TURN_ACCELERATION_LIMIT, TURN_ACCELERATION_LIMIT) * dt;
        self.at.yaw = wrap_angle(self.at.yaw + self.yaw_rate * dt);
    }
}

impl Sway {
    fn step(&mut self, settings: &HumanSettings, speed: f64, dt: f64) {
        let mean = [settings.sway_lateral, settings.sway_vertical];
        if mean == [0.0; 2] {
            return;
        }
        self.phase += TAU * settings.step_frequency * dt;
        if self.phase >= TAU {
            self.phase -= TAU;
            for (drawn, mean) in self.drawn.iter_mut().zip(mean) {
                *drawn = mean * self.generator.random_range(1.0 - SWAY_VARIATION..1.0 + SWAY_VARIATION);
            }
        }
        let stride = (speed / STRIDING_SPEED).min(1.0);
        for (size, drawn) in self.size.iter_mut().zip(self.drawn) {
            *size += (drawn * stride - *size) * dt / SWAY_TIME;
        }
    }
}

/// The vector, shortened to the limit if it is longer.
fn limited(vector: Vector, limit: f64) -> Vector {
    let norm = vector.norm();
    if norm > limit { vector * (limit / norm) } else { vector }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    const DT: f64 = 1.0 / 240.0;
    const START: PlanarPose = PlanarPose { position: Point::new(0.0, 0.0), yaw: 0.0 };

    fn sensed(at: &Walker) -> SensedObject {
        SensedObject { end: at.planar(), velocity: Vector::zeros(), yaw_rate: 0.0 }
    }

    #[test]
    fn a_walker_is_on_time_and_keeps_its_limits() {
        let settings = HumanSettings::default();
        let mut walker = Walker::new(START, settings, 1);
        let mut before = walker.velocity;
        for tick in 1..=40 {
            let angle = 0.05 * f64::from(tick);
            let goal = PlanarPose {
                position: Point::new(2.0 * math::sin(angle), 2.0 - 2.0 * math::cos(angle)),
                yaw: angle,
            };
            walker.begin(&HumanCommand::Walk { hand: goal }, 0.2);
            for _ in 0..48 {
                let sensed = sensed(&walker);
                walker.step(&sensed, DT);
                assert!((walker.velocity - before).norm() <= settings.acceleration_limit * DT + 1e-12);
                assert!(walker.velocity.norm() <= settings.speed_limit + 1e-12);
                before = walker.velocity;
            }
            if tick > 8 {
                let late = (goal.position - walker.planar().position).norm();
                assert!(late < 3e-3, "tick {tick}: {late} m");
                assert!((walker.planar().yaw - angle).abs() < 0.01);
            }
        }
    }

    #[test]
    fn a_walker_waits_for_an_object_that_stays_behind() {
        let mut walker = Walker::new(START, HumanSettings::default().steady(), 1);
        for tick in 1..=30 {
            let goal = PlanarPose { position: Point::new(0.1 * f64::from(tick), 0.0), yaw: 0.0 };
            walker.begin(&HumanCommand::Walk { hand: goal }, 0.2);
            for _ in 0..48 {
                walker.step(&SensedObject { end: START, velocity: Vector::zeros(), yaw_rate: 0.0 }, DT);
            }
        }
        let at = walker.planar().position.x;
        assert!(at > 0.03 && at < 0.042, "{at} m");
    }

    /// At a phase of 30 degrees, the hand is half the lateral amplitude to the left and, twice as fast, half
    /// the vertical one up.
    #[test]
    fn closed_form_the_hand_sways_to_the_side_and_up() {
        let mut walker = Walker::new(START, HumanSettings::default(), 3);
        (walker.sway.size, walker.sway.phase) = ([0.03, 0.016], std::f64::consts::FRAC_PI_6);
        let hand = walker.hand(0.7).translation.vector;
        assert!((hand.y - 0.015).abs() < 1e-12 && (hand.z - 0.708).abs() < 1e-12, "{hand}");
    }

    #[test]
    fn sway_stays_near_its_size_and_stops_with_the_walk() {
        let settings = HumanSettings::default();
        let mut walker = Walker::new(START, settings, 3);
        let mut most = [0.0_f64; 2];
        for tick in 1..=100 {
            let walked = 0.1 * f64::from(tick.min(50));
            let goal = PlanarPose { position: Point::new(walked, 0.0), yaw: 0.0 };
            walker.begin(&HumanCommand::Walk { hand: goal }, 0.2);
            if tick == 90 {
                most = [0.0; 2];
            }
            for _ in 0..48 {
                let sensed = sensed(&walker);
                walker.step(&sensed, DT);
                let hand = walker.hand(0.7).translation.vector;
                most = [most[0].max(hand.y.abs()), most[1].max((hand.z - 0.7).abs())];
            }
            if tick == 50 {
                assert!((0.008..0.0121).contains(&most[0]) && (0.004..0.0061).contains(&most[1]), "{most:?}");
            }
        }
        assert!(most[0] < 1e-4 && most[1] < 1e-4, "{most:?}");
    }
}

//! How the human's end and the robot's end of the object move, by differences between the ends of planning
//! steps.

use crate::geometry::{Point, Vector};
use crate::plant::Seen;
use serde::{Deserialize, Serialize};

/// The share of the walking speed below which somebody idles.
const IDLE_SHARE: f64 = 0.1;

/// A point at the end of a planning step, and its motion up to there by backward differences of its positions
/// at the ends of steps; before the first step it rests.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndMotion {
    /// Position, m, world frame.
    pub position: Point,
    /// Mean velocity over the step, m/s.
    pub velocity: Vector,
    /// Its change since the step before by the step's length, m/s^2.
    pub acceleration: Vector,
    /// The change of that, m/s^3.
    pub jerk: Vector,
}

impl EndMotion {
    fn at_rest(position: Point) -> Self {
        Self { position, velocity: Vector::zeros(), acceleration: Vector::zeros(), jerk: Vector::zeros() }
    }

    /// The motion of the next step, of `dt` seconds, which ends at `position`.
    fn then(&self, position: Point, dt: f64) -> Self {
        let velocity = (position - self.position) / dt;
        let acceleration = (velocity - self.velocity) / dt;
        Self { position, velocity, acceleration, jerk: (acceleration - self.acceleration) / dt }
    }
}

/// The motion of both ends of the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndMotions {
    /// The grasp.
    pub robot: EndMotion,
    /// The human's hand without sway; where the human has no body, s.
    pub human: EndMotion,
}

impl EndMotions {
    /// Both at rest where they are seen. `None` without a robot.
    pub(super) fn at_rest(seen: &Seen<'_>) -> Option<Self> {
        let [robot, human] = ends(seen)?.map(EndMotion::at_rest);
        Some(Self { robot, human })
    }

    /// The motion of the next step, of `dt` seconds, at whose end they are seen there.
    pub(super) fn then(&self, seen: &Seen<'_>, dt: f64) -> Option<Self> {
        let [robot, human] = ends(seen)?;
        Some(Self { robot: self.robot.then(robot, dt), human: self.human.then(human, dt) })
    }
}

/// Positions of the grasp and of the human's end. `None` without a robot.
fn ends(seen: &Seen<'_>) -> Option<[Point; 2]> {
    let grasp = seen.bodies.map(|bodies| bodies.grasp).or(seen.grasp)?;
    let human = seen.bodies.map(|bodies| bodies.hand_planar).or(seen.human)?;
    Some([grasp.translation.vector.xy().into(), human.position])
}

/// How both ends moved over an episode: the measures of fluency of Hoffman (2019), and means over the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionSummary {
    robot: EndSums,
    human: EndSums,
    /// Steps in which both idled, and in which neither did.
    both_idle: u64,
    neither_idle: u64,
}

/// Sums over the steps of an episode for one end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EndSums {
    steps: u64,
    acceleration: f64,
    jerk: f64,
    idle: u64,
}

impl EndSums {
    /// Mean magnitude of its acceleration, m/s^2.
    pub fn mean_acceleration(&self) -> f64 {
        self.acceleration / self.steps.max(1) as f64
    }

    /// Mean magnitude of its jerk, m/s^3.
    pub fn mean_jerk(&self) -> f64 {
        self.jerk / self.steps.max(1) as f64
    }

    /// Share of the steps in which it idled.
    pub fn idle_share(&self) -> f64 {
        self.idle as f64 / self.steps.max(1) as f64
    }

    fn add(&mut self, end: &EndMotion, is_idle: bool) {
        self.steps += 1;
        self.acceleration += end.acceleration.norm();
        self.jerk += end.jerk.norm();
        self.idle += u64::from(is_idle);
    }
}

impl MotionSummary {
    /// The robot's end.
    pub fn robot(&self) -> &EndSums {
        &self.robot
    }

    /// The human's end.
    pub fn human(&self) -> &EndSums {
        &self.human
    }

    /// Number of steps in which both idled: slower in the mean than a tenth of the walking speed.
    pub fn both_idle(&self) -> u64 {
        self.both_idle
    }

    /// Share of the steps in which neither idled.
    pub fn concurrent_activity(&self) -> f64 {
        self.neither_idle as f64 / self.robot.steps.max(1) as f64
    }

    /// Adds a step of a team whose walking speed is `speed` (m/s).
    pub(super) fn add(&mut self, ends: &EndMotions, speed: f64) {
        let [robot, human] = [&ends.robot, &ends.human].map(|end| end.velocity.norm() < IDLE_SHARE * speed);
        self.robot.add(&ends.robot, robot);
        self.human.add(&ends.human, human);
        self.both_idle += u64::from(robot && human);
        self.neither_idle += u64::from(!robot && !human);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions c t^3: third differences of a cubic are exact.
    #[test]
    fn closed_form_backward_differences_of_a_cubic() {
        let (dt, c) = (0.2, 0.5);
        let at =
            |k: i32| Point::new(c * (dt * f64::from(k)) * (dt * f64::from(k)) * (dt * f64::from(k)), 1.0);
        let mut end = EndMotion::at_rest(at(0));
        for k in 1..=5 {
            end = end.then(at(k), dt);
        }
        // the backward differences of t^3: 3 t^2 - 3 t dt + dt^2, 6 t - 6 dt, 6
        let t = 5.0 * dt;
        let close = |a: Vector, x: f64| assert!((a - Vector::new(c * x, 0.0)).norm() < 1e-9, "{a:?}, {x}");
        close(end.velocity, 3.0 * t * t - 3.0 * t * dt + dt * dt);
        close(end.acceleration, 6.0 * t - 6.0 * dt);
        close(end.jerk, 6.0);
    }

    #[test]
    fn closed_form_shares_of_idle_steps() {
        let moving = |speed: f64| EndMotion {
            velocity: Vector::new(0.0, speed),
            acceleration: Vector::new(3.0, 4.0),
            jerk: Vector::new(0.0, speed),
            ..EndMotion::at_rest(Point::origin())
        };
        let mut summary = MotionSummary::default();
        // a tenth of 0.5 m/s is not idle
        for [robot, human] in [[0.05, 0.04], [0.01, 0.5], [0.04, 0.04], [0.5, 0.5]] {
            summary.add(&EndMotions { robot: moving(robot), human: moving(human) }, 0.5);
        }
        let shares = [
            summary.robot().idle_share(),
            summary.human().idle_share(),
            summary.concurrent_activity(),
            summary.human().mean_acceleration(),
        ];
        assert_eq!(shares, [0.5, 0.5, 0.25, 5.0]);
        assert_eq!(summary.both_idle(), 1);
        assert!((summary.robot().mean_jerk() - 0.15).abs() < 1e-15);
    }
}

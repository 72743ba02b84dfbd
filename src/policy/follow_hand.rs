//! The human leads by the hand: the robot follows where the hand takes the object, on a path or not.

use super::{Decision, MethodEntry, Motion, RobotPolicy, RobotView};
use crate::control::HORIZON;
use crate::coordination::Mode;
use crate::geometry::{PlanarPose, Point, Vector, angle_of};
use crate::saved::{RestoreError, Saved};
use serde::{Deserialize, Serialize};

/// Largest speed (m/s) at which the hand is expected to go on.
const SPEED_LIMIT_M_S: f64 = 1.0;
/// Shares of the error of the last prediction by which the estimates of the hand's velocity and of its change
/// per planning step are corrected (Holt's double exponential smoothing).
const VELOCITY_SHARE: f64 = 0.6;
const CHANGE_SHARE: f64 = 0.15;

/// The policy's entry in the list.
pub(super) const METHOD: MethodEntry = MethodEntry {
    name: "follow-hand",
    about: "The human leads by the hand: the robot follows the hand like a trailer, not an option",
    make: || Box::new(FollowHand::default()),
};

/// A robot whose grasp follows the hand like the wheel of a trailer, at the distance at which it began. The
/// hand is expected to keep its velocity. On plants without hands, the robot follows the human on their
/// option.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct FollowHand {
    /// The hand in the last planning step.
    last: Option<SeenHand>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct SeenHand {
    /// Simulated time, s.
    time: f64,
    /// Position, m, world frame.
    position: Point,
    /// Its expected mean velocity in the next planning step, m/s, and the change of that per planning step,
    /// m/s.
    velocity: Vector,
    change: Vector,
    /// Distance of the grasp from the hand at the beginning, m.
    distance: f64,
}

impl SeenHand {
    /// The hand now, after `last`.
    fn after(last: Option<Self>, time: f64, position: Point, grasp: Point) -> Self {
        let Some(last) = last else {
            let distance = (position - grasp).norm();
            return Self { time, position, velocity: Vector::zeros(), change: Vector::zeros(), distance };
        };
        let step = time - last.time;
        let moved = if step > 0.0 { (position - last.position) / step } else { last.velocity };
        let error = moved - last.velocity;
        let change = last.change + error * CHANGE_SHARE;
        let velocity = last.velocity + error * VELOCITY_SHARE + change;
        let fastest = velocity.norm().max(SPEED_LIMIT_M_S);
        Self { time, position, velocity: velocity * (SPEED_LIMIT_M_S / fastest), change, ..last }
    }

    /// Poses of a grasp that is now at `grasp`, at the ends of the next planning steps of this length (s).
    fn trailed(&self, grasp: Point, step: f64) -> [PlanarPose; HORIZON] {
        let (mut hand, mut grasp) = (self.position, grasp);
        std::array::from_fn(|_| {
            hand += self.velocity * step;
            let ahead = (hand - grasp).try_normalize(1e-6).unwrap_or_else(Vector::x);
            grasp = hand - ahead * self.distance;
            PlanarPose { position: grasp, yaw: angle_of(ahead) }
        })
    }
}

impl RobotPolicy for FollowHand {
    fn initial_mode(&self) -> Mode {
        Mode::HumanLed
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let follow = Decision::follow();
        let (Some(hand), Some(grasp)) = (view.hand, &view.grasp) else { return follow };
        let [hand, grasp] = [hand, grasp].map(|pose| PlanarPose::from_above(pose).position);
        let seen = SeenHand::after(self.last, view.time, hand, grasp);
        self.last = Some(seen);
        follow.with_motion(Motion::Reference(seen.trailed(grasp, view.planning_step)))
    }

    fn save(&self) -> Saved {
        Saved::of(self)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        *self = saved.read("policy")?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind a hand that goes straight, the grasp keeps its distance and goes at the hand's velocity.
    #[test]
    fn closed_form_a_straight_walk_is_followed_at_the_hands_velocity() {
        let at = |x: f64| Point::new(x, 0.5);
        let mut seen = SeenHand::after(None, 0.0, at(1.2), at(0.0));
        for i in 1..=80 {
            let x = 0.1 * f64::from(i);
            seen = SeenHand::after(Some(seen), 0.2 * f64::from(i), at(1.2 + x), at(x));
        }
        for (i, pose) in seen.trailed(at(8.0), 0.2).iter().enumerate() {
            assert!((pose.position - at(8.1 + 0.1 * i as f64)).norm() < 1e-6, "{pose:?}");
            assert!(pose.yaw.abs() < 1e-6);
        }
    }
}

//! The robot's estimate of the option that the human walks, from P_o and the observed steps.

use crate::geometry::{Point, Vector, angle_of};
use crate::math;

/// Prediction time of [`Intent::moves_soon`] from the middle of the last step, in steps: half a step to its
/// end, plus the delay of the motors.
const PREDICTION_STEPS: f64 = 0.8;

/// The robot's estimate of where and how fast the human is going. It uses P_o and observations, not the
/// human's parameters.
///
/// P_o is weighted by the likelihood of the observed direction of the last step if the human were on option
/// o: exp(c cos(observed - expected)). The expected direction is that of o's path from the human's previous
/// position.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Intent {
    concentration: f64,
    /// Previous position of the human, m, world frame.
    before: Option<Point>,
    /// The displacement of one step along each option from there, m.
    expected: Vec<Vector>,
    #[serde(skip)]
    weights: Vec<f64>,
    /// Previous position of the hand, m; below, its speed (m/s), its displacement (m) and the change of the
    /// displacement.
    hand: Option<Point>,
    speed: Option<f64>,
    moved: Vector,
    change: Vector,
}

impl Intent {
    /// An estimate without observations. `concentration` is c, at least 0.
    pub fn new(concentration: f64) -> Self {
        Self {
            concentration,
            before: None,
            expected: Vec::new(),
            weights: Vec::new(),
            hand: None,
            speed: None,
            moved: Vector::zeros(),
            change: Vector::zeros(),
        }
    }

    /// Records the human's position and returns the most probable option; ties go to the lower index.
    /// `probabilities` is P_o from this position.
    pub fn observe(&mut self, position: Point, probabilities: &[f64]) -> usize {
        let step = self.before.map(|before| position - before);
        self.weights.clear();
        self.weights.extend(probabilities.iter().enumerate().map(|(o, p)| {
            let likelihood = match (step, self.expected.get(o)) {
                (Some(step), Some(expected)) if step.norm() > 0.0 && expected.norm() > 0.0 => {
                    math::exp(self.concentration * (math::cos(angle_of(step) - angle_of(*expected)) - 1.0))
                }
                _ => 1.0,
            };
            p * likelihood
        }));
        self.before = Some(position);
        let mut best = 0;
        for (o, weight) in self.weights.iter().enumerate() {
            if *weight > self.weights[best] {
                best = o;
            }
        }
        best
    }

    /// Records the hand's position, one `period` (s) after the last one.
    pub fn see_hand(&mut self, position: Point, period: f64) {
        if let Some(before) = self.hand.replace(position) {
            let moved = position - before;
            self.change = if self.speed.is_some() { moved - self.moved } else { Vector::zeros() };
            self.moved = moved;
            self.speed = Some(moved.norm() / period);
        }
    }

    /// Speed of the hand in the last step, m/s; `None` before there was one.
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Displacement of the hand in the last step, m; zero before there was one.
    pub fn moved(&self) -> Vector {
        self.moved
    }

    /// Predicted displacement of the hand in a step (m), if its displacement continues to change as in the
    /// last step.
    pub fn moves_soon(&self) -> Vector {
        self.moved + self.change * PREDICTION_STEPS
    }

    /// Records the displacement of one step along each option from here.
    pub fn expect(&mut self, steps: impl Iterator<Item = Vector>) {
        self.expected.clear();
        self.expected.extend(steps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_observed_direction_outweighs_a_prior() {
        let mut intent = Intent::new(20.0);
        // no observation: the prior decides
        assert_eq!(intent.observe(Point::origin(), &[0.6, 0.4]), 0);
        intent.expect([Vector::new(0.1, 0.0), Vector::new(0.07, 0.07)].into_iter());
        assert_eq!(intent.observe(Point::new(0.07, 0.07), &[0.6, 0.4]), 1);
        // both options have the same direction: the prior decides again
        intent.expect([Vector::new(0.1, 0.0), Vector::new(0.1, 0.0)].into_iter());
        assert_eq!(intent.observe(Point::new(0.17, 0.07), &[0.4, 0.6]), 1);
    }

    #[test]
    fn a_human_who_stands_still_gives_no_evidence() {
        let mut intent = Intent::new(20.0);
        intent.observe(Point::origin(), &[0.2, 0.8]);
        intent.expect([Vector::new(0.1, 0.0), Vector::new(0.0, 0.1)].into_iter());
        assert_eq!(intent.observe(Point::origin(), &[0.2, 0.8]), 1);
    }

    #[test]
    fn the_speed_is_that_of_the_last_step() {
        let mut intent = Intent::new(20.0);
        intent.see_hand(Point::origin(), 0.2);
        assert_eq!(intent.speed(), None);
        intent.see_hand(Point::new(0.07, 0.07), 0.2);
        assert!((intent.speed().unwrap() - 0.07 * 2f64.sqrt() / 0.2).abs() < 1e-12);
        assert!((intent.moves_soon() - Vector::new(0.07, 0.07)).norm() < 1e-12);
        // the hand comes to a stop: soon it moves back
        intent.see_hand(Point::new(0.08, 0.07), 0.2);
        assert!((intent.moved() - Vector::new(0.01, 0.0)).norm() < 1e-12);
        assert!((intent.moves_soon() - Vector::new(0.01 - 0.8 * 0.06, -0.8 * 0.07)).norm() < 1e-12);
    }
}

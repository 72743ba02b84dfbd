//! Predicted poses of the base under given rim speeds, with derivatives.

use super::limits::HalfPlane;
use super::{HORIZON, Inputs};
use crate::geometry::{PlanarPose, Vector, direction, left_of};
use crate::robot::Drive;
use nalgebra::SMatrix;

/// A base that rolls along given inputs, about which its positions are linearised.
pub(super) struct Rolling<'i> {
    inputs: &'i Inputs,
    steps: [Step; HORIZON],
    track: f64,
    period: f64,
}

/// One step of the base.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Direction of travel in the middle of the step.
    ahead: Vector,
    /// Speed, m/s.
    speed: f64,
    /// Pose at the end of the step.
    to: PlanarPose,
}

impl<'i> Rolling<'i> {
    /// A base that starts at `base`. The first two rows of `inputs` are the rim speeds.
    pub fn new(drive: &Drive, base: &PlanarPose, inputs: &'i Inputs, period: f64) -> Self {
        let mut at = *base;
        let steps = std::array::from_fn(|t| {
            let [left, right] = [inputs[(0, t)], inputs[(1, t)]];
            let turn = (right - left) / drive.track;
            let ahead = direction(at.yaw + turn * period / 2.0);
            at = drive.roll(&at, [left * period, right * period]);
            Step { ahead, speed: (left + right) / 2.0, to: at }
        });
        Self { inputs, steps, track: drive.track, period }
    }

    /// The pose of the base after step `t`.
    pub fn pose(&self, t: usize) -> &PlanarPose {
        &self.steps[t].to
    }

    /// The bound that keeps the base, after step `t`, from moving farther than `room` (m) in the direction
    /// `toward`.
    pub fn bound(&self, t: usize, toward: Vector, room: f64, price: f64) -> HalfPlane {
        let mut coefficients = Inputs::zeros();
        coefficients.fixed_rows_mut::<2>(0).copy_from(&self.gradient(t, toward));
        HalfPlane { coefficients, bound: coefficients.dot(self.inputs) + room, price, is_guide: false }
    }

    /// The gradient of `toward . p` for a point that the base carries at the offset `arm` (m), with respect
    /// to the rim speeds.
    pub fn gradient_at(&self, t: usize, toward: Vector, arm: Vector) -> SMatrix<f64, 2, HORIZON> {
        let mut gradient = self.gradient(t, toward);
        let turn = self.period / self.track * toward.dot(&left_of(arm));
        for t in 0..=t {
            gradient[(0, t)] -= turn;
            gradient[(1, t)] += turn;
        }
        gradient
    }

    /// The gradient of `toward . p` after step `t` with respect to the rim speeds, left and right, one column
    /// per step; s.
    fn gradient(&self, t: usize, toward: Vector) -> SMatrix<f64, 2, HORIZON> {
        let mut gradient = SMatrix::zeros();
        // the sideways motion in all later steps per turn before the step, m/rad
        let mut swung = 0.0;
        for (t, step) in self.steps[..=t].iter().enumerate().rev() {
            let sideways = self.period * step.speed * toward.dot(&left_of(step.ahead));
            let along = self.period * toward.dot(&step.ahead) / 2.0;
            let turn = self.period * (swung + sideways / 2.0) / self.track;
            gradient[(0, t)] = along - turn;
            gradient[(1, t)] = along + turn;
            swung += sideways;
        }
        gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn property_the_gradient_agrees_with_finite_differences() {
        let drive = Drive { track: 0.37, wheel_radius: 0.06, rim_speed_limit: 1.0, base_radius: 0.25 };
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..50 {
            let rims: [[f64; 2]; HORIZON] =
                std::array::from_fn(|_| [rng.random_range(-0.6..0.6), rng.random_range(-0.6..0.6)]);
            let base = PlanarPose { position: Point::new(0.3, -0.2), yaw: rng.random_range(-3.0..3.0) };
            let away = direction(rng.random_range(-3.0..3.0));
            let place = |rims: &[[f64; 2]; HORIZON]| {
                rims.iter()
                    .fold(base, |at, [l, r]| drive.roll(&at, [l * 0.2, r * 0.2]))
                    .position
                    .coords
                    .dot(&away)
            };
            let mut inputs = Inputs::zeros();
            for (t, [left, right]) in rims.iter().enumerate() {
                inputs[(0, t)] = *left;
                inputs[(1, t)] = *right;
            }
            let rolling = Rolling::new(&drive, &base, &inputs, 0.2);
            let gradient = rolling.gradient(HORIZON - 1, away);
            for t in 0..HORIZON {
                for wheel in 0..2 {
                    let (mut more, mut less) = (rims, rims);
                    more[t][wheel] += 1e-5;
                    less[t][wheel] -= 1e-5;
                    let slope = (place(&more) - place(&less)) / 2e-5;
                    // the linearisation takes the chord as long as the arc
                    assert!((slope - gradient[(wheel, t)]).abs() < 3e-3, "{slope} {}", gradient[(wheel, t)]);
                }
            }
        }
    }
}

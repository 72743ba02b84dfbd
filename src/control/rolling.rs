//! Predicted poses of the base under given inputs, with derivatives.

use super::limits::HalfPlane;
use super::{HORIZON, Inputs};
use crate::geometry::{PlanarPose, Vector, direction, left_of, wrap_angle};
use crate::robot::{BaseInput, BaseTwist, Drive, MAX_BASE_INPUTS};
use nalgebra::SMatrix;

/// A gradient with respect to the base's inputs, one column per step.
type Gradient = SMatrix<f64, MAX_BASE_INPUTS, HORIZON>;

/// A base that rolls along given inputs, about which its positions are linearised.
pub(super) struct Rolling<'i> {
    inputs: &'i Inputs,
    from: PlanarPose,
    steps: [Step; HORIZON],
    drive: Drive,
    period: f64,
}

/// One step of the base.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Direction in which the base points in the middle of the step.
    ahead: Vector,
    /// Velocity ahead and to the left, m/s.
    velocity: Vector,
    /// Pose at the end of the step.
    to: PlanarPose,
}

impl<'i> Rolling<'i> {
    /// A base that starts at `base`. The first rows of `inputs` are the base's.
    pub fn new(drive: &Drive, base: &PlanarPose, inputs: &'i Inputs, period: f64) -> Self {
        let mut at = *base;
        let steps = std::array::from_fn(|t| {
            let input = BaseInput::from_fn(|i, _| if i < drive.inputs() { inputs[(i, t)] } else { 0.0 });
            let BaseTwist { velocity, turn } = drive.twist(&input);
            let ahead = direction(at.yaw + turn * period / 2.0);
            at = drive.roll(&at, &(input * period));
            Step { ahead, velocity, to: at }
        });
        Self { inputs, from: *base, steps, drive: *drive, period }
    }

    /// The pose of the base after step `t`.
    pub fn pose(&self, t: usize) -> &PlanarPose {
        &self.steps[t].to
    }

    /// The bound that keeps the base, after step `t`, from moving farther than `room` (m) in the direction
    /// `toward`.
    pub fn bound(&self, t: usize, toward: Vector, room: f64, price: f64) -> HalfPlane {
        let mut coefficients = Inputs::zeros();
        coefficients.fixed_rows_mut::<MAX_BASE_INPUTS>(0).copy_from(&self.gradient(t, toward));
        HalfPlane { coefficients, bound: coefficients.dot(self.inputs) + room, price }
    }

    /// The pose of the base after so many steps, on the chords of its way; before the first step and after the
    /// last one, as if it went on in the same way.
    pub fn pose_after(&self, steps: f64) -> PlanarPose {
        let t = (steps.ceil() as usize).clamp(1, HORIZON) - 1;
        let to = *self.pose(t);
        let share = steps - t as f64;
        if share == 1.0 {
            return to;
        }
        let from = if t == 0 { self.from } else { *self.pose(t - 1) };
        let position = from.position + (to.position - from.position) * share;
        PlanarPose { position, yaw: from.yaw + wrap_angle(to.yaw - from.yaw) * share }
    }

    /// The bound that keeps a point of the base, at the offset `lever` (m), from moving farther than `room` (m)
    /// in the direction `toward` until this share of step `t` is done.
    pub fn bound_within(
        &self,
        (t, share): (usize, f64),
        toward: Vector,
        lever: Vector,
        room: f64,
        price: f64,
    ) -> HalfPlane {
        let mut of_base = self.gradient_at(t, toward, lever) * share;
        if share < 1.0 && t > 0 {
            of_base += self.gradient_at(t - 1, toward, lever) * (1.0 - share);
        }
        let mut coefficients = Inputs::zeros();
        coefficients.fixed_rows_mut::<MAX_BASE_INPUTS>(0).copy_from(&of_base);
        HalfPlane { coefficients, bound: coefficients.dot(self.inputs) + room, price }
    }

    /// The gradient of `toward . p` for a point that the base carries at the offset `arm` (m), with respect
    /// to the base's inputs.
    pub fn gradient_at(&self, t: usize, toward: Vector, arm: Vector) -> Gradient {
        let mut gradient = self.gradient(t, toward);
        if self.drive.is_omnidirectional() {
            let turn = self.period * toward.dot(&left_of(arm));
            (0..=t).for_each(|t| gradient[(2, t)] += turn);
            return gradient;
        }
        let turn = self.period / self.drive.track * toward.dot(&left_of(arm));
        for t in 0..=t {
            gradient[(0, t)] -= turn;
            gradient[(1, t)] += turn;
        }
        gradient
    }

    /// The gradient of `toward . p` after step `t` with respect to the base's inputs, one column per step; s,
    /// and for a turning rate m s/rad.
    fn gradient(&self, t: usize, toward: Vector) -> Gradient {
        let mut gradient = Gradient::zeros();
        if self.drive.is_omnidirectional() {
            // the motion across in all later steps per turn before the step, m/rad
            let mut swung = 0.0;
            for (t, step) in self.steps[..=t].iter().enumerate().rev() {
                let left = left_of(step.ahead);
                let [x, y] = step.velocity.into();
                let across = self.period * toward.dot(&(left * x - step.ahead * y));
                gradient[(0, t)] = self.period * toward.dot(&step.ahead);
                gradient[(1, t)] = self.period * toward.dot(&left);
                gradient[(2, t)] = self.period * (swung + across / 2.0);
                swung += across;
            }
            return gradient;
        }
        // the sideways motion in all later steps per turn before the step, m/rad
        let mut swung = 0.0;
        for (t, step) in self.steps[..=t].iter().enumerate().rev() {
            let sideways = self.period * step.velocity.x * toward.dot(&left_of(step.ahead));
            let along = self.period * toward.dot(&step.ahead) / 2.0;
            let turn = self.period * (swung + sideways / 2.0) / self.drive.track;
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
    use crate::robot::DriveKind;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    const DIFFERENTIAL: Drive = crate::control::DIFFERENTIAL;
    const OMNIDIRECTIONAL: Drive = Drive { kind: DriveKind::Omnidirectional, track: 0.0, ..DIFFERENTIAL };

    /// A random step of a drive's inputs.
    fn random(drive: &Drive, rng: &mut ChaCha8Rng) -> BaseInput {
        let mut input = BaseInput::zeros();
        input.iter_mut().take(drive.inputs()).for_each(|rate| *rate = rng.random_range(-0.6..0.6));
        input
    }

    #[test]
    fn property_the_gradient_agrees_with_finite_differences() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for drive in [DIFFERENTIAL, OMNIDIRECTIONAL] {
            for _ in 0..50 {
                let inputs: [BaseInput; HORIZON] = std::array::from_fn(|_| random(&drive, &mut rng));
                let base = PlanarPose { position: Point::new(0.3, -0.2), yaw: rng.random_range(-3.0..3.0) };
                let away = direction(rng.random_range(-3.0..3.0));
                let arm = Vector::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5));
                // of the base, and of a point that it carries
                let place = |inputs: &[BaseInput; HORIZON]| {
                    let at = inputs.iter().fold(base, |at, input| drive.roll(&at, &(input * 0.2)));
                    let of_base = at.position.coords.dot(&away);
                    [of_base, of_base + (nalgebra::Rotation2::new(at.yaw - base.yaw) * arm).dot(&away)]
                };
                let mut rows = Inputs::zeros();
                for (t, input) in inputs.iter().enumerate() {
                    rows.fixed_view_mut::<3, 1>(0, t).copy_from(input);
                }
                let rolling = Rolling::new(&drive, &base, &rows, 0.2);
                let last = HORIZON - 1;
                let turned = nalgebra::Rotation2::new(rolling.pose(last).yaw - base.yaw);
                let gradients = [rolling.gradient(last, away), rolling.gradient_at(last, away, turned * arm)];
                for t in 0..HORIZON {
                    for i in 0..drive.inputs() {
                        let (mut more, mut less) = (inputs, inputs);
                        more[t][i] += 1e-5;
                        less[t][i] -= 1e-5;
                        let (up, down) = (place(&more), place(&less));
                        for (which, gradient) in gradients.iter().enumerate() {
                            let slope = (up[which] - down[which]) / 2e-5;
                            // the linearisation takes the chord as long as the arc
                            let stated = gradient[(i, t)];
                            assert!((slope - stated).abs() < 3e-3, "{:?}: {slope} {stated}", drive.kind);
                        }
                    }
                }
            }
        }
    }
}

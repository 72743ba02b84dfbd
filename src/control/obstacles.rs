//! A world's obstacles and the way that the base would take in; half-planes that keep the base off them out.

use super::limits::{HalfPlane, Limits};
use super::{HORIZON, Inputs};
use crate::geometry::{Footprint, PlanarPose, Point, Vector, direction, left_of};
use crate::robot::Drive;
use crate::world::World;
use nalgebra::SMatrix;

/// The base keeps this much more (m) than its radius away: a bound that is paid for may be overstepped by millimetres.
const MARGIN: f64 = 0.01;
/// Obstacles farther from the base than this (m) at a step set no bound there.
const FAR: f64 = 0.5;

/// The outlines that the base must keep off.
#[derive(Clone, Debug)]
pub struct BaseObstacles {
    outlines: Vec<Footprint>,
}

impl BaseObstacles {
    /// Those of a world.
    pub fn new(world: &World) -> Self {
        Self { outlines: world.obstacles.iter().map(|o| o.footprint.clone()).collect() }
    }

    /// Replaces the half-planes in `limits`: for a base that starts at `base` and would move by `inputs`, the plane that separates it from
    /// each near obstacle at each step, linear in the inputs about these.
    ///
    /// With p(t) the base's place after t periods T along `inputs` and n the direction in which the obstacle's distance d grows, the bound is
    /// n . (p(t) + dp(t)/du (u - inputs)) >= n . p(t) - (d - radius - margin).
    pub fn half_planes(
        &self,
        drive: &Drive,
        base: &PlanarPose,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        limits.half_planes.clear();
        limits.half_planes.reserve(HORIZON * self.outlines.len());
        let mut at = *base;
        let mut steps = [Step::default(); HORIZON];
        for t in 0..HORIZON {
            let [left, right] = [inputs[(0, t)], inputs[(1, t)]];
            let turn = (right - left) / drive.track;
            let ahead = direction(at.yaw + turn * period / 2.0);
            steps[t] = Step { ahead, speed: (left + right) / 2.0 };
            at = drive.roll(&at, [left * period, right * period]);
            for outline in &self.outlines {
                let (distance, away) = outline.separation(at.position);
                if distance > drive.base_radius + FAR {
                    continue;
                }
                let coefficients = gradient(&steps[..=t], away, drive.track, period) * -1.0;
                let now = coefficients.dot(&inputs.fixed_rows::<2>(0));
                limits
                    .half_planes
                    .push(HalfPlane { coefficients, bound: now + distance - drive.base_radius - MARGIN });
            }
        }
    }

    /// Distance (m) between the base and the nearest obstacle, negative where they overlap; infinite without obstacles.
    pub fn clearance(&self, base: Point, radius: f64) -> f64 {
        self.outlines.iter().map(|o| o.separation(base).0 - radius).fold(f64::INFINITY, f64::min)
    }
}

/// One step of the base: direction of travel in its middle, and speed (m/s).
#[derive(Clone, Copy, Debug)]
struct Step {
    ahead: Vector,
    speed: f64,
}

impl Default for Step {
    fn default() -> Self {
        Self { ahead: Vector::x(), speed: 0.0 }
    }
}

/// The gradient of `away . p` after the steps with respect to the rim speeds, left and right, a column a step; s.
fn gradient(steps: &[Step], away: Vector, track: f64, period: f64) -> SMatrix<f64, 2, HORIZON> {
    let mut gradient = SMatrix::zeros();
    // what a turn before the step moves sideways in all later ones, m/rad
    let mut swung = 0.0;
    for (t, step) in steps.iter().enumerate().rev() {
        let sideways = period * step.speed * away.dot(&left_of(step.ahead));
        let along = period * away.dot(&step.ahead) / 2.0;
        let turn = period * (swung + sideways / 2.0) / track;
        gradient[(0, t)] = along - turn;
        gradient[(1, t)] = along + turn;
        swung += sideways;
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;
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
            let mut at = base;
            let steps = rims.map(|[l, r]| {
                let turn = (r - l) / drive.track;
                let step = Step { ahead: direction(at.yaw + turn * 0.1), speed: (l + r) / 2.0 };
                at = drive.roll(&at, [l * 0.2, r * 0.2]);
                step
            });
            let gradient = gradient(&steps, away, drive.track, 0.2);
            for t in 0..HORIZON {
                for wheel in 0..2 {
                    let (mut more, mut less) = (rims, rims);
                    more[t][wheel] += 1e-5;
                    less[t][wheel] -= 1e-5;
                    let slope = (place(&more) - place(&less)) / 2e-5;
                    // the chord is taken as long as the arc
                    assert!((slope - gradient[(wheel, t)]).abs() < 3e-3, "{slope} {}", gradient[(wheel, t)]);
                }
            }
        }
    }
}

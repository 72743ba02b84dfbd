//! A world's obstacles and the way that the robot would take in; half-planes that keep base and arm off them out.

use super::limits::{HalfPlane, Limits};
use super::{HORIZON, Inputs};
use crate::geometry::{Footprint, PlanarPose, Point, Vector, direction, left_of};
use crate::robot::{Configuration, Drive, InputVector, Robot};
use crate::world::World;
use nalgebra::SMatrix;

/// Base and arm keep this much more (m) than their radius away: a bound that is paid for may be overstepped by millimetres.
const MARGIN: f64 = 0.01;
/// Obstacles farther from the base than this (m) at a step set no bound there.
const FAR: f64 = 0.5;

/// The arm is taken as balls of this radius (m) around its joints.
const ARM_RADIUS: f64 = 0.1;
/// Obstacles farther from an arm's joint than this (m) set no bound there, those farther than this from the base none for the whole arm.
const FAR_FROM_ARM: f64 = 0.3;
const OUT_OF_REACH: f64 = 2.5;

/// What of the robot is kept out of obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Avoid {
    /// Nothing: the paper's eq. (7) knows no obstacles.
    Nothing,
    /// The base.
    Base,
    /// Base and arm.
    Robot,
}

/// The outlines that the robot must keep off, with their heights.
#[derive(Clone, Debug)]
pub struct RobotObstacles {
    outlines: Vec<(Footprint, f64)>,
}

impl RobotObstacles {
    /// Those of a world.
    pub fn new(world: &World) -> Self {
        Self { outlines: world.obstacles.iter().map(|o| (o.footprint.clone(), o.height)).collect() }
    }

    /// Replaces the half-planes in `limits`: for a robot that starts at `q` and would move by `inputs`, the plane that separates its base, and
    /// its arm's joints, from each near obstacle at each step, linear in the inputs about these.
    ///
    /// With p(t) a point's place after t periods T along `inputs` and n the direction in which the obstacle's distance d grows, the bound is
    /// n . (p(t) + dp(t)/du (u - inputs)) >= n . p(t) - (d - radius - margin). The base rolls on arcs; the arm's points move as their
    /// Jacobians at `q` say.
    pub fn half_planes(
        &self,
        avoid: Avoid,
        robot: &Robot,
        q: &Configuration,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        limits.half_planes.clear();
        limits.half_planes.reserve(HORIZON * self.outlines.len() * (2 + 2 * robot.joint_count()));
        if avoid != Avoid::Nothing {
            self.keep_base_off(&robot.drive, &q.base, inputs, period, limits);
        }
        if avoid == Avoid::Robot {
            self.keep_arm_off(robot, q, inputs, period, limits);
        }
    }

    fn keep_base_off(
        &self,
        drive: &Drive,
        base: &PlanarPose,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        let mut at = *base;
        let mut steps = [Step::default(); HORIZON];
        for t in 0..HORIZON {
            let [left, right] = [inputs[(0, t)], inputs[(1, t)]];
            let turn = (right - left) / drive.track;
            let ahead = direction(at.yaw + turn * period / 2.0);
            steps[t] = Step { ahead, speed: (left + right) / 2.0 };
            at = drive.roll(&at, [left * period, right * period]);
            for (outline, _) in &self.outlines {
                let (distance, away) = outline.separation(at.position);
                if distance > drive.base_radius + FAR {
                    continue;
                }
                let mut coefficients = Inputs::zeros();
                let gradient = gradient(&steps[..=t], away, drive.track, period);
                coefficients.fixed_rows_mut::<2>(0).copy_from(&-gradient);
                let bound = coefficients.dot(inputs) + distance - drive.base_radius - MARGIN;
                limits.half_planes.push(HalfPlane { coefficients, bound });
            }
        }
    }

    /// Every second step: an arm does not get past an obstacle between two.
    fn keep_arm_off(
        &self,
        robot: &Robot,
        q: &Configuration,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        let base = q.base.position;
        robot.arm_points(q, |point, jacobian| {
            // what is above the base is kept off with it
            if (point.xy() - base.coords).norm() + ARM_RADIUS <= robot.drive.base_radius {
                return;
            }
            for (outline, height) in &self.outlines {
                if point.z - ARM_RADIUS > *height || outline.separation(base).0 > OUT_OF_REACH {
                    continue;
                }
                let mut moved = InputVector::zeros();
                for t in 0..HORIZON {
                    moved += inputs.column(t);
                    if t % 2 == 0 {
                        continue;
                    }
                    let at = point + jacobian * moved * period;
                    let (distance, away) = outline.separation(Point::new(at.x, at.y));
                    if distance > ARM_RADIUS + FAR_FROM_ARM {
                        continue;
                    }
                    let toward = jacobian.fixed_rows::<2>(0).tr_mul(&away) * -period;
                    let mut coefficients = Inputs::zeros();
                    for step in 0..=t {
                        coefficients.set_column(step, &toward);
                    }
                    let bound = toward.dot(&moved) + distance - ARM_RADIUS - MARGIN;
                    limits.half_planes.push(HalfPlane { coefficients, bound });
                }
            }
        });
    }

    /// Distance (m) between the base and the nearest obstacle, negative where they overlap; infinite without obstacles.
    pub fn clearance(&self, base: Point, radius: f64) -> f64 {
        self.outlines.iter().map(|(o, _)| o.separation(base).0 - radius).fold(f64::INFINITY, f64::min)
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

//! A world's obstacles and the way that the robot would take in; half-planes that keep base and arm off them out.

use super::limits::{HalfPlane, Limits};
use super::rolling::Rolling;
use super::{HORIZON, Inputs};
use crate::geometry::{Bounds, Footprint, PlanarPose, Point, Vector};
use crate::robot::{Configuration, Drive, InputVector, MAX_INPUTS, Robot};
use crate::world::World;

/// Base and arm keep this much more (m) than their radius away: a bound that is paid for may be overstepped by millimetres.
const MARGIN: f64 = 0.01;
/// Obstacles farther from the base than this (m) at a step set no bound there.
const FAR: f64 = 0.5;

/// What an overstepped bound costs: this times its square (m), a thousand times what the same tracking error costs.
const PRICE: f64 = 1e6;
/// The arm is taken as balls of this radius (m) around its joints.
const ARM_RADIUS: f64 = 0.1;
/// Obstacles farther from an arm's joint than this (m) set no bound there, those farther than this from the base none for the whole arm.
const FAR_FROM_ARM: f64 = 0.6;
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

/// The outlines that the robot must keep off.
#[derive(Clone, Debug)]
pub struct RobotObstacles {
    outlines: Vec<Outline>,
}

#[derive(Clone, Debug)]
struct Outline {
    footprint: Footprint,
    bounds: Bounds,
    /// m.
    height: f64,
}

impl Outline {
    /// Signed distance (m) to `p` and the direction in which it grows, if that is no more than `reach` (m, not negative).
    fn near(&self, p: Point, reach: f64) -> Option<(f64, Vector)> {
        if !self.bounds.grown(reach).contains(p) {
            return None;
        }
        Some(self.footprint.separation(p)).filter(|(distance, _)| *distance <= reach)
    }
}

impl RobotObstacles {
    /// Those of a world.
    pub fn new(world: &World) -> Self {
        let outline = |footprint: &Footprint, height| Outline {
            footprint: footprint.clone(),
            bounds: footprint.bounds(),
            height,
        };
        Self { outlines: world.obstacles.iter().map(|o| outline(&o.footprint, o.height)).collect() }
    }

    /// Replaces the half-planes in `limits`: for a robot that starts at `q` and would move by `inputs`, the plane that separates its base, and
    /// its arm's joints, from each near obstacle at each step, linear in the inputs about these.
    ///
    /// With p(t) a point's place after t periods T along `inputs` and n the direction in which the obstacle's distance d grows, the bound is
    /// n . (p(t) + dp(t)/du (u - inputs)) >= n . p(t) - (d - radius - margin). The base rolls on arcs and carries
    /// the arm's points, which move on it as their Jacobians at `q` say.
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
        let rolling = Rolling::new(drive, base, inputs, period);
        for t in 0..HORIZON {
            let at = rolling.pose(t).position;
            for outline in &self.outlines {
                let Some((distance, away)) = outline.near(at, drive.base_radius + FAR) else { continue };
                let room = distance - drive.base_radius - MARGIN;
                limits.half_planes.push(rolling.bound(t, -away, room, PRICE));
            }
        }
    }

    fn keep_arm_off(
        &self,
        robot: &Robot,
        q: &Configuration,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        let base = q.base;
        let rolling = Rolling::new(&robot.drive, &base, inputs, period);
        robot.arm_points(q, |point, jacobian| {
            let carried = point.xy() - base.position.coords;
            // what is above the base is kept off with it
            if carried.norm() + ARM_RADIUS <= robot.drive.base_radius {
                return;
            }
            for outline in &self.outlines {
                let is_below = point.z - ARM_RADIUS > outline.height;
                if is_below || outline.near(base.position, OUT_OF_REACH).is_none() {
                    continue;
                }
                let mut moved = InputVector::zeros();
                for t in 0..HORIZON {
                    moved += inputs.column(t);
                    // as the base carries the point, and as the arm moves it on the base
                    let then = rolling.pose(t);
                    let turned = nalgebra::Rotation2::new(then.yaw - base.yaw);
                    let arm = jacobian.fixed_view::<2, { MAX_INPUTS - 2 }>(0, 2);
                    let away_from_base =
                        turned * (carried + arm * moved.fixed_rows::<{ MAX_INPUTS - 2 }>(2) * period);
                    let at = then.position + away_from_base;
                    let Some((distance, away)) = outline.near(at, ARM_RADIUS + FAR_FROM_ARM) else {
                        continue;
                    };
                    let mut coefficients = Inputs::zeros();
                    let rims = rolling.gradient_at(t, -away, away_from_base);
                    coefficients.fixed_rows_mut::<2>(0).copy_from(&rims);
                    let joints = arm.tr_mul(&(turned.inverse() * -away)) * period;
                    for step in 0..=t {
                        coefficients.fixed_view_mut::<{ MAX_INPUTS - 2 }, 1>(2, step).copy_from(&joints);
                    }
                    let bound = coefficients.dot(inputs) + distance - ARM_RADIUS - MARGIN;
                    limits.half_planes.push(HalfPlane { coefficients, bound, price: PRICE });
                }
            }
        });
    }

    /// Distance (m) between the base and the nearest obstacle, negative where they overlap; infinite without obstacles.
    pub fn clearance(&self, base: Point, radius: f64) -> f64 {
        let separations = self.outlines.iter().map(|o| o.footprint.separation(base).0);
        separations.map(|distance| distance - radius).fold(f64::INFINITY, f64::min)
    }

    /// Whether every obstacle is farther than `room` (m, not negative) from `p`.
    pub fn is_clear(&self, p: Point, room: f64) -> bool {
        self.outlines.iter().all(|o| o.near(p, room).is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// A plane's bound says what its distance is about the inputs: so its coefficients are compared with what distances do.
    #[test]
    fn property_half_planes_of_base_and_arm_agree_with_finite_differences() {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-3, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"post\"\n\
                    shape = \"cylinder\"\ncenter_m = [1.1, 0.5]\nradius_m = 0.1\nheight_m = 2.0\n";
        let world = World::parse("w.toml", text).unwrap();
        let robot = Robot::built_in().unwrap();
        let obstacles = RobotObstacles::new(&world);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut compared = 0;
        for _ in 0..20 {
            let base = PlanarPose {
                position: Point::new(rng.random_range(-0.2..0.2), rng.random_range(-0.3..0.3)),
                yaw: rng.random_range(-0.6..0.6),
            };
            let mut q = Configuration { base, joints: robot.postures[0].joints };
            q.joints.iter_mut().take(robot.joint_count()).for_each(|q| *q += rng.random_range(-0.3..0.3));
            let mut inputs = Inputs::zeros();
            for t in 0..HORIZON {
                for i in 0..2 + robot.joint_count() {
                    inputs[(i, t)] =
                        if i < 2 { rng.random_range(0.0..0.5) } else { rng.random_range(-0.2..0.2) };
                }
            }
            let planes = |inputs: &Inputs| {
                let mut limits = Limits::new(&robot);
                obstacles.half_planes(Avoid::Robot, &robot, &q, inputs, 0.2, &mut limits);
                limits.half_planes
            };
            let here = planes(&inputs);
            for (i, t) in [(0, 0), (1, 3), (0, 7), (2, 0), (3, 4), (5, 6), (7, 1)] {
                let (mut more, mut less) = (inputs, inputs);
                more[(i, t)] += 1e-5;
                less[(i, t)] -= 1e-5;
                let distance =
                    |plane: &HalfPlane, inputs: &Inputs| plane.bound - plane.coefficients.dot(inputs);
                for ((plane, up), down) in here.iter().zip(planes(&more)).zip(planes(&less)) {
                    let slope = (distance(&up, &more) - distance(&down, &less)) / 2e-5;
                    let stated = -plane.coefficients[(i, t)];
                    // the chord is taken as long as the arc
                    assert!((slope - stated).abs() < 3e-3, "input {i}, step {t}: {slope} {stated}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 3000, "{compared}");
    }

    #[test]
    fn property_what_is_clear_is_farther_than_that_from_every_outline() {
        let world = World::parse("w.toml", include_str!("../../worlds/free-form.toml")).unwrap();
        let obstacles = RobotObstacles::new(&world);
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let mut clear = 0;
        for _ in 0..5000 {
            let at = Point::new(rng.random_range(-2.0..12.0), rng.random_range(-6.0..6.0));
            let room = rng.random_range(0.0..1.0);
            let is_clear = obstacles.is_clear(at, room);
            assert_eq!(is_clear, obstacles.clearance(at, 0.0) > room, "{at} {room}");
            clear += u32::from(is_clear);
        }
        assert!((500..4500).contains(&clear), "{clear}");
    }
}

//! Linearised half-planes that keep base and arm off a world's obstacles.

mod arm;
mod base;
mod outlines;

pub use outlines::{Avoid, RobotObstacles};

use super::limits::Limits;
use super::{HORIZON, Inputs};
use crate::geometry::Footprint;
use crate::robot::{Configuration, Robot};

/// The number of outlines near the robot for which memory is set aside: of a map's many, few are near at a
/// time.
const MANY_OUTLINES: usize = 32;

impl RobotObstacles {
    /// Replaces the half-planes in `limits`. They separate the base, and points of the arm, from each
    /// near obstacle at each step, for a robot that starts at `q` and moves by `inputs`. They are linear in
    /// the inputs about these.
    ///
    /// A base that is a polygon has a bound for every corner of it that is nearly nearest to an obstacle, and
    /// for every corner of the obstacle that is so near to one of its sides. Where the two overlap, or do
    /// so one step earlier or later, n is the direction of least penetration. Near an obstacle, steps are
    /// divided.
    ///
    /// Let p(t) be a point's position after t periods T along `inputs`, and n the gradient of the obstacle's
    /// distance d. The bound is n . (p(t) + dp(t)/du (u - inputs)) >= n . p(t) - (d - radius - margin). The
    /// base rolls on arcs and carries the arm's points, which move relative to it by their Jacobians at `q`.
    /// Where such a point would be in an obstacle, or too close on its far side, n points to the side on which
    /// the arm's chain from base to grasp passes the obstacle, and d is measured along n.
    ///
    /// The arm's planes are linear in its joints, and less accurate the farther the arm has turned. Where the
    /// base's inputs are given, the weight of each step is 0.7 of that of the previous step. Where the base is
    /// free, eq. (7) predicts with B(q) for the whole horizon: the weight decreases with the distance between
    /// p(t) and where B(q) puts the point, to none at the radius of the arm, because a plane about p(t) then
    /// says nothing about that plan.
    #[expect(clippy::too_many_arguments)]
    pub fn half_planes(
        &self,
        avoid: Avoid,
        robot: &Robot,
        q: &Configuration,
        inputs: &Inputs,
        period: f64,
        is_base_given: bool,
        limits: &mut Limits,
    ) {
        limits.half_planes.clear();
        let points = 2 + robot.arm_point_count(arm::SPACING_M);
        let corners = match &robot.footprint {
            Footprint::Polygon(corners) => base::PARTS_OF_STEP * (corners.len() + self.most_corners),
            Footprint::Disc { .. } => 0,
        };
        let near = self.outlines.len().min(MANY_OUTLINES);
        limits.half_planes.reserve(HORIZON * near * (points + corners));
        if avoid != Avoid::Nothing {
            self.keep_base_off(robot, &q.base, inputs, period, limits);
        }
        if avoid == Avoid::Robot {
            self.keep_arm_off(robot, q, inputs, period, is_base_given, limits);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::limits::HalfPlane;
    use crate::geometry::{PlanarPose, Point};
    use crate::world::World;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// The coefficients of a plane predict how its distance changes with the inputs.
    #[test]
    fn property_half_planes_of_base_and_arm_agree_with_finite_differences() {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-3, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"post\"\n\
                    shape = \"cylinder\"\ncenter_m = [1.1, 0.5]\nradius_m = 0.1\nheight_m = 2.0\n";
        let world = World::parse("w.toml", text).unwrap();
        let robot = Robot::built_in().unwrap();
        let obstacles = RobotObstacles::new(&world);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut compared = 0;
        for _ in 0..30 {
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
            let planes = |avoid, inputs: &Inputs| {
                let mut limits = Limits::new(&robot);
                obstacles.half_planes(avoid, &robot, &q, inputs, 0.2, false, &mut limits);
                limits.half_planes
            };
            let distance = |plane: &HalfPlane, inputs: &Inputs| plane.bound - plane.coefficients.dot(inputs);
            for avoid in [Avoid::Base, Avoid::Robot] {
                let here = planes(avoid, &inputs);
                for (i, t) in [(0, 0), (1, 3), (0, 7), (2, 0), (3, 4), (5, 6), (7, 1)] {
                    let (mut more, mut less) = (inputs, inputs);
                    more[(i, t)] += 1e-5;
                    less[(i, t)] -= 1e-5;
                    let moved = planes(avoid, &more).into_iter().zip(planes(avoid, &less));
                    for (plane, (up, down)) in here.iter().zip(moved) {
                        // where an arm violates its bound, the direction is the chain's, and held
                        if avoid == Avoid::Robot && distance(plane, &inputs) < 0.0 {
                            continue;
                        }
                        let slope = (distance(&up, &more) - distance(&down, &less)) / 2e-5;
                        let stated = -plane.coefficients[(i, t)];
                        // the linearisation takes the chord as long as the arc
                        assert!((slope - stated).abs() < 3e-3, "input {i}, step {t}: {slope} {stated}");
                        compared += 1;
                    }
                }
            }
        }
        assert!(compared > 3000, "{compared}");
    }
}

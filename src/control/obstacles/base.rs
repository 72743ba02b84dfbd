//! Half-planes that keep the base off obstacles.

use super::outlines::{MARGIN_M, RobotObstacles};
use crate::control::limits::Limits;
use crate::control::rolling::Rolling;
use crate::control::{HORIZON, Inputs};
use crate::geometry::{Footprint, Placed, PlanarPose, wrap_angle};
use crate::robot::Robot;

/// Distance (m) from the base beyond which an obstacle sets no bound for the base.
const RANGE_M: f64 = 0.5;
/// How much farther (m) than the nearest corner another one of a base may be that still has a bound. A side
/// turns against a flat wall about either of its ends.
const CORNERS_RANGE_M: f64 = 0.15;
/// The parts into which a step is divided for a base near an obstacle.
pub(super) const PARTS_OF_STEP: usize = 3;
/// Weight of the squared violation (m) of a bound: a thousand times that of the same tracking error.
const PRICE: f64 = 1e6;

impl RobotObstacles {
    pub(super) fn keep_base_off(
        &self,
        robot: &Robot,
        base: &PlanarPose,
        inputs: &Inputs,
        period: f64,
        limits: &mut Limits,
    ) {
        let rolling = Rolling::new(&robot.drive, base, inputs, period);
        let radius = robot.drive.base_radius;
        for t in 0..HORIZON {
            let at = rolling.pose(t);
            for outline in &self.outlines {
                let Some((distance, away)) = outline.near(at.position, radius + RANGE_M) else {
                    continue;
                };
                if let Footprint::Disc { .. } = robot.footprint {
                    let room = distance - radius - MARGIN_M;
                    limits.half_planes.push(rolling.bound(t, -away, room, PRICE));
                    continue;
                }
                let placed = Placed::new(&robot.footprint, at);
                let distance = placed.separation(&outline.footprint).distance;
                if distance > RANGE_M {
                    continue;
                }
                let step = rolling.pose_after(t as f64);
                let length =
                    (at.position - step.position).norm() + radius * wrap_angle(at.yaw - step.yaw).abs();
                // within a step that is longer than the distance, a corner may pass through the end of a wall
                let parts = if distance <= 2.0 * length { PARTS_OF_STEP } else { 1 };
                for part in 1..=parts {
                    let share = part as f64 / parts as f64;
                    let placed =
                        |by: f64| Placed::new(&robot.footprint, &rolling.pose_after(t as f64 + share + by));
                    let (here, motion) = (placed(0.0), [placed(-1.0), placed(1.0)]);
                    let motion = if parts > 1 { motion.as_slice() } else { &[] };
                    let mut nearest = f64::INFINITY;
                    here.witnesses_on_motion(&outline.footprint, motion, |witness| {
                        nearest = nearest.min(witness.distance);
                    });
                    here.witnesses_on_motion(&outline.footprint, motion, |witness| {
                        if witness.distance <= nearest + CORNERS_RANGE_M {
                            let (at, room) = ((t, share), witness.distance - MARGIN_M);
                            let (toward, lever) = (-witness.away, witness.lever);
                            let bound = rolling.bound_within(at, toward, lever, room, PRICE);
                            limits.half_planes.push(bound);
                        }
                    });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Avoid;
    use crate::control::limits::HalfPlane;
    use crate::geometry::Point;
    use crate::robot::Configuration;
    use crate::world::World;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// The coefficients of a plane predict how its distance changes with the inputs: for the corners of a base
    /// of 0.9 m by 0.5 m, on either drive, next to a post and a wall's end, and within steps. (Of a pillar on
    /// the way, the direction is held.)
    #[test]
    fn property_half_planes_of_a_polygon_agree_with_finite_differences() {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-3, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"post\"\n\
                    shape = \"box\"\ncenter_m = [0.4, 0.7]\nsize_m = [0.2, 0.2]\nheight_m = 2.0\n[[obstacle]]\nname = \"wall\"\n\
                    shape = \"box\"\ncenter_m = [0.9, -1.5]\nsize_m = [0.1, 2]\nheight_m = 2.0\n";
        let obstacles = RobotObstacles::new(&World::parse("w.toml", text).unwrap());
        let mut robot = Robot::built_in().unwrap();
        let corners = [(-0.4, -0.25), (0.5, -0.25), (0.5, 0.25), (-0.4, 0.25)];
        robot.footprint = Footprint::Polygon(corners.map(|(x, y)| Point::new(x, y)).to_vec());
        robot.drive.base_radius = 0.6;
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let (mut compared, mut within) = (0, 0);
        for case in 0..60 {
            if case == 30 {
                robot.drive.kind = crate::robot::DriveKind::Omnidirectional;
            }
            let base = PlanarPose {
                position: Point::new(rng.random_range(-0.2..0.2), rng.random_range(-0.1..0.1)),
                yaw: rng.random_range(-0.4..0.4),
            };
            let q = Configuration { base, joints: robot.postures[0].joints };
            let mut inputs = Inputs::zeros();
            for t in 0..HORIZON {
                for i in 0..robot.drive.inputs() {
                    inputs[(i, t)] = rng.random_range(0.0..[0.5, 0.3, 0.2][i]);
                }
            }
            let planes = |inputs: &Inputs| {
                let mut limits = Limits::new(&robot);
                obstacles.half_planes(Avoid::Base, &robot, &q, inputs, 0.2, false, &mut limits);
                limits.half_planes
            };
            let distance = |plane: &HalfPlane, inputs: &Inputs| plane.bound - plane.coefficients.dot(inputs);
            let here = planes(&inputs);
            within += usize::from(here.len() > 3 * HORIZON);
            for i in 0..robot.drive.inputs() {
                for t in [0, 3, 6] {
                    let (mut more, mut less) = (inputs, inputs);
                    more[(i, t)] += 1e-6;
                    less[(i, t)] -= 1e-6;
                    let (up, down) = (planes(&more), planes(&less));
                    if [up.len(), down.len()] != [here.len(); 2] {
                        continue;
                    }
                    for (plane, (up, down)) in here.iter().zip(up.iter().zip(&down)) {
                        // where another corner is nearest, the two are of different ones
                        let is_same = (up.coefficients - down.coefficients).norm() < 1e-4;
                        let slope = (distance(up, &more) - distance(down, &less)) / 2e-6;
                        let stated = -plane.coefficients[(i, t)];
                        assert!(
                            !is_same || (slope - stated).abs() < 5e-3,
                            "input {i}, step {t}: {slope} {stated}"
                        );
                        compared += usize::from(is_same);
                    }
                }
            }
        }
        assert!(compared > 2000 && within > 20, "{compared} {within}");
    }

    /// A base whose side is along a wall has a bound for either end of the side: it may not turn into the
    /// wall.
    #[test]
    fn a_side_along_a_wall_is_kept_off_at_both_ends() {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-3, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"wall\"\n\
                    shape = \"box\"\ncenter_m = [0, 1.28]\nsize_m = [8, 2]\nheight_m = 2.0\n";
        let obstacles = RobotObstacles::new(&World::parse("w.toml", text).unwrap());
        let mut robot = Robot::built_in().unwrap();
        let corners = [(-0.45, -0.25), (0.45, -0.25), (0.45, 0.25), (-0.45, 0.25)];
        robot.footprint = Footprint::Polygon(corners.map(|(x, y)| Point::new(x, y)).to_vec());
        robot.drive.base_radius = crate::math::hypot(0.45, 0.25);
        let q = Configuration {
            base: PlanarPose { position: Point::origin(), yaw: 0.0 },
            joints: robot.postures[0].joints,
        };
        let mut limits = Limits::new(&robot);
        let standing = Inputs::zeros();
        obstacles.half_planes(Avoid::Base, &robot, &q, &standing, 0.2, false, &mut limits);
        // the margin of 1 cm leaves 2 cm
        assert!(limits.half_planes.iter().all(|plane| (plane.bound - 0.02).abs() < 1e-12));
        for turn in [0.1, -0.1] {
            let mut turning = Inputs::zeros();
            turning.row_mut(0).fill(-turn);
            turning.row_mut(1).fill(turn);
            let over = |plane: &HalfPlane| plane.coefficients.dot(&turning) - plane.bound;
            let most = limits.half_planes.iter().map(over).fold(f64::NEG_INFINITY, f64::max);
            assert!(most > 0.1, "{turn}: {most} m");
        }
    }
}

//! Linearised half-planes that keep base and arm off a world's obstacles.

use super::limits::{HalfPlane, Limits};
use super::reaching::{ArmJacobian, Reaching};
use super::rolling::Rolling;
use super::{HORIZON, Inputs};
use crate::geometry::{Bounds, Footprint, Placed, PlanarPose, Point, Vector, wrap_angle};
use crate::robot::{Configuration, InputVector, MAX_BASE_INPUTS, MAX_JOINTS, PointJacobian, Robot};
use crate::world::World;
use nalgebra::Vector3;

/// Additional distance (m) of base and arm from obstacles, because a soft bound may be violated by
/// millimetres.
const MARGIN_M: f64 = 0.01;
/// Distance (m) from the base beyond which an obstacle sets no bound for the base.
const BASE_RANGE_M: f64 = 0.5;
/// How much farther (m) than the nearest corner another one of a base may be that still has a bound. A side
/// turns against a flat wall about either of its ends.
const CORNERS_RANGE_M: f64 = 0.15;
/// The parts into which a step is divided for a base near an obstacle.
const PARTS_OF_STEP: usize = 3;

/// Weight of the squared violation (m) of a bound: a thousand times that of the same tracking error.
const VIOLATION_PRICE: f64 = 1e6;
/// The same for the arm: the balls around its points are wider than its links, so that a centimetre less of the
/// space between is not worth the object.
const ARM_PRICE: f64 = 1e5;
/// Radius (m) of the balls around points of the arm that stand for the arm: half a link's width and a little
/// more. The points are its joints, and points between them where a link is longer than the spacing (m), so
/// that nothing wider than 9 cm fits between two balls.
const ARM_RADIUS_M: f64 = 0.08;
const ARM_SPACING_M: f64 = 0.25;
/// Factor of the weight of the arm's half-planes from one step to the next where the base's inputs are given:
/// while the base swings round a corner, the arm turns by radians within the horizon.
const CONFIDENCE: f64 = 0.7;
/// Distances (m) beyond which an obstacle sets no bound: from a joint of the arm for that joint, and from the
/// base for the whole arm.
const ARM_RANGE_M: f64 = 0.6;
const ARM_REACH_M: f64 = 2.5;

/// The parts of the robot that are kept off obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Avoid {
    /// None, as in the paper's eq. (7).
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
    /// The largest number of corners of an outline.
    most_corners: usize,
}

#[derive(Clone, Debug)]
struct Outline {
    footprint: Footprint,
    bounds: Bounds,
    /// Height, m.
    height: f64,
}

impl Outline {
    /// Signed distance (m) to `p` and its gradient, if the distance is no more than `reach` (m, not
    /// negative).
    fn near(&self, p: Point, reach: f64) -> Option<(f64, Vector)> {
        if !self.bounds.grown(reach).contains(p) {
            return None;
        }
        Some(self.footprint.separation(p)).filter(|(distance, _)| *distance <= reach)
    }

    /// The distance for a point of the arm that is too close, measured toward the side on which the arm's
    /// chain from `from` to `to` passes the outline. The nearest side may be the far side of a wall, which
    /// the arm cannot pass. `None` if the chain meets the outline.
    fn beside(&self, p: Point, [from, to]: [Point; 2]) -> Option<(f64, Vector)> {
        let away = self.footprint.toward_segment(from, to)?;
        Some((p.coords.dot(&away) - self.footprint.reach(away), away))
    }
}

impl RobotObstacles {
    /// The outlines of a world.
    pub fn new(world: &World) -> Self {
        let outline = |footprint: &Footprint, height| Outline {
            footprint: footprint.clone(),
            bounds: footprint.bounds(),
            height,
        };
        let corners = world.obstacles.iter().map(|o| match &o.footprint {
            Footprint::Polygon(corners) => corners.len(),
            Footprint::Disc { .. } => 1,
        });
        let most_corners = corners.max().unwrap_or(0);
        let outlines = world.obstacles.iter().map(|o| outline(&o.footprint, o.height)).collect();
        Self { outlines, most_corners }
    }

    /// Replaces the half-planes in `limits`. They separate the base, and points of the arm, from each
    /// near obstacle at each step, for a robot that starts at `q` and moves by `inputs`. They are linear in
    /// the inputs about these.
    ///
    /// A base that is a polygon has a bound for every corner of it that is nearly nearest to an obstacle, and
    /// for every corner of the obstacle that is so near beside one of its sides. Where the two overlap, or do
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
        let points = 2 + robot.arm_point_count(ARM_SPACING_M);
        let corners = match &robot.footprint {
            Footprint::Polygon(corners) => PARTS_OF_STEP * (corners.len() + self.most_corners),
            Footprint::Disc { .. } => 0,
        };
        limits.half_planes.reserve(HORIZON * self.outlines.len() * (points + corners));
        if avoid != Avoid::Nothing {
            self.keep_base_off(robot, &q.base, inputs, period, limits);
        }
        if avoid == Avoid::Robot {
            self.keep_arm_off(robot, q, inputs, period, is_base_given, limits);
        }
    }

    fn keep_base_off(
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
                let Some((distance, away)) = outline.near(at.position, radius + BASE_RANGE_M) else {
                    continue;
                };
                if let Footprint::Disc { .. } = robot.footprint {
                    let room = distance - radius - MARGIN_M;
                    limits.half_planes.push(rolling.bound(t, -away, room, VIOLATION_PRICE));
                    continue;
                }
                let placed = Placed::new(&robot.footprint, at);
                let distance = placed.separation(&outline.footprint).distance;
                if distance > BASE_RANGE_M {
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
                            let bound = rolling.bound_within(at, toward, lever, room, VIOLATION_PRICE);
                            limits.half_planes.push(bound);
                        }
                    });
                }
            }
        }
    }

    fn keep_arm_off(
        &self,
        robot: &Robot,
        q: &Configuration,
        inputs: &Inputs,
        period: f64,
        is_base_given: bool,
        limits: &mut Limits,
    ) {
        let base = q.base;
        let reaching = Reaching::new(&robot.drive, &base, inputs, period);
        let placed = Placed::new(&robot.footprint, &base);
        let carried = |point: &Vector3<f64>| point.xy() - base.position.coords;
        let first = robot.drive.inputs();
        let arm_of = |jacobian: &PointJacobian| jacobian.fixed_view::<2, MAX_JOINTS>(0, first).into_owned();
        // the arm's chain leads from the base to its last point, the grasp
        let (mut to_grasp, mut grasp_arm) = (Vector::zeros(), ArmJacobian::zeros());
        robot.arm_points(q, f64::INFINITY, |point, jacobian| {
            (to_grasp, grasp_arm) = (carried(&point), arm_of(jacobian));
        });
        let chain: [_; HORIZON] = std::array::from_fn(|t| {
            [reaching.rolling.pose(t).position, reaching.place(to_grasp, &grasp_arm, t).1]
        });
        let mut so_far = InputVector::zeros();
        let moved: [InputVector; HORIZON] = std::array::from_fn(|t| {
            so_far += inputs.column(t) * period;
            so_far
        });
        robot.arm_points(q, ARM_SPACING_M, |point, jacobian| {
            let from_base = carried(&point);
            // the bounds of the base also cover what is above it
            let is_above = match &robot.footprint {
                Footprint::Disc { radius, .. } => from_base.norm() + ARM_RADIUS_M <= *radius,
                outline => {
                    let of_base = placed.inside_frame(base.position + from_base);
                    outline.separation(of_base).0 <= -ARM_RADIUS_M
                }
            };
            if is_above {
                return;
            }
            let arm = arm_of(jacobian);
            for outline in &self.outlines {
                let is_below = point.z - ARM_RADIUS_M > outline.height;
                if is_below || outline.near(base.position, ARM_REACH_M).is_none() {
                    continue;
                }
                let mut faded = ARM_PRICE / CONFIDENCE;
                for (t, chain) in chain.iter().enumerate() {
                    let (lever, at) = reaching.place(from_base, &arm, t);
                    faded *= CONFIDENCE;
                    let price = match is_base_given {
                        true => faded,
                        false => {
                            let predicted = point.xy() + (jacobian * moved[t]).xy();
                            ARM_PRICE * (1.0 - (at.coords - predicted).norm() / ARM_RADIUS_M)
                        }
                    };
                    if price <= 0.0 {
                        continue;
                    }
                    let Some((mut distance, mut away)) = outline.near(at, ARM_RADIUS_M + ARM_RANGE_M) else {
                        continue;
                    };
                    if distance < ARM_RADIUS_M + MARGIN_M {
                        let beside = outline.beside(at, *chain);
                        // from outside, on the right side of it, the nearest place is the one to keep off
                        let is_astray = |(_, side): &(f64, Vector)| distance < 0.0 || away.dot(side) < 0.0;
                        (distance, away) = beside.filter(is_astray).unwrap_or((distance, away));
                    }
                    let mut coefficients = Inputs::zeros();
                    let of_base = reaching.rolling.gradient_at(t, -away, lever);
                    coefficients.fixed_rows_mut::<MAX_BASE_INPUTS>(0).copy_from(&of_base);
                    let joints = arm.tr_mul(&(reaching.turned(t).inverse() * -away)) * period;
                    // the third row is a joint's where the base has two inputs
                    for step in 0..=t {
                        coefficients.fixed_view_mut::<MAX_JOINTS, 1>(first, step).copy_from(&joints);
                    }
                    let bound = coefficients.dot(inputs) + distance - ARM_RADIUS_M - MARGIN_M;
                    limits.half_planes.push(HalfPlane { coefficients, bound, price });
                }
            }
        });
    }

    /// Distance (m) between a base at this pose and the nearest obstacle, negative where they overlap; infinite
    /// without obstacles.
    pub fn clearance(&self, base: &PlanarPose, footprint: &Footprint) -> f64 {
        let placed = Placed::new(footprint, base);
        let separations = self.outlines.iter().map(|o| placed.separation(&o.footprint).distance);
        separations.fold(f64::INFINITY, f64::min)
    }

    /// Whether a base at this pose overlaps no obstacle by `tolerance` (m) or more.
    pub fn has_room(&self, base: &PlanarPose, footprint: &Footprint, tolerance: f64) -> bool {
        let (corners, radius) = match footprint {
            Footprint::Disc { radius, .. } => return self.is_clear(base.position, radius - tolerance),
            Footprint::Polygon(corners) => (corners, 0.0),
        };
        let radius = corners.iter().map(|c| c.coords.norm_squared()).fold(radius, f64::max).sqrt();
        let placed = Placed::new(footprint, base);
        self.outlines.iter().all(|o| {
            o.near(base.position, radius).is_none() || placed.separation(&o.footprint).distance > -tolerance
        })
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

    /// The same for the corners of a base of 0.9 m by 0.5 m, on either drive, beside a post and a wall's end,
    /// and within steps. (Of a pillar on the way, the direction is held.)
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

    /// A base whose side is along a wall has a bound for either end of the side: it may not turn into the wall.
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

    /// Both faces of a wall are nearer than its end, but the arm cannot pass through it.
    #[test]
    fn an_elbow_is_led_round_the_end_of_a_wall() {
        let robot = Robot::built_in().unwrap();
        let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let elbow_out = robot.postures.iter().find(|p| p.name == "elbow-out").unwrap();
        let q = Configuration { base, joints: elbow_out.joints };
        let mut elbow = Point::origin();
        robot.arm_points(&q, f64::INFINITY, |point, _| {
            if point.y.abs() > elbow.y.abs() {
                elbow = point.xy().into();
            }
        });
        assert!(elbow.y > 0.25, "{elbow}");
        // the elbow would go through it 0.15 m from its end
        let end = elbow.y - 0.15;
        let wall = format!("center_m = [{}, {}]\nsize_m = [0.1, 4]\n", elbow.x + 0.4, end + 2.0);
        let text = format!(
            "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-3, 0]\ntarget_m = [9, 0]\n[[obstacle]]\nname = \"wall\"\n\
             shape = \"box\"\n{wall}height_m = 2.0\n"
        );
        let obstacles = RobotObstacles::new(&World::parse("w.toml", &text).unwrap());
        let mut inputs = Inputs::zeros();
        inputs.fixed_rows_mut::<2>(0).fill(0.5);
        let mut limits = Limits::new(&robot);
        obstacles.half_planes(Avoid::Robot, &robot, &q, &inputs, 0.2, false, &mut limits);
        let overstepped =
            limits.half_planes.iter().map(|plane| plane.coefficients.dot(&inputs) - plane.bound);
        let most = overstepped.fold(0.0, f64::max);
        assert!((most - (0.15 + ARM_RADIUS_M + MARGIN_M)).abs() < 1e-9, "{most} m");
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
            let pose = PlanarPose { position: at, yaw: 0.0 };
            let disc = Footprint::Disc { center: Point::origin(), radius: 0.0 };
            assert_eq!(is_clear, obstacles.clearance(&pose, &disc) > room, "{at} {room}");
            clear += u32::from(is_clear);
        }
        assert!((500..4500).contains(&clear), "{clear}");
    }
}

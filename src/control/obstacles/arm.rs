//! Half-planes that keep the arm off obstacles.

use super::outlines::{MARGIN_M, Outline, RobotObstacles};
use crate::control::limits::{HalfPlane, Limits};
use crate::control::reaching::{ArmJacobian, Reaching};
use crate::control::{HORIZON, Inputs};
use crate::geometry::{Footprint, Placed, Point, Vector};
use crate::robot::{Configuration, InputVector, MAX_BASE_INPUTS, MAX_JOINTS, PointJacobian, Robot};
use nalgebra::Vector3;

/// Weight of the squared violation (m) of a bound, a tenth of that for the base: the balls around the arm's
/// points are wider than its links, so that a centimetre less of the space between is not worth the object.
const PRICE: f64 = 1e5;
/// Radius (m) of the balls around points of the arm that stand for the arm: half a link's width and a little
/// more. The points are its joints, and points between them where a link is longer than the spacing (m), so
/// that nothing wider than 9 cm fits between two balls.
const RADIUS_M: f64 = 0.08;
pub(super) const SPACING_M: f64 = 0.25;
/// Factor of the weight of the arm's half-planes from one step to the next where the base's inputs are given:
/// while the base swings round a corner, the arm turns by radians within the horizon.
const CONFIDENCE: f64 = 0.7;
/// Distances (m) beyond which an obstacle sets no bound: from a joint of the arm for that joint, and from the
/// base for the whole arm.
const RANGE_M: f64 = 0.6;
const REACH_M: f64 = 2.5;

impl Outline {
    /// The distance for a point of the arm that is too close, measured toward the side on which the arm's
    /// chain from `from` to `to` passes the outline. The nearest side may be the far side of a wall, which
    /// the arm cannot pass. `None` if the chain meets the outline.
    fn distance_on_chain_side(&self, p: Point, [from, to]: [Point; 2]) -> Option<(f64, Vector)> {
        let away = self.footprint.toward_segment(from, to)?;
        Some((p.coords.dot(&away) - self.footprint.reach(away), away))
    }
}

impl RobotObstacles {
    pub(super) fn keep_arm_off(
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
        robot.arm_points(q, SPACING_M, |point, jacobian| {
            let from_base = carried(&point);
            // the bounds of the base also cover what is above it
            let is_above = match &robot.footprint {
                Footprint::Disc { radius, .. } => from_base.norm() + RADIUS_M <= *radius,
                outline => {
                    let of_base = placed.inside_frame(base.position + from_base);
                    outline.separation(of_base).0 <= -RADIUS_M
                }
            };
            if is_above {
                return;
            }
            let arm = arm_of(jacobian);
            for outline in &self.outlines {
                let is_below = point.z - RADIUS_M > outline.height;
                if is_below || outline.near(base.position, REACH_M).is_none() {
                    continue;
                }
                let mut faded = PRICE / CONFIDENCE;
                for (t, chain) in chain.iter().enumerate() {
                    let (lever, at) = reaching.place(from_base, &arm, t);
                    faded *= CONFIDENCE;
                    let price = match is_base_given {
                        true => faded,
                        false => {
                            let predicted = point.xy() + (jacobian * moved[t]).xy();
                            PRICE * (1.0 - (at.coords - predicted).norm() / RADIUS_M)
                        }
                    };
                    if price <= 0.0 {
                        continue;
                    }
                    let Some((mut distance, mut away)) = outline.near(at, RADIUS_M + RANGE_M) else {
                        continue;
                    };
                    if distance < RADIUS_M + MARGIN_M {
                        let on_chain_side = outline.distance_on_chain_side(at, *chain);
                        // from outside, on the right side of it, the nearest place is the one to keep off
                        let is_astray = |(_, side): &(f64, Vector)| distance < 0.0 || away.dot(side) < 0.0;
                        (distance, away) = on_chain_side.filter(is_astray).unwrap_or((distance, away));
                    }
                    let mut coefficients = Inputs::zeros();
                    let of_base = reaching.rolling.gradient_at(t, -away, lever);
                    coefficients.fixed_rows_mut::<MAX_BASE_INPUTS>(0).copy_from(&of_base);
                    let joints = arm.tr_mul(&(reaching.turned(t).inverse() * -away)) * period;
                    // the third row is a joint's where the base has two inputs
                    for step in 0..=t {
                        coefficients.fixed_view_mut::<MAX_JOINTS, 1>(first, step).copy_from(&joints);
                    }
                    let bound = coefficients.dot(inputs) + distance - RADIUS_M - MARGIN_M;
                    limits.half_planes.push(HalfPlane { coefficients, bound, price });
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Avoid;
    use crate::geometry::PlanarPose;
    use crate::world::World;

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
        assert!((most - (0.15 + RADIUS_M + MARGIN_M)).abs() < 1e-9, "{most} m");
    }
}

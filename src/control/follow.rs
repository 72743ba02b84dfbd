//! Path following of the base: its inputs by pure pursuit along the path that the grasp has taken.
//!
//! DEVIATION (eq. 7): with the weights of eq. (7) alone, the base trails the grasp by a metre and cuts the
//! corners of the path between them; the horizon is too short to see the wall in time. The path of the grasp
//! is free, so on the physical plant the base follows it.

use super::holonomic;
use super::limits::{BaseInputs, Limits};
use super::rolling::Rolling;
use super::{Inputs, Reference, RobotObstacles};
use crate::geometry::{
    Footprint, PlanarPose, Point, Pose, Vector, angle_of, direction, left_of, nearest_on_segment, wrap_angle,
};
use crate::math;
use crate::robot::{BaseInput, BaseTwist, Drive, InputJacobian, pose_difference};
use nalgebra::Rotation3;

/// Look-ahead distances along the path, m. The longest rolls most smoothly but cuts corners most: it is used
/// unless the base would come too near to an obstacle.
const LOOK_AHEADS_M: [f64; 3] = [0.65, 0.45, 0.3];
/// Tried as well where all of those come too near. If these do too, the one with the most room is used.
const SHORT_LOOK_AHEADS_M: [f64; 2] = [0.2, 0.12];
/// Time over which the base looks out for obstacles, s.
const LOOK_OUT_S: f64 = 1.2;
/// How far (m) the base may overlap an obstacle: the base is narrower than its disc, or than the polygon
/// around its shapes.
pub const LOOK_OUT_TOLERANCE_M: f64 = 0.005;
/// Gain of the spacing between base and grasp, 1/s.
const SPACING_GAIN: f64 = 1.0;
/// Gain of the turn on the spot toward a path in another direction, 1/s.
const TURN_GAIN: f64 = 3.0;
/// Largest rate at which the base turns, rad/s. The arm holds the grasp up to a metre away, in place.
const TURN_RATE_LIMIT: f64 = 1.3;
/// Gain of a free base's turning toward the grasp, 1/s.
const FREE_TURN_GAIN: f64 = 1.0;
/// Weight of the squared deviation (rad/s) from that turning.
pub const TURN_PRICE: f64 = 100.0;
/// Weight of the squared deviation (m/s, rad/s) from the base's inputs that follow the path.
pub const GUIDE_PRICE: f64 = 1e4;

/// Weight of the squared violation (m) of the bound on the distance from where those inputs lead; that of an
/// obstacle's bound.
const GUIDE_WIDTH_PRICE: f64 = 1e6;

/// A base that follows a path.
pub struct Follower<'w> {
    /// Points along the path, [`Follower::STEP`] apart, m. The last is the present reference of the grasp.
    pub way: &'w [Point],
    /// Present and target speed of the grasp along the path, m/s; negative when reversing.
    pub speeds: [f64; 2],
    /// Acceleration from the present to the target speed, m/s^2.
    pub acceleration: f64,
    /// Largest acceleration of the rims, or of an omnidirectional base along each axis, m/s^2.
    pub rim_acceleration: f64,
    /// Wanted distance of the base from the grasp, m. It is measured straight: in a bend, a distance along the
    /// path would fold the arm.
    pub distance: f64,
    /// Bearing of the grasp from straight ahead of the base, rad: an omnidirectional base keeps it.
    pub bearing: f64,
    /// The outline of the base.
    pub footprint: &'w Footprint,
    /// The obstacles that the base keeps off.
    pub obstacles: &'w RobotObstacles,
}

impl Follower<'_> {
    /// Distance between points, m.
    pub const STEP: f64 = 0.05;

    /// Inputs of the base by pure pursuit (Coulter 1992) of a point ahead on the path, at the speed that
    /// keeps the distance, within the limits of the drive. `input` is the present one.
    pub fn inputs(&self, drive: &Drive, base: &PlanarPose, input: BaseInput, period: f64) -> BaseInputs {
        let look_aheads: &[f64] =
            if drive.is_omnidirectional() { &holonomic::LOOK_AHEADS_M } else { &LOOK_AHEADS_M };
        for &look_ahead in look_aheads {
            let mut is_clear = true;
            let inputs = self.rolled_out(look_ahead, drive, base, input, period, |at| {
                is_clear &= self.obstacles.has_room(at, self.footprint, LOOK_OUT_TOLERANCE_M);
            });
            if is_clear {
                return inputs;
            }
        }
        let (mut most, mut best) = (f64::NEG_INFINITY, BaseInputs::default());
        for &look_ahead in look_aheads.iter().rev().chain(&SHORT_LOOK_AHEADS_M) {
            let mut room = f64::INFINITY;
            let inputs = self.rolled_out(look_ahead, drive, base, input, period, |at| {
                room = room.min(self.obstacles.clearance(at, self.footprint));
            });
            if room > most {
                (most, best) = (room, inputs);
            }
            if room > -LOOK_OUT_TOLERANCE_M {
                break;
            }
        }
        best
    }

    /// The inputs of the base with this look-ahead (m). Calls `on_pose` for the poses that it comes to.
    fn rolled_out(
        &self,
        look_ahead: f64,
        drive: &Drive,
        base: &PlanarPose,
        input: BaseInput,
        period: f64,
        mut on_pose: impl FnMut(&PlanarPose),
    ) -> BaseInputs {
        let mut chosen = BaseInputs::default();
        let mut pursuit = Pursuit { look_ahead, at: *base, input, speed: self.speeds[0], ahead: 0.0 };
        for i in 0..((LOOK_OUT_S / period).round() as usize).max(chosen.len()) {
            pursuit.step(self, drive, period);
            if let Some(input) = chosen.get_mut(i) {
                *input = pursuit.input;
            }
            on_pose(&pursuit.at);
        }
        chosen
    }

    /// The position along the path of its point nearest to `at`; where the path passes twice, the later one.
    fn locate(&self, at: Point) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        for (i, pair) in self.way.windows(2).enumerate() {
            let foot = nearest_on_segment(at, pair[0], pair[1]);
            let distance = (at - foot).norm_squared();
            if distance <= best.0 {
                best = (distance, i as f64 * Self::STEP + (foot - pair[0]).norm());
            }
        }
        best.1
    }

    fn point(&self, along: f64) -> Point {
        let i = (along / Self::STEP).floor() as usize;
        match self.way.get(i..i + 2) {
            Some([a, b]) => a + (b - a) * (along / Self::STEP - i as f64),
            _ => self.end(),
        }
    }

    fn end(&self) -> Point {
        self.way.last().copied().unwrap_or_default()
    }

    /// The direction in which the path ends, of length 1; 0 for a path of one point.
    fn end_direction(&self) -> Vector {
        let [.., before, end] = self.way else { return Vector::zeros() };
        (end - before).try_normalize(1e-9).unwrap_or_default()
    }
}

/// A base on its way by pure pursuit.
struct Pursuit {
    look_ahead: f64,
    at: PlanarPose,
    input: BaseInput,
    /// Speed of the grasp (m/s), and how far it has come (m).
    speed: f64,
    ahead: f64,
}

impl Pursuit {
    fn step(&mut self, follower: &Follower, drive: &Drive, period: f64) {
        let Self { look_ahead, at, input: last, speed: grasp_speed, ahead } = self;
        let along = follower.locate(at.position);
        let change = follower.acceleration * period;
        let to = follower.speeds[1];
        *grasp_speed =
            if *grasp_speed < to { (*grasp_speed + change).min(to) } else { (*grasp_speed - change).max(to) };
        // when reversing, look behind
        let side = if *grasp_speed < 0.0 { -1.0 } else { 1.0 };
        let goal = (follower.point((along + side * *look_ahead).max(0.0)) - at.position) * side;
        let behind = (follower.end() - at.position).norm() + *ahead;
        *ahead += *grasp_speed * period;
        if drive.is_omnidirectional() {
            let wanted = side * (*grasp_speed + SPACING_GAIN * (behind - follower.distance));
            let sight = holonomic::Sight {
                goal,
                speed: side * wanted.max(0.0),
                to_grasp: follower.end() + follower.end_direction() * *ahead - at.position,
                bearing: follower.bearing,
                turning: [TURN_GAIN, TURN_RATE_LIMIT],
                acceleration: follower.rim_acceleration,
            };
            *last = sight.input(drive, at, last, period);
            *at = drive.roll(at, &(*last * period));
            return;
        }
        let bearing = wrap_angle(angle_of(goal) - at.yaw);
        let wanted = side * (*grasp_speed + SPACING_GAIN * (behind - follower.distance));
        let speed = wanted.max(0.0) * math::cos(bearing).max(0.0);
        let turn = if math::cos(bearing) > 0.0 && goal.norm() > 1e-3 {
            2.0 * math::sin(bearing) / goal.norm() * speed
                + TURN_GAIN * (1.0 - math::cos(bearing)) * bearing.signum()
        } else {
            TURN_GAIN * bearing
        };
        let turn = turn.clamp(-TURN_RATE_LIMIT, TURN_RATE_LIMIT);
        let rims = drive.input(&BaseTwist { velocity: Vector::new(side * speed, 0.0), turn });
        let fastest = rims.x.abs().max(rims.y.abs());
        let scale = if fastest > drive.rim_speed_limit { drive.rim_speed_limit / fastest } else { 1.0 };
        let change = follower.rim_acceleration * period;
        *last = last.zip_map(&rims, |last, rim| (rim * scale).clamp(last - change, last + change));
        *at = drive.roll(at, &(*last * period));
    }
}

/// Inputs that turn an omnidirectional base toward the grasp, which is off its bearing by this angle (rad).
/// Only the turning rates count.
///
/// DEVIATION (eq. 7): a base that is free moves sideways as well as ahead. One that is longer than wide does
/// not fit sideways through an opening for its width.
pub fn turn_toward_grasp(off: f64, period: f64) -> BaseInputs {
    let mut left = off;
    BaseInputs::default().map(|_| {
        let rate = FREE_TURN_GAIN * left;
        left -= rate * period;
        BaseInput::new(0.0, 0.0, rate)
    })
}

/// Replaces the base's part of the inputs.
pub fn set_base(drive: &Drive, inputs: &mut Inputs, base: &BaseInputs) {
    for (t, input) in base.iter().enumerate() {
        inputs.view_mut((0, t), (drive.inputs(), 1)).copy_from(&input.rows(0, drive.inputs()));
    }
}

/// Adds bounds that keep the base within `width` (m), along and across, of where the inputs `guide` take it, at
/// every step. They are linear about `inputs`.
pub fn keep_near(
    drive: &Drive,
    base: &PlanarPose,
    inputs: &Inputs,
    (guide, width): (&BaseInputs, f64),
    period: f64,
    limits: &mut Limits,
) {
    let rolling = Rolling::new(drive, base, inputs, period);
    let mut guided = *base;
    for (t, input) in guide.iter().enumerate() {
        guided = drive.roll(&guided, &(input * period));
        let ahead = direction(guided.yaw);
        let off = rolling.pose(t).position - guided.position;
        for toward in [ahead, -ahead, left_of(ahead), -left_of(ahead)] {
            limits.half_planes.push(rolling.bound(t, toward, width - toward.dot(&off), GUIDE_WIDTH_PRICE));
        }
    }
}

/// The part of `reference` that remains for the arm when the base has these inputs. It is seen from the
/// base's pose at each step, in the present world axes, so that the prediction is right for a turning base.
pub fn seen_from_base(
    reference: &Reference,
    grasp: &Pose,
    base: &PlanarPose,
    drive: &Drive,
    inputs: &BaseInputs,
    period: f64,
) -> Reference {
    let mut seen = *reference;
    let mut at = *base;
    let here = base.at_height(0.0);
    for (t, input) in inputs.iter().enumerate() {
        at = drive.roll(&at, &(input * period));
        let goal = Pose::from_parts(
            (grasp.translation.vector + reference.fixed_view::<3, 1>(0, t)).into(),
            Rotation3::new(reference.fixed_view::<3, 1>(3, t).into_owned()) * grasp.rotation,
        );
        let from_there = here * at.at_height(0.0).inverse() * goal;
        seen.set_column(t, &pose_difference(&from_there, grasp));
    }
    seen
}

/// The motion that B predicts for a base with these inputs, to be added to the arm's remaining reference.
pub fn rolled(drive: &Drive, jacobian: &InputJacobian, base: &BaseInputs, period: f64) -> Reference {
    let mut rolled = Reference::zeros();
    let mut so_far = nalgebra::Vector6::zeros();
    for (t, input) in base.iter().enumerate() {
        let mut rate = jacobian.column(0) * input.x + jacobian.column(1) * input.y;
        if drive.is_omnidirectional() {
            rate += jacobian.column(2) * input.z;
        }
        so_far += rate * period;
        rolled.set_column(t, &so_far);
    }
    rolled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::HORIZON;
    use crate::geometry::direction;
    use crate::world::World;
    use std::f64::consts::FRAC_PI_2;

    const DRIVE: Drive = crate::control::DIFFERENTIAL;
    const DISC: Footprint = Footprint::Disc { center: Point::new(0.0, 0.0), radius: DRIVE.base_radius };
    const PERIOD: f64 = 0.2;

    /// The path of a grasp that goes round a corner of `angle` (rad) and is `walked` (m) past it.
    fn corner(angle: f64, walked: f64) -> Vec<Point> {
        let point = |along: f64| Point::from(direction(if along < 0.0 { 0.0 } else { angle }) * along);
        (0..50).rev().map(|i| point(walked - Follower::STEP * f64::from(i))).collect()
    }

    fn obstacles(boxes: &str) -> RobotObstacles {
        let head = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-9, 0]\ntarget_m = [9, 0]\n";
        RobotObstacles::new(&World::parse("w.toml", &format!("{head}{boxes}")).unwrap())
    }

    fn no_obstacles() -> RobotObstacles {
        obstacles(
            "[[obstacle]]\nname = \"far\"\nshape = \"box\"\ncenter_m = [0, 50]\nsize_m = [1, 1]\nheight_m = 1\n",
        )
    }

    fn follower<'w>(way: &'w [Point], speeds: [f64; 2], obstacles: &'w RobotObstacles) -> Follower<'w> {
        Follower {
            way,
            speeds,
            acceleration: 0.9,
            rim_acceleration: 1.2,
            distance: 0.8,
            bearing: 0.0,
            footprint: &DISC,
            obstacles,
        }
    }

    fn off_the_way(base: &PlanarPose, way: &[Point]) -> f64 {
        let off = |w: &[Point]| (base.position - nearest_on_segment(base.position, w[0], w[1])).norm();
        way.windows(2).map(off).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_base_follows_round_corners_and_keeps_its_distance() {
        let obstacles = no_obstacles();
        for angle in [0.0, 0.5, -1.0, 1.5] {
            let mut base = PlanarPose { position: Point::new(-1.8, 0.0), yaw: 0.0 };
            let mut rims = BaseInput::new(0.5, 0.5, 0.0);
            for tick in 0..40 {
                let walked = -1.0 + 0.1 * f64::from(tick);
                let way = corner(angle, walked);
                let follower = follower(&way, [0.5; 2], &obstacles);
                let before = rims;
                rims = follower.inputs(&DRIVE, &base, rims, PERIOD)[0];
                for (rim, before) in rims.iter().zip(&before) {
                    assert!(
                        rim.abs() <= 1.0
                            && (rim - before).abs() <= follower.rim_acceleration * PERIOD + 1e-12
                    );
                }
                base = DRIVE.roll(&base, &(rims * PERIOD));
                let off = off_the_way(&base, &way);
                // at full speed; a team slows before a bend
                assert!(off < 0.15, "{angle}: {off} m off the way");
                // a body length past the corner it is back on the path
                if walked > 2.0 {
                    assert!(off < 0.02, "{angle}: {off} m off the way, {walked} m past the corner");
                    // the base has already moved by a tenth of a metre, the grasp has not
                    let behind = (way[49] - base.position).norm();
                    assert!((behind - 0.7).abs() < 0.03, "{angle}: {behind} m behind");
                }
            }
        }
    }

    /// The base reverses along its path, round corners as well, and keeps its distance.
    #[test]
    fn a_base_rolls_back_on_its_way() {
        let obstacles = no_obstacles();
        for angle in [0.0, 0.5, -1.0] {
            let start = Point::from(direction(angle) * 0.4);
            let mut base = PlanarPose { position: start, yaw: angle };
            let mut rims = BaseInput::zeros();
            for tick in 0..40 {
                let walked = 1.2 - 0.06 * f64::from(tick);
                let way = corner(angle, walked);
                let follower = follower(&way, [-0.3; 2], &obstacles);
                rims = follower.inputs(&DRIVE, &base, rims, PERIOD)[0];
                base = DRIVE.roll(&base, &(rims * PERIOD));
                let off = off_the_way(&base, &way);
                assert!(off < 0.12, "{angle}: {off} m off the way");
            }
            let behind = (corner(angle, -1.2)[49] - base.position).norm();
            assert!((behind - 0.8).abs() < 0.08 && base.position.x < -1.5, "{angle}: {behind} m behind");
            assert!(base.yaw.abs() < 0.1, "{angle}: {} rad", base.yaw);
        }
    }

    /// Round the corner of a wall, the base looks less far ahead than in free space, and stays clear.
    #[test]
    fn a_base_does_not_cut_the_corner_of_a_wall() {
        let wall = "[[obstacle]]\nname = \"wall\"\nshape = \"box\"\ncenter_m = [-2.27, 2.27]\nsize_m = [4, 4]\nheight_m = 1\n";
        let least_clearance = |obstacles: &RobotObstacles| {
            let wall = self::obstacles(wall);
            let mut base = PlanarPose { position: Point::new(-1.8, 0.0), yaw: 0.0 };
            let mut rims = BaseInput::new(0.5, 0.5, 0.0);
            let clearances = (0..40).map(|tick| {
                let way = corner(FRAC_PI_2, -1.0 + 0.05 * f64::from(tick));
                rims = follower(&way, [0.25; 2], obstacles).inputs(&DRIVE, &base, rims, PERIOD)[0];
                base = DRIVE.roll(&base, &(rims * PERIOD));
                wall.clearance(&base, &DISC)
            });
            clearances.fold(f64::INFINITY, f64::min)
        };
        let (free, near_wall) = (least_clearance(&no_obstacles()), least_clearance(&obstacles(wall)));
        assert!(free < -0.05 && near_wall > -0.02, "{free} {near_wall}");
    }

    /// A base that should roll at 0.5 m/s and rolls at 0.4 m/s falls 2 cm behind in every step.
    #[test]
    fn closed_form_the_width_about_a_guide() {
        let robot = crate::robot::Robot::built_in().unwrap();
        let rolled = |speed: f64| {
            let mut inputs = Inputs::zeros();
            inputs.fixed_rows_mut::<2>(0).fill(speed);
            inputs
        };
        let (guide, inputs) = ([BaseInput::new(0.5, 0.5, 0.0); HORIZON], rolled(0.4));
        let mut limits = Limits::new(&robot);
        let base = PlanarPose { position: Point::new(3.0, -1.0), yaw: 0.7 };
        keep_near(&robot.drive, &base, &inputs, (&guide, 0.05), PERIOD, &mut limits);
        assert_eq!(limits.half_planes.len(), 4 * HORIZON);
        for (i, plane) in limits.half_planes.iter().enumerate() {
            let behind = 0.02 * (1 + i / 4) as f64;
            let room = |inputs: &Inputs| plane.bound - plane.coefficients.dot(inputs);
            // ahead, behind, left, right
            let expected = 0.05 + [behind, -behind, 0.0, 0.0][i % 4];
            assert!((room(&inputs) - expected).abs() < 1e-12, "bound {i}: {} {expected}", room(&inputs));
            assert!((room(&rolled(0.5)) - 0.05).abs() < 1e-12, "bound {i} on the guide");
        }
    }

    #[test]
    fn closed_form_a_free_base_turns_as_the_angle_left_decreases() {
        let turning = turn_toward_grasp(0.5, PERIOD);
        let turned: f64 = turning.iter().map(|input| input.z * PERIOD).sum();
        let left = (0..HORIZON).fold(0.5, |left, _| left * (1.0 - FREE_TURN_GAIN * PERIOD));
        assert!((0.5 - turned - left).abs() < 1e-12, "{turned} {left}");
        assert!(turning.iter().all(|input| input.xy() == Vector::zeros()));
    }

    /// The arm does everything if the base stands still, and nothing if the base moves as the reference does.
    #[test]
    fn closed_form_what_is_left_for_the_arm() {
        let grasp = PlanarPose { position: Point::new(1.0, 0.2), yaw: 0.3 }.at_height(0.7);
        let base = PlanarPose { position: Point::new(0.1, 0.0), yaw: 0.2 };
        let rims: BaseInputs = std::array::from_fn(|t| BaseInput::new(0.1 * t as f64, 0.5, 0.0));
        let mut reference = Reference::zeros();
        let mut at = base;
        for (t, rim) in rims.iter().enumerate() {
            at = DRIVE.roll(&at, &(rim * PERIOD));
            let carried = at.at_height(0.0) * base.at_height(0.0).inverse() * grasp;
            reference.set_column(t, &pose_difference(&carried, &grasp));
        }
        let left = seen_from_base(&reference, &grasp, &base, &DRIVE, &rims, PERIOD);
        assert!(left.norm() < 1e-12, "{left}");
        let still = seen_from_base(&reference, &grasp, &base, &DRIVE, &[BaseInput::zeros(); HORIZON], PERIOD);
        assert!((still - reference).norm() < 1e-12);
    }
}

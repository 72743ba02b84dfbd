//! Postures solved by inverse kinematics from random starts, ranked by their room to move.

use super::footprint::across;
use super::level::FULL;
use super::link::JointKind;
use super::reach::Span;
use super::{JointVector, Motion, Robot, collision, pose_difference};
use crate::geometry::{Footprint, Pose, Vector, direction, wrap_angle};
use nalgebra::{Matrix6, Point3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::{FRAC_PI_2, PI};

/// A posture that holds the grasp level, straight ahead of the middle of the axle, or where an arm that
/// is not free can.
#[derive(Clone, Debug)]
pub(super) struct FoundPosture {
    pub joints: JointVector,
    /// x and y of the grasp in the drive's frame, m.
    pub ahead: f64,
    pub lateral_offset: f64,
    /// Turn of the grasp about its x axis that the posture needs, rad: a multiple of a right angle.
    pub roll: f64,
    /// Room to move: distance from limits as a share, less near singular configurations, near the ends of the
    /// reach, and where the arm stands out to the side of the base; 0 to 1.
    pub room: f64,
}

/// Where the grasp is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Places {
    /// Straight ahead of the middle of the axle.
    Ahead,
    /// There, and at any bearing from which the object clears the base; near the base as well.
    Around,
}

/// Starts for every place of the grasp and every roll, ahead and around.
const STARTS: usize = 16;
const STARTS_AROUND: usize = 6;
/// Places of the grasp, ahead of the base's edge, m.
const AHEAD_M: [f64; 6] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7];
/// Places around the base: distances from its edge, m, and bearings to the left and right, rad.
const AROUND_M: [f64; 5] = [0.11, 0.16, 0.25, 0.4, 0.6];
const BEARINGS_RAD: [f64; 7] = [0.0, 0.4, -0.4, 0.8, -0.8, 1.3, -1.3];
/// Least distance of the grasp from the base's edge, ahead or to the side, m: the object extends forward from
/// it.
const MIN_AHEAD_M: f64 = 0.1;
const MIN_LATERAL_M: f64 = 0.15;
/// A grasp so far from the axis halves the room, m.
const LATERAL_HALF_M: f64 = 0.3;
const MAX_STEPS: usize = 150;
const TOLERANCE: f64 = 1e-9;
/// Least distance from a limit as a share of half the range.
const MIN_CLEARANCE: f64 = 0.05;
/// The least singular value of an arm far from singular configurations.
const DEXTEROUS: f64 = 0.15;
/// Postures in a robot file, and how far one of their joints differs (rad or m).
const MAX_POSTURES: usize = 3;
const DIFFERENT: f64 = 0.7;
/// Postures whose reach is looked at, the best of all that were found.
const MAX_REACHES: usize = 80;
/// Reach ahead, back and to the sides that is enough, m, and turning of the grasp, rad: as the base follows
/// its path, the grasp moves against it by this much.
const ENOUGH_REACH_M: f64 = 0.25;
const ENOUGH_TURN_RAD: f64 = 0.8;
/// Steps of the search for the ends of the reach, as shares of what is enough.
const REACH_STEPS: u32 = 10;
/// Distance of the arm from the base's edge, to the side, at which there is no room left, m.
const MAX_OVERHANG_M: f64 = 0.4;
/// The same for a base that is a polygon, where the room is less from this far inside its edge on: on its way
/// through openings for the base, the arm needs some.
const MAX_OVERHANG_NARROW_M: f64 = 0.2;
const ROOM_INSIDE_M: f64 = 0.1;
/// Least factor of room for reach and width, so that a posture without either is better than none.
const MIN_SHARE: f64 = 0.05;
/// Least share of the reach that is enough, where the grasp is not straight ahead: with less, the arm loses the
/// object as soon as the base turns.
const MIN_REACH_AROUND: f64 = 0.3;
/// Radius of the arm in checks against the base, m.
const ARM_RADIUS_M: f64 = 0.05;
/// The spacing of the balls of eq. (7), m.
const BALL_SPACING_M: f64 = 0.25;

/// The best postures with the grasp at this height, best first; all have the roll of the best. Empty if none
/// exists. The arm stays above the base's outline.
pub(super) fn search(robot: &Robot, height: f64, footprint: &Footprint, places: Places) -> Vec<FoundPosture> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut all: Vec<FoundPosture> = Vec::new();
    let is_full = robot.freedom() == FULL;
    let mut poses = Vec::new();
    let starts = if places == Places::Ahead { STARTS } else { STARTS_AROUND };
    for [ahead, beside] in positions(robot, height, footprint, places) {
        for roll in [0.0, FRAC_PI_2, PI, -FRAC_PI_2] {
            let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
            let goal = Pose::from_parts(Vector3::new(ahead, beside, height).into(), turn);
            for _ in 0..starts {
                let start = robot.random_joints(&mut rng);
                let joints = match is_full {
                    true => solve(robot, &goal, start),
                    false => robot.level(start, height, &turn),
                };
                all.extend(joints.and_then(|joints| judge(robot, joints, roll, footprint, &mut poses)));
            }
        }
    }
    let by_room = |a: &FoundPosture, b: &FoundPosture| b.room.total_cmp(&a.room);
    all.sort_by(by_room);
    all.truncate(MAX_REACHES);
    let least_reach = if places == Places::Ahead { 0.0 } else { MIN_REACH_AROUND };
    all.retain_mut(|found| {
        let reach = reach_share(robot, found);
        found.room *= reach * width_share(robot, &found.joints, footprint);
        reach >= least_reach
    });
    all.sort_by(by_room);
    let mut best: Vec<FoundPosture> = Vec::new();
    for found in all {
        let is_new =
            |kept: &FoundPosture| kept.roll == found.roll && difference(robot, kept, &found) > DIFFERENT;
        if best.iter().all(is_new) && best.len() < MAX_POSTURES {
            best.push(found);
        }
    }
    best
}

/// The places of the grasp that are tried, x and y in the drive's frame, m.
fn positions(robot: &Robot, height: f64, footprint: &Footprint, places: Places) -> Vec<[f64; 2]> {
    if places == Places::Ahead {
        let edge = footprint.reach(Vector::x());
        return AHEAD_M.map(|d| [edge + d, 0.0]).to_vec();
    }
    let span = Span::new(robot);
    let around = BEARINGS_RAD.into_iter().flat_map(|bearing| {
        let way = direction(bearing);
        let edge = footprint.reach(way);
        AROUND_M.map(|d| [(edge + d) * way.x, (edge + d) * way.y])
    });
    around.filter(|&[x, y]| span.has(&Vector3::new(x, y, height))).collect()
}

/// The largest difference of a joint between two postures, rad or m; full turns do not count.
fn difference(robot: &Robot, one: &FoundPosture, other: &FoundPosture) -> f64 {
    let by = one.joints - other.joints;
    let of = robot.joints.iter().zip(by.iter()).map(|(joint, by)| match joint.motion {
        Motion::Revolute => wrap_angle(*by).abs(),
        Motion::Prismatic => by.abs(),
    });
    of.fold(0.0, f64::max)
}

/// Damped least squares towards the goal, kept within the limits. `None` if it does not get there.
fn solve(robot: &Robot, goal: &Pose, mut joints: JointVector) -> Option<JointVector> {
    const DAMPING: f64 = 1e-4;
    const MAX_STEP: f64 = 0.4;
    for _ in 0..MAX_STEPS {
        let kinematics = robot.kinematics(&Robot::at_origin(&joints));
        let error = pose_difference(goal, &kinematics.grasp);
        if error.norm() <= TOLERANCE {
            return Some(joints);
        }
        let arm = robot.arm_jacobian(&kinematics.jacobian);
        let damping = DAMPING * error.norm().min(1.0);
        let gram = arm * arm.transpose() + Matrix6::identity() * (damping + 1e-12);
        let step: JointVector = arm.transpose() * gram.cholesky()?.solve(&error);
        joints += step * (MAX_STEP / step.amax().max(MAX_STEP));
        for (at, joint) in joints.iter_mut().zip(&robot.joints) {
            *at = at.clamp(joint.lower, joint.upper);
        }
    }
    None
}

/// The posture with its room; `None` if it has too little, the object would be above the base, or the arm
/// touches itself or passes through the base.
fn judge(
    robot: &Robot,
    mut joints: JointVector,
    roll: f64,
    footprint: &Footprint,
    poses: &mut Vec<Pose>,
) -> Option<FoundPosture> {
    let grasp = robot.drive_from_grasp(&joints).translation.vector;
    let (ahead, half_width) = (footprint.reach(Vector::x()), across(footprint) / 2.0);
    let is_clear =
        grasp.x >= ahead + MIN_AHEAD_M || grasp.x >= 0.0 && grasp.y.abs() >= half_width + MIN_LATERAL_M;
    for (at, joint) in joints.iter_mut().zip(&robot.joints) {
        // continuous joints within a turn
        if joint.motion == Motion::Revolute && joint.upper.is_infinite() {
            *at -= (*at / (2.0 * PI)).round() * 2.0 * PI;
        }
    }
    let clearance = robot.limit_clearance(&joints).map_or(1.0, |(_, share)| share);
    if !is_clear || clearance < MIN_CLEARANCE || passes_through_base(robot, &joints, footprint) {
        return None;
    }
    if robot.self_contact(&joints, poses).is_some() || robot.immovable(&joints).is_some() {
        return None;
    }
    let room = clearance.min(0.5) * (robot.dexterity_where_free(&joints) / DEXTEROUS).min(1.0);
    let room = room / (1.0 + grasp.y.abs() / LATERAL_HALF_M);
    Some(FoundPosture { joints, ahead: grasp.x, lateral_offset: grasp.y, roll, room })
}

/// How far the grasp can move ahead, back and to either side and turn, the least of all, as a share of what is
/// enough.
fn reach_share(robot: &Robot, found: &FoundPosture) -> f64 {
    // an arm that is not free leaves most of it to the base
    if robot.freedom() < FULL {
        return 1.0;
    }
    let start = Robot::at_origin(&found.joints);
    let grasp = robot.grasp_pose(&start);
    let share = |way: Vector3<f64>, turn: f64| {
        let (mut at, mut reached) = (start, 0);
        for step in 1..=REACH_STEPS {
            let share = f64::from(step) / f64::from(REACH_STEPS);
            let mut goal = grasp;
            goal.translation.vector += way * share;
            goal.rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), turn * share) * goal.rotation;
            let closed = robot.close(&at, &goal, TOLERANCE);
            let Some((closed, _)) = closed.filter(|(q, _)| robot.is_within_limits(&q.joints)) else { break };
            (at, reached) = (closed, step);
        }
        f64::from(reached) / f64::from(REACH_STEPS)
    };
    let ways = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()];
    let ways = ways.into_iter().map(|way| share(way * ENOUGH_REACH_M, 0.0));
    let turns = [ENOUGH_TURN_RAD, -ENOUGH_TURN_RAD].map(|turn| share(Vector3::zeros(), turn));
    ways.chain(turns).fold(1.0, f64::min).max(MIN_SHARE)
}

/// The largest distance of the arm from the middle of the base to either side, m: its joints with balls of
/// this radius (m) around them, and the collision shapes of the links from the base to the grasp.
pub(super) fn arm_half_width(robot: &Robot, joints: &JointVector, radius: f64) -> f64 {
    let mut widest: f64 = 0.0;
    let q = Robot::at_origin(joints);
    robot.arm_points(&q, f64::INFINITY, |at, _| widest = widest.max(at.y.abs() + radius));
    on_arm_corners(robot, joints, |corner, radius| widest = widest.max(corner.y.abs() + radius));
    widest
}

/// How far the arm's collision shapes are outside the balls of this radius (m) that eq. (7) keeps off
/// obstacles, m. What is nearest to the grasp does not count: it is ahead.
pub(super) fn outside_balls(robot: &Robot, joints: &JointVector, radius: f64) -> f64 {
    let mut farthest: f64 = 0.0;
    on_corners_outside(robot, joints, radius, |outside, _| farthest = farthest.max(outside));
    farthest
}

/// Half of the width (m) about the middle of the base that what is more than `allowed` m outside these balls
/// needs, with as much again for its motion; 0 if nothing is.
pub(super) fn half_width_outside_balls(
    robot: &Robot,
    joints: &JointVector,
    radius: f64,
    allowed: f64,
) -> f64 {
    let mut widest: f64 = 0.0;
    on_corners_outside(robot, joints, radius, |outside, lateral| {
        if outside > allowed {
            widest = widest.max(lateral + allowed);
        }
    });
    widest
}

/// Calls `on_corner` for what is outside these balls: by how much, and how far from the middle of the base to
/// either side, m.
fn on_corners_outside(robot: &Robot, joints: &JointVector, radius: f64, mut on_corner: impl FnMut(f64, f64)) {
    let mut balls = Vec::new();
    robot.arm_points(&Robot::at_origin(joints), BALL_SPACING_M, |at, _| balls.push(at));
    on_arm_corners(robot, joints, |corner, of_corner| {
        let distances = balls.iter().map(|ball| (ball - corner).norm()).enumerate();
        if let Some((nearest, distance)) = distances.min_by(|a, b| a.1.total_cmp(&b.1))
            && nearest + 1 < balls.len()
            && distance + of_corner > radius
        {
            on_corner(distance + of_corner - radius, corner.y.abs() + of_corner);
        }
    });
}

/// Calls `on_corner` for points of the collision shapes of the links from the base to the grasp, each with a
/// radius around it, m.
fn on_arm_corners(robot: &Robot, joints: &JointVector, mut on_corner: impl FnMut(Vector3<f64>, f64)) {
    let poses = robot.link_poses(&Robot::at_origin(joints));
    let links = std::iter::successors(Some(robot.grasp_link), |&at| robot.links[at].parent);
    let path: Vec<usize> = links.take_while(|&at| at != robot.base_link).collect();
    // a lift's own shapes stay above the base
    let turns = |at: &usize| {
        let joint = robot.links[*at].joint.as_ref();
        joint.is_some_and(|j| j.coupling.joint.is_some() && j.kind != JointKind::Prismatic)
    };
    let of_arm = path.iter().rposition(turns).map_or(0, |first| first + 1);
    for &at in &path[..of_arm] {
        for shape in &robot.links[at].collisions {
            let world_from_shape = poses[at] * shape.link_from_shape;
            for (corner, radius) in collision::corners(&shape.shape) {
                on_corner((world_from_shape * Point3::from(corner)).coords, radius);
            }
        }
    }
}

/// 1 for an arm that is no wider than the base, less for an elbow that stands out. For a disc, joints count;
/// for a polygon, which is as narrow as the base itself, shapes do.
fn width_share(robot: &Robot, joints: &JointVector, footprint: &Footprint) -> f64 {
    let (widest, farthest) = match footprint {
        Footprint::Disc { .. } => {
            let mut widest: f64 = 0.0;
            let q = Robot::at_origin(joints);
            robot.arm_points(&q, f64::INFINITY, |at, _| widest = widest.max(at.y.abs()));
            (widest + ARM_RADIUS_M, MAX_OVERHANG_M)
        }
        Footprint::Polygon(_) => {
            let widest = arm_half_width(robot, joints, ARM_RADIUS_M) + ROOM_INSIDE_M;
            (widest, MAX_OVERHANG_NARROW_M + ROOM_INSIDE_M)
        }
    };
    (1.0 - (widest - across(footprint) / 2.0) / farthest).clamp(MIN_SHARE, 1.0)
}

/// Whether the arm, as thick segments between its joints, comes below the first of them within the base's
/// outline, or below the floor.
pub(super) fn passes_through_base(robot: &Robot, joints: &JointVector, footprint: &Footprint) -> bool {
    let mut points = Vec::new();
    robot.arm_points(&Robot::at_origin(joints), f64::INFINITY, |at, _| points.push(at));
    let Some(shoulder) = points.iter().map(|p| p.xy()).next() else { return false };
    let first = points.iter().position(|p| (p.xy() - shoulder).norm() > 0.05).unwrap_or(0);
    let floor = points.get(first.saturating_sub(1)).map_or(0.0, |p| p.z) - 2.0 * ARM_RADIUS_M;
    points[first..].windows(2).any(|pair| {
        (0..=10).any(|i| {
            let p = pair[0] + (pair[1] - pair[0]) * (f64::from(i) / 10.0);
            let is_above_base = || footprint.separation(p.xy().into()).0 < ARM_RADIUS_M;
            p.z < ARM_RADIUS_M || (p.z < floor.min(0.6) && is_above_base())
        })
    })
}

//! An arm that does not carry, tucked away: near the axis of the base, and touching nothing.

use super::postures::passes_through_base;
use super::{JointVector, Robot};
use crate::geometry::Pose;
use crate::math;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Random positions that are tried, and of them those that are looked at closely.
const STARTS: usize = 800;
const CLOSE: usize = 60;
/// How far positions are moved to find better ones, rad or m, and how often each.
const MOVES: [f64; 4] = [0.5, 0.25, 0.12, 0.06];
const TRIES: usize = 60;
/// Spacing of the points of an arm whose distance counts, m.
const SPACING_M: f64 = 0.1;
/// How much more it counts that a point is ahead, where the object is.
const AHEAD: f64 = 0.5;
/// Least distance from a limit as a share of half the range.
const MIN_CLEARANCE: f64 = 0.02;

/// The joint positions at which the arm's farthest point is nearest to the base's axis; the same for every
/// call. `None` if the arm touches the robot, the floor or its limits wherever it was tried.
pub(super) fn tucked(robot: &Robot) -> Option<JointVector> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut poses = Vec::new();
    let mut starts: Vec<(f64, JointVector)> = (0..STARTS)
        .map(|_| robot.random_joints(&mut rng))
        .map(|joints| (extent(robot, &joints), joints))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(CLOSE);
    let (mut least, mut best) = starts.into_iter().find(|(_, joints)| is_clear(robot, joints, &mut poses))?;
    for by in MOVES {
        for _ in 0..TRIES {
            let mut joints = best;
            for (at, joint) in joints.iter_mut().zip(&robot.joints) {
                *at = (*at + rng.random_range(-by..by)).clamp(joint.lower, joint.upper);
            }
            let extent = extent(robot, &joints);
            if extent < least && is_clear(robot, &joints, &mut poses) {
                (least, best) = (extent, joints);
            }
        }
    }
    Some(best)
}

/// The largest distance of the arm from the base's axis, m; more where it is ahead.
fn extent(robot: &Robot, joints: &JointVector) -> f64 {
    let mut farthest: f64 = 0.0;
    robot.arm_points(&Robot::at_origin(joints), SPACING_M, |at, _| {
        farthest = farthest.max(math::hypot(at.x, at.y) + AHEAD * at.x.max(0.0));
    });
    farthest
}

fn is_clear(robot: &Robot, joints: &JointVector, poses: &mut Vec<Pose>) -> bool {
    let clearance = robot.limit_clearance(joints).map_or(1.0, |(_, share)| share);
    clearance >= MIN_CLEARANCE
        && !passes_through_base(robot, joints, &robot.footprint)
        && robot.self_contact(joints, poses).is_none()
}

//! How far a robot can carry, and how much room a posture leaves.

use super::{Configuration, JointVector, Posture, Robot, collision, footprint};
use crate::geometry::{PlanarPose, Point, Pose};

/// Step of the search for the ends of the reach, m.
const STEP_M: f64 = 0.01;
/// The farthest from the drive that is searched, m.
const MAX_REACH_M: f64 = 3.0;
/// Tolerance of the grasp's pose, m and rad.
const TOLERANCE: f64 = 1e-9;

/// Where the grasp can be moved straight ahead and back from a posture, level and at its height: x in the
/// drive's frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Nearest x.
    pub nearest: f64,
    /// Farthest x.
    pub farthest: f64,
}

impl Robot {
    /// The configuration of some joints at the world's origin.
    pub(super) fn at_origin(joints: &JointVector) -> Configuration {
        Configuration { base: PlanarPose { position: Point::origin(), yaw: 0.0 }, joints: *joints }
    }

    /// `drive_from_base`: the drive's frame is on the floor, midway between the wheels.
    pub fn drive_from_base(&self) -> Pose {
        self.drive_from_base
    }

    /// `drive_from_grasp` with these joints.
    pub fn drive_from_grasp(&self, joints: &JointVector) -> Pose {
        self.grasp_pose(&Self::at_origin(joints))
    }

    /// The reach from a posture, to 1 cm. The arm ends at a limit of a joint or where it is stretched.
    pub fn reach(&self, posture: &Posture) -> Reach {
        let start = Self::at_origin(&posture.joints);
        let pose = self.grasp_pose(&start);
        let walk = |by: f64| {
            let (mut at, mut end) = (start, pose.translation.x);
            while end.abs() < MAX_REACH_M {
                let mut next = pose;
                next.translation.x = end + by;
                let Some((closed, _)) = self.close(&at, &next, TOLERANCE) else { break };
                if !self.is_within_limits(&closed.joints) {
                    break;
                }
                (at, end) = (closed, next.translation.x);
            }
            end
        };
        Reach { nearest: walk(-STEP_M), farthest: walk(STEP_M) }
    }

    /// Whether every joint is within its limits.
    pub fn is_within_limits(&self, joints: &JointVector) -> bool {
        self.joints.iter().zip(joints.iter()).all(|(joint, at)| (joint.lower..=joint.upper).contains(at))
    }

    /// The joint that is nearest to a limit, and its distance from it as a share of half its range: 0 at the
    /// limit, 1 in the middle. `None` if no joint has limits.
    pub fn limit_clearance(&self, joints: &JointVector) -> Option<(usize, f64)> {
        let shares = self.joints.iter().zip(joints.iter()).enumerate().filter_map(|(i, (joint, at))| {
            let half = (joint.upper - joint.lower) / 2.0;
            half.is_finite().then(|| (i, (at - joint.lower).min(joint.upper - at) / half))
        });
        shares.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The least singular value of the arm's Jacobian (m/s and rad/s per unit of joint rate): 0 where the arm
    /// cannot move its grasp in some direction. Directions in which it can never move are left out.
    pub fn dexterity(&self, joints: &JointVector) -> f64 {
        self.squared_singular_values(joints)[self.freedom().clamp(1, 6) - 1].max(0.0).sqrt()
    }

    /// Twice the largest distance of the footprint from the middle of the base, m.
    pub fn footprint_across(&self) -> f64 {
        footprint::across(&self.footprint)
    }

    /// The largest distance of the base's collision shapes from the middle of the axle, seen from above, m.
    /// `None` if it has none.
    pub fn base_extent(&self) -> Option<f64> {
        collision::base_extent(self)
    }
}

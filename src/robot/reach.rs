//! How far a robot can carry, and how much room a posture leaves.

use super::level::FULL;
use super::{Configuration, JointVector, Robot, collision, footprint};
use crate::geometry::{PlanarPose, Point, Pose};
use nalgebra::{Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::{FRAC_PI_2, PI};

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

impl Reach {
    /// The way from one to the other, m.
    pub fn length(&self) -> f64 {
        self.farthest - self.nearest
    }
}

/// Random configurations by which a span is known, and the share by which it may be larger.
const SAMPLES: usize = 2000;
const BEYOND: f64 = 1.05;
/// Heights at which a level grasp is sought, a step apart, m, with so many starts each.
const HEIGHT_STEP_M: f64 = 0.05;
const HEIGHTS: u32 = 45;
const STARTS: usize = 12;

/// The room in which an arm can have its grasp, in any orientation, in the drive's frame.
pub(super) struct Span {
    /// Where its first joint that turns is, m.
    shoulder: Vector3<f64>,
    /// The farthest from it, m.
    radius: f64,
    /// The lowest and the highest, and the farthest ahead, m.
    lowest: f64,
    highest: f64,
    ahead: f64,
}

impl Span {
    /// Measured in random configurations, the same for every call.
    pub fn new(robot: &Robot) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut span = Self {
            shoulder: Vector3::zeros(),
            radius: 0.0,
            lowest: f64::INFINITY,
            highest: f64::NEG_INFINITY,
            ahead: f64::NEG_INFINITY,
        };
        let mut first = None;
        robot.arm_points(&Robot::at_origin(&robot.random_joints(&mut rng)), f64::INFINITY, |at, _| {
            first.get_or_insert(at);
        });
        span.shoulder = first.unwrap_or_default();
        for _ in 0..SAMPLES {
            let at = robot.drive_from_grasp(&robot.random_joints(&mut rng)).translation.vector;
            span.radius = span.radius.max((at - span.shoulder).norm());
            span.lowest = span.lowest.min(at.z);
            span.highest = span.highest.max(at.z);
            span.ahead = span.ahead.max(at.x);
        }
        span
    }

    /// Whether a point may be within reach.
    pub fn has(&self, point: &Vector3<f64>) -> bool {
        let beyond = (BEYOND - 1.0) * self.radius;
        let is_at_height = (self.lowest - beyond..=self.highest + beyond).contains(&point.z);
        is_at_height && (point - self.shoulder).norm() <= BEYOND * self.radius
    }
}

impl Robot {
    /// What the arm reaches, for the error that no posture is found: a sentence.
    pub(super) fn told_reach(&self) -> String {
        let Span { lowest, highest, ahead, .. } = Span::new(self);
        let (low, high) = (lowest.max(0.0), highest.max(0.0));
        let all = format!(
            "its arm reaches {low:.2} to {high:.2} m above the floor and {ahead:.2} m ahead of the drive"
        );
        let edge = footprint::across(&self.footprint) / 2.0;
        let edge = self.base_extent().unwrap_or(edge);
        let level = self.level_heights();
        match (level.first(), level.last()) {
            (Some((first, joints)), Some((last, _))) => {
                let why = self.immovable(joints).map_or(String::new(), |why| format!("; {why}"));
                format!("{all}, level at {first:.2} to {last:.2} m; the base extends to {edge:.2} m{why}")
            }
            _ => format!("{all}, but never level and straight ahead"),
        }
    }

    /// The heights at which the arm holds its grasp level and straight ahead, wherever that is in the plane
    /// and whatever it touches, m, with joint positions.
    fn level_heights(&self) -> Vec<(f64, JointVector)> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut level = |height: f64| {
            [0.0, FRAC_PI_2, PI, -FRAC_PI_2].into_iter().find_map(|roll| {
                let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
                (0..STARTS).find_map(|_| {
                    let start = self.random_joints(&mut rng);
                    self.level(start, height, &turn)
                })
            })
        };
        let heights = (0..HEIGHTS).map(|step| f64::from(step) * HEIGHT_STEP_M);
        heights.filter_map(|height| Some((height, level(height)?))).collect()
    }
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
    pub fn reach(&self, posture: &JointVector) -> Reach {
        let start = Self::at_origin(posture);
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
    /// cannot move its grasp in some direction, as of fewer than six joints.
    pub fn dexterity(&self, joints: &JointVector) -> f64 {
        self.squared_singular_values(joints)[FULL - 1].max(0.0).sqrt()
    }

    /// The same without directions in which the arm can never move.
    pub(super) fn dexterity_where_free(&self, joints: &JointVector) -> f64 {
        self.squared_singular_values(joints)[self.freedom().clamp(1, FULL) - 1].max(0.0).sqrt()
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

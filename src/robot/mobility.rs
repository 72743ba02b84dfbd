//! How a robot moves its grasp from a posture: the directions that its arm lacks, the speeds in the plane that
//! base and arm reach together, the width that it needs, and why it may not carry at all.

use super::level::MIN_FREE;
use super::{InputJacobian, InputVector, JointVector, MAX_INPUTS, MAX_JOINTS, Robot};
use crate::geometry::Vector;
use nalgebra::{Matrix6, SMatrix, Vector6};

/// The directions of the grasp in the drive's frame, as what an arm does to it.
const DIRECTIONS: [&str; 6] =
    ["move it ahead", "move it sideways", "raise it", "roll it", "pitch it", "turn it"];
/// Those of them in the plane.
const IN_PLANE: [usize; 3] = [0, 1, 5];
/// The largest part of a motion that may be missing for it to count as possible: the axes of calibrated URDFs
/// are not quite parallel.
const TOLERANCE: f64 = 0.02;
/// A grasp nearer to the base's axis is on it, m.
const ON_AXIS_M: f64 = 1e-3;
/// How far ahead of the axle the arm must turn its grasp at least, m: nearer, the base would have to turn on
/// the spot at every step to the side.
const MIN_HINGE_M: f64 = 0.02;
/// A straight way in steps (m), 8 m in all, and the angle (rad) by which a base that turns away has turned on
/// it: of 18 published robots, five turn by more than 1.4 rad, the others by less than 0.15.
const STRAIGHT_STEP_M: f64 = 0.1;
const STRAIGHT_STEPS: usize = 80;
const TURNED_AWAY_RAD: f64 = 0.5;
/// Iterations of Lawson's algorithm, and the least weight in it.
const STEPS: usize = 200;
const MIN_WEIGHT: f64 = 1e-6;

/// The largest speeds of the grasp in the plane, level and at its height, from a posture: 0 where base and arm
/// together cannot move it so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarSpeeds {
    /// Ahead, without turning, m/s.
    pub ahead: f64,
    /// To either side, without turning, m/s.
    pub sideways: f64,
    /// Turning in place, rad/s.
    pub turning: f64,
}

impl Robot {
    /// What the arm alone cannot do to its grasp from this posture, such as "move it ahead".
    pub fn missing_motions(&self, joints: &JointVector) -> Vec<&'static str> {
        let missing = self.missing_shares(joints);
        let largest = missing.max();
        let is_missing = |share: &f64| *share > TOLERANCE && *share >= largest.min(0.5);
        let named = DIRECTIONS.into_iter().zip(missing.iter());
        named.filter(|(_, share)| is_missing(share)).map(|(name, _)| name).collect()
    }

    /// Whether the arm alone moves its grasp in the plane and turns it, whichever way.
    pub(crate) fn is_arm_free_in_plane(&self, joints: &JointVector) -> bool {
        let missing = self.missing_shares(joints);
        IN_PLANE.into_iter().all(|direction| missing[direction] <= TOLERANCE)
    }

    /// The share of each direction that the arm lacks.
    fn missing_shares(&self, joints: &JointVector) -> Vector6<f64> {
        let arm = self.arm_jacobian(&self.kinematics(&Self::at_origin(joints)).jacobian);
        (Matrix6::identity() - possible(&(arm * arm.transpose()))).diagonal()
    }

    /// How fast base and arm together move the grasp in the plane from this posture.
    pub fn planar_speeds(&self, joints: &JointVector) -> PlanarSpeeds {
        let jacobian = self.kinematics(&Self::at_origin(joints)).jacobian;
        let limits = self.input_limits();
        let along = |row: usize| {
            let mut twist = Vector6::zeros();
            twist[row] = 1.0;
            largest_share(&jacobian, &limits, &twist).map_or(0.0, |share| 1.0 / share)
        };
        PlanarSpeeds { ahead: along(0), sideways: along(1), turning: along(5) }
    }
}

/// Why a robot cannot carry from a posture, although its arm holds the grasp there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Immovable {
    /// Base and arm together cannot move the grasp in the plane and turn it, level and at its height.
    Bound,
    /// The arm moves the grasp to the side only by turning it about an axis so far ahead of the axle, m.
    Hinge(f64),
}

impl std::fmt::Display for Immovable {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Bound => f.write_str(
                "direction: base and arm together cannot move the grasp to the side and turn it, level and at its height",
            ),
            Self::Hinge(ahead) => write!(
                f,
                "direction: the arm moves its grasp to the side only by turning it about an axis {:.2} m {} the axle, as a hinge; a base that pushes at such a hinge swings round. It must be at least {MIN_HINGE_M} m ahead of the axle",
                ahead.abs(),
                if *ahead < 0.0 { "behind" } else { "ahead of" }
            ),
        }
    }
}

impl Robot {
    /// The distance of the grasp to the left of the base's axis that the base keeps while it carries, m; 0 for
    /// an omnidirectional base, which follows the grasp in any direction.
    pub fn kept_offset(&self, joints: &JointVector) -> f64 {
        let lateral = self.drive_from_grasp(joints).translation.y;
        if self.drive.is_omnidirectional() || lateral.abs() < ON_AXIS_M { 0.0 } else { lateral }
    }

    /// The width about the grasp's path that the robot needs from a posture, m: that of its base, or more where
    /// the base moves beside the path.
    pub fn carrying_width(&self, joints: &JointVector) -> f64 {
        let offset = self.kept_offset(joints);
        if offset == 0.0 {
            return self.width();
        }
        let side = self.footprint.reach(Vector::new(0.0, -offset.signum()));
        self.width().max(2.0 * (offset.abs() + side))
    }

    /// Why the robot cannot carry from this posture, by its kinematics.
    pub(super) fn immovable(&self, joints: &JointVector) -> Option<Immovable> {
        let speeds = self.planar_speeds(joints);
        if [speeds.ahead, speeds.sideways, speeds.turning].contains(&0.0) {
            return Some(Immovable::Bound);
        }
        if self.drive.is_omnidirectional() {
            return None;
        }
        let ahead = self.hinge(joints)?;
        (ahead < MIN_HINGE_M).then_some(Immovable::Hinge(ahead))
    }

    /// How far ahead of the axle the base turns while the grasp stays where it is, if it cannot turn about any
    /// place, m.
    pub(crate) fn hinge(&self, joints: &JointVector) -> Option<f64> {
        let there = self.kinematics(&Self::at_origin(joints));
        let at = there.grasp.translation.vector;
        // the base, moved ahead in place of the wheels' second column; its turning is what is to be made up for
        let mut columns = InputJacobian::zeros();
        columns.columns_mut(0, MAX_JOINTS).copy_from(&self.arm_jacobian(&there.jacobian));
        columns[(0, MAX_JOINTS)] = 1.0;
        let turned = Vector6::new(at.y, -at.x, 0.0, 0.0, 0.0, -1.0);
        if PossibleTwist::new(&columns, &turned).is_some() {
            return None;
        }
        columns[(1, MAX_JOINTS + 1)] = 1.0;
        let turning = PossibleTwist::new(&columns, &turned)?;
        Some(-turning.weighted(&InputVector::repeat(1.0))?[MAX_JOINTS + 1])
    }

    /// Whether a differential base turns away while its grasp goes straight ahead by the least inputs, as eq.
    /// (7) moves it where nothing else counts: on most bases the grasp stays ahead, or comes back there.
    pub fn turns_away(&self, joints: &JointVector) -> bool {
        let mut q = Self::at_origin(joints);
        !self.drive.is_omnidirectional()
            && (0..STRAIGHT_STEPS).any(|_| {
                let jacobian = self.kinematics(&q).jacobian;
                let ahead = PossibleTwist::new(&jacobian, &(Vector6::x() * STRAIGHT_STEP_M));
                let Some(input) = ahead.and_then(|ahead| ahead.weighted(&InputVector::repeat(1.0))) else {
                    return true;
                };
                q.base = self.drive.roll(&q.base, &self.base_input(&input));
                q.joints += self.joint_rates(&input);
                q.base.yaw.abs() > TURNED_AWAY_RAD
            })
    }
}

/// The largest share of a limit that inputs with this `twist` need, where that is as small as it can be: the
/// Chebyshev norm of the scaled inputs, by Lawson's algorithm (weighted least squares, whose weights grow with
/// the inputs). `None` if no inputs have the twist.
fn largest_share(jacobian: &InputJacobian, limits: &InputVector, twist: &Vector6<f64>) -> Option<f64> {
    let mut possible = PossibleTwist::new(jacobian, twist)?;
    for (mut column, limit) in possible.jacobian.column_iter_mut().zip(limits) {
        column *= *limit;
    }
    let mut weights = InputVector::repeat(1.0);
    let mut least: Option<f64> = None;
    for _ in 0..STEPS {
        let shares = possible.weighted(&weights)?;
        let largest = shares.amax();
        least = Some(least.map_or(largest, |least| least.min(largest)));
        weights
            .zip_apply(&shares, |weight, share| *weight = (*weight * share.abs() / largest).max(MIN_WEIGHT));
    }
    least
}

/// The projection onto the directions of a matrix `J J'` in which J moves the grasp by more than imprecise axes
/// do.
fn possible(gram: &Matrix6<f64>) -> Matrix6<f64> {
    let eigen = gram.symmetric_eigen();
    let mut onto = Matrix6::zeros();
    for (column, square) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
        if *square > MIN_FREE * MIN_FREE {
            onto += column * column.transpose();
        }
    }
    onto
}

/// A twist that inputs can make, with their Jacobian, both without the directions that are not [`possible`].
struct PossibleTwist {
    jacobian: InputJacobian,
    twist: Vector6<f64>,
    /// The projection onto those directions.
    impossible: Matrix6<f64>,
}

impl PossibleTwist {
    /// `None` if the twist has a part in those directions.
    fn new(jacobian: &InputJacobian, twist: &Vector6<f64>) -> Option<Self> {
        let onto = possible(&(jacobian * jacobian.transpose()));
        let within = onto * twist;
        let impossible = Matrix6::identity() - onto;
        ((within - twist).amax() <= TOLERANCE).then_some(Self {
            jacobian: onto * jacobian,
            twist: within,
            impossible,
        })
    }

    /// The inputs with the twist whose weighted squares have the least sum; `None` if the numbers do not allow
    /// it.
    fn weighted(&self, weights: &InputVector) -> Option<InputVector> {
        let mut spread: SMatrix<f64, 6, MAX_INPUTS> = self.jacobian;
        for (mut column, weight) in spread.column_iter_mut().zip(weights) {
            column /= *weight;
        }
        let gram = spread * self.jacobian.transpose();
        // what is added has no part in the twist, and makes the matrix regular
        let regular = gram + self.impossible * gram.amax();
        Some(spread.tr_mul(&regular.cholesky()?.solve(&self.twist)))
    }
}

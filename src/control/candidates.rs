//! The candidate set Q of eq. (8): configurations that keep the grasp's pose and can be reached within one
//! period.

use super::limits::Limits;
use crate::robot::{Configuration, InputJacobian, InputVector, Kinematics, MAX_INPUTS, MAX_JOINTS, Robot};
use nalgebra::SMatrix;

/// The kind of configurations that eq. (8) chooses among.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateSet {
    /// The present configuration only: no pose optimisation.
    None,
    /// Self-motion of the arm with a fixed base.
    Arm,
    /// Self-motion of base and arm together.
    WholeBody,
}

/// A candidate configuration and the rates that lead to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The configuration.
    pub configuration: Configuration,
    /// Mean rates over one period that lead there, as inputs.
    pub rates: InputVector,
    /// The whole-body Jacobian J there.
    pub jacobian: InputJacobian,
}

impl Candidate {
    /// The present configuration, with its kinematics.
    pub fn at_rest(configuration: &Configuration, at: &Kinematics) -> Self {
        Self { configuration: *configuration, rates: InputVector::zeros(), jacobian: at.jacobian }
    }
}

/// Number of candidates on either side of the present configuration; with the present one, the paper's |Q| =
/// 15.
pub const PER_SIDE: usize = 7;
/// Largest deviation of the grasp from its pose, m and rad.
const GRASP_TOLERANCE: f64 = 1e-7;
/// Length below which a direction of self-motion is degenerate.
const DEGENERATE: f64 = 1e-6;

/// The state around which candidates are generated.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The present configuration, q_c.
    pub configuration: &'a Configuration,
    /// The kinematics at that configuration.
    pub kinematics: &'a Kinematics,
    /// The robot's rate limits.
    pub limits: &'a Limits,
    /// Control period, s.
    pub period: f64,
    /// The share of the rate limits that the motion to a candidate may use, up to 1.
    pub share: f64,
}

impl Neighbourhood<'_> {
    /// The candidates that can be reached in one period, into `found`: the present configuration first, then
    /// steps outward on alternating sides. A side has none if a joint limit leaves no room.
    ///
    /// With one direction of self-motion (the arm of seven joints) there are seven equal steps to either
    /// side, up to the rate limits. With more directions, the seven steps are distributed over the directions
    /// in turn. The steps follow the direction at the present configuration, and Newton's iteration returns
    /// the grasp to its pose.
    pub fn candidates(&self, set: CandidateSet, found: &mut Vec<Candidate>) {
        found.clear();
        found.push(Candidate::at_rest(self.configuration, self.kinematics));
        let arm_only = match set {
            CandidateSet::None => return,
            CandidateSet::Arm => true,
            CandidateSet::WholeBody => false,
        };
        let basis = self_motions(self.robot, &self.kinematics.jacobian, arm_only);
        for (d, direction) in basis.directions().enumerate() {
            let levels = (PER_SIDE + basis.count - 1 - d) / basis.count;
            // the correction per squared rate at the present configuration, as found on the first side
            let mut bend = InputVector::zeros();
            for side in [1.0, -1.0] {
                let outward = direction * side;
                let mut reach = self.reach(&outward);
                for _ in 0..4 {
                    let before = found.len();
                    let excess = self.side(&(outward * reach), levels, &mut bend, found);
                    if excess <= self.share {
                        break;
                    }
                    // closing the loop took a joint beyond its rate limit: shorten the steps
                    found.truncate(before);
                    reach *= 0.999 * self.share / excess;
                }
            }
        }
    }

    /// Adds the equal steps up to `outermost` (rates). Returns the largest rate as a multiple of its limit.
    ///
    /// The grasp returns to its pose by a correction of the joints, which begins with the square of the step.
    /// Its ratio to that, extrapolated from the steps so far, is the first guess; `bend` is the ratio at the
    /// present configuration, per squared rate.
    fn side(
        &self,
        outermost: &InputVector,
        levels: usize,
        bend: &mut InputVector,
        found: &mut Vec<Candidate>,
    ) -> f64 {
        let Self { robot, configuration: q, kinematics, period, .. } = *self;
        if outermost.norm() * period < DEGENERATE {
            return 0.0;
        }
        // the ratios at the last three steps, the latest first, with the step's square as the unit
        let unit = (outermost / levels as f64).norm_squared();
        let mut ratios = [*bend * unit; 3];
        let mut excess: f64 = 0.0;
        for level in 1..=levels {
            let step = outermost * (level as f64 / levels as f64);
            let square = (level * level) as f64;
            let [last, second, third] = &ratios;
            let ratio = match level {
                1 => *last,
                2 | 3 => last * 2.0 - second,
                _ => (last - second) * 3.0 + third,
            };
            let guess = robot.advance(q, &(step + ratio * square), period);
            let Some((closed, there)) = robot.close(&guess, &kinematics.grasp, GRASP_TOLERANCE) else {
                break;
            };
            let mut rates = step;
            rates
                .fixed_rows_mut::<MAX_JOINTS>(robot.drive.inputs())
                .copy_from(&((closed.joints - q.joints) / period));
            let ratio = (rates - step) / square;
            ratios = if level == 1 && *bend == InputVector::zeros() {
                [ratio; 3]
            } else {
                [ratio, ratios[0], ratios[1]]
            };
            if level == 2 {
                *bend = (ratios[1] * 2.0 - ratios[0]) / unit;
            }
            excess = excess.max(self.largest_share(&rates));
            let joints = robot.joints.iter().zip(closed.joints.iter());
            if !joints.into_iter().all(|(joint, there)| (joint.lower..=joint.upper).contains(there)) {
                break;
            }
            found.push(Candidate { configuration: closed, rates, jacobian: there.jacobian });
        }
        excess
    }

    /// The largest rate as a multiple of its limit.
    fn largest_share(&self, rates: &InputVector) -> f64 {
        let shares = rates.iter().zip(self.limits.rates()).filter(|(_, limit)| **limit > 0.0);
        shares.map(|(rate, limit)| rate.abs() / limit).fold(0.0, f64::max)
    }

    /// How many times `direction` (rates) fits into one period, given the limits of rates and joint
    /// positions.
    fn reach(&self, direction: &InputVector) -> f64 {
        let mut reach = self.share / self.largest_share(direction);
        let base = self.robot.drive.inputs();
        for (i, joint) in self.robot.joints.iter().enumerate() {
            let (rate, at) = (direction[i + base], self.configuration.joints[i]);
            let room = if rate > 0.0 { joint.upper - at } else { joint.lower - at };
            if rate != 0.0 {
                reach = reach.min((room / (rate * self.period)).max(0.0));
            }
        }
        if reach.is_finite() { reach } else { 0.0 }
    }
}

/// An orthonormal basis of the null space: inputs that do not move the grasp.
struct Basis {
    vectors: [InputVector; MAX_INPUTS],
    count: usize,
}

impl Basis {
    fn directions(&self) -> impl Iterator<Item = &InputVector> {
        self.vectors[..self.count].iter()
    }
}

/// The basis by Gram-Schmidt with pivoting on the columns of the null-space projector I - J^+ J. The same J
/// gives the same basis.
fn self_motions(robot: &Robot, jacobian: &InputJacobian, arm_only: bool) -> Basis {
    let mut j = *jacobian;
    let base = robot.drive.inputs();
    let first = if arm_only { base } else { 0 };
    j.columns_mut(0, base).scale_mut(if arm_only { 0.0 } else { 1.0 });
    let qr = j.transpose().col_piv_qr();
    let (rows, scales) = (qr.q(), qr.r().diagonal().abs());
    let rank = scales.iter().filter(|scale| **scale > 1e-5 * scales[0]).count();
    let mut projector = SMatrix::<f64, MAX_INPUTS, MAX_INPUTS>::zeros();
    let last = base + robot.joint_count();
    for i in first..last {
        projector[(i, i)] = 1.0;
    }
    for row in rows.column_iter().take(rank) {
        projector -= row * row.transpose();
    }
    let count = (last - first).saturating_sub(rank).min(PER_SIDE);
    let mut basis = Basis { vectors: [InputVector::zeros(); MAX_INPUTS], count: 0 };
    for _ in 0..count {
        let pivot = (first..last)
            .max_by(|&a, &b| projector[(a, a)].total_cmp(&projector[(b, b)]).then(b.cmp(&a)))
            .filter(|&i| projector[(i, i)] > DEGENERATE);
        let Some(pivot) = pivot else { break };
        let vector = projector.column(pivot) / projector[(pivot, pivot)].sqrt();
        projector -= vector * vector.transpose();
        basis.vectors[basis.count] = vector;
        basis.count += 1;
    }
    basis
}

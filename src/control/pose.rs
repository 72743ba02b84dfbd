//! Eq. (8): the candidate configuration that is best prepared for all options.
//!
//! The winner is the exact minimum over all candidates. Most problems need not be solved for it: the optimum
//! without limits bounds the cost of every (candidate, option) from below, and eq. (7) is solved with limits
//! only where that bound can still win.

use super::candidates::{Candidate, Neighbourhood};
use super::follow::set_base;
use super::limits::Limits;
use super::obstacles::{Avoid, RobotObstacles};
use super::{
    BaseInputs, ClosedForm, ControlSettings, ModalReference, Mpc, PoseCriterion, Reference, SolveOutcome,
};
use crate::robot::{BaseInput, Configuration, InputJacobian, Kinematics, Robot};

/// The difference below which costs are equal. The earlier candidate then wins: the present configuration
/// first, then those nearest to it.
pub const TIE: f64 = 1e-9;

/// The outcome of eq. (8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseChoice {
    /// Index of the chosen candidate; 0 is the present configuration.
    pub index: usize,
    /// The chosen candidate.
    pub candidate: Candidate,
    /// kappa ||q* - q_c||^2, the cost of the motion to it.
    pub motion_cost: f64,
    /// Number of candidates.
    pub candidates: usize,
    /// Number of eq. (7)'s problems that were solved with limits.
    pub solved: usize,
}

/// A candidate of eq. (8) with its objective: the sum of eq. (8), or for [`PoseCriterion::Manipulability`]
/// the negative manipulability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidateCost<'a> {
    /// The candidate.
    pub candidate: &'a Candidate,
    /// A lower bound of the objective: its value without limits. `None` where costs were not evaluated.
    pub lower_bound: Option<f64>,
    /// The objective. `None` where its lower bound, or a part of its sum, already exceeded the least value,
    /// or there was no choice.
    pub cost: Option<f64>,
}

/// A solver of eq. (8) that keeps memory between calls.
#[derive(Clone, Debug, Default)]
pub struct PoseOptimiser {
    candidates: Vec<Candidate>,
    modal: Vec<ModalReference>,
    /// Lower bounds of weight times cost: one row of options per candidate.
    bounds: Vec<f64>,
    /// Objective of each candidate: first a lower bound, later the value.
    totals: Vec<f64>,
    /// The initial lower bounds of the objectives.
    lower_bounds: Vec<f64>,
    order: Vec<usize>,
}

/// The input of eq. (8).
#[derive(Clone, Copy, Debug)]
pub struct PoseProblem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The present configuration, q_c.
    pub configuration: &'a Configuration,
    /// The kinematics at that configuration.
    pub kinematics: &'a Kinematics,
    /// s_o(1..H) of every option.
    pub references: &'a [Reference],
    /// The weight of every option: P_o.
    pub weights: &'a [f64],
    /// The obstacles, and the parts of the robot that are kept off them.
    pub obstacles: Option<(&'a RobotObstacles, Avoid)>,
    /// The base's inputs that follow a path, if it does. Where the guide alone decides them, the references
    /// cover the arm's part only, and only the arm is optimised; else B's motion by these inputs is part of the
    /// references.
    pub base: Option<&'a BaseInputs>,
    /// Control period, s.
    pub period: f64,
    /// The share of the rate limits that the change of configuration may use, up to 1.
    pub share: f64,
}

impl PoseProblem<'_> {
    /// Eq. (7) without limits at a candidate; of the arm alone where the base's inputs are given.
    fn form(&self, candidate: &Candidate, settings: &ControlSettings) -> ClosedForm {
        let mut jacobian = candidate.jacobian;
        if let Some(base) = self.base {
            let drive = &self.robot.drive;
            if !settings.is_base_given() {
                let weights = [settings.state_weight, settings.input_weight];
                let prices = BaseInput::repeat(settings.guide_price);
                return ClosedForm::guided(&(jacobian * self.period), weights, drive, base, &prices);
            }
            jacobian.columns_mut(0, drive.inputs()).fill(0.0);
        }
        ClosedForm::new(&(jacobian * self.period), settings.state_weight, settings.input_weight)
    }
}

impl PoseOptimiser {
    /// The candidate with the least sum_o P_o G_o(q) + kappa ||q - q_c||^2, each G_o with all limits.
    pub fn choose(
        &mut self,
        problem: &PoseProblem,
        settings: &ControlSettings,
        limits: &mut Limits,
        mpc: &mut Mpc,
    ) -> PoseChoice {
        let PoseProblem { robot, configuration, kinematics, period, share, .. } = *problem;
        let around = Neighbourhood { robot, configuration, kinematics, limits, period, share };
        around.candidates(settings.candidates, &mut self.candidates);
        self.totals.clear();
        self.lower_bounds.clear();
        let mut solved = 0;
        let index = match (self.candidates.len(), settings.criterion) {
            (1, _) => 0,
            (_, PoseCriterion::Manipulability) => self.most_manipulable(robot),
            _ => {
                self.bound(problem, settings);
                self.least(problem, settings, limits, mpc, &mut solved)
            }
        };
        let candidate = self.candidates[index];
        let motion_cost = motion_cost(robot, &candidate, configuration, settings);
        PoseChoice { index, candidate, motion_cost, candidates: self.candidates.len(), solved }
    }

    /// The candidates of the last call.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The candidates of the last call with their objectives.
    pub fn candidate_costs(&self) -> impl Iterator<Item = CandidateCost<'_>> {
        self.candidates.iter().enumerate().map(|(i, candidate)| CandidateCost {
            candidate,
            lower_bound: self.lower_bounds.get(i).copied(),
            cost: self.totals.get(i).copied().filter(|total| total.is_finite()),
        })
    }

    fn most_manipulable(&mut self, robot: &Robot) -> usize {
        self.totals.clear();
        self.totals.extend(self.candidates.iter().map(|c| -manipulability(robot, &c.jacobian)));
        first_within_tie(&self.totals)
    }

    fn bound(&mut self, problem: &PoseProblem, settings: &ControlSettings) {
        self.bounds.clear();
        self.totals.clear();
        self.modal.clear();
        self.modal.extend(problem.references.iter().map(ModalReference::new));
        for candidate in &self.candidates {
            let form = problem.form(candidate, settings);
            let mut total = motion_cost(problem.robot, candidate, problem.configuration, settings);
            for (reference, weight) in self.modal.iter().zip(problem.weights) {
                let bound = if *weight > 0.0 { weight * form.cost(reference) } else { 0.0 };
                self.bounds.push(bound);
                total += bound;
            }
            self.totals.push(total);
        }
        self.lower_bounds.extend(&self.totals);
    }

    /// Replaces bounds by values, in the order of the bounds, as long as a bound is no greater than the least
    /// value.
    fn least(
        &mut self,
        problem: &PoseProblem,
        settings: &ControlSettings,
        limits: &mut Limits,
        mpc: &mut Mpc,
        solved: &mut usize,
    ) -> usize {
        self.order.clear();
        self.order.extend(0..self.candidates.len());
        let totals = &self.totals;
        self.order.sort_unstable_by(|&a, &b| totals[a].total_cmp(&totals[b]).then(a.cmp(&b)));
        let options = problem.references.len();
        let given = problem.base.filter(|_| settings.is_base_given());
        let mut best = f64::INFINITY;
        for &c in &self.order {
            if self.totals[c] > best + TIE {
                self.totals[c] = f64::INFINITY;
                continue;
            }
            let candidate = &self.candidates[c];
            // again, since few candidates come so far
            let form = problem.form(candidate, settings);
            limits.set(problem.robot, &candidate.configuration, &candidate.rates, problem.period);
            for (o, (reference, weight)) in problem.references.iter().zip(problem.weights).enumerate() {
                if *weight <= 0.0 {
                    continue;
                }
                if let Some((obstacles, avoid)) = problem.obstacles {
                    let (q, mut inputs) = (&candidate.configuration, form.inputs(&self.modal[o]));
                    if let Some(base) = given {
                        set_base(&problem.robot.drive, &mut inputs, base);
                    }
                    obstacles.half_planes(
                        avoid,
                        problem.robot,
                        q,
                        &inputs,
                        problem.period,
                        given.is_some(),
                        limits,
                    );
                    if let Some(base) = given {
                        let drive = &problem.robot.drive;
                        limits.half_planes.iter_mut().for_each(|plane| plane.settle_base(drive, base));
                    }
                }
                let without = self.totals[c] - self.bounds[c * options + o];
                let plan = mpc.solve_below(&form, limits, reference, (best + TIE - without) / weight);
                *solved += usize::from(plan.is_none_or(|p| p.outcome != SolveOutcome::Unconstrained));
                self.totals[c] = plan.map_or(f64::INFINITY, |p| without + weight * p.cost);
                if self.totals[c] > best + TIE {
                    self.totals[c] = f64::INFINITY;
                    break;
                }
            }
            best = best.min(self.totals[c]);
        }
        first_within_tie(&self.totals)
    }
}

/// kappa ||q - q_c||^2. The motion of the base is priced by its rates, like an input. Without a price, the
/// optimiser would move the base for free.
pub fn motion_cost(
    robot: &Robot,
    candidate: &Candidate,
    from: &Configuration,
    settings: &ControlSettings,
) -> f64 {
    let arm = (candidate.configuration.joints - from.joints).norm_squared();
    settings.pose_weight * (arm + robot.base_input(&candidate.rates).norm_squared())
}

/// The smallest singular value of B, m or rad for a unit input.
pub fn least_singular_value(input_matrix: &InputJacobian) -> f64 {
    (input_matrix * input_matrix.transpose()).symmetric_eigenvalues().min().max(0.0).sqrt()
}

/// Yoshikawa's measure of the arm, sqrt(det(J J')), for a whole-body Jacobian.
pub fn manipulability(robot: &Robot, jacobian: &InputJacobian) -> f64 {
    let arm = robot.arm_jacobian(jacobian);
    (arm * arm.transpose()).determinant().max(0.0).sqrt()
}

fn first_within_tie(totals: &[f64]) -> usize {
    let least = totals.iter().copied().fold(f64::INFINITY, f64::min);
    totals.iter().position(|t| *t <= least + TIE).unwrap_or(0)
}

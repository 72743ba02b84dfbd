//! Eq. (8): the candidate configuration that is best prepared for all options.
//!
//! The winner is the exact minimum over all candidates, found without solving most problems: the optimum without limits bounds the cost of
//! every (candidate, option) from below, and eq. (7) is solved with limits only where that bound can still win.

use super::candidates::{Candidate, Neighbourhood};
use super::follow::set_base;
use super::limits::Limits;
use super::obstacles::{Avoid, RobotObstacles};
use super::{ClosedForm, Mpc, Reference, Rims, Settings, SolveOutcome};
use crate::robot::{Configuration, InputJacobian, Kinematics, MAX_JOINTS, Robot};

/// What eq. (8) chooses by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseCriterion {
    /// Eq. (8): the options' costs, weighted by P_o.
    Expected,
    /// Eq. (8) with the same weight for every option.
    Uniform,
    /// Eq. (8) for the option that is being tracked, alone.
    Tracked,
    /// Not eq. (8): the largest manipulability sqrt(det(J J')) of the arm (Yoshikawa 1985).
    Manipulability,
}

/// Costs closer than this are equal, and the earlier candidate wins: the present configuration first, then those nearest to it.
pub const TIE: f64 = 1e-9;

/// The outcome of eq. (8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseChoice {
    /// Which candidate: 0 is the present configuration.
    pub index: usize,
    /// The winner.
    pub candidate: Candidate,
    /// kappa ||q* - q_c||^2, the cost of going there.
    pub motion_cost: f64,
    /// How many candidates there were.
    pub candidates: usize,
    /// How many of eq. (7)'s problems were solved with limits.
    pub solved: usize,
}

/// A candidate of eq. (8), and what was found of the sum that is minimised: that of eq. (8), or for
/// [`PoseCriterion::Manipulability`] minus the manipulability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Considered<'a> {
    /// The candidate.
    pub candidate: &'a Candidate,
    /// A lower bound of the sum: its value without limits. `None` where costs were not asked for.
    pub floor: Option<f64>,
    /// The sum. `None` where the lower bound, or a part of the sum, already exceeded the least, or there was no choice.
    pub total: Option<f64>,
}

/// Solves eq. (8); keeps memory between calls.
#[derive(Clone, Debug, Default)]
pub struct PoseOptimiser {
    candidates: Vec<Candidate>,
    forms: Vec<ClosedForm>,
    /// Lower bounds of weight times cost, a row of options a candidate.
    bounds: Vec<f64>,
    /// Lower bound, then value, of each candidate's total.
    totals: Vec<f64>,
    /// The lower bounds that the totals began as.
    floors: Vec<f64>,
    order: Vec<usize>,
}

/// What eq. (8) is solved for.
#[derive(Clone, Copy, Debug)]
pub struct PoseProblem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Where it is, q_c.
    pub configuration: &'a Configuration,
    /// Its kinematics there.
    pub kinematics: &'a Kinematics,
    /// s_o(1..H) of every option.
    pub references: &'a [Reference],
    /// The weight of every option: P_o.
    pub weights: &'a [f64],
    /// The obstacles, and what is kept out of them.
    pub obstacles: Option<(&'a RobotObstacles, Avoid)>,
    /// Rim speeds of the base, where these are settled: then the references are what is left for the arm, and only the arm is optimised.
    pub rims: Option<&'a Rims>,
    /// Control period, s.
    pub period: f64,
    /// The share of the rate limits that the change of configuration may take, up to 1.
    pub share: f64,
    /// What the arm's half-planes of a step are worth beside those of the step before: see [`RobotObstacles::half_planes`].
    pub confidence: f64,
}

impl PoseOptimiser {
    /// The candidate of least sum_o P_o G_o(q) + kappa ||q - q_c||^2, each G_o with all limits.
    pub fn choose(
        &mut self,
        problem: &PoseProblem,
        settings: &Settings,
        limits: &mut Limits,
        mpc: &mut Mpc,
    ) -> PoseChoice {
        let PoseProblem { robot, configuration, kinematics, period, share, .. } = *problem;
        let around = Neighbourhood { robot, configuration, kinematics, limits, period, share };
        around.candidates(settings.candidates, &mut self.candidates);
        self.totals.clear();
        self.floors.clear();
        let mut solved = 0;
        let index = match (self.candidates.len(), settings.criterion) {
            (1, _) => 0,
            (_, PoseCriterion::Manipulability) => self.most_manipulable(robot),
            _ => {
                self.bound(problem, settings);
                self.least(problem, limits, mpc, &mut solved)
            }
        };
        let candidate = self.candidates[index];
        let motion_cost = motion_cost(&candidate, configuration, settings);
        PoseChoice { index, candidate, motion_cost, candidates: self.candidates.len(), solved }
    }

    /// The candidates of the last call.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// What the last call made of its candidates.
    pub fn considered(&self) -> impl Iterator<Item = Considered<'_>> {
        self.candidates.iter().enumerate().map(|(i, candidate)| Considered {
            candidate,
            floor: self.floors.get(i).copied(),
            total: self.totals.get(i).copied().filter(|total| total.is_finite()),
        })
    }

    fn most_manipulable(&mut self, robot: &Robot) -> usize {
        self.totals.clear();
        self.totals.extend(
            self.candidates.iter().map(|c| -manipulability(&robot.kinematics(&c.configuration).jacobian)),
        );
        first_within_tie(&self.totals)
    }

    fn bound(&mut self, problem: &PoseProblem, settings: &Settings) {
        self.forms.clear();
        self.bounds.clear();
        self.totals.clear();
        for candidate in &self.candidates {
            let mut jacobian = problem.robot.kinematics(&candidate.configuration).jacobian;
            if problem.rims.is_some() {
                jacobian.fixed_columns_mut::<2>(0).fill(0.0);
            }
            let form =
                ClosedForm::new(&(jacobian * problem.period), settings.state_weight, settings.input_weight);
            let mut total = motion_cost(candidate, problem.configuration, settings);
            for (reference, weight) in problem.references.iter().zip(problem.weights) {
                let bound = if *weight > 0.0 { weight * form.cost(reference) } else { 0.0 };
                self.bounds.push(bound);
                total += bound;
            }
            self.forms.push(form);
            self.totals.push(total);
        }
        self.floors.extend(&self.totals);
    }

    /// Turns bounds into values, in the order of the bounds, as long as a bound is no greater than the best value.
    fn least(
        &mut self,
        problem: &PoseProblem,
        limits: &mut Limits,
        mpc: &mut Mpc,
        solved: &mut usize,
    ) -> usize {
        self.order.clear();
        self.order.extend(0..self.candidates.len());
        let totals = &self.totals;
        self.order.sort_unstable_by(|&a, &b| totals[a].total_cmp(&totals[b]).then(a.cmp(&b)));
        let options = problem.references.len();
        let mut best = f64::INFINITY;
        for &c in &self.order {
            if self.totals[c] > best + TIE {
                self.totals[c] = f64::INFINITY;
                continue;
            }
            let (candidate, form) = (&self.candidates[c], &self.forms[c]);
            limits.set(problem.robot, &candidate.configuration, &candidate.rates, problem.period);
            for (o, (reference, weight)) in problem.references.iter().zip(problem.weights).enumerate() {
                if *weight <= 0.0 {
                    continue;
                }
                if let Some((obstacles, avoid)) = problem.obstacles {
                    let (q, mut inputs) = (&candidate.configuration, form.inputs(reference));
                    if let Some(rims) = problem.rims {
                        set_base(&mut inputs, rims);
                    }
                    let confidence = problem.confidence;
                    obstacles.half_planes(
                        avoid,
                        problem.robot,
                        q,
                        &inputs,
                        problem.period,
                        confidence,
                        limits,
                    );
                    if let Some(rims) = problem.rims {
                        limits.half_planes.iter_mut().for_each(|plane| plane.settle_base(rims));
                    }
                }
                let without = self.totals[c] - self.bounds[c * options + o];
                let plan = mpc.solve_below(form, limits, reference, (best + TIE - without) / weight);
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

/// kappa ||q - q_c||^2. Motion of the base is priced as an input, by its rates: unpriced, it would be a free way out.
pub fn motion_cost(candidate: &Candidate, from: &Configuration, settings: &Settings) -> f64 {
    let arm = (candidate.configuration.joints - from.joints).norm_squared();
    settings.pose_weight * (arm + candidate.rates.fixed_rows::<2>(0).norm_squared())
}

/// Yoshikawa's measure of the arm, sqrt(det(J J')), from the whole-body Jacobian.
pub fn manipulability(jacobian: &InputJacobian) -> f64 {
    let arm = jacobian.fixed_columns::<MAX_JOINTS>(2);
    (arm * arm.transpose()).determinant().max(0.0).sqrt()
}

fn first_within_tie(totals: &[f64]) -> usize {
    let least = totals.iter().copied().fold(f64::INFINITY, f64::min);
    totals.iter().position(|t| *t <= least + TIE).unwrap_or(0)
}

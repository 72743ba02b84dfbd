//! Eq. (7): a reference, B(q) and limits in; the optimal inputs, their cost, and how they were found out.
//!
//! If the optimum without limits respects the limits, it is the answer. Otherwise multipliers m >= 0 of the constraints that it violates are
//! found in the dual, u = u* - Hess^-1 A' m, whose program has as many variables as constraints; constraints that the new u violates join, until
//! none does. The dual is solved by exchanging its active set, or by clarabel where that does not settle.

use super::active_set::{ActiveSet, slack};
use super::closed_form::InverseHessian;
use super::limits::{Limits, Row};
use super::qp::Qp;
use super::{ClosedForm, Inputs, Reference};

/// Rounds in which violated constraints may join; each adds at least one.
const ROUNDS: usize = 40;
/// What a half-plane's violation costs: this times its square (m), a thousand times what the same tracking error costs.
const SLACK_PRICE: f64 = 1e6;

/// The solution of eq. (7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// u(0..H-1).
    pub inputs: Inputs,
    /// G, eq. (7), including the price of violated half-planes.
    pub cost: f64,
    /// How it was found.
    pub outcome: SolveOutcome,
}

/// How a plan was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveOutcome {
    /// In closed form: no limit is active.
    Unconstrained,
    /// With this many active limits.
    Constrained {
        /// Limits with a positive multiplier.
        active: usize,
    },
    /// Not at all: the first input without limits, scaled down into them, is applied once; where even that is no number, nothing is.
    Fallback(Failure),
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Something that came in is no finite number.
    NotFinite,
    /// The solver stopped without a solution.
    NotSolved,
}

/// Solves eq. (7); keeps solvers and memory between calls. Results do not depend on earlier calls.
#[derive(Clone, Debug, Default)]
pub struct Mpc {
    qp: Qp,
    active_set: ActiveSet,
    rows: Vec<Row>,
    joining: Vec<Row>,
    /// Hess^-1 a of each row.
    responses: Vec<Inputs>,
    /// a . u* - b of each row.
    excess: Vec<f64>,
    /// D = A Hess^-1 A', by rows.
    dual: Vec<f64>,
    positive: Vec<bool>,
    multipliers: Vec<f64>,
    /// Duals that clarabel was asked for, over all calls.
    interior_point_solves: u64,
}

impl Mpc {
    /// Solves eq. (7) for a reference. `limits` must be those of the configuration that `free` was made for.
    pub fn solve(&mut self, free: &ClosedForm, limits: &Limits, reference: &Reference) -> Plan {
        let inputs = free.inputs(reference);
        let cost = free.cost(reference);
        if !(cost.is_finite() && inputs.iter().all(|u| u.is_finite())) {
            let outcome = SolveOutcome::Fallback(Failure::NotFinite);
            return Plan { inputs: Inputs::zeros(), cost: f64::INFINITY, outcome };
        }
        if limits.allow(&inputs) {
            return Plan { inputs, cost, outcome: SolveOutcome::Unconstrained };
        }
        self.solve_constrained(free, limits, &inputs, cost).unwrap_or_else(|| Plan {
            inputs: limits.scaled_first(&inputs),
            cost: f64::INFINITY,
            outcome: SolveOutcome::Fallback(Failure::NotSolved),
        })
    }

    /// How many duals had to be solved by clarabel, over all calls.
    pub fn interior_point_solves(&self) -> u64 {
        self.interior_point_solves
    }

    fn solve_constrained(
        &mut self,
        free: &ClosedForm,
        limits: &Limits,
        optimum: &Inputs,
        free_cost: f64,
    ) -> Option<Plan> {
        let inverse = free.inverse_hessian();
        self.rows.clear();
        self.responses.clear();
        self.excess.clear();
        self.positive.clear();
        self.joining.clear();
        limits.violations(optimum, |row, _| self.joining.push(row));
        for _ in 0..ROUNDS {
            self.join(&inverse, limits, optimum);
            self.solve_dual()?;
            let mut inputs = *optimum;
            for (m, response) in self.multipliers.iter().zip(&self.responses).filter(|(m, _)| **m > 0.0) {
                inputs -= response * *m;
            }
            // a row that has joined is settled by its multiplier; what is left of its violation is rounding, or paid for
            let (rows, joining) = (&self.rows, &mut self.joining);
            limits.violations(&inputs, |row, _| {
                if !rows.contains(&row) {
                    joining.push(row);
                }
            });
            if self.joining.is_empty() {
                let active = self.multipliers.iter().filter(|m| **m > 0.0).count();
                let outcome = SolveOutcome::Constrained { active };
                return Some(Plan { inputs, cost: free_cost + self.dual_value(), outcome });
            }
        }
        None
    }

    /// Takes the joining rows in, expected to be active, and makes D anew.
    fn join(&mut self, inverse: &InverseHessian, limits: &Limits, optimum: &Inputs) {
        for row in self.joining.drain(..) {
            self.rows.push(row);
            self.responses.push(inverse.apply(&limits.coefficients(row)));
            self.excess.push(limits.product(row, optimum) - limits.bound(row));
            self.positive.push(true);
        }
        let n = self.rows.len();
        self.dual.clear();
        self.dual.resize(n * n, 0.0);
        for (i, &row) in self.rows.iter().enumerate() {
            for (j, response) in self.responses.iter().enumerate().skip(i) {
                let product = limits.product(row, response);
                self.dual[i * n + j] = product;
                self.dual[j * n + i] = product;
            }
            if let Row::Base(_) = row {
                self.dual[i * n + i] += 1.0 / SLACK_PRICE;
            }
        }
    }

    fn solve_dual(&mut self) -> Option<()> {
        let Self { dual, excess, positive, multipliers, .. } = self;
        if self.active_set.minimise(dual, excess, positive, multipliers) {
            return Some(());
        }
        self.interior_point_solves += 1;
        if !self.qp.minimise(dual, excess, multipliers) {
            return None;
        }
        // the interior point says which are positive (those that outweigh their slack); what they are exactly follows from that
        let interior = multipliers.clone();
        for (i, is_positive) in positive.iter_mut().enumerate() {
            *is_positive = interior[i] * dual[i * excess.len() + i] > slack(dual, excess, &interior, i);
        }
        if !self.active_set.minimise(dual, excess, positive, multipliers) {
            multipliers.clone_from(&interior);
        }
        Some(())
    }

    /// What the limits add to the cost, by duality: 2 c' m - m' D m.
    fn dual_value(&self) -> f64 {
        let weighed = |(i, m): (usize, &f64)| {
            m * (self.excess[i] - slack(&self.dual, &self.excess, &self.multipliers, i))
        };
        self.multipliers.iter().enumerate().map(weighed).sum()
    }
}

//! Eq. (7): the optimal inputs for a reference under limits, their cost, and how they were found.
//!
//! If the optimum without limits respects the limits, it is the solution. Otherwise the multipliers m >= 0 of
//! the violated constraints are found in the dual, u = u* - Hess^-1 A' m, which has as many variables as
//! constraints. Constraints that the new u violates are added until none is left. The dual is solved by an
//! active-set method, or by clarabel if that does not converge.

use super::active_set::{ActiveSet, slack};
use super::limits::{Constraint, Limits};
use super::qp::Qp;
use super::{ClosedForm, Inputs, ModalReference, Reference};

/// Largest number of rounds that add violated constraints; each round adds at least one.
const ROUNDS: usize = 40;
/// Number of constraints for which memory is kept.
const ROOM: usize = 160;

/// The solution of eq. (7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// u(0..H-1).
    pub inputs: Inputs,
    /// G, eq. (7), including the price of violated half-planes.
    pub cost: f64,
    /// How the solution was found.
    pub outcome: SolveOutcome,
}

/// How a plan was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum SolveOutcome {
    /// In closed form: no limit is active.
    Unconstrained,
    /// With active constraints, which are those with a positive multiplier.
    Constrained {
        /// Number of active limits of joints and wheels and of half-planes that keep the robot off obstacles.
        active: usize,
    },
    /// Not found. The first input of the optimum without limits is scaled down into the limits and applied
    /// once; if that is not finite, no input is applied.
    Fallback(Failure),
}

/// The reason why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Failure {
    /// A problem with numbers that are not finite.
    NotFinite,
    /// The solver stopped without a solution.
    NotSolved,
}

/// A solver of eq. (7) that keeps solvers and memory between calls. Results do not depend on earlier calls.
#[derive(Clone, Debug)]
pub struct Mpc {
    qp: Qp,
    active_set: ActiveSet,
    rows: Vec<Constraint>,
    joining: Vec<Constraint>,
    /// Hess^-1 a of each row.
    responses: Vec<Inputs>,
    /// a . u* - b of each row.
    excess: Vec<f64>,
    /// D = A Hess^-1 A', by rows.
    dual: Vec<f64>,
    positive: Vec<bool>,
    multipliers: Vec<f64>,
}

impl Default for Mpc {
    /// A solver with memory for many constraints, so that later calls need not allocate.
    fn default() -> Self {
        Self {
            qp: Qp::default(),
            active_set: ActiveSet::with_room(ROOM),
            rows: Vec::with_capacity(ROOM),
            joining: Vec::with_capacity(ROOM),
            responses: Vec::with_capacity(ROOM),
            excess: Vec::with_capacity(ROOM),
            dual: Vec::with_capacity(ROOM * ROOM),
            positive: Vec::with_capacity(ROOM),
            multipliers: Vec::with_capacity(ROOM),
        }
    }
}

/// The reason why there is no plan under limits.
enum Stopped {
    /// The cost exceeds the cutoff.
    Above,
    Unsolved,
}

/// The optimum without limits, if it is finite.
fn finite_optimum(free: &ClosedForm, reference: &Reference) -> Option<Plan> {
    let reference = ModalReference::new(reference);
    let (inputs, cost) = (free.inputs(&reference), free.cost(&reference));
    let is_finite = cost.is_finite() && inputs.iter().all(|u| u.is_finite());
    is_finite.then_some(Plan { inputs, cost, outcome: SolveOutcome::Unconstrained })
}

impl Mpc {
    /// The solution of eq. (7) for a reference. `limits` must belong to the configuration that `free` was
    /// made for.
    pub fn solve(&mut self, free: &ClosedForm, limits: &Limits, reference: &Reference) -> Plan {
        let failed = |inputs, failure| {
            let outcome = SolveOutcome::Fallback(failure);
            Plan { inputs, cost: f64::INFINITY, outcome }
        };
        let Some(optimum) = finite_optimum(free, reference) else {
            return failed(Inputs::zeros(), Failure::NotFinite);
        };
        match self.constrain(free, limits, optimum, f64::INFINITY) {
            Ok(plan) => plan,
            Err(Stopped::Above | Stopped::Unsolved) => {
                failed(limits.scaled_first(&optimum.inputs), Failure::NotSolved)
            }
        }
    }

    /// The plan of [`Mpc::solve`] if its cost is at most `cutoff`; `None` if the cost is higher, which is
    /// usually known early, or if there is no plan.
    pub fn solve_below(
        &mut self,
        free: &ClosedForm,
        limits: &Limits,
        reference: &Reference,
        cutoff: f64,
    ) -> Option<Plan> {
        let optimum = finite_optimum(free, reference)?;
        match self.constrain(free, limits, optimum, cutoff) {
            Ok(plan) if plan.cost <= cutoff => Some(plan),
            _ => None,
        }
    }

    fn constrain(
        &mut self,
        free: &ClosedForm,
        limits: &Limits,
        optimum: Plan,
        cutoff: f64,
    ) -> Result<Plan, Stopped> {
        if limits.allow(&optimum.inputs) {
            return Ok(optimum);
        }
        self.rows.clear();
        self.responses.clear();
        self.excess.clear();
        self.positive.clear();
        self.dual.clear();
        self.find_joining(limits, &optimum.inputs);
        for _ in 0..ROUNDS {
            self.join(free, limits, &optimum.inputs);
            if self.solve_dual().is_none() {
                return Err(Stopped::Unsolved);
            }
            let mut inputs = optimum.inputs;
            for (m, response) in self.multipliers.iter().zip(&self.responses).filter(|(m, _)| **m > 0.0) {
                inputs -= response * *m;
            }
            self.find_joining(limits, &inputs);
            // with some of the constraints only, the optimum is a lower bound
            let cost = optimum.cost + self.dual_value();
            if self.joining.is_empty() {
                let active = self.multipliers.iter().filter(|m| **m > 0.0).count();
                return Ok(Plan { inputs, cost, outcome: SolveOutcome::Constrained { active } });
            }
            if cost > cutoff {
                return Err(Stopped::Above);
            }
        }
        Err(Stopped::Unsolved)
    }

    /// Finds the rows to add: those that `inputs` violates and that were not added before. Rows added before
    /// are settled by their multipliers; their remaining violation is rounding, or paid for. A joint's
    /// positions follow from its rates, so a position is added only when all rates are satisfied, the worst
    /// one first. This keeps dependent rows apart.
    fn find_joining(&mut self, limits: &Limits, inputs: &Inputs) {
        let (rows, joining) = (&self.rows, &mut self.joining);
        joining.clear();
        let mut worst = 0.0;
        limits.violations(inputs, |row, excess| {
            let position_of = |row: &Constraint| match row {
                Constraint::Position { input, .. } => Some(*input),
                _ => None,
            };
            let joint = position_of(&row);
            let last = joining.last();
            let last_is_rate = |i| matches!(last, Some(Constraint::Rate { input, .. }) if *input == i);
            let last_is_position = |i| last.and_then(position_of) == Some(i);
            match joint {
                _ if rows.contains(&row) => {}
                Some(i) if last_is_rate(i) => {}
                Some(i) if last_is_position(i) => {
                    if excess > worst {
                        joining.pop();
                        joining.push(row);
                        worst = excess;
                    }
                }
                _ => {
                    joining.push(row);
                    worst = excess;
                }
            }
        });
    }

    /// Adds the joining rows, which are expected to be active, and extends D by them.
    fn join(&mut self, free: &ClosedForm, limits: &Limits, optimum: &Inputs) {
        let joined = self.joining.len();
        for row in self.joining.drain(..) {
            self.rows.push(row);
            self.responses.push(free.inverse_hessian_times(&limits.coefficients(row)));
            self.excess.push(limits.product(row, optimum) - limits.bound(row));
            self.positive.push(true);
        }
        let (n, before) = (self.rows.len(), self.rows.len() - joined);
        // from the last row on, so that nothing is overwritten before it has moved
        self.dual.resize(n * n, 0.0);
        for i in (1..before).rev() {
            self.dual.copy_within(i * before..(i + 1) * before, i * n);
        }
        for i in before..n {
            for j in 0..=i {
                let product = limits.product(self.rows[j], &self.responses[i]);
                self.dual[i * n + j] = product;
                self.dual[j * n + i] = product;
            }
            if let Constraint::Place(place) = self.rows[i] {
                self.dual[i * n + i] += 1.0 / limits.half_planes[place].price;
            }
        }
    }

    fn solve_dual(&mut self) -> Option<()> {
        let Self { dual, excess, positive, multipliers, .. } = self;
        if self.active_set.minimise(dual, excess, positive, multipliers) {
            return Some(());
        }
        if !self.qp.minimise(dual, excess, multipliers) {
            return None;
        }
        for (i, is_positive) in positive.iter_mut().enumerate() {
            *is_positive = multipliers[i] * dual[i * excess.len() + i] > slack(dual, excess, multipliers, i);
        }
        Some(())
    }

    /// The cost that the limits add, by duality: 2 c' m - m' D m.
    fn dual_value(&self) -> f64 {
        let weighed = |(i, m): (usize, &f64)| {
            m * (self.excess[i] - slack(&self.dual, &self.excess, &self.multipliers, i))
        };
        self.multipliers.iter().enumerate().map(weighed).sum()
    }
}

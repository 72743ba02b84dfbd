//! The exact unconstrained optimum of eq. (7), its cost, and the inverse of its Hessian.
//!
//! x(t+1) = x(t) + B u(t) with scalar weights decouples along the left singular vectors U_k of B. With z =
//! U_k' x, rho_t = U_k' s(t) and u(t) = sum_k B' U_k w_k(t), each direction is a scalar problem z(t+1) =
//! z(t) + s_k^2 w(t). Its value function p z^2 - 2 g z + c is computed backward from t = H. Nothing divides
//! by s_k, so a direction that B does not reach is handled as well.

use super::{HORIZON, Inputs, Reference};
use crate::robot::{InputJacobian, MAX_INPUTS};
use nalgebra::{Matrix6, SMatrix, Vector6};

type Square = SMatrix<f64, HORIZON, HORIZON>;

/// Eq. (7) without limits, for one B.
#[derive(Clone, Copy, Debug)]
pub struct ClosedForm {
    state_weight: f64,
    input_weight: f64,
    /// U: one column per direction.
    directions: Matrix6<f64>,
    /// s_k^2, squared singular values of B.
    squares: Vector6<f64>,
    /// B' U: one column per direction.
    actuation: SMatrix<f64, MAX_INPUTS, 6>,
    /// p after step t, and R / (R + s^2 p), 1 / (R + s^2 p): one column per step, one row per direction.
    value: Reference,
    decay: Reference,
    reciprocal: Reference,
}

impl ClosedForm {
    /// The problem for `input_matrix` B (the period times the Jacobian), Q = `state_weight` I and R =
    /// `input_weight` I.
    pub fn new(input_matrix: &InputJacobian, state_weight: f64, input_weight: f64) -> Self {
        let eigen = (input_matrix * input_matrix.transpose()).symmetric_eigen();
        let squares = eigen.eigenvalues.map(|s2| s2.max(0.0));
        let (mut value, mut decay, mut reciprocal) =
            (Reference::zeros(), Reference::zeros(), Reference::zeros());
        let mut p = Vector6::repeat(state_weight);
        for t in (0..HORIZON).rev() {
            let d = (squares.component_mul(&p)).add_scalar(input_weight);
            value.set_column(t, &p);
            reciprocal.set_column(t, &d.map(|d| 1.0 / d));
            let ratio = d.map(|d| input_weight / d);
            decay.set_column(t, &ratio);
            p = p.component_mul(&ratio).add_scalar(state_weight);
        }
        Self {
            state_weight,
            input_weight,
            directions: eigen.eigenvectors,
            squares,
            actuation: input_matrix.transpose() * eigen.eigenvectors,
            value,
            decay,
            reciprocal,
        }
    }

    /// The smallest singular value of B, m or rad for a unit input.
    pub fn least_singular_value(&self) -> f64 {
        self.squares.min().sqrt()
    }

    /// G*: the optimal cost without limits, which is a lower bound of the optimal cost with limits.
    pub fn cost(&self, reference: &Reference) -> f64 {
        let along = self.directions.tr_mul(reference);
        let mut g = Vector6::zeros();
        let mut saved = 0.0;
        for t in (0..HORIZON).rev() {
            g += along.column(t) * self.state_weight;
            saved += g.component_mul(&g).component_mul(&self.squares).dot(&self.reciprocal.column(t));
            g.component_mul_assign(&self.decay.column(t));
        }
        self.state_weight * reference.norm_squared() - saved
    }

    /// u*(0..H-1): the optimal inputs without limits.
    pub fn inputs(&self, reference: &Reference) -> Inputs {
        let along = self.directions.tr_mul(reference);
        let mut g = Vector6::zeros();
        let mut gains = Reference::zeros();
        for t in (0..HORIZON).rev() {
            g += along.column(t) * self.state_weight;
            gains.set_column(t, &g);
            g.component_mul_assign(&self.decay.column(t));
        }
        let mut z = Vector6::zeros();
        let mut weights = Reference::zeros();
        for t in 0..HORIZON {
            let w = (gains.column(t) - self.value.column(t).component_mul(&z))
                .component_mul(&self.reciprocal.column(t));
            z += self.squares.component_mul(&w);
            weights.set_column(t, &w);
        }
        self.actuation * weights
    }

    /// The inverse of the Hessian of eq. (7) with respect to u(0..H-1), where the cost is u' Hess u - 2 f'
    /// u + const.
    pub fn inverse_hessian(&self) -> InverseHessian {
        // (L'L) of the running sums z(t) = s^2 sum w: entry (i, j) counts the states that both inputs affect
        let reach = Square::from_fn(|i, j| (HORIZON - i.max(j)) as f64);
        let corrections = std::array::from_fn(|k| {
            let hessian =
                Square::identity() * self.input_weight + reach * (self.state_weight * self.squares[k]);
            // positive definite, since the input weight is positive
            let solved = hessian.cholesky().map_or(Square::zeros(), |factor| factor.solve(&reach));
            solved * (-self.state_weight / self.input_weight)
        });
        InverseHessian { input_weight: self.input_weight, actuation: self.actuation, corrections }
    }
}

/// Hess^-1 = I / R + sum_k (B' U_k)(B' U_k)' (x) E_k with E_k = -(Q / R) (R I + Q s_k^2 L'L)^-1 L'L, an H x H
/// matrix in time.
#[derive(Clone, Copy, Debug)]
pub struct InverseHessian {
    input_weight: f64,
    actuation: SMatrix<f64, MAX_INPUTS, 6>,
    corrections: [Square; 6],
}

impl InverseHessian {
    /// Hess^-1 a.
    pub fn apply(&self, a: &Inputs) -> Inputs {
        let mut corrected = Reference::zeros();
        let along = self.actuation.tr_mul(a);
        for (k, correction) in self.corrections.iter().enumerate() {
            corrected.set_row(k, &(along.row(k) * correction.transpose()));
        }
        a / self.input_weight + self.actuation * corrected
    }
}

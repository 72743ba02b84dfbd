//! The exact unconstrained optimum of eq. (7), its cost, and the inverse of its Hessian.
//!
//! With x(0) = 0, the states of x(t+1) = x(t) + B u(t) are X = B U L', where L is the H x H lower triangle of
//! ones. The singular value decomposition L = W diag(sigma) V' holds the modes of the horizon: with S W = Y
//! and U V = Z, the cost Q ||X - S||^2 + R ||U||^2 is the sum over modes j of Q ||sigma_j B z_j - y_j||^2 +
//! R ||z_j||^2. Each is a regularised least-squares problem in six dimensions. With A_j = I + sigma_j^2 (Q /
//! R) B B', its solution is z_j = sigma_j (Q / R) B' A_j^-1 y_j, and its cost is Q y_j' A_j^-1 y_j. A_j is at
//! least I, so a direction that B does not reach is handled as well.

use super::follow::rolled;
use super::{BaseInputs, HORIZON, Inputs, Reference};
use crate::math;
use crate::robot::{BaseInput, Drive, Factor, InputJacobian, Lanes};
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// One number for each mode.
type Lane = SVector<f64, HORIZON>;
type Square = SMatrix<f64, HORIZON, HORIZON>;

/// The singular value decomposition of L: its inverse takes differences in time, whose singular vectors are
/// sampled sines and cosines.
struct Modes {
    /// W: one row per step, one column per mode.
    of_states: Square,
    /// V.
    of_inputs: Square,
    /// sigma.
    gains: Lane,
}

static MODES: LazyLock<Modes> = LazyLock::new(|| {
    let steps = (2 * HORIZON + 1) as f64;
    let angle = |mode: usize| (2 * mode + 1) as f64 * PI / steps;
    let scale = 2.0 / steps.sqrt();
    Modes {
        of_states: Square::from_fn(|step, mode| scale * math::sin((step + 1) as f64 * angle(mode))),
        of_inputs: Square::from_fn(|step, mode| scale * math::cos((step as f64 + 0.5) * angle(mode))),
        gains: Lane::from_fn(|mode, _| 0.5 / math::sin(angle(mode) / 2.0)),
    }
});

/// A reference in the modes of the horizon: Y.
#[derive(Clone, Copy, Debug)]
pub struct ModalReference(Lanes<HORIZON>);

impl ModalReference {
    /// The modes of a reference.
    pub fn new(reference: &Reference) -> Self {
        Self(MODES.of_states.tr_mul(&reference.transpose()))
    }
}

/// Eq. (7) without limits, for one B.
#[derive(Clone, Copy, Debug)]
pub struct ClosedForm {
    state_weight: f64,
    input_weight: f64,
    /// B, with guided inputs in units of their share.
    input_matrix: InputJacobian,
    /// A_j of every mode.
    factor: Factor<HORIZON>,
    guide: Option<Guide>,
}

/// The guide of a base's inputs: R u^2 + P (u - g)^2 is (R + P) (u - r)^2 plus a constant, with r = P g /
/// (R + P). So u - r is an input like the others in units of its share, the square root of R / (R + P). Each
/// input has its own price P.
#[derive(Clone, Copy, Debug)]
struct Guide {
    /// The number of guided inputs, which are the first.
    count: usize,
    shares: BaseInput,
    /// r.
    rest: BaseInputs,
    /// The modes of the motion that r makes.
    motion: Lanes<HORIZON>,
    /// The constant.
    cost: f64,
}

impl Guide {
    /// Inputs in units of the shares, or back.
    fn scaled(&self, mut inputs: Inputs) -> Inputs {
        for i in 0..self.count {
            inputs.row_mut(i).scale_mut(self.shares[i]);
        }
        inputs
    }
}

impl ClosedForm {
    /// The problem for `input_matrix` B (the period times the Jacobian), Q = `state_weight` I and R =
    /// `input_weight` I.
    pub fn new(input_matrix: &InputJacobian, state_weight: f64, input_weight: f64) -> Self {
        let gram = input_matrix * input_matrix.transpose();
        let scale = MODES.gains.component_mul(&MODES.gains) * (state_weight / input_weight);
        let factor = Factor::new(1.0, &scale, &gram);
        Self { state_weight, input_weight, input_matrix: *input_matrix, factor, guide: None }
    }

    /// The same with the squared deviation (m/s, rad/s) of each of the base's inputs from `base` in the cost,
    /// times its price.
    pub fn guided(
        input_matrix: &InputJacobian,
        [state_weight, input_weight]: [f64; 2],
        drive: &Drive,
        base: &BaseInputs,
        prices: &BaseInput,
    ) -> Self {
        let count = drive.inputs();
        let parts = prices.map(|price| price / (input_weight + price));
        let rest = base.map(|input| input.component_mul(&parts));
        let shares = prices.map(|price| (input_weight / (input_weight + price)).sqrt());
        let squares = |input: &BaseInput| {
            let of = input.iter().zip(&parts).take(count).map(|(rate, part)| rate * rate * part);
            of.sum::<f64>()
        };
        let cost = input_weight * base.iter().map(squares).sum::<f64>();
        let motion = ModalReference::new(&rolled(drive, input_matrix, &rest, 1.0)).0;
        let mut scaled = *input_matrix;
        for i in 0..count {
            scaled.column_mut(i).scale_mut(shares[i]);
        }
        let guide = Guide { count, shares, rest, motion, cost };
        Self { guide: Some(guide), ..Self::new(&scaled, state_weight, input_weight) }
    }

    /// Y without the motion of a guided base.
    fn left_of(&self, reference: &ModalReference) -> Lanes<HORIZON> {
        self.guide.as_ref().map_or(reference.0, |guide| reference.0 - guide.motion)
    }

    /// G*: the optimal cost without limits, which is a lower bound of the optimal cost with limits.
    pub fn cost(&self, reference: &ModalReference) -> f64 {
        let of_guide = self.guide.as_ref().map_or(0.0, |guide| guide.cost);
        self.state_weight * self.factor.quadratic(&self.left_of(reference)) + of_guide
    }

    /// u*(0..H-1): the optimal inputs without limits.
    pub fn inputs(&self, reference: &ModalReference) -> Inputs {
        let gains = MODES.gains * (self.state_weight / self.input_weight);
        let inputs = self.act(self.factor.solve(&self.left_of(reference)), &gains);
        let Some(guide) = &self.guide else { return inputs };
        let mut inputs = guide.scaled(inputs);
        for (t, rest) in guide.rest.iter().enumerate() {
            let mut guided = inputs.view_mut((0, t), (guide.count, 1));
            guided += rest.rows(0, guide.count);
        }
        inputs
    }

    /// Hess^-1 a, where Hess is the Hessian of eq. (7) with respect to u(0..H-1): the cost is u' Hess u -
    /// 2 f' u + const. In each mode it is R I + Q sigma_j^2 B'B, whose inverse is (I - sigma_j^2 (Q / R) B'
    /// A_j^-1 B) / R.
    pub fn inverse_hessian_times(&self, a: &Inputs) -> Inputs {
        let scaled = |inputs| self.guide.as_ref().map_or(inputs, |guide| guide.scaled(inputs));
        let a = scaled(*a);
        let along = MODES.of_inputs.tr_mul(&(self.input_matrix * a).transpose());
        let gains = MODES.gains.component_mul(&MODES.gains) * (self.state_weight / self.input_weight);
        scaled((a - self.act(self.factor.solve(&along), &gains)) / self.input_weight)
    }

    /// B' of each mode times its gain, as inputs over time.
    fn act(&self, mut modes: Lanes<HORIZON>, gains: &Lane) -> Inputs {
        modes.column_iter_mut().for_each(|mut column| column.component_mul_assign(gains));
        self.input_matrix.tr_mul(&(MODES.of_inputs * modes).transpose())
    }
}

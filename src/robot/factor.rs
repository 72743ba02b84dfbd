//! Factors of symmetric positive definite matrices of six rows, several side by side.

use nalgebra::{Matrix6, SMatrix, SVector};

/// `N` vectors of six numbers: one row per vector, so that all are reckoned side by side.
pub(crate) type Lanes<const N: usize> = SMatrix<f64, N, 6>;

/// The factors F diag(d) F' of `N` matrices, with ones on the diagonal of F. Unlike Cholesky's they need no
/// square roots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const N: usize> {
    /// F below its diagonal, column after column.
    lower: SMatrix<f64, N, 15>,
    /// 1 / d.
    reciprocal: Lanes<N>,
}

/// The place of entry (i, j) in [`Factor::lower`].
const fn below(i: usize, j: usize) -> usize {
    j * (11 - j) / 2 + i - j - 1
}

impl<const N: usize> Factor<N> {
    /// The factors of `diagonal` I + `scale` `gram`, for each scale. Only the lower triangle of `gram` is read.
    pub fn new(diagonal: f64, scale: &SVector<f64, N>, gram: &Matrix6<f64>) -> Self {
        let mut lower = SMatrix::<f64, N, 15>::zeros();
        let (mut pivots, mut reciprocal) = (Lanes::<N>::zeros(), Lanes::<N>::zeros());
        for j in 0..6 {
            let mut pivot = (scale * gram[(j, j)]).add_scalar(diagonal);
            // row j of F, times the pivots
            let mut scaled = [SVector::<f64, N>::zeros(); 6];
            for (k, scaled) in scaled.iter_mut().enumerate().take(j) {
                let entry = lower.column(below(j, k));
                *scaled = entry.component_mul(&pivots.column(k));
                pivot -= entry.component_mul(scaled);
            }
            let inverse = pivot.map(|p| 1.0 / p);
            pivots.set_column(j, &pivot);
            reciprocal.set_column(j, &inverse);
            for i in j + 1..6 {
                let mut entry = scale * gram[(i, j)];
                for (k, scaled) in scaled.iter().enumerate().take(j) {
                    entry -= lower.column(below(i, k)).component_mul(scaled);
                }
                lower.set_column(below(i, j), &entry.component_mul(&inverse));
            }
        }
        Self { lower, reciprocal }
    }

    /// Whether all matrices are positive definite.
    pub fn is_definite(&self) -> bool {
        self.reciprocal.iter().all(|r| *r > 0.0 && r.is_finite())
    }

    /// y' A^-1 y of each matrix A, summed.
    pub fn quadratic(&self, y: &Lanes<N>) -> f64 {
        let solved = self.forward(y);
        solved.component_mul(&solved).dot(&self.reciprocal)
    }

    /// A^-1 y of each matrix A.
    pub fn solve(&self, y: &Lanes<N>) -> Lanes<N> {
        let mut solved = self.forward(y).component_mul(&self.reciprocal);
        for i in (1..6).rev() {
            let known = solved.column(i).into_owned();
            for j in 0..i {
                let mut rest = solved.column_mut(j);
                rest -= self.lower.column(below(i, j)).component_mul(&known);
            }
        }
        solved
    }

    /// F^-1 y.
    fn forward(&self, y: &Lanes<N>) -> Lanes<N> {
        let mut solved = *y;
        for j in 0..5 {
            let known = solved.column(j).into_owned();
            for i in j + 1..6 {
                let mut rest = solved.column_mut(i);
                rest -= self.lower.column(below(i, j)).component_mul(&known);
            }
        }
        solved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector6};

    #[test]
    fn closed_form_factors_solve_as_cholesky_does() {
        let half = Matrix6::from_fn(|i, j| (1.0 + i as f64) / (2.0 + (i * j) as f64) - 0.3 * j as f64);
        let gram = half * half.transpose();
        let factor = Factor::new(0.5, &Vector2::new(1.0, 30.0), &gram);
        assert!(factor.is_definite());
        let y = Lanes::from_fn(|n, i| (i as f64 - 2.0) * (1.0 + n as f64));
        let solved = factor.solve(&y);
        let mut quadratic = 0.0;
        for (n, scale) in [1.0, 30.0].into_iter().enumerate() {
            let whole = Matrix6::from_diagonal_element(0.5) + gram * scale;
            let y: Vector6<f64> = y.row(n).transpose();
            let slow = whole.cholesky().unwrap().solve(&y);
            assert!((solved.row(n).transpose() - slow).norm() < 1e-12 * slow.norm());
            quadratic += y.dot(&slow);
        }
        assert!((factor.quadratic(&y) - quadratic).abs() < 1e-12 * quadratic);
        assert!(!Factor::new(0.0, &Vector2::new(1.0, 1.0), &Matrix6::zeros()).is_definite());
    }
}

//! A small quadratic program over non-negative numbers. No other file uses clarabel.
//!
//! The inequality-constrained eq. (7) has 72 unknowns for nine inputs, but its dual has only one multiplier
//! for each constraint that may be active: minimise 1/2 m' D m - c' m over m >= 0. Programs are padded to a
//! few sizes, and a solver is kept for each size. Later programs of that size reuse its symbolic
//! factorisation and its memory.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

/// Solvers for programs of every size so far.
#[derive(Default)]
pub struct Qp {
    solvers: Vec<Sized>,
    scale: Vec<f64>,
    upper: Vec<f64>,
    linear: Vec<f64>,
}

struct Sized {
    size: usize,
    solver: DefaultSolver<f64>,
}

/// A copy begins without solvers: they hold no state that a result depends on.
impl Clone for Qp {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for Qp {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Qp").field("sizes", &self.solvers.iter().map(|s| s.size).collect::<Vec<_>>()).finish()
    }
}

impl Qp {
    /// Minimises 1/2 m' D m - c' m over m >= 0. D is given by rows and must be symmetric and positive
    /// semidefinite with a positive diagonal. Returns false if no minimum was found; `minimiser` is then
    /// unspecified.
    pub fn minimise(&mut self, d: &[f64], c: &[f64], minimiser: &mut Vec<f64>) -> bool {
        let n = c.len();
        let size = padded(n);
        // scale to a unit diagonal and a linear term of size 1, since clarabel's own scaling would depend on
        // earlier programs
        self.scale.clear();
        self.scale.extend((0..n).map(|i| 1.0 / d[i * n + i].sqrt()));
        let largest = c.iter().zip(&self.scale).map(|(c, s)| (c * s).abs()).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite() && self.scale.iter().all(|s| s.is_finite())) {
            return false;
        }
        self.upper.clear();
        for j in 0..size {
            for i in 0..=j {
                self.upper.push(match (i < n && j < n, i == j) {
                    (true, _) => d[i * n + j] * self.scale[i] * self.scale[j],
                    (false, diagonal) => f64::from(u8::from(diagonal)),
                });
            }
        }
        // the linear term pushes the padding to 0
        self.linear.clear();
        self.linear.extend((0..size).map(|i| if i < n { -c[i] * self.scale[i] / largest } else { 1.0 }));
        let Some(solver) = self.solver(size) else { return false };
        solver.solve();
        if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            return false;
        }
        let found = &solver.solution.x;
        minimiser.clear();
        minimiser.extend((0..n).map(|i| (found[i] * largest).max(0.0)));
        for (m, s) in minimiser.iter_mut().zip(&self.scale) {
            *m *= s;
        }
        minimiser.iter().all(|m| m.is_finite())
    }

    fn solver(&mut self, size: usize) -> Option<&mut DefaultSolver<f64>> {
        if let Some(i) = self.solvers.iter().position(|s| s.size == size) {
            let solver = &mut self.solvers[i].solver;
            solver.update_P(&self.upper).ok()?;
            solver.update_q(&self.linear).ok()?;
            return Some(solver);
        }
        let columns = (0..=size).map(|j| j * (j + 1) / 2).collect();
        let rows = (0..size).flat_map(|j| 0..=j).collect();
        let p = CscMatrix::new(size, size, columns, rows, self.upper.clone());
        let a = CscMatrix::new(size, size, (0..=size).collect(), (0..size).collect(), vec![-1.0; size]);
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .equilibrate_enable(false)
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .max_threads(1)
            .build()
            .ok()?;
        let b = vec![0.0; size];
        let solver =
            DefaultSolver::new(&p, &self.linear, &a, &b, &[NonnegativeConeT(size)], settings).ok()?;
        self.solvers.push(Sized { size, solver });
        self.solvers.last_mut().map(|s| &mut s.solver)
    }
}

/// The padded size of a program of `n` multipliers: few sizes, little padding.
fn padded(n: usize) -> usize {
    let step = if n <= 16 { 4 } else { 16 };
    n.next_multiple_of(step).max(4)
}

/// Minimises u' H u - 2 f' u subject to A u <= b as a dense program without the crate's shortcuts: the
/// reference for tests of [`super::Mpc`].
#[cfg(test)]
pub fn dense(
    h: &nalgebra::DMatrix<f64>,
    f: &[f64],
    a: &nalgebra::DMatrix<f64>,
    b: &[f64],
) -> Option<Vec<f64>> {
    let n = f.len();
    let upper = CscMatrix::new(
        n,
        n,
        (0..=n).map(|j| j * (j + 1) / 2).collect(),
        (0..n).flat_map(|j| 0..=j).collect(),
        (0..n).flat_map(|j| (0..=j).map(move |i| 2.0 * h[(i, j)])).collect(),
    );
    let rows = CscMatrix::new(
        a.nrows(),
        n,
        (0..=n).map(|j| j * a.nrows()).collect(),
        (0..n).flat_map(|_| 0..a.nrows()).collect(),
        a.as_slice().to_vec(),
    );
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()
        .ok()?;
    let linear: Vec<f64> = f.iter().map(|f| -2.0 * f).collect();
    let mut solver =
        DefaultSolver::new(&upper, &linear, &rows, b, &[NonnegativeConeT(b.len())], settings).ok()?;
    solver.solve();
    if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
        return None;
    }
    // the interior point leaves errors of 1e-5 in inputs of low cost: solve the equalities of the active
    // constraints
    let (slacks, multipliers) = (&solver.solution.s, &solver.solution.z);
    let active: Vec<usize> = (0..b.len()).filter(|&i| multipliers[i] > slacks[i]).collect();
    let k = active.len();
    let mut system = nalgebra::DMatrix::zeros(n + k, n + k);
    system.view_mut((0, 0), (n, n)).copy_from(&(h * 2.0));
    let mut right: Vec<f64> = f.iter().map(|f| 2.0 * f).collect();
    for (j, &i) in active.iter().enumerate() {
        system.view_mut((n + j, 0), (1, n)).copy_from(&a.row(i));
        system.view_mut((0, n + j), (n, 1)).copy_from(&a.row(i).transpose());
        right.push(b[i]);
    }
    let solved = system.lu().solve(&nalgebra::DVector::from_vec(right))?;
    Some(solved.as_slice()[..n].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_bound_that_holds_one_multiplier_at_zero() {
        let mut found = Vec::new();
        let mut qp = Qp::default();
        // the minimum is (5/3, -4/3) without bounds; with bounds the second is 0 and the first 1/2
        assert!(qp.minimise(&[2.0, 1.0, 1.0, 2.0], &[1.0, -1.0], &mut found));
        assert!((found[0] - 0.5).abs() < 1e-7 && found[1].abs() < 1e-7, "{found:?}");
        // the same solver with other numbers
        assert!(qp.minimise(&[200.0, 100.0, 100.0, 200.0], &[1.0, 1.0], &mut found));
        assert!((found[0] - 1.0 / 300.0).abs() < 1e-9 && (found[1] - found[0]).abs() < 1e-9, "{found:?}");
        assert_eq!(qp.solvers.len(), 1);
    }

    #[test]
    fn a_solver_used_before_gives_the_same_bits_as_a_new_one() {
        let (mut old, mut a, mut b) = (Qp::default(), Vec::new(), Vec::new());
        let d = [3.0, 1.0, 0.5, 1.0, 2.0, -0.3, 0.5, -0.3, 1.5];
        assert!(old.minimise(&[9.0, 1.0, 1.0, 2.0], &[1e3, -1.0], &mut a));
        assert!(old.minimise(&d, &[1.0, -2.0, 0.7], &mut a));
        assert!(Qp::default().minimise(&d, &[1.0, -2.0, 0.7], &mut b));
        assert_eq!(a, b);
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let mut found = Vec::new();
        assert!(!Qp::default().minimise(&[f64::NAN], &[1.0], &mut found));
        assert!(!Qp::default().minimise(&[1.0], &[f64::INFINITY], &mut found));
    }
}

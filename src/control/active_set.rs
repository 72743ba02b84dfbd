//! An exact active-set solver for the dual of eq. (7): minimise 1/2 m' D m - c' m over m >= 0, from a guess
//! of which m are positive.
//!
//! The first method is block principal pivoting (Judice and Pires 1994). It solves D m = c on the multipliers
//! assumed positive, then moves all multipliers that violate the optimality conditions to the other set. It
//! usually ends after two or three steps. Otherwise the method of Lawson and Hanson (1974) continues. It adds
//! one multiplier at a time and lowers the objective at each step, and therefore terminates.

use super::limits::TOLERANCE;

/// Steps of block pivoting, and steps of the second method per multiplier.
const BLOCK_STEPS: usize = 8;
const SINGLE_STEPS: usize = 5;
/// Relative ridge added to D's diagonal, since rows may be dependent, such as a rate and a position that
/// bound the same input.
const RIDGE: f64 = 1e-11;
/// Solves with the ridge; each solves for the residual of the previous one.
const SOLVE_PASSES: usize = 2;
/// A multiplier larger than this multiple of what its row alone needs indicates rows that contradict each
/// other.
const CONTRADICTION: f64 = 1e8;

/// Working memory of the method, kept between calls.
#[derive(Clone, Debug, Default)]
pub struct ActiveSet {
    chosen: Vec<usize>,
    factor: Vec<f64>,
    trial: Vec<f64>,
}

impl ActiveSet {
    /// A solver with memory for `n` multipliers.
    pub fn with_room(n: usize) -> Self {
        Self {
            chosen: Vec::with_capacity(n),
            factor: Vec::with_capacity(n * n + n),
            trial: Vec::with_capacity(n),
        }
    }

    /// Finds the minimiser for D (by rows) and c. `positive` guesses which multipliers are positive. Returns
    /// false if the minimiser was not found; `multipliers` is then unspecified.
    pub fn minimise(
        &mut self,
        d: &[f64],
        c: &[f64],
        positive: &mut [bool],
        multipliers: &mut Vec<f64>,
    ) -> bool {
        multipliers.clear();
        multipliers.resize(c.len(), 0.0);
        self.exchange_blocks(d, c, positive, multipliers) || self.exchange_singly(d, c, positive, multipliers)
    }

    fn exchange_blocks(
        &mut self,
        d: &[f64],
        c: &[f64],
        positive: &mut [bool],
        multipliers: &mut [f64],
    ) -> bool {
        for _ in 0..BLOCK_STEPS {
            self.solve(d, c, positive);
            multipliers.copy_from_slice(&self.trial);
            let mut wrong = 0;
            for i in 0..c.len() {
                let is_wrong = match positive[i] {
                    true => multipliers[i] < 0.0,
                    false => slack(d, c, multipliers, i) < -TOLERANCE,
                };
                positive[i] ^= is_wrong;
                wrong += usize::from(is_wrong);
            }
            if wrong == 0 {
                return is_consistent(d, c, multipliers);
            }
        }
        false
    }

    fn exchange_singly(
        &mut self,
        d: &[f64],
        c: &[f64],
        positive: &mut [bool],
        multipliers: &mut [f64],
    ) -> bool {
        multipliers.fill(0.0);
        for _ in 0..SINGLE_STEPS * (c.len() + BLOCK_STEPS) {
            self.solve(d, c, positive);
            // step toward the solution until a multiplier would become negative; those multipliers leave
            let blocks = |i: &usize| positive[*i] && self.trial[*i] <= 0.0;
            let ratio = |i: usize| multipliers[i] / (multipliers[i] - self.trial[i]);
            let blocked =
                (0..c.len()).filter(blocks).map(|i| if multipliers[i] > 0.0 { ratio(i) } else { 0.0 });
            let step = blocked.fold(1.0, f64::min);
            let mut left = false;
            for i in 0..c.len() {
                let blocking = positive[i] && self.trial[i] <= 0.0;
                multipliers[i] += step * (self.trial[i] - multipliers[i]);
                if blocking && multipliers[i] <= 1e-14 * self.trial[i].abs() {
                    (positive[i], multipliers[i], left) = (false, 0.0, true);
                }
            }
            if left {
                continue;
            }
            // the gain in the objective by each row alone
            let gain = |i: usize| -slack(d, c, multipliers, i) / d[i * c.len() + i].sqrt();
            let violated = |i: &usize| !positive[*i] && slack(d, c, multipliers, *i) < -TOLERANCE;
            let Some(next) =
                (0..c.len()).filter(violated).max_by(|&a, &b| gain(a).total_cmp(&gain(b)).then(b.cmp(&a)))
            else {
                return is_consistent(d, c, multipliers);
            };
            positive[next] = true;
        }
        false
    }

    /// Solves D m = c on the positive rows by Cholesky's factorisation, with m = 0 elsewhere, into `trial`.
    fn solve(&mut self, d: &[f64], c: &[f64], positive: &[bool]) {
        let n = c.len();
        self.chosen.clear();
        self.chosen.extend((0..n).filter(|&i| positive[i]));
        let (chosen, k) = (&self.chosen, self.chosen.len());
        self.factor.clear();
        self.factor.resize(k * k + k, 0.0);
        let (l, x) = self.factor.split_at_mut(k * k);
        for i in 0..k {
            for j in 0..=i {
                let (row_i, row_j) = (&l[i * k..i * k + j], &l[j * k..j * k + j]);
                let known: f64 = row_i.iter().zip(row_j).map(|(a, b)| a * b).sum();
                let entry = d[chosen[i] * n + chosen[j]];
                l[i * k + j] = if i == j {
                    ((entry - known).max(0.0) + RIDGE * entry).sqrt()
                } else {
                    (entry - known) / l[j * k + j]
                };
            }
        }
        self.trial.clear();
        self.trial.resize(n, 0.0);
        // the first pass solves, the others remove the effect of the ridge
        for _ in 0..SOLVE_PASSES {
            for i in 0..k {
                let known: f64 = l[i * k..i * k + i].iter().zip(&x[..i]).map(|(l, x)| l * x).sum();
                x[i] = (-slack(d, c, &self.trial, chosen[i]) - known) / l[i * k + i];
            }
            for i in (0..k).rev() {
                let known: f64 = (i + 1..k).map(|p| l[p * k + i] * x[p]).sum();
                x[i] = (x[i] - known) / l[i * k + i];
            }
            for (&i, m) in chosen.iter().zip(x.iter()) {
                self.trial[i] += m;
            }
        }
    }
}

fn is_consistent(d: &[f64], c: &[f64], multipliers: &[f64]) -> bool {
    let n = c.len();
    let largest = (0..n).map(|i| c[i].abs() / d[i * n + i].sqrt()).fold(0.0, f64::max);
    (0..n).all(|i| {
        multipliers[i].is_finite() && multipliers[i] * d[i * n + i].sqrt() <= CONTRADICTION * largest
    })
}

/// (D m - c)_i.
pub fn slack(d: &[f64], c: &[f64], multipliers: &[f64], i: usize) -> f64 {
    let n = c.len();
    let product: f64 = d[i * n..(i + 1) * n].iter().zip(multipliers).map(|(d, m)| d * m).sum();
    product - c[i]
}

#[cfg(test)]
mod tests {
    use super::super::qp::Qp;
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn property_the_minimiser_satisfies_the_conditions_of_optimality() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..300 {
            let n = rng.random_range(1..30);
            let root: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
            let d: Vec<f64> = (0..n * n)
                .map(|k| {
                    let (i, j) = (k / n, k % n);
                    (0..n).map(|p| root[i * n + p] * root[j * n + p]).sum::<f64>()
                        + f64::from(u8::from(i == j))
                })
                .collect();
            let c: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
            let mut multipliers = Vec::new();
            let mut positive: Vec<bool> = (0..n).map(|_| rng.random_range(0..2) == 0).collect();
            assert!(ActiveSet::default().minimise(&d, &c, &mut positive, &mut multipliers));
            let mut slow = Vec::new();
            if c.iter().any(|c| *c > 0.0) {
                assert!(Qp::default().minimise(&d, &c, &mut slow));
                let largest = slow.iter().zip(&multipliers).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(largest < 1e-5, "{largest} from the interior point's");
            }
            for (i, m) in multipliers.iter().enumerate() {
                let slack = slack(&d, &c, &multipliers, i);
                assert!(*m >= 0.0 && slack >= -1e-9 && (m * slack).abs() < 1e-9, "{m} {slack}");
            }
        }
    }

    #[test]
    fn of_two_equal_rows_the_stricter_counts() {
        let (mut positive, mut multipliers) = ([true, true], Vec::new());
        let same = [2.0, 2.0, 2.0, 2.0];
        assert!(ActiveSet::default().minimise(&same, &[1.0, 3.0], &mut positive, &mut multipliers));
        assert_eq!((multipliers[0], positive), (0.0, [false, true]));
        assert!((multipliers[1] - 1.5).abs() < 1e-10);
    }

    #[test]
    fn rows_that_contradict_each_other_are_refused() {
        let opposed = [1.0, -1.0, -1.0, 1.0];
        assert!(!ActiveSet::default().minimise(&opposed, &[1.0, 1.0], &mut [true, true], &mut Vec::new()));
    }
}

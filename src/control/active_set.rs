//! The dual of eq. (7), minimise 1/2 m' D m - c' m over m >= 0, and a guess of which m are positive in; the exact minimiser out.
//!
//! Block principal pivoting (Judice and Pires 1994; Portugal, Judice and Vicente 1994): on the multipliers taken to be positive D m = c is
//! solved, and all that contradict the conditions of optimality change sides at once; if that does not reduce their number for a while, only
//! the last one does (Murty's rule, which ends). What comes out satisfies all conditions to rounding, or is refused.

use super::limits::TOLERANCE;

/// Steps before giving up: a few suffice, or a degenerate D leads astray.
const STEPS: usize = 60;
/// A row whose part across the rows before it is less than this, squared and relative to the row, is taken to depend on them.
const DEPENDENT: f64 = 1e-12;
/// Steps that may pass without progress before only one row changes sides at a time.
const PATIENCE: usize = 3;

/// Memory for the method, kept between calls.
#[derive(Clone, Debug, Default)]
pub struct ActiveSet {
    chosen: Vec<usize>,
    factor: Vec<f64>,
}

impl ActiveSet {
    /// Finds the minimiser for D (given by rows) and c, with `positive` saying which multipliers are expected to be positive. False if it was
    /// not found: then `multipliers` is unspecified.
    pub fn minimise(
        &mut self,
        d: &[f64],
        c: &[f64],
        positive: &mut [bool],
        multipliers: &mut Vec<f64>,
    ) -> bool {
        let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
        for _ in 0..STEPS {
            self.solve(d, c, positive, multipliers);
            let wrong = |i: usize| match positive[i] {
                true => multipliers[i] < 0.0,
                false => slack(d, c, multipliers, i) < -TOLERANCE,
            };
            self.chosen.clear();
            self.chosen.extend((0..c.len()).filter(|&i| wrong(i)));
            let Some(&last) = self.chosen.last() else { return true };
            if self.chosen.len() < fewest {
                fewest = self.chosen.len();
                patience = PATIENCE;
            } else if patience > 0 {
                patience -= 1;
            } else {
                self.chosen.clear();
                self.chosen.push(last);
            }
            for &i in &self.chosen {
                positive[i] = !positive[i];
            }
        }
        false
    }

    /// D m = c on the positive rows by Cholesky's factorisation, m = 0 elsewhere. Rows are taken in the order of how much they ask for, and one
    /// that depends on those before it (a rate and a position that bound the same input, say) is made non-positive.
    fn solve(&mut self, d: &[f64], c: &[f64], positive: &mut [bool], multipliers: &mut Vec<f64>) {
        let n = c.len();
        let diagonal = |i: usize| d[i * n + i];
        let asks = |i: usize| c[i] / diagonal(i).sqrt();
        let chosen = &mut self.chosen;
        chosen.clear();
        chosen.extend((0..n).filter(|&i| positive[i]));
        chosen.sort_unstable_by(|&a, &b| asks(b).total_cmp(&asks(a)).then(a.cmp(&b)));
        let stride = chosen.len();
        self.factor.clear();
        self.factor.resize(stride * stride + stride, 0.0);
        let (l, x) = self.factor.split_at_mut(stride * stride);
        let mut k = 0;
        while k < chosen.len() {
            for j in 0..k {
                let known: f64 = (0..j).map(|p| l[k * stride + p] * l[j * stride + p]).sum();
                l[k * stride + j] = (d[chosen[k] * n + chosen[j]] - known) / l[j * stride + j];
            }
            let known: f64 = (0..k).map(|p| l[k * stride + p].powi(2)).sum();
            let rest = diagonal(chosen[k]) - known;
            if rest > DEPENDENT * diagonal(chosen[k]) {
                l[k * stride + k] = rest.sqrt();
                k += 1;
            } else {
                positive[chosen.remove(k)] = false;
            }
        }
        for i in 0..k {
            let known: f64 = (0..i).map(|p| l[i * stride + p] * x[p]).sum();
            x[i] = (c[chosen[i]] - known) / l[i * stride + i];
        }
        for i in (0..k).rev() {
            let known: f64 = (i + 1..k).map(|p| l[p * stride + i] * x[p]).sum();
            x[i] = (x[i] - known) / l[i * stride + i];
        }
        multipliers.clear();
        multipliers.resize(n, 0.0);
        for (&i, m) in chosen.iter().zip(x.iter()) {
            multipliers[i] = *m;
        }
    }
}

/// (D m - c)_i.
pub fn slack(d: &[f64], c: &[f64], multipliers: &[f64], i: usize) -> f64 {
    let n = c.len();
    let product: f64 = d[i * n..(i + 1) * n].iter().zip(multipliers).map(|(d, m)| d * m).sum();
    product - c[i]
}

#[cfg(test)]
mod tests {
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
            for (i, m) in multipliers.iter().enumerate() {
                let slack = slack(&d, &c, &multipliers, i);
                assert!(*m >= 0.0 && slack >= -1e-9 && (m * slack).abs() < 1e-9, "{m} {slack}");
            }
        }
    }

    #[test]
    fn of_two_rows_that_say_the_same_the_stricter_counts() {
        let (mut positive, mut multipliers) = ([true, true], Vec::new());
        let same = [2.0, 2.0, 2.0, 2.0];
        assert!(ActiveSet::default().minimise(&same, &[1.0, 3.0], &mut positive, &mut multipliers));
        assert_eq!((multipliers[0], positive), (0.0, [false, true]));
        assert!((multipliers[1] - 1.5).abs() < 1e-15);
    }

    #[test]
    fn rows_that_contradict_each_other_are_refused() {
        let opposed = [1.0, -1.0, -1.0, 1.0];
        assert!(!ActiveSet::default().minimise(&opposed, &[1.0, 1.0], &mut [true, true], &mut Vec::new()));
    }
}

//! The lower envelope of the options' cost curves at one `gamma`: the winner on each part of a range of
//! `alpha`.
//!
//! Within a range that contains no [turning point](super::curve::turning_point), any two curves cross at most
//! once, and their slopes determine which of them wins on the left. Sorted by slope, the envelope is one pass
//! with a stack.

use super::curve::{Curve, Level, Pair};
use crate::math;

/// The curves over one range of `alpha`, and their envelope at the last `gamma`.
#[derive(Debug, Clone, Default)]
pub(super) struct Envelope {
    /// Start of the range of `alpha`.
    pub lower: f64,
    /// End of the range of `alpha`.
    pub upper: f64,
    /// Weight `c_r` of perceived risk.
    pub risk_weight: f64,
    /// The `gamma` the levels belong to.
    pub gamma: f64,
    /// Curves by falling slope: a curve can only take over to the right of one of lower rank.
    pub curves: Vec<Curve>,
    /// The perceived risks of the curves at `gamma`, by rank.
    pub levels: Vec<Level>,
    /// `D^alpha` at both ends of the range, by rank.
    ends: Vec<(f64, f64)>,
    /// The winners found by [`winners`](Self::winners), left to right.
    pub stack: Vec<Winner>,
}

/// A winner on one part of the envelope.
#[derive(Debug, Clone, Copy)]
pub(super) struct Winner {
    /// Rank of the curve.
    pub rank: usize,
    /// The `alpha` where its part starts; the part ends where the next one starts.
    pub start: f64,
}

impl Envelope {
    /// Takes over the front for the range `[lower, upper]` of `alpha`.
    pub fn reset(&mut self, front: &[Curve], lower: f64, upper: f64) {
        (self.lower, self.upper) = (lower, upper);
        self.curves.clear();
        self.curves.extend_from_slice(front);
        let middle = 0.5 * (lower + upper);
        let steeper = |a: &Curve, b: &Curve| b.slope(middle).total_cmp(&a.slope(middle));
        // The front is sorted by length; slopes fall with it except among lengths below 1.
        self.curves.reverse();
        if front.len() > 1 && front[1].length < 1.0 {
            self.curves.sort_unstable_by(|a, b| steeper(a, b).then(b.length.total_cmp(&a.length)));
        }
        self.ends.clear();
        self.ends.extend(self.curves.iter().map(|c| (c.perceived_length(lower), c.perceived_length(upper))));
        self.levels.clear();
        self.levels.resize(self.curves.len(), Level::default());
    }

    /// Prelec's function for all curves at `gamma`.
    pub fn set_gamma(&mut self, gamma: f64) {
        self.gamma = gamma;
        for (level, curve) in self.levels.iter_mut().zip(&self.curves) {
            *level = Level::at(curve, gamma, self.risk_weight);
        }
    }

    /// Prelec's function at `gamma` for some curves only.
    pub fn set_gamma_of(&mut self, ranks: &[usize], gamma: f64) {
        self.gamma = gamma;
        for &rank in ranks {
            self.levels[rank] = Level::at(&self.curves[rank], gamma, self.risk_weight);
        }
    }

    /// The two curves of these ranks, the lower rank on the left.
    pub fn pair(&self, left: usize, right: usize) -> Pair {
        Pair::new(left, &self.curves[left], right, &self.curves[right])
    }

    /// Risk gap of a pair at the present `gamma`.
    pub fn risk_gap(&self, pair: &Pair) -> f64 {
        pair.risk_gap(&self.levels, self.gamma, self.risk_weight)
    }

    /// The `alpha` where a pair crosses at the present `gamma`.
    pub fn crossing(&self, pair: &mut Pair) -> f64 {
        let risk_gap = self.risk_gap(pair);
        pair.crossing(risk_gap, self.lower, self.upper)
    }

    /// Cost of the left curve of a pair minus that of the right one at `alpha` and the present `gamma`.
    pub fn difference(&self, pair: &Pair, alpha: f64) -> f64 {
        let (left, right) = (pair.left, pair.right);
        let stored = if alpha == self.lower {
            Some((self.ends[left].0, self.ends[right].0))
        } else if alpha == self.upper {
            Some((self.ends[left].1, self.ends[right].1))
        } else {
            None
        };
        if let Some((left_length, right_length)) = stored {
            let difference = left_length - right_length + (self.levels[left].cost - self.levels[right].cost);
            // Far from a tie the rounding of the stored powers does not matter.
            if difference.abs() > 1e-9 * (left_length + right_length + self.risk_weight) {
                return difference;
            }
        }
        pair.difference(alpha, self.risk_gap(pair))
    }

    /// Finds the envelope at `gamma` from scratch and leaves it in `stack`.
    pub fn winners(&mut self, gamma: f64) {
        self.set_gamma(gamma);
        self.stack.clear();
        for rank in 0..self.curves.len() {
            let start = loop {
                let Some(&top) = self.stack.last() else { break Some(self.lower) };
                let mut pair = self.pair(top.rank, rank);
                if self.difference(&pair, self.upper) <= 0.0 {
                    break None;
                }
                if self.difference(&pair, top.start) < 0.0 {
                    break Some(self.crossing(&mut pair));
                }
                self.stack.pop();
            };
            if let Some(start) = start {
                self.stack.push(Winner { rank, start });
            }
        }
    }
}

impl Level {
    fn at(curve: &Curve, gamma: f64, risk_weight: f64) -> Self {
        let exponent = math::exp(gamma * curve.log_surprise);
        Self { exponent, cost: risk_weight * math::exp(-exponent) }
    }
}

//! The population of alpha and gamma: independent truncated normals on the belief's ranges.
//!
//! Means are uniform on the range a priori, and the logarithms of the spreads are uniform. A person's
//! likelihood steps at the borders of the options' regions only, so the integral over alpha is exact: a sum
//! of distribution functions. The integral over gamma is a sum over narrow rows. The integral over the
//! population's four parameters is a sum over all nodes.

use cocarry::Error;
use cocarry::math;
use cocarry::preference::Marginal;
use serde::Serialize;

/// Nodes of the mean of a normal, at the middles of equal parts of the range.
const MEANS: usize = 25;
/// Nodes of its spread, at the middles of equal parts of the logarithm.
const SPREADS: usize = 10;
/// The least and the largest spread, in parts of the range. With the largest, the normal is nearly uniform.
const SPREAD_RANGE: [f64; 2] = [0.05, 2.0];
/// Rows of gamma.
pub(super) const ROWS: usize = 64;

/// The quantities of a population that are reported, as in outputs.
pub const QUANTITIES: [&str; 4] = ["mean of alpha", "spread of alpha", "mean of gamma", "spread of gamma"];

/// A parameter's populations: every pair of a mean and a spread.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub normals: Vec<Marginal>,
    /// Mean and standard deviation of each over people, after truncation.
    people: Vec<[f64; 2]>,
}

impl Axis {
    fn new([low, high]: [f64; 2]) -> Result<Self, Error> {
        let width = high - low;
        let [least, most] = SPREAD_RANGE;
        let mut axis = Self { normals: Vec::new(), people: Vec::new() };
        for s in 0..SPREADS {
            let spread = least * width * math::pow(most / least, (s as f64 + 0.5) / SPREADS as f64);
            for m in 0..MEANS {
                let mean = low + width * (m as f64 + 0.5) / MEANS as f64;
                let normal = Marginal::truncated_normal(mean, spread, low, high)?;
                // from d/dx density = -(x - mean) / spread^2 density, by parts
                let [at_low, at_high] = [low, high].map(|end| normal.density(end));
                let variance = math::squared(spread);
                let first = mean - variance * (at_high - at_low);
                let second = mean * first + variance * (1.0 - (high * at_high - low * at_low));
                axis.normals.push(normal);
                axis.people.push([first, (second - first * first).max(0.0).sqrt()]);
            }
        }
        Ok(axis)
    }
}

/// The step functions of alpha on every row of gamma: from one participant's answers.
#[derive(Clone, Debug)]
pub(super) struct Steps(pub Vec<Vec<(f64, f64)>>);

/// The grid of all populations.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub alpha: Axis,
    pub gamma: Axis,
    gammas: [f64; 2],
    /// The rows' probabilities, by gamma's population.
    rows: Vec<RowMasses>,
    /// The probability of each row, by row and then by gamma's population.
    masses: Vec<f64>,
}

/// The probabilities of the rows of gamma.
#[derive(Clone, Debug)]
pub(super) struct RowMasses {
    /// Up to the beginning of each row, and to the end of the last.
    pub up_to: [f64; ROWS + 1],
}

impl RowMasses {
    pub fn of(&self, row: usize) -> f64 {
        self.up_to[row + 1] - self.up_to[row]
    }
}

impl Grid {
    pub fn new(ranges: [[f64; 2]; 2]) -> Result<Self, Error> {
        let [alpha, gamma] = [Axis::new(ranges[0])?, Axis::new(ranges[1])?];
        let mut grid = Self { alpha, gamma, gammas: ranges[1], rows: Vec::new(), masses: Vec::new() };
        grid.rows = grid.gamma.normals.iter().map(|normal| grid.row_masses(normal)).collect();
        grid.masses = (0..ROWS).flat_map(|row| grid.rows.iter().map(move |masses| masses.of(row))).collect();
        Ok(grid)
    }

    /// Number of populations.
    pub fn len(&self) -> usize {
        self.alpha.normals.len() * self.gamma.normals.len()
    }

    /// The populations of alpha and gamma of a node.
    pub fn at(&self, node: usize) -> [usize; 2] {
        [node / self.gamma.normals.len(), node % self.gamma.normals.len()]
    }

    /// The ends of a row.
    pub fn row(&self, row: usize) -> [f64; 2] {
        let [low, high] = self.gammas;
        [row, row + 1].map(|end| low + (high - low) * end as f64 / ROWS as f64)
    }

    /// The probabilities of the rows.
    pub fn row_masses(&self, gamma: &Marginal) -> RowMasses {
        RowMasses { up_to: std::array::from_fn(|row| gamma.cdf(self.row(row)[0])) }
    }

    /// The probabilities of the rows under one of gamma's populations.
    pub fn masses_of(&self, gamma: usize) -> &RowMasses {
        &self.rows[gamma]
    }

    /// The steps of a likelihood in the middle of each row.
    pub fn steps(&self, at: impl Fn(f64) -> Vec<(f64, f64)>) -> Steps {
        let middle = |row| 0.5 * (self.row(row)[0] + self.row(row)[1]);
        Steps((0..ROWS).map(|row| at(middle(row))).collect())
    }

    /// The integral over alpha on each row.
    pub fn along_alpha(&self, steps: &Steps, alpha: &Marginal) -> [f64; ROWS] {
        std::array::from_fn(|row| {
            let steps = &steps.0[row];
            integral(steps, steps.iter().map(|(from, _)| alpha.cdf(*from)))
        })
    }

    /// The integrals of one likelihood over every population: by alpha's, then gamma's.
    pub fn integrals(&self, steps: &Steps) -> Vec<f64> {
        let gammas = self.rows.len();
        let mut values = vec![0.0; self.len()];
        for (normal, values) in self.alpha.normals.iter().zip(values.chunks_exact_mut(gammas)) {
            let along = self.along_alpha(steps, normal);
            // all of gamma's populations at once, row by row: their sums do not wait for each other
            for (along, masses) in along.iter().zip(self.masses.chunks_exact(gammas)) {
                values.iter_mut().zip(masses).for_each(|(sum, mass)| *sum += along * mass);
            }
        }
        values
    }

    /// The posterior probability of each row of one person, given the integrals along alpha by alpha's
    /// population, and gamma's population, not scaled.
    pub fn rows_given(&self, along_alpha: &[f64; ROWS], gamma: &RowMasses) -> [f64; ROWS] {
        std::array::from_fn(|row| along_alpha[row] * gamma.of(row))
    }

    /// The distribution of a quantity under weights of the nodes.
    pub fn figure(&self, which: usize, weights: &[f64]) -> Figure {
        let (people, sums) = match which < 2 {
            true => (&self.alpha.people, self.sums(weights, 0)),
            false => (&self.gamma.people, self.sums(weights, 1)),
        };
        Figure::of(people.iter().map(|person| person[which % 2]).zip(sums).collect())
    }

    /// The weights of the populations of alpha (0) or gamma (1).
    fn sums(&self, weights: &[f64], axis: usize) -> Vec<f64> {
        let mut sums = vec![0.0; if axis == 0 { self.alpha.people.len() } else { self.gamma.people.len() }];
        weights.iter().enumerate().for_each(|(node, weight)| sums[self.at(node)[axis]] += weight);
        sums
    }

    fn quantity(&self, which: usize, node: usize) -> f64 {
        let [alpha, gamma] = self.at(node);
        let people = if which < 2 { self.alpha.people[alpha] } else { self.gamma.people[gamma] };
        people[which % 2]
    }
}

/// The integral of a step function of alpha, given alpha's probability up to each step.
pub(super) fn integral(steps: &[(f64, f64)], up_to: impl Iterator<Item = f64>) -> f64 {
    steps.iter().zip(up_to).map(|((_, step), below)| step * (1.0 - below)).sum::<f64>().max(0.0)
}

/// The posterior of a quantity: moments and intervals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Median.
    pub median: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// The central 50 % interval.
    pub interval_50: [f64; 2],
    /// The central 80 % interval.
    pub interval_80: [f64; 2],
    /// The central 95 % interval.
    pub interval: [f64; 2],
}

impl Figure {
    /// The figure of a distribution with this mean and standard deviation. `quantile` is the value up to which
    /// there is a probability.
    pub(super) fn new([mean, std]: [f64; 2], quantile: impl Fn(f64) -> f64) -> Self {
        Self {
            median: quantile(0.5),
            mean,
            std,
            interval_50: [0.25, 0.75].map(&quantile),
            interval_80: [0.1, 0.9].map(&quantile),
            interval: [0.025, 0.975].map(&quantile),
        }
    }

    /// The figure of values with weights that sum to 1.
    pub(super) fn of(mut values: Vec<(f64, f64)>) -> Self {
        let mean: f64 = values.iter().map(|(value, weight)| value * weight).sum();
        let variance: f64 = values.iter().map(|(value, weight)| math::squared(value - mean) * weight).sum();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self::new([mean, variance.sqrt()], |share| {
            let mut sum = 0.0;
            let reaches = |(_, weight): &&(f64, f64)| {
                sum += weight;
                sum >= share
            };
            values.iter().find(reaches).or(values.last()).map_or(mean, |(value, _)| *value)
        })
    }
}

/// The posterior of a population.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Population {
    /// The posterior of each of [`QUANTITIES`].
    pub posterior: [Figure; 4],
    /// The prior of each of them.
    pub prior: [Figure; 4],
    /// Relative entropy of the posterior of all four parameters to their prior, nats.
    pub information: f64,
    /// The logarithm of the probability of all answers.
    pub log_evidence: f64,
}

/// Weights of the populations, from the logarithms of their likelihoods; and the logarithm of the evidence.
/// `None` if no population is possible.
pub(super) fn weights(log_likelihoods: &[f64]) -> Option<(Vec<f64>, f64)> {
    let most = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return None;
    }
    let weights: Vec<f64> = log_likelihoods.iter().map(|l| math::exp(l - most)).collect();
    let total: f64 = weights.iter().sum();
    let evidence = most + math::ln(total / weights.len() as f64);
    Some((weights.into_iter().map(|w| w / total).collect(), evidence))
}

impl Population {
    pub(super) fn new(grid: &Grid, weights: &[f64], log_evidence: f64) -> Self {
        let figure = |which: usize, weight: &dyn Fn(usize) -> f64| {
            Figure::of((0..grid.len()).map(|node| (grid.quantity(which, node), weight(node))).collect())
        };
        let even = 1.0 / grid.len() as f64;
        let relative = |w: &&f64| **w > 0.0;
        Self {
            posterior: std::array::from_fn(|which| figure(which, &|node| weights[node])),
            prior: std::array::from_fn(|which| figure(which, &|_| even)),
            information: weights.iter().filter(relative).map(|w| w * math::ln(w / even)).sum(),
            log_evidence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cocarry::preference::{Belief, Perception, Posterior, Prospect, Ways, human_choice};

    const RANGES: [[f64; 2]; 2] = [[0.55, 0.95], [0.5, 1.1]];
    const PROSPECTS: [Prospect; 4] = [
        Prospect::new(41.86, 0.66),
        Prospect::new(17.4, 0.363),
        Prospect::new(14.33, 0.547),
        Prospect::new(21.36, 0.247),
    ];

    #[test]
    fn property_brute_force_of_integrals_over_populations() {
        let grid = Grid::new(RANGES).unwrap();
        let mut posterior = Posterior::new(Belief::default(), 10.0).unwrap();
        let likelihoods = [0.1, 0.3, 0.9, 0.05];
        let evidence = posterior.observe(&PROSPECTS, &Ways::default(), &likelihoods).unwrap();
        let integrals = grid.integrals(&grid.steps(|gamma| posterior.steps_at(gamma)));
        for node in (0..grid.len()).step_by(4001) {
            let [a, g] = grid.at(node);
            let (alpha, gamma) = (&grid.alpha.normals[a], &grid.gamma.normals[g]);
            let points = 400;
            let mut wanted = 0.0;
            for i in 0..points {
                for j in 0..points {
                    let at =
                        |normal: &Marginal, i: i32| normal.quantile((f64::from(i) + 0.5) / f64::from(points));
                    let human = Perception { alpha: at(alpha, i), gamma: at(gamma, j) };
                    wanted += likelihoods[human_choice(&PROSPECTS, 10.0, human, None)];
                }
            }
            wanted /= f64::from(points * points);
            let found = evidence * integrals[node];
            assert!((found - wanted).abs() < 2e-3, "{alpha} {gamma}: {found} {wanted}");
        }
    }

    #[test]
    fn closed_form_moments_of_people() {
        let axis = Axis::new(RANGES[0]).unwrap();
        for (normal, [mean, std]) in axis.normals.iter().zip(&axis.people) {
            let n = 20_000;
            let values: Vec<f64> =
                (0..n).map(|i| normal.quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
            let found = crate::statistics::mean_and_std(&values);
            assert!((found.0 - mean).abs() < 1e-6, "{normal}: {found:?} {mean}");
            assert!((found.1 - std).abs() < 1e-5, "{normal}: {found:?} {std}");
        }
    }
}

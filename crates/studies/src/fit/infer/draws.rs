//! Independent draws from posterior and prior.
//!
//! Populations are drawn from the nodes of their grid; then every person given each of them: a row of gamma, gamma
//! within the row, and alpha exactly from the step function at this gamma. A person's draws come from streams of
//! random numbers of their own, so people can be drawn one after the other.

use super::evidence::Perceived;
use super::population::{Grid, along};
use cocarry::learning::Tolerance;
use cocarry::math;
use cocarry::preference::{Belief, Marginal, Perception, WeightedSample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Number of chains, each with its own stream of random numbers.
pub const CHAINS: usize = 4;

/// Draws, one chain after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draws {
    /// Draws of each chain.
    pub length: usize,
    /// Mean and spread, before truncation, of alpha's and of gamma's normal; empty without a population.
    pub population: [Vec<f64>; 4],
    /// By person.
    pub alpha: Vec<Vec<f64>>,
    /// By person.
    pub gamma: Vec<Vec<f64>>,
    /// By person; empty without switches.
    pub eta: Vec<Vec<f64>>,
    /// The logarithm of the joint density of population (by means and logarithms of spreads), alpha, gamma and
    /// answers, up to a constant.
    pub log_density: Vec<f64>,
}

/// What draws are drawn from.
pub(super) struct Source<'a> {
    pub belief: &'a Belief,
    pub grid: &'a Grid,
    /// The probabilities of the populations; `None` if everybody is alone.
    pub crowd: Option<&'a [f64]>,
    /// Draws of each chain.
    pub length: usize,
    pub seed: u64,
    /// Tells several sets of draws with one seed apart.
    pub set: u64,
}

/// The draws of one person, one chain after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct PersonDraws {
    pub alpha: Vec<f64>,
    pub gamma: Vec<f64>,
    pub eta: Vec<f64>,
    /// What each draw adds to the logarithm of the joint density.
    pub log_density: Vec<f64>,
}

impl Source<'_> {
    /// A population for every draw, as nodes of the grid; empty if everybody is alone.
    pub fn nodes(&self) -> Vec<usize> {
        let Some(weights) = self.crowd else { return Vec::new() };
        let cumulated = cumulated(weights.iter().copied());
        let chain = |chain: u64| {
            let mut rng = self.rng(0, chain);
            (0..self.length).map(|_| pick(&cumulated, &mut rng)).collect::<Vec<_>>()
        };
        (0..CHAINS as u64).flat_map(chain).collect()
    }

    /// The generator of a chain: of the population (0), or of a person (from 1).
    fn rng(&self, whose: u64, chain: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream((whose << 8) + self.set * CHAINS as u64 + chain);
        rng
    }

    /// Mean and spread, before truncation, of alpha's and of gamma's normal in every draw.
    pub fn population(&self, nodes: &[usize]) -> [Vec<f64>; 4] {
        let mut all: [Vec<f64>; 4] = Default::default();
        for node in nodes {
            let [a, g] = self.grid.at(*node);
            let normals = [&self.grid.alpha.normals[a], &self.grid.gamma.normals[g]];
            let shapes = normals.map(|normal| normal.normal_shape().unwrap_or_default());
            let values = [shapes[0].0, shapes[0].1, shapes[1].0, shapes[1].1];
            all.iter_mut().zip(values).for_each(|(all, value)| all.push(value));
        }
        all
    }

    /// The draws of the person with this number, given the populations drawn.
    pub fn person(
        &self,
        number: usize,
        person: &Perceived,
        tolerance: Option<&Tolerance>,
        nodes: &[usize],
    ) -> PersonDraws {
        let mut draws = PersonDraws::default();
        let steps = self.grid.steps(|gamma| person.posterior.steps_at(gamma));
        let (crowd, alone) = match (self.crowd, self.belief) {
            (Some(_), _) => (self.grid.by_population(&steps), Vec::new()),
            (None, Belief::Independent { alpha, gamma }) => {
                let masses = self.grid.row_masses(gamma);
                let along = self.grid.along_alpha(&steps, alpha);
                (Vec::new(), along.iter().zip(&masses).map(|(a, b)| a * b).collect())
            }
            (None, Belief::Samples(set)) => {
                let weight = |s: &WeightedSample| s.weight * person.posterior.density(s.perception);
                (Vec::new(), set.samples().iter().map(weight).collect())
            }
        };
        let alone = cumulated(alone.into_iter());
        for chain in 0..CHAINS {
            let mut rng = self.rng(number as u64 + 1, chain as u64);
            for draw in 0..self.length {
                let (human, density) = match (nodes.get(chain * self.length + draw), self.belief) {
                    (Some(node), _) => {
                        let [a, g] = self.grid.at(*node);
                        let rows = self.grid.rows_given(&crowd[a], g);
                        let normals = [self.grid.alpha.normals[a], self.grid.gamma.normals[g]];
                        person_within(self.grid, person, &cumulated(rows.into_iter()), &normals, &mut rng)
                    }
                    (None, Belief::Independent { alpha, gamma }) => {
                        person_within(self.grid, person, &alone, &[*alpha, *gamma], &mut rng)
                    }
                    (None, Belief::Samples(set)) => {
                        let sample = set.samples()[pick(&alone, &mut rng)];
                        (sample.perception, sample.weight)
                    }
                };
                let likelihood = person.posterior.density(human).max(f64::MIN_POSITIVE);
                draws.log_density.push(person.log_evidence + math::ln(likelihood) + math::ln(density));
                draws.alpha.push(human.alpha);
                draws.gamma.push(human.gamma);
                draws.eta.extend(tolerance.map(|tolerance| tolerance.quantile(rng.random())));
            }
        }
        draws
    }
}

impl Draws {
    /// Those of the populations, before those of people are added.
    pub(super) fn new(source: &Source, nodes: &[usize]) -> Self {
        let log_density = vec![0.0; CHAINS * source.length];
        Self { length: source.length, population: source.population(nodes), log_density, ..Self::default() }
    }

    /// Adds the draws of the next person.
    pub(super) fn add(&mut self, person: PersonDraws) {
        self.alpha.push(person.alpha);
        self.gamma.push(person.gamma);
        if !person.eta.is_empty() {
            self.eta.push(person.eta);
        }
        self.log_density.iter_mut().zip(person.log_density).for_each(|(sum, own)| *sum += own);
    }
}

/// Sums up to and including each number.
fn cumulated(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let add = |sum: &mut f64, number: f64| {
        *sum += number;
        Some(*sum)
    };
    numbers.scan(0.0, add).collect()
}

/// The index that a uniform number falls to.
fn pick(cumulated: &[f64], rng: &mut ChaCha8Rng) -> usize {
    let Some(total) = cumulated.last() else { return 0 };
    let at = rng.random::<f64>() * total;
    cumulated.partition_point(|sum| *sum <= at).min(cumulated.len() - 1)
}

/// A person by the cumulated probabilities of the rows of gamma, and the density of such people.
fn person_within(
    grid: &Grid,
    person: &Perceived,
    rows: &[f64],
    [alpha, gamma]: &[Marginal; 2],
    rng: &mut ChaCha8Rng,
) -> (Perception, f64) {
    let [from, to] = grid.row(pick(rows, rng));
    let [below, above] = [from, to].map(|end| gamma.cdf(end));
    let drawn = gamma.quantile(below + rng.random::<f64>() * (above - below)).clamp(from, to);
    let steps = person.posterior.steps_at(drawn);
    // only without lapses, at the rim of what is possible
    let is_possible = along(&steps, alpha) > 0.0;
    let drawn = if is_possible { drawn } else { 0.5 * (from + to) };
    let steps = if is_possible { steps } else { person.posterior.steps_at(drawn) };
    let human = Perception { alpha: alpha_along(&steps, alpha, rng), gamma: drawn };
    (human, alpha.density(human.alpha) * gamma.density(human.gamma))
}

/// An alpha by its distribution times a step function.
fn alpha_along(steps: &[(f64, f64)], alpha: &Marginal, rng: &mut ChaCha8Rng) -> f64 {
    let (mut value, mut sum) = (0.0, 0.0);
    let mut parts: Vec<[f64; 2]> = Vec::new();
    let mut cumulated = Vec::new();
    for (i, (from, step)) in steps.iter().enumerate() {
        value += step;
        let ends = [*from, steps.get(i + 1).map_or(f64::INFINITY, |next| next.0)].map(|end| alpha.cdf(end));
        sum += value.max(0.0) * (ends[1] - ends[0]);
        parts.push(ends);
        cumulated.push(sum);
    }
    let part = pick(&cumulated, rng);
    let [below, above] = parts.get(part).copied().unwrap_or([0.0, 1.0]);
    alpha.quantile(below + rng.random::<f64>() * (above - below))
}

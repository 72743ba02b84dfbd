//! Independent draws from posterior and prior.
//!
//! A population is drawn from the nodes of its grid; then every person given it: a row of gamma, gamma within
//! the row, and alpha exactly from the step function at this gamma.

use super::evidence::Perceived;
use super::population::{Grid, Integrals, along};
use crate::parallel::in_parallel;
use cocarry::learning::{Tolerance, TolerancePrior};
use cocarry::math;
use cocarry::preference::{Belief, Marginal, Perception};
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

/// The distributions that draws come from.
pub(super) struct DrawSource<'a> {
    pub belief: &'a Belief,
    pub people: &'a [Perceived],
    /// By person; empty without switches.
    pub tolerances: &'a [Tolerance],
    pub tolerance: TolerancePrior,
    pub crowd: Option<Crowd<'a>>,
    pub grid: &'a Grid,
}

/// A population with its people.
pub(super) struct Crowd<'a> {
    /// The probabilities of the nodes.
    pub weights: &'a [f64],
    pub integrals: &'a [Integrals],
}

/// One draw.
struct Draw {
    population: Option<[f64; 4]>,
    people: Vec<[f64; 2]>,
    etas: Vec<f64>,
    log_density: f64,
}

impl DrawSource<'_> {
    /// Draws `length` times in every chain. `stream` tells several sets of draws with one seed apart.
    pub fn draws(&self, length: usize, seed: u64, stream: u64) -> Draws {
        let cumulated: Vec<f64> = self.crowd.as_ref().map_or(Vec::new(), |crowd| {
            let mut sum = 0.0;
            let add = |weight: &f64| {
                sum += weight;
                sum
            };
            crowd.weights.iter().map(add).collect()
        });
        let alone = self.rows_alone();
        let chains = in_parallel(CHAINS, &|| (), |chain| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream * CHAINS as u64 + chain as u64);
            (0..length).map(|_| self.draw(&cumulated, &alone, &mut rng)).collect::<Vec<_>>()
        });
        let people = self.people.len();
        let mut draws = Draws {
            length,
            alpha: vec![Vec::new(); people],
            gamma: vec![Vec::new(); people],
            ..Draws::default()
        };
        draws.eta = vec![Vec::new(); self.tolerances.len()];
        for draw in chains.into_iter().flatten() {
            for (all, value) in draws.population.iter_mut().zip(draw.population.iter().flatten()) {
                all.push(*value);
            }
            for (p, [alpha, gamma]) in draw.people.into_iter().enumerate() {
                draws.alpha[p].push(alpha);
                draws.gamma[p].push(gamma);
            }
            for (p, eta) in draw.etas.into_iter().enumerate() {
                draws.eta[p].push(eta);
            }
            draws.log_density.push(draw.log_density);
        }
        draws
    }

    /// Without a population: the probability of each person's rows.
    fn rows_alone(&self) -> Vec<Vec<f64>> {
        let Belief::Independent { alpha, gamma } = self.belief else { return Vec::new() };
        let masses = self.grid.row_masses(gamma);
        let of = |person: &Perceived| {
            let steps = self.grid.steps(|gamma| person.posterior.steps_at(gamma));
            self.grid.along_alpha(&steps, alpha).iter().zip(&masses).map(|(a, b)| a * b).collect()
        };
        match self.crowd {
            Some(_) => Vec::new(),
            None => self.people.iter().map(of).collect(),
        }
    }

    fn draw(&self, cumulated: &[f64], alone: &[Vec<f64>], rng: &mut ChaCha8Rng) -> Draw {
        let mut draw = Draw { population: None, people: Vec::new(), etas: Vec::new(), log_density: 0.0 };
        let node = self.crowd.as_ref().map(|_| pick(cumulated, rng));
        if let Some([a, g]) = node.map(|node| self.grid.at(node)) {
            let normals = [&self.grid.alpha.normals[a], &self.grid.gamma.normals[g]];
            let shapes =
                normals.map(|normal| normal.normal_shape().expect("populations of the grid are normal"));
            draw.population = Some([shapes[0].0, shapes[0].1, shapes[1].0, shapes[1].1]);
        }
        for (p, person) in self.people.iter().enumerate() {
            let own = match (&self.crowd, node, self.belief) {
                (Some(crowd), Some(node), _) => {
                    let [a, g] = self.grid.at(node);
                    let rows = self.grid.rows_given(&crowd.integrals[p], [a, g]);
                    let normals = [self.grid.alpha.normals[a], self.grid.gamma.normals[g]];
                    Some((rows.to_vec(), normals))
                }
                (_, _, Belief::Independent { alpha, gamma }) => Some((alone[p].clone(), [*alpha, *gamma])),
                _ => None,
            };
            let (human, density) = match (own, self.belief) {
                (Some((rows, normals)), _) => {
                    let human = person_within(self.grid, person, &rows, &normals, rng);
                    (human, normals[0].density(human.alpha) * normals[1].density(human.gamma))
                }
                (None, Belief::Samples(set)) => {
                    let mut sum = 0.0;
                    let weights: Vec<f64> = set
                        .samples()
                        .iter()
                        .map(|s| {
                            sum += s.weight * person.posterior.density(s.perception);
                            sum
                        })
                        .collect();
                    let sample = set.samples()[pick(&weights, rng)];
                    (sample.perception, sample.weight)
                }
                (None, _) => continue,
            };
            let likelihood = person.posterior.density(human).max(f64::MIN_POSITIVE);
            draw.log_density += person.log_evidence + math::ln(likelihood) + math::ln(density);
            draw.people.push([human.alpha, human.gamma]);
        }
        draw.etas.extend(self.tolerances.iter().map(|tolerance| tolerance.quantile(rng.random())));
        draw
    }
}

/// The index that a uniform number falls to.
fn pick(cumulated: &[f64], rng: &mut ChaCha8Rng) -> usize {
    let Some(total) = cumulated.last() else { return 0 };
    let at = rng.random::<f64>() * total;
    cumulated.partition_point(|sum| *sum <= at).min(cumulated.len() - 1)
}

/// A person by the probabilities of the rows of gamma.
fn person_within(
    grid: &Grid,
    person: &Perceived,
    rows: &[f64],
    [alpha, gamma]: &[Marginal; 2],
    rng: &mut ChaCha8Rng,
) -> Perception {
    let mut sum = 0.0;
    let add = |row: &f64| {
        sum += row;
        sum
    };
    let row = pick(&rows.iter().map(add).collect::<Vec<_>>(), rng);
    let [from, to] = grid.row(row);
    let [below, above] = [from, to].map(|end| gamma.cdf(end));
    let drawn = gamma.quantile(below + rng.random::<f64>() * (above - below)).clamp(from, to);
    let steps = person.posterior.steps_at(drawn);
    // only without lapses, at the rim of what is possible
    let is_possible = along(&steps, alpha) > 0.0;
    let drawn = if is_possible { drawn } else { 0.5 * (from + to) };
    let steps = if is_possible { steps } else { person.posterior.steps_at(drawn) };
    Perception { alpha: alpha_along(&steps, alpha, rng), gamma: drawn }
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

//! Independent draws from posterior and prior.
//!
//! A population is drawn from the nodes of its grid; then every person given it: a row of gamma, gamma within
//! the row, and alpha exactly from the step function at this gamma.

use super::evidence::Perceived;
use super::population::{Grid, ROWS, RowMasses, integral};
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
    pub people: People<'a>,
    /// By person; empty without switches.
    pub tolerances: &'a [Tolerance],
    pub tolerance: TolerancePrior,
    /// The probabilities of the nodes of the grid; `None` without a population.
    pub weights: Option<&'a [f64]>,
    pub grid: &'a Grid,
}

/// The people that are drawn.
#[derive(Clone, Copy)]
pub(super) enum People<'a> {
    Each(&'a [Perceived]),
    /// This many people with the same posterior.
    Equal(&'a Perceived, usize),
}

impl People<'_> {
    pub fn len(&self) -> usize {
        match self {
            Self::Each(people) => people.len(),
            Self::Equal(_, count) => *count,
        }
    }

    fn get(&self, person: usize) -> &Perceived {
        match self {
            Self::Each(people) => &people[person],
            Self::Equal(person, _) => person,
        }
    }
}

/// The draws of one person: of alpha, of gamma, and what each adds to the logarithm of the density.
pub(super) type PersonDraws = [Vec<f64>; 3];

/// The probabilities of the rows of gamma for a person, not scaled.
enum Rows {
    /// The integrals along alpha, by alpha's population, for those that are drawn.
    Population(Vec<Option<[f64; ROWS]>>),
    /// The rows' probabilities before the answers, and after them.
    Alone(Box<(RowMasses, [f64; ROWS])>),
    /// The cumulated weights of samples instead.
    Samples(Vec<f64>),
}

/// People whose draws are in memory at a time.
const AT_ONCE: usize = 64;
/// Words of the stream of random numbers that a number takes.
const WORDS: usize = 2;

impl DrawSource<'_> {
    /// Draws `length` times in every chain; `each` gets every person's draws, in order. `stream` tells several
    /// sets of draws with one seed apart. People come one after the other, and not draw by draw, so that memory
    /// does not grow with their number: every number has its place in the stream.
    pub fn draws(&self, length: usize, seed: u64, stream: u64, mut each: impl FnMut(PersonDraws)) -> Draws {
        let places = Places::new(self, length, seed, stream);
        let nodes = self.nodes(&places);
        let mut draws = Draws { length, log_density: vec![0.0; CHAINS * length], ..Draws::default() };
        for [a, g] in nodes.iter().flatten().map(|node| self.grid.at(*node)) {
            let normals = [&self.grid.alpha.normals[a], &self.grid.gamma.normals[g]];
            let shapes =
                normals.map(|normal| normal.normal_shape().expect("populations of the grid are normal"));
            let numbers = [shapes[0].0, shapes[0].1, shapes[1].0, shapes[1].1];
            draws.population.iter_mut().zip(numbers).for_each(|(all, number)| all.push(number));
        }
        // of equal people once
        let shared = match self.people {
            People::Equal(person, _) => Some(self.rows(person, nodes.as_deref())),
            People::Each(_) => None,
        };
        let count = self.people.len();
        for first in (0..count).step_by(AT_ONCE) {
            let people = in_parallel(AT_ONCE.min(count - first), &|| (), |i| {
                let person = self.people.get(first + i);
                match &shared {
                    Some(rows) => self.person(first + i, rows, nodes.as_deref(), &places),
                    None => {
                        let rows = self.rows(person, nodes.as_deref());
                        self.person(first + i, &rows, nodes.as_deref(), &places)
                    }
                }
            });
            for person in people {
                draws.log_density.iter_mut().zip(&person[2]).for_each(|(sum, term)| *sum += term);
                each(person);
            }
        }
        draws
    }

    /// The draws of eta, by person.
    pub fn etas(&self, length: usize, seed: u64, stream: u64) -> Vec<Vec<f64>> {
        let places = Places::new(self, length, seed, stream);
        in_parallel(self.tolerances.len(), &|| (), |p| {
            let eta = |draw| self.tolerances[p].quantile(places.eta(draw, p).random());
            (0..CHAINS * length).map(eta).collect()
        })
    }

    /// The population of every draw; `None` without populations.
    fn nodes(&self, places: &Places) -> Option<Vec<usize>> {
        let mut sum = 0.0;
        let add = |weight: &f64| {
            sum += weight;
            sum
        };
        let cumulated: Vec<f64> = self.weights?.iter().map(add).collect();
        Some((0..CHAINS * places.length).map(|draw| pick(&cumulated, &mut places.node(draw))).collect())
    }

    fn rows(&self, person: &Perceived, nodes: Option<&[usize]>) -> Rows {
        let steps = || self.grid.steps(|gamma| person.posterior.steps_at(gamma));
        match (nodes, self.belief) {
            (Some(nodes), _) => {
                let steps = steps();
                let mut along = vec![None; self.grid.alpha.normals.len()];
                for [a, _] in nodes.iter().map(|node| self.grid.at(*node)) {
                    along[a]
                        .get_or_insert_with(|| self.grid.along_alpha(&steps, &self.grid.alpha.normals[a]));
                }
                Rows::Population(along)
            }
            (None, Belief::Independent { alpha, gamma }) => {
                let masses = self.grid.row_masses(gamma);
                let rows = self.grid.rows_given(&self.grid.along_alpha(&steps(), alpha), &masses);
                Rows::Alone(Box::new((masses, rows)))
            }
            (None, Belief::Samples(set)) => {
                let mut sum = 0.0;
                let weights = set.samples().iter().map(|sample| {
                    sum += sample.weight * person.posterior.density(sample.perception);
                    sum
                });
                Rows::Samples(weights.collect())
            }
        }
    }

    /// All draws of a person.
    fn person(&self, p: usize, rows: &Rows, nodes: Option<&[usize]>, places: &Places) -> PersonDraws {
        let (grid, person) = (self.grid, self.people.get(p));
        let mut draws: PersonDraws = Default::default();
        for draw in 0..CHAINS * places.length {
            let rng = &mut places.person(draw, p);
            let mut within = |rows: &[f64; ROWS], masses: &RowMasses, normals: [Marginal; 2]| {
                let human = person_within(grid, person, rows, masses, &normals, rng);
                (human, normals[0].density(human.alpha) * normals[1].density(human.gamma))
            };
            let (human, density) = match (rows, self.belief) {
                (Rows::Population(along), _) => {
                    let [a, g] = grid.at(nodes.map_or(0, |nodes| nodes[draw]));
                    let along = along[a].as_ref().expect("integrals of every population drawn");
                    let masses = grid.masses_of(g);
                    let normals = [grid.alpha.normals[a], grid.gamma.normals[g]];
                    within(&grid.rows_given(along, masses), masses, normals)
                }
                (Rows::Alone(alone), Belief::Independent { alpha, gamma }) => {
                    let (masses, rows) = alone.as_ref();
                    within(rows, masses, [*alpha, *gamma])
                }
                (Rows::Samples(weights), Belief::Samples(set)) => {
                    let sample = set.samples()[pick(weights, rng)];
                    (sample.perception, sample.weight)
                }
                _ => unreachable!("the rows are those of the belief"),
            };
            let likelihood = person.posterior.density(human).max(f64::MIN_POSITIVE);
            let term = person.log_evidence + math::ln(likelihood) + math::ln(density);
            draws.iter_mut().zip([human.alpha, human.gamma, term]).for_each(|(all, number)| all.push(number));
        }
        draws
    }
}

/// The places of numbers in the streams of random numbers, one stream for each chain: of a draw first the
/// population's, then every person's, then every eta.
struct Places {
    length: usize,
    /// Of each chain, at its beginning.
    chains: [ChaCha8Rng; CHAINS],
    /// Numbers of the population, of a person, and of all people.
    numbers: [usize; 3],
    /// Numbers of a draw.
    all: usize,
}

impl Places {
    fn new(source: &DrawSource, length: usize, seed: u64, stream: u64) -> Self {
        let chains = std::array::from_fn(|chain| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream * CHAINS as u64 + chain as u64);
            rng
        });
        let of_node = usize::from(source.weights.is_some());
        // the row, gamma in it, the step of alpha, alpha in it
        let of_person = if matches!(source.belief, Belief::Samples(_)) { 1 } else { 4 };
        let people = of_person * source.people.len();
        let all = of_node + people + source.tolerances.len();
        Self { length, chains, numbers: [of_node, of_person, people], all }
    }

    fn at(&self, draw: usize, number: usize) -> ChaCha8Rng {
        let mut rng = self.chains[draw / self.length].clone();
        rng.set_word_pos((WORDS * (draw % self.length * self.all + number)) as u128);
        rng
    }

    fn node(&self, draw: usize) -> ChaCha8Rng {
        self.at(draw, 0)
    }

    fn person(&self, draw: usize, person: usize) -> ChaCha8Rng {
        self.at(draw, self.numbers[0] + self.numbers[1] * person)
    }

    fn eta(&self, draw: usize, person: usize) -> ChaCha8Rng {
        self.at(draw, self.numbers[0] + self.numbers[2] + person)
    }
}

/// The index that a uniform number falls to.
fn pick(cumulated: &[f64], rng: &mut ChaCha8Rng) -> usize {
    let Some(total) = cumulated.last() else { return 0 };
    let at = rng.random::<f64>() * total;
    cumulated.partition_point(|sum| *sum <= at).min(cumulated.len() - 1)
}

/// A person by the probabilities of the rows of gamma, after the answers and before them.
fn person_within(
    grid: &Grid,
    person: &Perceived,
    rows: &[f64; ROWS],
    masses: &RowMasses,
    [alpha, gamma]: &[Marginal; 2],
    rng: &mut ChaCha8Rng,
) -> Perception {
    let mut sum = 0.0;
    let cumulated = rows.map(|row| {
        sum += row;
        sum
    });
    let row = pick(&cumulated, rng);
    let [from, to] = grid.row(row);
    let below = masses.up_to[row];
    let drawn = gamma.quantile(below + rng.random::<f64>() * masses.of(row)).clamp(from, to);
    let along = AlongAlpha::new(&person.posterior.steps_at(drawn), alpha);
    if along.integral > 0.0 {
        return Perception { alpha: along.draw(alpha, rng), gamma: drawn };
    }
    // only without lapses, at the rim of what is possible
    let middle = 0.5 * (from + to);
    let along = AlongAlpha::new(&person.posterior.steps_at(middle), alpha);
    Perception { alpha: along.draw(alpha, rng), gamma: middle }
}

/// The distribution of alpha times a step function.
struct AlongAlpha {
    /// Alpha's probability up to every step, and 1.
    up_to: Vec<f64>,
    /// The cumulated probabilities of the parts between the steps, not scaled.
    cumulated: Vec<f64>,
    integral: f64,
}

impl AlongAlpha {
    fn new(steps: &[(f64, f64)], alpha: &Marginal) -> Self {
        let up_to: Vec<f64> = steps.iter().map(|(from, _)| alpha.cdf(*from)).chain([1.0]).collect();
        let (mut value, mut sum) = (0.0, 0.0);
        let parts = steps.iter().zip(up_to.windows(2));
        let cumulated = parts.map(|((_, step), ends)| {
            value += step;
            sum += value.max(0.0) * (ends[1] - ends[0]);
            sum
        });
        let cumulated = cumulated.collect();
        let integral = integral(steps, up_to.iter().copied());
        Self { up_to, cumulated, integral }
    }

    fn draw(&self, alpha: &Marginal, rng: &mut ChaCha8Rng) -> f64 {
        let part = pick(&self.cumulated, rng);
        let [below, above] = match self.cumulated.is_empty() {
            false => [self.up_to[part], self.up_to[part + 1]],
            true => [0.0, 1.0],
        };
        alpha.quantile(below + rng.random::<f64>() * (above - below))
    }
}

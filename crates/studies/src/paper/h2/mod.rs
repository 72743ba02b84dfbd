//! H2, Table II: accumulated objective cost with and without the mode transition, and the Environment 4
//! example. The team is a point, as in the paper, or has bodies.

pub mod bodies;
pub mod section;

use super::{COLUMNS, ENVIRONMENTS, EXAMPLE, EXAMPLE_ENVIRONMENT, EXAMPLE_HUMAN, Environment};
use super::{Route, prepared, route, run_prepared};
use crate::parallel::{OnDone, in_parallel};
use crate::statistics::{self, Paired, mean_and_std};
use cocarry::Error;
use cocarry::coordination::{self, Mode};
use cocarry::episode::{Episode, EpisodeSettings, Outcome, Summary, Tick};
use cocarry::policy::Method;
use cocarry::preference::{Belief, Perception};
use cocarry::scenario::{GivenWorld, Plant, PreparedScenario, Scenario};
use cocarry::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;
use std::collections::BTreeSet;

/// The number of grid midpoints in alpha, and in gamma, for the expectation.
pub const GRID: usize = 40;
/// The number of random humans, as in the paper.
pub const SAMPLES: usize = 20;
/// Units of work of [`table`], for a progress bar.
pub const EPISODES: usize = ENVIRONMENTS.len() * COLUMNS.len() * (GRID * GRID + SAMPLES);

/// One cell of Table II.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostRow {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// `mutual`, or `without-model`.
    pub method: Method,
    /// eta; none without the model.
    pub eta: Option<f64>,
    /// The paper's mean over twenty humans, m.
    pub paper_mean: f64,
    /// Our expectation over the grid, m.
    pub ours_mean: f64,
    /// Our mean over twenty seeded humans, m.
    pub sample_mean: f64,
    /// Their standard deviation, m.
    pub sample_std: f64,
    /// The cost minus that without the model, of the same twenty humans, m; corrected for the comparisons of
    /// the table. `None` without the model.
    pub sample_against_without: Option<Paired>,
    /// Step of the mode transition; it does not depend on the human.
    pub transition_step: Option<u64>,
    /// Episodes of the cell that did not arrive.
    pub not_arrived: usize,
}

/// Table II: the expectation over humans drawn from the settings' belief, and twenty of them from `seed`.
///
/// # Errors
/// If a built-in world is not valid.
pub fn table(settings: &EpisodeSettings, seed: u64, on_done: OnDone) -> Result<Vec<CostRow>, Error> {
    let grid = humans_on_grid(settings.predictor.belief(), GRID);
    let sample = humans_at_random(settings.predictor.belief(), seed, SAMPLES);
    let mut rows = Vec::new();
    for environment in &ENVIRONMENTS {
        let prepared = prepared(environment.world()?, settings, &Plant::Point)?;
        let mut without = Vec::new();
        for (column, eta) in COLUMNS.into_iter().enumerate() {
            let (mut row, costs) = cell(environment, column, &prepared, [&grid, &sample], on_done)?;
            match eta {
                None => without = costs,
                Some(_) => row.sample_against_without = Paired::of_lists(&costs, &without, true),
            }
            rows.push(row);
        }
    }
    statistics::correct(rows.iter_mut().filter_map(|row| row.sample_against_without.as_mut()));
    Ok(rows)
}

/// A cell's row, and the costs of the twenty humans.
fn cell(
    environment: &Environment,
    column: usize,
    prepared: &PreparedScenario,
    [grid, sample]: [&[Perception]; 2],
    on_done: OnDone,
) -> Result<(CostRow, Vec<f64>), Error> {
    let eta = COLUMNS[column];
    let prepared = with_eta(prepared, eta, EXAMPLE_HUMAN)?;
    let (led, transition_step) = led_by_robot(&prepared)?;
    let costs = |humans: &[Perception]| {
        let ends = in_parallel(humans.len(), on_done, |i| finish(led.clone().with_preference(humans[i])));
        let costs: Vec<f64> = ends.iter().map(|s| s.accumulated_cost).collect();
        (costs, ends.iter().filter(|s| s.outcome != Outcome::Arrived).count())
    };
    let (on_grid, lost_on_grid) = costs(grid);
    let (at_random, lost_at_random) = costs(sample);
    let (sample_mean, sample_std) = mean_and_std(&at_random);
    let row = CostRow {
        environment: environment.number,
        method: method(eta),
        eta,
        paper_mean: environment.objective_cost[column],
        ours_mean: mean_and_std(&on_grid).0,
        sample_mean,
        sample_std,
        sample_against_without: None,
        transition_step,
        not_arrived: lost_on_grid + lost_at_random,
    };
    Ok((row, at_random))
}

/// The expectations of Table II in another world, m, in the order of [`COLUMNS`]: over an `n` by `n` midpoint
/// grid of humans. NaN where an episode does not arrive.
///
/// # Errors
/// If the world or its options are not valid.
pub fn expected_costs(
    world: impl Into<GivenWorld>,
    settings: &EpisodeSettings,
    n: usize,
) -> Result<[f64; COLUMNS.len()], Error> {
    let prepared = prepared(world, settings, &Plant::Point)?;
    let humans = humans_on_grid(settings.predictor.belief(), n);
    let mut means = [f64::NAN; COLUMNS.len()];
    for (mean, eta) in means.iter_mut().zip(COLUMNS) {
        let prepared = with_eta(&prepared, eta, EXAMPLE_HUMAN)?;
        let (led, _) = led_by_robot(&prepared)?;
        let ends = in_parallel(humans.len(), &|| (), |i| finish(led.clone().with_preference(humans[i])));
        let costs = ends.iter().map(|s| match s.outcome {
            Outcome::Arrived => s.accumulated_cost,
            _ => f64::NAN,
        });
        *mean = mean_and_std(&costs.collect::<Vec<f64>>()).0;
    }
    Ok(means)
}

/// The method of a column of Table II.
fn method(eta: Option<f64>) -> Method {
    if eta.is_some() { Method::MUTUAL } else { Method::WITHOUT_MODEL }
}

/// The episode of a human in a column of Table II.
fn with_eta(
    prepared: &PreparedScenario,
    eta: Option<f64>,
    human: Perception,
) -> Result<PreparedScenario, Error> {
    let base = prepared.scenario();
    let coordination = coordination::StubbornnessSettings {
        eta: eta.unwrap_or(base.settings.coordination.eta),
        ..base.settings.coordination
    };
    let settings = EpisodeSettings {
        method: method(eta),
        coordination,
        predict_while_human_leads: false,
        ..base.settings.clone()
    };
    prepared.prepare(Scenario { human, settings, ..base.clone() })
}

/// The part of an episode that is the same for all humans, since a leading robot does not know this human:
/// the episode just before the step at which the human takes over, and that step.
fn led_by_robot(prepared: &PreparedScenario) -> Result<(Episode<'_>, Option<u64>), Error> {
    let mut episode = prepared.episode()?;
    if prepared.scenario().settings.method == Method::WITHOUT_MODEL {
        return Ok((episode, None));
    }
    loop {
        let mut next = episode.clone();
        if next.step().is_some() {
            return Ok((episode, None));
        }
        if next.tick().mode == Mode::HumanLed {
            return Ok((episode, Some(next.tick().step)));
        }
        episode = next;
    }
}

fn finish(mut episode: Episode) -> Summary {
    while episode.step().is_none() {}
    episode.summary().clone()
}

/// The humans of the expectation: midpoints of equal shares of probability, or the belief's samples.
fn humans_on_grid(belief: &Belief, n: usize) -> Vec<Perception> {
    let middle = |i: usize| (i as f64 + 0.5) / n as f64;
    match belief {
        Belief::Samples(set) => set.samples().iter().map(|s| s.perception).collect(),
        Belief::Independent { alpha, gamma } => (0..n * n)
            .map(|i| Perception {
                alpha: alpha.quantile(middle(i / n)),
                gamma: gamma.quantile(middle(i % n)),
            })
            .collect(),
    }
}

/// The first `n` humans of a seed.
fn humans_at_random(belief: &Belief, seed: u64, n: usize) -> Vec<Perception> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| belief.sample(&mut rng)).collect()
}

/// One of the four runs of the example.
#[derive(Clone, Debug)]
pub struct ExampleRun {
    /// eta; none without the model.
    pub eta: Option<f64>,
    /// The paper's result, in its environment: step of the transition, and last option.
    pub paper: Option<(Option<u64>, &'static str)>,
    /// The summary of the episode.
    pub summary: Summary,
    /// Name of the last option.
    pub ended_on: String,
    /// Every step.
    pub ticks: Vec<Tick>,
}

/// The runs of the Environment 4 example of Sec. V-B in an environment: with eta 5, 10.5 and 15, and without
/// the model.
///
/// # Errors
/// If the built-in world is not valid.
pub fn example(
    environment: &Environment,
    settings: &EpisodeSettings,
) -> Result<(World, Vec<ExampleRun>), Error> {
    let prepared = prepared(environment.world()?, settings, &Plant::Point)?;
    let is_papers = environment.number == EXAMPLE_ENVIRONMENT.number;
    let runs = EXAMPLE
        .iter()
        .map(|&(eta, step, option)| (Some(eta), is_papers.then_some((step, option))))
        .chain([(None, None)])
        .map(|(eta, paper)| {
            let mut ticks = Vec::new();
            let summary = run_prepared(&with_eta(&prepared, eta, EXAMPLE_HUMAN)?, |t| ticks.push(t.clone()))?;
            let ended_on = prepared.options().options()[summary.last_option].name.clone();
            Ok(ExampleRun { eta, paper, summary, ended_on, ticks })
        })
        .collect::<Result<_, Error>>()?;
    Ok((prepared.world().clone(), runs))
}

/// Table II for a team with bodies: the same humans on the planning level, where the team is a point, and on
/// the physical plant.
#[derive(Clone, Copy, Debug)]
pub struct WithBodies<'a> {
    /// The physical plant.
    pub plant: &'a Plant,
    /// The episode's settings; method and eta are replaced.
    pub settings: &'a EpisodeSettings,
    /// Humans per cell.
    pub humans: usize,
    /// Seed of the humans and of their gaits.
    pub seed: u64,
}

/// The relative difference up to which costs are alike: a team with bodies accelerates gently.
const ALIKE: f64 = 0.05;

/// One cell of Table II with bodies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodiesRow {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// `mutual`, or `without-model`.
    pub method: Method,
    /// eta; none without the model.
    pub eta: Option<f64>,
    /// Episodes run.
    pub humans: usize,
    /// Episodes that arrived, without any contact with an obstacle.
    pub arrived: usize,
    /// Outcomes of the other episodes, in the order of the humans.
    pub lost: Vec<&'static str>,
    /// Mean accumulated objective cost of the point team, m. This figure and those below are of the humans
    /// who arrive with bodies.
    pub point_mean: f64,
    /// The same with bodies, m.
    pub physical_mean: f64,
    /// The cost with bodies minus that without the model, of the humans who arrive both times, m; corrected
    /// for the comparisons of the table. `None` without the model.
    pub against_without: Option<Paired>,
    /// Mean ratio of the cost with bodies to that of the point, per human.
    pub mean_ratio: f64,
    /// The ratio that is farthest from 1.
    pub farthest_ratio: f64,
    /// Episodes whose ratio is within 5 % of 1.
    pub alike: usize,
    /// Episodes that end on the same option.
    pub same_option: usize,
    /// The largest difference between the steps of the transitions.
    pub transition_difference: u64,
    /// Root mean square distance between grasp and reference over all steps, m.
    pub position_error_rms: f64,
    /// Mean and largest of the episodes' root mean square force of the human on the object, N.
    pub hand_force_rms: [f64; 2],
    /// Largest deflection of a grip, m.
    #[serde(rename = "largest_grip_deflection_m")]
    pub deflection: f64,
}

/// Units of work of [`WithBodies::table`] for a number of humans, for a progress bar.
pub fn units(humans: usize) -> usize {
    ENVIRONMENTS.len() * COLUMNS.len() * humans
}

impl WithBodies<'_> {
    /// The cells, in the order of Table II.
    ///
    /// # Errors
    /// If a built-in world is not valid, or the physical plant cannot be set up in it.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<BodiesRow>, Error> {
        let humans = humans_at_random(self.settings.predictor.belief(), self.seed, self.humans);
        let mut rows = Vec::new();
        for environment in &ENVIRONMENTS {
            let prepared = prepared(environment.world()?, self.settings, self.plant)?;
            let mut without = Vec::new();
            for eta in COLUMNS {
                let ends = in_parallel(humans.len(), on_done, |i| {
                    let point = with_eta(&prepared, eta, humans[i])?;
                    let seed = self.seed.wrapping_add(i as u64);
                    let physical = prepared.prepare(Scenario { seed, ..point.scenario().clone() })?;
                    let point =
                        point.prepare(Scenario { plant: Plant::Point, ..point.scenario().clone() })?;
                    Ok((run_prepared(&point, |_| {})?, run_prepared(&physical, |_| {})?))
                });
                let ends = ends.into_iter().collect::<Result<Vec<_>, Error>>()?;
                let costs: Vec<Cost> = ends.iter().map(|(_, physical)| cost(physical)).collect();
                let mut row = row(environment, eta, &ends);
                match eta {
                    None => without = costs,
                    Some(_) => row.against_without = against(&costs, &without),
                }
                rows.push(row);
            }
        }
        statistics::correct(rows.iter_mut().filter_map(|row| row.against_without.as_mut()));
        Ok(rows)
    }
}

/// The cost and the route of an episode that arrived.
type Cost = Option<(f64, Route)>;

fn cost(physical: &Summary) -> Cost {
    (physical.outcome == Outcome::Arrived).then(|| (physical.accumulated_cost, route(physical)))
}

/// The comparison of the humans who arrive both times. If all of them take the same routes, they differ by
/// gait noise only.
fn against(costs: &[Cost], without: &[Cost]) -> Option<Paired> {
    let both: Vec<_> = costs.iter().zip(without).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
    let routes: BTreeSet<(Route, Route)> = both.iter().map(|(a, b)| (a.1, b.1)).collect();
    let [first, second]: [Vec<f64>; 2] =
        [both.iter().map(|(a, _)| a.0).collect(), both.iter().map(|(_, b)| b.0).collect()];
    Paired::of_lists(&first, &second, routes.len() > 1)
}

fn row(environment: &Environment, eta: Option<f64>, ends: &[(Summary, Summary)]) -> BodiesRow {
    let arrived = || ends.iter().filter(|(_, physical)| physical.outcome == Outcome::Arrived);
    let of = |value: &dyn Fn(&(Summary, Summary)) -> f64| arrived().map(value).collect::<Vec<f64>>();
    let ratios = of(&|(point, physical)| physical.accumulated_cost / point.accumulated_cost);
    let off = |ratio: &f64| (ratio - 1.0).abs();
    let forces = of(&|(_, physical)| physical.interaction.map_or(f64::NAN, |i| i.rms_force()));
    let step = |summary: &Summary| summary.transition.map(|t| t.step);
    let differences = arrived().map(|(point, physical)| match (step(point), step(physical)) {
        (Some(a), Some(b)) => a.abs_diff(b),
        (None, None) => 0,
        _ => u64::MAX,
    });
    let squared: f64 = of(&|(_, p)| p.control.map_or(0.0, |c| c.squared_error)).iter().sum();
    let steps: u64 = arrived().map(|(_, physical)| physical.steps).sum();
    BodiesRow {
        environment: environment.number,
        method: method(eta),
        eta,
        humans: ends.len(),
        arrived: arrived().count(),
        lost: ends
            .iter()
            .filter(|(_, physical)| physical.outcome != Outcome::Arrived)
            .map(|(_, physical)| physical.outcome.name())
            .collect(),
        point_mean: mean_and_std(&of(&|(point, _)| point.accumulated_cost)).0,
        physical_mean: mean_and_std(&of(&|(_, physical)| physical.accumulated_cost)).0,
        against_without: None,
        mean_ratio: mean_and_std(&ratios).0,
        farthest_ratio: ratios.iter().copied().max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(f64::NAN),
        alike: ratios.iter().filter(|ratio| off(ratio) <= ALIKE).count(),
        same_option: arrived().filter(|(point, physical)| point.last_option == physical.last_option).count(),
        transition_difference: differences.max().unwrap_or(0),
        position_error_rms: (squared / steps as f64).sqrt(),
        hand_force_rms: [mean_and_std(&forces).0, forces.iter().copied().fold(0.0, f64::max)],
        deflection: of(&|(_, p)| p.interaction.map_or(0.0, |i| i.deflection)).into_iter().fold(0.0, f64::max),
    }
}

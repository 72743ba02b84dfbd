//! H2, Table II: accumulated objective cost with and without the mode transition, and the Environment 4 example.

use super::{BuiltInError, COLUMNS, ENVIRONMENTS, EXAMPLE, EXAMPLE_ENVIRONMENT, EXAMPLE_HUMAN, Environment};
use crate::coordination::{self, Mode};
use crate::episode::{Episode, Outcome, Settings, Summary, Tick, run};
use crate::options::OptionSet;
use crate::parallel::{OnDone, in_parallel};
use crate::policy::Method;
use crate::preference::{Belief, Perception};
use crate::statistics::{self, Paired, mean_and_std};
use crate::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// The expectation is taken over a grid of this many midpoints in alpha, and as many in gamma.
pub const GRID: usize = 40;
/// Random humans, as in the paper.
pub const SAMPLES: usize = 20;
/// Units of work of [`table`], for a progress bar.
pub const EPISODES: usize = ENVIRONMENTS.len() * COLUMNS.len() * (GRID * GRID + SAMPLES);

/// One cell of Table II.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
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
    /// The same twenty humans' cost less that without the model, m; corrected for the comparisons of the table. None without the model.
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
pub fn table(settings: &Settings, seed: u64, on_done: OnDone) -> Result<Vec<Row>, BuiltInError> {
    let grid = humans_on_grid(settings.predictor.belief());
    let sample = humans_at_random(settings.predictor.belief(), seed, SAMPLES);
    let mut rows = Vec::new();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world()?, settings.predictor.risk_weight())?;
        let mut without = Vec::new();
        for (column, eta) in COLUMNS.into_iter().enumerate() {
            let (mut row, costs) = cell(environment, column, eta, &set, settings, [&grid, &sample], on_done);
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
    eta: Option<f64>,
    set: &OptionSet,
    settings: &Settings,
    [grid, sample]: [&[Perception]; 2],
    on_done: OnDone,
) -> (Row, Vec<f64>) {
    let settings = with_eta(settings, eta);
    let (led, transition_step) = led_by_robot(set, &settings);
    let costs = |humans: &[Perception]| {
        let ends = in_parallel(humans.len(), on_done, |i| finish(led.clone().with_preference(humans[i])));
        let costs: Vec<f64> = ends.iter().map(|s| s.accumulated_cost).collect();
        (costs, ends.iter().filter(|s| s.outcome != Outcome::Arrived).count())
    };
    let (on_grid, lost_on_grid) = costs(grid);
    let (at_random, lost_at_random) = costs(sample);
    let (sample_mean, sample_std) = mean_and_std(&at_random);
    let row = Row {
        environment: environment.number,
        method: settings.method,
        eta,
        paper_mean: environment.objective_cost[column],
        ours_mean: mean_and_std(&on_grid).0,
        sample_mean,
        sample_std,
        sample_against_without: None,
        transition_step,
        not_arrived: lost_on_grid + lost_at_random,
    };
    (row, at_random)
}

/// The settings of a column of Table II.
pub(super) fn with_eta(settings: &Settings, eta: Option<f64>) -> Settings {
    let method = if eta.is_some() { Method::MUTUAL } else { Method::WITHOUT_MODEL };
    let coordination =
        coordination::Settings { eta: eta.unwrap_or(settings.coordination.eta), ..settings.coordination };
    Settings { method, coordination, predict_while_human_leads: false, ..settings.clone() }
}

/// The part of an episode that is the same for all humans, since a robot that leads knows nothing of this one: the episode just before the
/// step at which the human takes over, and that step.
fn led_by_robot<'a>(set: &'a OptionSet, settings: &'a Settings) -> (Episode<'a>, Option<u64>) {
    let mut episode = Episode::new(set, settings, EXAMPLE_HUMAN);
    if settings.method == Method::WITHOUT_MODEL {
        return (episode, None);
    }
    loop {
        let mut next = episode.clone();
        if next.step().is_some() {
            return (episode, None);
        }
        if next.tick().mode == Mode::HumanLed {
            return (episode, Some(next.tick().step));
        }
        episode = next;
    }
}

fn finish(mut episode: Episode) -> Summary {
    while episode.step().is_none() {}
    episode.summary().clone()
}

/// Midpoints of equal shares of probability; where the belief is made of samples, those.
fn humans_on_grid(belief: &Belief) -> Vec<Perception> {
    let middle = |i: usize| (i as f64 + 0.5) / GRID as f64;
    match belief {
        Belief::Samples(set) => set.samples().iter().map(|s| s.perception).collect(),
        Belief::Independent { alpha, gamma } => (0..GRID * GRID)
            .map(|i| Perception {
                alpha: alpha.quantile(middle(i / GRID)),
                gamma: gamma.quantile(middle(i % GRID)),
            })
            .collect(),
    }
}

/// The first `n` humans of a seed.
pub(super) fn humans_at_random(belief: &Belief, seed: u64, n: usize) -> Vec<Perception> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| belief.sample(&mut rng)).collect()
}

/// One of the four runs of the example.
#[derive(Clone, Debug)]
pub struct ExampleRun {
    /// eta; none without the model.
    pub eta: Option<f64>,
    /// What the paper reports, in its environment: step of the transition, and the option ended on.
    pub paper: Option<(Option<u64>, &'static str)>,
    /// How it went.
    pub summary: Summary,
    /// Name of the option ended on.
    pub ended_on: String,
    /// Every step.
    pub ticks: Vec<Tick>,
}

/// The human of the Environment 4 example of Sec. V-B in an environment: eta 5, 10.5 and 15, and without the model.
///
/// # Errors
/// If the built-in world is not valid.
pub fn example(
    environment: &Environment,
    settings: &Settings,
) -> Result<(World, Vec<ExampleRun>), BuiltInError> {
    let world = environment.world()?;
    let set = OptionSet::new(&world, settings.predictor.risk_weight())?;
    let is_papers = environment.number == EXAMPLE_ENVIRONMENT.number;
    let runs = EXAMPLE
        .iter()
        .map(|&(eta, step, option)| (Some(eta), is_papers.then_some((step, option))))
        .chain([(None, None)])
        .map(|(eta, paper)| {
            let mut ticks = Vec::new();
            let summary = run(&set, &with_eta(settings, eta), EXAMPLE_HUMAN, |t| ticks.push(t.clone()));
            let ended_on = set.options()[summary.last_option].name.clone();
            ExampleRun { eta, paper, summary, ended_on, ticks }
        })
        .collect();
    Ok((world, runs))
}

//! The paper's claims, one folder each: the run, then its tables, pictures and sentences (`section.rs`), with
//! our results next to the paper's. This file has the paper's figures and the four environments that were
//! calibrated to them.
//!
//! Source: A. J. Mahmud, W. Li, X. Wang, "Mutual Adaptation in Human-Robot Co-Transportation with Human
//! Preference Uncertainty"; the table is named at each figure.

pub mod arrivals;
pub mod contacts;
pub(crate) mod coverage;
pub mod cycles;
pub mod h1;
pub mod h2;
pub mod h3;
pub mod h4;
pub mod pairs;
pub mod part;
pub mod placed;
pub mod slots;
pub mod starts;

use cocarry::Error;
use cocarry::episode::{Episode, EpisodeSettings, Summary, Tick};
use cocarry::preference::Perception;
use cocarry::scenario::{GivenWorld, Plant, PreparedScenario, Scenario};
use cocarry::world::World;
use std::path::Path;
use std::sync::Arc;

/// One of the paper's environments.
#[derive(Debug)]
pub struct Environment {
    /// 1 to 4.
    pub number: u32,
    /// The name of its world on the command line.
    pub name: &'static str,
    /// Table I: mean answer of twenty participants, percent, options in the order of the figure's caption.
    pub human_percent: [f64; 4],
    /// Table I, in parentheses: the paper's own model output, percent.
    pub model_percent: [f64; 4],
    /// Table II: mean accumulated objective cost, m, in the order of [`COLUMNS`].
    pub objective_cost: [f64; 4],
    /// Table III: mean control cost C with pose optimisation, in the order of [`SETTINGS`].
    pub control_cost_with: [f64; 4],
    /// Table III: mean control cost C without it.
    pub control_cost_without: [f64; 4],
}

/// A setting of humans in Table III: alpha and gamma are uniform within a half-range of a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HumanSetting {
    /// S1 to S4.
    pub name: &'static str,
    /// Centre and half-range of alpha.
    pub alpha: [f64; 2],
    /// Centre and half-range of gamma.
    pub gamma: [f64; 2],
}

/// Table III's columns.
pub const SETTINGS: [HumanSetting; 4] = [
    HumanSetting { name: "S1", alpha: [0.65, 0.1], gamma: [0.6, 0.1] },
    HumanSetting { name: "S2", alpha: [0.75, 0.2], gamma: [0.7, 0.2] },
    HumanSetting { name: "S3", alpha: [0.8, 0.15], gamma: [0.85, 0.15] },
    HumanSetting { name: "S4", alpha: [0.85, 0.1], gamma: [0.95, 0.15] },
];

/// Table II's rows: without the model, then with eta = 5, 10.5 and 15.
pub const COLUMNS: [Option<f64>; 4] = [None, Some(5.0), Some(10.5), Some(15.0)];

/// The human of the Environment 4 example (Sec. V-B), who prefers option 4 at the start. The paper does not
/// give the parameters.
pub const EXAMPLE_HUMAN: Perception = Perception { alpha: 0.747, gamma: 0.765 };

/// Sec. V-B, Environment 4 example: eta, the step at which stubbornness exceeds 1 (not given for eta = 5),
/// and the last option.
pub const EXAMPLE: [(f64, Option<u64>, &str); 3] =
    [(5.0, None, "4"), (10.5, Some(42), "3"), (15.0, Some(66), "3")];

/// The environment of that example.
pub const EXAMPLE_ENVIRONMENT: &Environment = &ENVIRONMENTS[3];

/// The four environments.
pub const ENVIRONMENTS: [Environment; 4] = [
    Environment {
        number: 1,
        name: "environment-1",
        human_percent: [5.0, 45.0, 40.0, 10.0],
        model_percent: [0.0, 39.5, 36.1, 24.4],
        objective_cost: [1939.67, 1925.38, 1916.11, 1755.42],
        control_cost_with: [843.9, 781.5, 1546.5, 805.3],
        control_cost_without: [1078.3, 992.7, 1759.1, 1315.1],
    },
    Environment {
        number: 2,
        name: "environment-2",
        human_percent: [45.0, 13.5, 6.5, 35.0],
        model_percent: [51.6, 8.7, 0.0, 39.7],
        objective_cost: [1962.98, 1895.16, 1887.75, 1586.56],
        control_cost_with: [1267.7, 1094.4, 1130.1, 1162.2],
        control_cost_without: [2139.7, 1688.1, 1180.1, 1281.6],
    },
    Environment {
        number: 3,
        name: "environment-3",
        // sums to 95, as printed
        human_percent: [12.5, 30.0, 47.5, 5.0],
        model_percent: [5.1, 35.5, 59.4, 0.0],
        objective_cost: [1946.48, 1927.35, 1853.84, 1826.19],
        control_cost_with: [705.2, 639.3, 1003.8, 796.2],
        control_cost_without: [732.8, 647.1, 1200.4, 1034.3],
    },
    Environment {
        number: 4,
        name: "environment-4",
        human_percent: [8.0, 15.0, 41.0, 36.0],
        model_percent: [3.6, 18.3, 46.3, 31.8],
        objective_cost: [2279.98, 2213.82, 1767.07, 1767.07],
        control_cost_with: [760.2, 1424.4, 822.1, 972.9],
        control_cost_without: [890.9, 2332.5, 1136.6, 981.2],
    },
];

impl Environment {
    /// The world of this environment.
    ///
    /// # Errors
    /// Never in a build that passes its tests: the file is part of the program.
    pub fn world(&self) -> Result<World, Error> {
        World::find(Path::new(""), self.name)
    }
}

/// The prepared scenario of a team in a world, which the scenarios of its humans share, with what they find at
/// places.
fn prepared(
    world: impl Into<GivenWorld>,
    settings: &EpisodeSettings,
    plant: &Plant,
) -> Result<PreparedScenario, Error> {
    let scenario = Scenario { settings: settings.clone(), ..Scenario::new(world.into(), plant.clone()) };
    // the humans differ, places and predictions do not
    Ok(scenario.prepare()?.keeping_places(Arc::default()))
}

/// Runs the episode of a scenario to its end, and calls `on_tick` after every step.
fn run_prepared(prepared: &PreparedScenario, on_tick: impl FnMut(&Tick)) -> Result<Summary, Error> {
    Ok(run_episode(prepared.episode()?, on_tick))
}

/// Runs an episode to its end, and calls `on_tick` after every step.
fn run_episode(mut episode: Episode<'_>, mut on_tick: impl FnMut(&Tick)) -> Summary {
    while episode.step().is_none() {
        on_tick(episode.tick());
    }
    episode.summary().clone()
}

/// The route of an episode, which shows whether humans make the same choices: first option, last option and
/// number of option changes.
type Route = [u64; 3];

fn route(summary: &Summary) -> Route {
    [summary.first_option as u64, summary.last_option as u64, summary.option_changes.into()]
}

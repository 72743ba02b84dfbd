//! How a team with bodies carries: arrivals, errors of the grasp, grips and forces, in all built-in worlds.
//! Not in the paper.

pub mod section;

use super::{COLUMNS, prepared, run_prepared};
use crate::parallel::{OnDone, in_parallel};
use crate::statistics::mean_and_std;
use cocarry::Error;
use cocarry::coordination;
use cocarry::episode::{ControlSummary, EpisodeSettings, InteractionSummary, Outcome, Summary};
use cocarry::policy::Method;
use cocarry::scenario::{
    GivenPerception, GivenWorld, Plant, PreferenceChanges, Scenario, WorldText, drawn_changes, drawn_human,
};
use cocarry::world::BUILT_IN_WORLDS;
use serde::Serialize;

/// Default number of seeds, for [`ArrivalStudy::seeds`].
pub const SEEDS: usize = 100;

/// The study of arrivals.
#[derive(Clone, Copy, Debug)]
pub struct ArrivalStudy<'a> {
    /// The physical plant.
    pub plant: &'a Plant,
    /// The episode's settings; method and eta are replaced.
    pub settings: &'a EpisodeSettings,
    /// Humans in each cell of Table II's methods; fewer in the other [`Cell`]s.
    pub seeds: usize,
    /// Seed of the first human and its gait; the others have the seeds that follow.
    pub seed: u64,
}

/// Who leads, and whether humans change their mind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// eta, if the method has it.
    pub eta: Option<f64>,
    /// Whether humans change their preference once or twice.
    pub has_changes: bool,
}

/// All episodes of a cell in a world.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArrivalRow {
    /// The world's title.
    pub world: String,
    /// The method.
    pub method: Method,
    /// eta, if the method has it.
    pub eta: Option<f64>,
    /// Whether humans change their preference once or twice.
    pub has_changes: bool,
    /// Episodes run.
    pub episodes: usize,
    /// Episodes that arrived without any contact.
    pub arrived: usize,
    /// Root mean square distance between grasp and reference of an episode, m: mean and largest.
    pub error_rms: [f64; 2],
    /// Largest deflection of a grip, m.
    pub deflection: f64,
    /// The human's force on the object, N rms of an episode: least and largest.
    pub hand_force: [f64; 2],
    /// Largest force in a grip, N.
    pub peak_force: f64,
    /// A grip's force above 10 Hz, N rms of an episode: least and largest.
    pub force_noise: [f64; 2],
    /// Largest effort of a motor of the arm, as a share of its limit.
    pub effort_share: f64,
}

impl ArrivalStudy<'_> {
    /// The cells, with their number of humans: Table II's methods; two fifths of the humans where they lead,
    /// with and without changes of preference; a fifth with `mutual` and changes.
    fn cells(&self) -> Vec<(Cell, usize)> {
        let method = |eta: Option<f64>| if eta.is_some() { Method::MUTUAL } else { Method::WITHOUT_MODEL };
        let [more, fewer] = [2 * self.seeds / 5, self.seeds / 5].map(|n| n.max(1));
        let paper = COLUMNS.map(|eta| (Cell { method: method(eta), eta, has_changes: false }, self.seeds));
        let led = [false, true]
            .map(|has_changes| (Cell { method: Method::HUMAN_LED, eta: None, has_changes }, more));
        let changing = [5.0, 10.5]
            .map(|eta| (Cell { method: Method::MUTUAL, eta: Some(eta), has_changes: true }, fewer));
        paper.into_iter().chain(led).chain(changing).collect()
    }

    /// Units of work, for a progress bar.
    pub fn units(&self) -> usize {
        BUILT_IN_WORLDS.len() * self.cells().iter().map(|(_, n)| n).sum::<usize>()
    }

    /// The rows, by world and cell.
    ///
    /// # Errors
    /// If a built-in world is not valid, or the physical plant cannot be set up in it.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<ArrivalRow>, Error> {
        let mut rows = Vec::new();
        for world in BUILT_IN_WORLDS {
            let world = WorldText { file: world.name.to_owned(), text: world.text.to_owned() }.into();
            for (cell, n) in self.cells() {
                rows.push(self.row(&world, cell, n, on_done)?);
            }
        }
        Ok(rows)
    }

    fn row(&self, world: &GivenWorld, cell: Cell, n: usize, on_done: OnDone) -> Result<ArrivalRow, Error> {
        let base = self.settings.coordination;
        let coordination = coordination::StubbornnessSettings { eta: cell.eta.unwrap_or(base.eta), ..base };
        let settings = EpisodeSettings { method: cell.method, coordination, ..self.settings.clone() };
        let prepared = prepared(world.clone(), &settings, self.plant)?;
        let (belief, given) = (settings.predictor.belief(), GivenPerception::default());
        let ends = in_parallel(n, on_done, |i| {
            let seed = self.seed.wrapping_add(i as u64);
            let human = drawn_human(belief, given, seed);
            let changes = match cell.has_changes {
                true => {
                    let count = PreferenceChanges::OnceOrTwice;
                    drawn_changes(count, belief, given, seed, prepared.options(), &settings)
                }
                false => Vec::new(),
            };
            run_prepared(
                &prepared.prepare(Scenario { seed, human, changes, ..prepared.scenario().clone() })?,
                |_| (),
            )
        });
        let ends = ends.into_iter().collect::<Result<Vec<Summary>, Error>>()?;
        let control = |of: fn(&ControlSummary, u64) -> f64| -> Vec<f64> {
            ends.iter().filter_map(|end| Some(of(end.control.as_ref()?, end.steps))).collect()
        };
        let physics = |of: fn(&InteractionSummary) -> f64| -> Vec<f64> {
            ends.iter().filter_map(|end| end.interaction.as_ref().map(of)).collect()
        };
        let errors = control(|control, steps| control.error_rms(steps));
        Ok(ArrivalRow {
            world: prepared.world().name.clone(),
            method: cell.method,
            eta: cell.eta,
            has_changes: cell.has_changes,
            episodes: n,
            arrived: ends.iter().filter(|end| end.outcome == Outcome::Arrived).count(),
            error_rms: [mean_and_std(&errors).0, largest(&errors)],
            deflection: largest(&physics(|i| i.deflection)),
            hand_force: ends_of(&physics(InteractionSummary::rms_force)),
            peak_force: largest(&physics(|i| i.peak_force)),
            force_noise: ends_of(&physics(InteractionSummary::force_noise)),
            effort_share: largest(&physics(|i| i.effort_share)),
        })
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// The least and the largest.
fn ends_of(values: &[f64]) -> [f64; 2] {
    [values.iter().copied().fold(f64::INFINITY, f64::min), largest(values)]
}

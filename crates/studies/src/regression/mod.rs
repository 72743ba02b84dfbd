//! The regression gate: figures of runs compared with a recorded baseline.

mod baseline;
mod figures;
mod tolerance;

pub use baseline::{Baseline, Run, Value};
pub use figures::{Figure, Route, figure_names, figures, is_near};
pub use tolerance::{FORMAT, Tolerance};

use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::quantities::{Record, View};
use cocarry::scenario::Scenario;

/// The figures of a run, in the order of [`figure_names`].
pub type Figures = Record;

/// A figure that moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// The run's name.
    pub run: String,
    /// The figure.
    pub figure: String,
    /// The recorded value; `None` if there was none.
    pub recorded: Option<Figure>,
    /// The new value; `None` if the run no longer has the figure.
    pub now: Option<Figure>,
    /// Its tolerance.
    pub tolerance: Tolerance,
}

/// Runs all episodes to their ends. The results are in the order of the scenarios.
pub fn run_all(scenarios: Vec<Scenario>, on_done: OnDone) -> Vec<Result<Figures, Error>> {
    in_parallel(scenarios.len(), on_done, |i| {
        let prepared = scenarios[i].clone().prepare()?;
        let mut episode = prepared.episode()?;
        let mut route = Route::new(&prepared);
        while episode.step().is_none() {
            route.step(&prepared, episode.position());
        }
        Ok(figures(&View::new(&prepared, &episode), &route))
    })
}

/// The figures of a run that moved by more than their tolerance, in the order of the new figures; then those
/// that disappeared.
pub fn moved(baseline: &Baseline, run: &Run, now: &Figures) -> Vec<Moved> {
    let recorded = run.recorded.as_deref().unwrap_or_default();
    let moved = |figure: &str, recorded: Option<&Figure>, now: Option<&Figure>| Moved {
        run: run.name.clone(),
        figure: figure.to_owned(),
        recorded: recorded.cloned(),
        now: now.cloned(),
        tolerance: baseline.tolerance(figure),
    };
    let mut found = Vec::new();
    for (name, value) in now {
        let before = recorded.iter().find(|(recorded, _)| recorded == name).map(|(_, figure)| figure);
        if before.is_none_or(|before| !is_near(before, value, baseline.tolerance(name))) {
            found.push(moved(name, before, Some(value)));
        }
    }
    for (name, value) in recorded {
        if now.iter().all(|(known, _)| known != name) {
            found.push(moved(name, Some(value), None));
        }
    }
    found
}

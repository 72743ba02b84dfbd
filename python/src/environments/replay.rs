//! Episodes of an environment run again, for its pictures.

use super::lane::{STANCES, acted};
use super::rules::{Rules, Task};
use crate::episode::Cell;
use crate::error::words;
use cocarry::human::Stance;
use cocarry::scenario::{Partners, PreparedScenario};
use cocarry_recording::recording::{Ending, Recorder};
use std::io::Cursor;
use std::sync::{Arc, Mutex, PoisonError};

/// The recording of an episode that is run again by these actions.
pub(super) fn recording(
    rules: &Rules,
    period: f64,
    prepared: Arc<PreparedScenario>,
    actions: &[Vec<f64>],
) -> Result<Vec<u8>, String> {
    let next = Arc::new(Mutex::new((0, Stance::Follow)));
    let partners = Partners { human: acted(rules.task, &next, &prepared), policy: None };
    let mut cell = Cell::begin(prepared, partners, None).map_err(|error| words(&error))?;
    cell.with_dependent_mut(|prepared, running| {
        let episode = &mut running.episode;
        let file = Cursor::new(Vec::new());
        let mut recorder =
            Recorder::new(file, "the episode", prepared, episode).map_err(|error| words(&error))?;
        if actions.is_empty() && episode.step().is_none() {
            recorder.step(episode).map_err(|error| words(&error))?;
        }
        for action in actions {
            if let [_, option, stance] = action[..]
                && rules.task == Task::Both
            {
                let stance = STANCES[(stance as usize).min(STANCES.len() - 1)];
                *next.lock().unwrap_or_else(PoisonError::into_inner) = (option as usize, stance);
            }
            if episode.begin_step().is_some() {
                break;
            }
            let action: Vec<f64> = action.iter().copied().chain([period]).collect();
            let decision = rules.decision(episode, &action);
            episode.finish_step(&decision);
            recorder.step(episode).map_err(|error| words(&error))?;
        }
        let ending = episode.begin_step().map_or(Ending::Interrupted, Ending::Over);
        recorder.finish(episode, ending).map(Cursor::into_inner).map_err(|error| words(&error))
    })
}

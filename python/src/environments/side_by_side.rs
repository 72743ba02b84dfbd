//! Work for all lanes, on all threads.

use super::lane::{Lane, Note, StepResult};
use super::rules::Rules;
use super::{Lanes, in_use};
use crate::error::{ScenarioError, guarded};
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use std::iter;
use std::sync::{Mutex, PoisonError};

/// All lanes. What is asked of every one of them at once stands in their notes, next to each other.
pub(super) struct SideBySide {
    pub(super) lanes: Vec<Lane>,
    pub(super) notes: Vec<Note>,
}

impl SideBySide {
    pub(super) fn new(count: usize) -> Self {
        let lanes: Vec<_> = (0..count as u64).map(Lane::new).collect();
        Self { notes: lanes.iter().map(Lane::note).collect(), lanes }
    }
}

impl Lanes {
    /// Runs `work` for every lane and its part of the arrays, on this thread and those of the pool.
    pub(super) fn each(
        &self,
        py: Python<'_>,
        actions: &[f64],
        work: impl Fn(&Rules, usize, &mut Lane, &[f64], &mut [f64]) -> StepResult + Sync,
    ) -> PyResult<()> {
        let SideBySide { lanes, notes } = &mut *self.lock()?;
        let mut observations = self.observations.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut rewards = self.rewards.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut terminated = self.terminated.bind(py).try_readwrite().map_err(|_| in_use())?;
        let mut truncated = self.truncated.bind(py).try_readwrite().map_err(|_| in_use())?;
        let (observations, rewards) = (observations.as_slice_mut()?, rewards.as_slice_mut()?);
        let (terminated, truncated) = (terminated.as_slice_mut()?, truncated.as_slice_mut()?);
        let width = if actions.is_empty() { 0 } else { actions.len() / lanes.len() };
        let (rules, size, pool) = (&self.rules, self.size, self.pool.as_ref().map(|(pool, _)| pool));
        let threads = 1 + pool.map_or(0, rayon::ThreadPool::current_num_threads);
        let part = lanes.len().div_ceil(threads);
        let one = |(i, (lane, note), places): (usize, (&mut Lane, &mut Note), Places<'_>)| {
            let (((observation, reward), terminated), truncated) = places;
            let result = work(rules, i, lane, &actions[i * width..(i + 1) * width], observation);
            (*reward, *terminated, *truncated) = (result.reward, result.terminated, result.truncated);
            *note = lane.note();
        };
        let error = py.detach(|| {
            guarded(|| {
                let places = observations.chunks_mut(part * size).zip(rewards.chunks_mut(part));
                let flags = terminated.chunks_mut(part).zip(truncated.chunks_mut(part));
                let parts = lanes.chunks_mut(part).zip(notes.chunks_mut(part)).zip(places).zip(flags);
                let parts =
                    parts.enumerate().map(|(p, (((lanes, notes), (observations, rewards)), (t, u)))| {
                        let lanes = lanes.iter_mut().zip(notes).enumerate();
                        let places = observations.chunks_mut(size).zip(rewards).zip(t).zip(u);
                        lanes.zip(places).map(move |((i, lane), places)| (p * part + i, lane, places))
                    });
                match pool {
                    None => parts.flatten().for_each(one),
                    Some(pool) => on_all_threads(pool, parts, one),
                }
                let failed = notes.iter().position(|note| note.has_failed);
                failed.and_then(|i| lanes[i].error.take())
            })
        })?;
        error.map_or(Ok(()), |error| Err(ScenarioError::new_err(error)))
    }
}

/// A lane's places in the arrays.
type Places<'p> = (((&'p mut [f64], &'p mut f64), &'p mut bool), &'p mut bool);

/// Does `work` for the items of all parts on this thread and those of a pool. Each begins with a part of its
/// own, which its core remembers from the last time, and then helps the others from the ends of theirs.
fn on_all_threads<T, Part: DoubleEndedIterator<Item = T> + Send>(
    pool: &rayon::ThreadPool,
    parts: impl Iterator<Item = Part>,
    work: impl Fn(T) + Sync,
) {
    let parts: Vec<_> = parts.map(Mutex::new).collect();
    let take = |part: &Mutex<Part>, next: fn(&mut Part) -> Option<T>| {
        next(&mut part.lock().unwrap_or_else(PoisonError::into_inner))
    };
    let work_from = |own: usize| {
        if let Some(own) = parts.get(own) {
            iter::from_fn(|| take(own, Part::next)).for_each(&work);
        }
        for other in &parts {
            iter::from_fn(|| take(other, Part::next_back)).for_each(&work);
        }
    };
    pool.in_place_scope(|scope| {
        scope.spawn_broadcast(|_, thread| work_from(1 + thread.index()));
        work_from(0);
    });
}

//! The state of lanes as bytes, for pickles and copies in mid-episode.

use super::lane::{Lane, StepResult, acted};
use super::rules::Rules;
use crate::episode::Cell;
use crate::error::{SnapshotError, words};
use cocarry::saved::Saved;
use cocarry::scenario::{Partners, Snapshot};
use numpy::PyArrayMethods;
use pyo3::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A lane's generator and episode.
#[derive(Serialize, Deserialize)]
struct LaneState {
    seed: [u8; 32],
    /// How far the generator is in its stream, as text: CBOR has no numbers of 128 bits.
    drawn: String,
    world: usize,
    subjective: f64,
    costs: [f64; 3],
    is_over: bool,
    /// The bytes of its snapshot; none before the first reset.
    #[serde(with = "serde_bytes")]
    episode: Option<Vec<u8>>,
    observation: Vec<f64>,
    result: StepResult,
}

impl Lane {
    fn state(&self, observation: &[f64], result: StepResult) -> Result<LaneState, String> {
        let snapshot = |cell: &Cell| {
            let prepared = cell.borrow_owner();
            prepared.snapshot(&cell.borrow_dependent().episode).bytes().map_err(|error| words(&error))
        };
        Ok(LaneState {
            seed: self.rng.get_seed(),
            drawn: self.rng.get_word_pos().to_string(),
            world: self.world,
            subjective: self.subjective,
            costs: self.costs,
            is_over: self.is_over,
            episode: self.cell.as_ref().map(snapshot).transpose()?,
            observation: observation.to_vec(),
            result,
        })
    }

    fn restore(&mut self, rules: &Rules, state: &LaneState) -> Result<(), String> {
        let base = rules.bases.get(state.world).ok_or("the state has another world")?;
        self.rng = ChaCha8Rng::from_seed(state.seed);
        self.rng.set_word_pos(state.drawn.parse().map_err(|_| "the state is not valid")?);
        (self.world, self.subjective, self.costs) = (state.world, state.subjective, state.costs);
        self.is_over = state.is_over;
        let Some(bytes) = &state.episode else { return Ok(()) };
        let Snapshot { scenario, state, .. } =
            Snapshot::parse("state", bytes).map_err(|error| words(&error))?;
        let prepared = base.prepare(scenario).map_err(|error| words(&error))?;
        let partners = Partners { human: acted(rules.task, &self.human, &prepared), policy: None };
        let made = Cell::begin(Arc::new(prepared), partners, Some(state));
        let mut cell = made.map_err(|error| words(&error))?;
        cell.with_dependent_mut(|prepared, running| {
            self.bound = rules.bound(prepared);
            running.outcome = running.episode.ended().filter(|_| self.is_over);
            if rules.tells_built_in {
                self.built_in = rules.built_in(prepared, &running.episode);
            }
        });
        self.cell = Some(cell);
        Ok(())
    }
}

impl super::Lanes {
    /// The state of every lane, as bytes.
    pub(super) fn save(&self, py: Python<'_>) -> PyResult<Vec<u8>> {
        let lanes = &self.lock()?.lanes;
        let size = self.rules.numbers().len();
        let read = |index: usize, lane: &Lane| {
            let observation = self.observations.bind(py).readonly();
            let begin = index * size;
            let observation = observation.as_slice()?[begin..begin + size].to_vec();
            let result = StepResult {
                reward: self.rewards.bind(py).readonly().as_slice()?[index],
                terminated: self.terminated.bind(py).readonly().as_slice()?[index],
                truncated: self.truncated.bind(py).readonly().as_slice()?[index],
            };
            lane.state(&observation, result).map_err(SnapshotError::new_err)
        };
        let states = lanes.iter().enumerate().map(|(index, lane)| read(index, lane));
        Ok(Saved::of(&states.collect::<PyResult<Vec<_>>>()?).bytes().to_vec())
    }

    /// Restores what [`Lanes::save`](super::Lanes::save) returned.
    pub(super) fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let invalid = || SnapshotError::new_err("the state of an environment is not valid");
        let states: Vec<LaneState> = Saved::from_bytes(bytes).read("environment").map_err(|_| invalid())?;
        let count = self.lock()?.lanes.len();
        let size = self.rules.numbers().len();
        if states.len() != count || states.iter().any(|state| state.observation.len() != size) {
            return Err(invalid());
        }
        self.each(py, &[], |rules, index, lane, _, observation| {
            let state = &states[index];
            match lane.restore(rules, state) {
                Ok(()) => observation.copy_from_slice(&state.observation),
                Err(error) => lane.error = Some(error),
            }
            state.result
        })
    }
}

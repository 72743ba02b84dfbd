//! An episode under way in; all that its further steps depend on, to write down, out. With that and the same inputs it goes on.

use super::carrier::{Carrier, CarrierState};
use super::retreat::Retreat;
use super::{Episode, Manipulator, Settings, Summary, Tick};
use crate::coordination::Coordinator;
use crate::geometry::Path;
use crate::options::{OptionSet, Progress};
use crate::preference::Perception;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// An episode after so many steps, without what it borrows.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    human: Perception,
    coordinator: Coordinator,
    progress: Progress,
    path: Path,
    along: f64,
    turns_until: f64,
    tick: Tick,
    summary: Summary,
    underway: bool,
    steps_without_progress: u32,
    carrier: Option<CarrierState>,
    retreat: Retreat,
}

/// A state that belongs to another episode.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the state is one of another episode: its {part} does not belong here")]
pub struct Misfit {
    /// What does not belong.
    pub part: &'static str,
}

impl State {
    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.summary.steps
    }

    /// What does not belong to an episode with these options and this robot.
    fn misfit(&self, options: &OptionSet, has_robot: bool, is_physical: bool) -> Option<Misfit> {
        let n = options.options().len();
        let are_options = |indices: &[usize]| indices.iter().all(|&option| option < n);
        let Summary { first_option, last_option, .. } = self.summary;
        let belongs = [
            ("place", options.knows(&self.progress)),
            (
                "way",
                [self.along, self.turns_until].iter().all(|m| m.is_finite())
                    && self.path.length().is_finite()
                    && self.retreat.is_finite(),
            ),
            ("option", are_options(&[self.tick.executed, self.tick.preferred, first_option, last_option])),
            ("option", self.tick.steps_back_for.is_none_or(|option| option < n)),
            ("robot", self.carrier.is_some() == has_robot),
            ("plant", self.carrier.as_ref().is_none_or(|c| c.is_physical() == is_physical)),
        ];
        belongs.into_iter().find(|(_, belongs)| !belongs).map(|(part, _)| Misfit { part })
    }
}

impl<'a> Episode<'a> {
    /// What the episode has come to.
    pub fn state(&self) -> State {
        #[rustfmt::skip]
        let Self {
            human, coordinator, progress, path, along, turns_until, tick, summary, underway, steps_without_progress, carrier, retreat,
            // given
            options: _, settings: _, tick_limit: _, changes: _, ignores_loss: _,
            // memory, and what every step works out anew
            predictor: _, prospects: _, choice: _, expected: _, gait: _,
        } = self;
        State {
            human: *human,
            coordinator: coordinator.clone(),
            progress: progress.clone(),
            path: path.clone(),
            along: *along,
            turns_until: *turns_until,
            tick: tick.clone(),
            summary: summary.clone(),
            underway: *underway,
            steps_without_progress: *steps_without_progress,
            carrier: carrier.as_ref().map(Carrier::state),
            retreat: *retreat,
        }
    }

    /// The episode that had come to `state`: it goes on with the same bits, if options, settings and robot are the same, and changes of mind
    /// are given again ([`Episode::with_changes`]). `is_physical` says that its plant is the physical one.
    ///
    /// # Errors
    /// [`Misfit`] if they cannot be.
    pub fn resume(
        options: &'a OptionSet,
        settings: &'a Settings,
        manipulator: Option<Manipulator<'a>>,
        is_physical: bool,
        state: State,
    ) -> Result<Self, Misfit> {
        if let Some(misfit) = state.misfit(options, manipulator.is_some(), is_physical) {
            return Err(misfit);
        }
        #[rustfmt::skip]
        let State {
            human, coordinator, progress, path, along, turns_until, tick, summary, underway, steps_without_progress, carrier, retreat,
        } = state;
        let fresh = Self::new(options, settings, human);
        let (n, walk) = (options.options().len(), fresh.walk_settings());
        let carrier = manipulator.zip(carrier).map(|(m, state)| Carrier::resumed(m, walk, n, state));
        Ok(Self {
            coordinator,
            progress,
            path,
            along,
            turns_until,
            tick,
            summary,
            underway,
            steps_without_progress,
            carrier,
            retreat,
            ..fresh
        })
    }
}

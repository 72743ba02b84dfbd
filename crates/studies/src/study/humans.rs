//! The distributions of a study's humans, by name.

use super::{Study, SweepError};
use cocarry::episode::{EpisodeSettings, PreferenceChange};
use cocarry::options::OptionSet;
use cocarry::preference::{Belief, Marginal, Perception};
use cocarry::scenario::{GivenPerception, PreferenceChanges, Scenario, drawn_changes};
use std::collections::BTreeSet;

/// The source of one parameter of a human.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// Drawn from a distribution.
    Drawn(Marginal),
    /// The same for all humans.
    Fixed(f64),
}

/// A population of humans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Humans {
    pub alpha: Range,
    pub gamma: Range,
}

impl Humans {
    /// A human's preference changes: the same as `cocarry run --seed --preference-changes` draws.
    pub fn draw_changes(
        &self,
        count: PreferenceChanges,
        seed: u64,
        options: &OptionSet,
        settings: &EpisodeSettings,
    ) -> Vec<PreferenceChange> {
        drawn_changes(count, &self.belief(), self.given(), seed, options, settings)
    }

    /// Whether all of them are the same human, without a parameter to draw.
    pub fn are_one(&self) -> bool {
        self.given().is_complete()
    }

    /// The distribution of the humans: `cocarry run --seed` draws the same humans with it as the robot's
    /// belief. A fixed parameter is drawn as well, so that it does not change the draw of the other one.
    pub fn belief(&self) -> Belief {
        match Belief::default() {
            Belief::Independent { alpha, gamma } => Belief::Independent {
                alpha: self.alpha.marginal().unwrap_or(alpha),
                gamma: self.gamma.marginal().unwrap_or(gamma),
            },
            other => other,
        }
    }

    /// The parameters that all humans share.
    pub fn given(&self) -> GivenPerception {
        GivenPerception { alpha: self.alpha.fixed(), gamma: self.gamma.fixed() }
    }
}

impl Range {
    fn marginal(self) -> Option<Marginal> {
        match self {
            Self::Drawn(marginal) => Some(marginal),
            Self::Fixed(_) => None,
        }
    }

    fn fixed(self) -> Option<f64> {
        match self {
            Self::Drawn(_) => None,
            Self::Fixed(value) => Some(value),
        }
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Drawn(marginal) => marginal.fmt(f),
            Self::Fixed(value) => value.fmt(f),
        }
    }
}

impl Study {
    /// Sets `human_warnings`, by a scenario of each population of humans with a given parameter.
    pub(super) fn warn_of_humans(&mut self) -> Result<(), SweepError> {
        // of a drawn parameter, one draw says nothing about the others
        const PLAUSIBLE: f64 = 1.0;
        let mut known = BTreeSet::new();
        for i in 0..self.cells.len() {
            let humans = self.cells[i].humans;
            let GivenPerception { alpha, gamma } = self.contents.humans[humans].1.given();
            if !known.insert(humans) || alpha.or(gamma).is_none() {
                continue;
            }
            let human = Perception { alpha: alpha.unwrap_or(PLAUSIBLE), gamma: gamma.unwrap_or(PLAUSIBLE) };
            let scenario = Scenario { human, ..self.scenario_of(i, 0) };
            let made = self.prepared[self.prepared_of[i]].prepare(scenario);
            let made = made.map_err(|source| self.refused(i, source))?;
            let slow = made.slow_drive().map(ToString::to_string);
            let others: Vec<String> = slow.into_iter().chain(made.robot_warnings()).collect();
            let new = made.warnings().into_iter().filter(|warning| !others.contains(warning));
            for warning in new {
                if !self.human_warnings.contains(&warning) {
                    self.human_warnings.push(warning);
                }
            }
        }
        Ok(())
    }
}

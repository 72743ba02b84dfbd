//! The path that the team is on, and how it comes onto another.
//!
//! DEVIATION (eq. 3): a point turns on the spot, as soon as another option is preferred. A team whose bodies have come too near to an opening to
//! turn away from it reverses on its own path first, and then turns.

use super::Team;
use crate::geometry::{Path, Point};
use crate::options::{OptionSet, Progress};
use serde::{Deserialize, Serialize};

/// So far (m) beyond where it means to turn, a team gives up reversing.
const OVERSHOOT_M: f64 = 0.1;

/// The path under way and the team's place on it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Route {
    /// From where the option was chosen to the target; empty before the first step.
    pub path: Path,
    /// How far along it the team is, m.
    pub along: f64,
    /// Until it is so far along it (m), it is turning onto it.
    turns_until: f64,
    /// Which way the team goes in this step.
    pub travel: Travel,
    reversing: Reversing,
}

/// The direction of travel along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Travel {
    /// Toward the path's end.
    #[default]
    Forward,
    /// Back to where there is room to turn. The leader announces the reversal.
    Backward,
}

/// Whether a team reverses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Reversing {
    /// It does not.
    #[default]
    No,
    /// To this place along the path under way, m.
    To(f64),
    /// It did, and there was no room after all: not again on this path.
    InVain,
}

/// What came of a wish to turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnOutcome {
    /// The team is on the new path.
    Turned,
    /// It reverses to where there is room.
    Reverses,
    /// It goes on, for now.
    GoesOn,
}

impl Route {
    /// The first path.
    pub fn begin(&mut self, path: Path) {
        self.path = path;
    }

    /// Keeps to the path under way, forward.
    pub fn keep(&mut self) {
        self.travel = Travel::Forward;
        if let Reversing::To(_) = self.reversing {
            self.reversing = Reversing::No;
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let reversing = match self.reversing {
            Reversing::To(place) => place.is_finite(),
            Reversing::No | Reversing::InVain => true,
        };
        reversing && self.along.is_finite() && self.turns_until.is_finite() && self.path.length().is_finite()
    }

    /// Turns onto `option`, now or as soon as there is room. A path under way is walked on as it is until then.
    pub fn turn_onto(
        &mut self,
        option: usize,
        team: &mut dyn Team,
        options: &OptionSet,
        progress: &Progress,
    ) -> TurnOutcome {
        self.travel = Travel::Forward;
        if self.along < self.turns_until {
            return TurnOutcome::GoesOn;
        }
        let next = options.path(progress, option).unwrap_or_default();
        match team.turn(&self.path, self.along, next, options) {
            Some(turned) => {
                *self = Self { path: turned.path, turns_until: turned.until, ..Self::default() };
                TurnOutcome::Turned
            }
            None => self.reverse(option, team, options, progress),
        }
    }

    /// There is no room to turn onto an option here: the team reverses to where there is, if going on leads through an opening before.
    fn reverse(
        &mut self,
        option: usize,
        team: &dyn Team,
        options: &OptionSet,
        progress: &Progress,
    ) -> TurnOutcome {
        if self.reversing == Reversing::No {
            let next = |from: Point| {
                let mut progress = progress.clone();
                options.advance(&mut progress, from);
                options.path(&progress, option).unwrap_or_default()
            };
            let place = team.place_to_turn(&self.path, [self.turns_until, self.along], &next, options);
            self.reversing = place.map_or(Reversing::No, Reversing::To);
        }
        match self.reversing {
            Reversing::To(place) if self.along < place - OVERSHOOT_M => {
                self.reversing = Reversing::InVain;
                TurnOutcome::GoesOn
            }
            Reversing::To(_) => {
                self.travel = Travel::Backward;
                TurnOutcome::Reverses
            }
            Reversing::No | Reversing::InVain => TurnOutcome::GoesOn,
        }
    }
}

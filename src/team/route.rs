//! The path of the team, and its change onto another path.
//!
//! DEVIATION (eq. 3): a point turns on the spot as soon as another option is preferred. A team whose bodies
//! are too close to an opening to turn away from it first reverses on its own path, and then turns.

use super::{Travel, Turned, Walk};
use crate::geometry::{Path, Point};
use crate::options::{OptionSet, Progress};
use serde::{Deserialize, Serialize};

/// Distance (m) beyond the place to turn at which a team gives up reversing.
const OVERSHOOT_M: f64 = 0.1;

/// The present path and the team's position on it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Route {
    /// The path from where the option was chosen to the target; empty before the first step.
    pub path: Path,
    /// The team's position along it, m.
    pub along: f64,
    /// The position (m) at which the team has completed its turn onto the path.
    turns_until: f64,
    /// The team's direction of travel in this step.
    pub travel: Travel,
    reversing: Reversing,
}

/// The state of reversing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Reversing {
    /// The team does not reverse.
    #[default]
    No,
    /// It reverses to this position along the present path, m.
    To(f64),
    /// It reversed and did not turn: it found no room, or another decision came first. It does not try again
    /// on this path. As it reverses, the decision may change, and change back as it goes on.
    InVain,
}

/// The outcome of an attempt to turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnOutcome {
    /// The team is on the new path.
    Turned,
    /// The team reverses to a place with room to turn.
    Reverses,
    /// The team continues for now.
    GoesOn,
}

impl Route {
    /// Starts on the way onto the first path.
    pub fn begin(&mut self, turned: Turned) {
        (self.path, self.turns_until) = (turned.path, turned.until);
    }

    /// Continues forward on the present path.
    pub fn keep(&mut self) {
        self.travel = Travel::Forward;
        self.give_up_reversing();
    }

    fn give_up_reversing(&mut self) {
        if let Reversing::To(_) = self.reversing {
            self.reversing = Reversing::InVain;
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

    /// Turns onto `option`, at once or as soon as there is room. Until then the team stays on its present
    /// path.
    pub fn turn_onto(
        &mut self,
        option: usize,
        walk: &mut dyn Walk,
        options: &OptionSet,
        progress: &Progress,
    ) -> TurnOutcome {
        self.travel = Travel::Forward;
        if self.along < self.turns_until {
            self.give_up_reversing();
            return TurnOutcome::GoesOn;
        }
        let next = options.path_passing(progress, option, walk.passing()).unwrap_or_default();
        match walk.turn(&self.path, self.along, next) {
            Some(turned) => {
                *self = Self { path: turned.path, turns_until: turned.until, ..Self::default() };
                TurnOutcome::Turned
            }
            None => self.reverse(option, walk, options, progress),
        }
    }

    /// Where there is no room to turn onto an option: lets the team reverse to a place with room, if its path
    /// leads through an opening before the next such place.
    fn reverse(
        &mut self,
        option: usize,
        walk: &dyn Walk,
        options: &OptionSet,
        progress: &Progress,
    ) -> TurnOutcome {
        if self.reversing == Reversing::No {
            let next = |from: Point| {
                let mut progress = progress.clone();
                options.advance(&mut progress, from);
                options.path_passing(&progress, option, walk.passing()).unwrap_or_default()
            };
            let place = walk.place_to_turn(&self.path, [self.turns_until, self.along], &next);
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

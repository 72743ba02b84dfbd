//! A turn for which there is no room in; whether the team steps back to where there is, out.
//!
//! DEVIATION (eq. 3): a point turns on the spot, as soon as another option is preferred. A team whose bodies have come too near to an opening to
//! turn away from it steps back on its own way first, and then turns.

use super::Episode;
use super::team::Gait;
use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// So far (m) beyond where it means to turn, a team gives up stepping back.
const OVERSHOT: f64 = 0.1;

/// Whether a team steps back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Retreat {
    /// It does not.
    None,
    /// To so far along the path under way, m.
    To(f64),
    /// It did, and there was no room after all: not again on this path.
    InVain,
}

impl Retreat {
    /// Whether it leads anywhere.
    pub fn is_finite(&self) -> bool {
        !matches!(self, Self::To(place) if !place.is_finite())
    }

    /// The team goes on with the option that it is on.
    pub fn call_off(&mut self) {
        if let Self::To(_) = self {
            *self = Self::None;
        }
    }
}

impl Episode<'_> {
    /// There is no room to turn onto an option here: the team steps back to where there is, if going on leads through an opening before.
    pub(super) fn step_back(&mut self, option: usize) {
        if self.retreat == Retreat::None {
            self.retreat = self.place_behind(option).map_or(Retreat::None, Retreat::To);
        }
        match self.retreat {
            Retreat::To(place) if self.along < place - OVERSHOT => self.retreat = Retreat::InVain,
            Retreat::To(_) => {
                self.gait = Gait::Backward;
                self.tick.steps_back_for = Some(option);
            }
            Retreat::None | Retreat::InVain => {}
        }
    }

    fn place_behind(&self, option: usize) -> Option<f64> {
        let next = |from: Point| {
            let mut progress = self.progress.clone();
            self.options.advance(&mut progress, from);
            self.options.path(&progress, option).unwrap_or_default()
        };
        let from = [self.turns_until, self.along];
        self.carrier.as_ref()?.place_behind(&self.path, from, next, self.options)
    }
}

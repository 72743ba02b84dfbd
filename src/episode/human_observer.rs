//! Observations of the human in an episode: the same that the robot of `--belief learn` makes.

use super::Episode;
use super::evaluated::prospect;
use super::learn::is_consistent;
use crate::coordination::{Mode, misalignment};
use crate::human::Stance;
use crate::learning::{Learner, LearningError, LearningSettings};
use crate::preference::{Belief, Prospect, Ways};

/// Where a human who leads is seen to go.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// The options at this place.
    pub prospects: Vec<Prospect>,
    /// Which of them have become one way.
    pub ways: Ways,
    /// Whether a human on each option would walk as this human does.
    pub is_consistent: Vec<bool>,
}

/// The observations of an episode.
#[derive(Clone, Debug)]
pub struct HumanObserver {
    sightings: Vec<Sighting>,
    /// Says which steps are sightings, and what taking over says about eta.
    learner: Learner,
    /// Mode in the step before.
    mode: Option<Mode>,
}

impl HumanObserver {
    /// An observer that has seen nothing yet; `initial_stubbornness` is phi(0) of the episode.
    ///
    /// # Errors
    /// [`LearningError`]: the settings are out of range.
    pub fn new(settings: LearningSettings, initial_stubbornness: f64) -> Result<Self, LearningError> {
        let learner = Learner::new(settings, Belief::default(), 0.0, initial_stubbornness)?;
        Ok(Self { sightings: Vec::new(), learner, mode: None })
    }

    /// Sees the step that the episode has just taken.
    pub fn observe(&mut self, episode: &Episode) {
        let tick = episode.tick();
        let Some((human, decision)) = episode.decided() else { return };
        let was_led = self.mode.replace(tick.mode) == Some(Mode::RobotLed);
        if was_led {
            self.learner.observe_led_step(misalignment(&tick.options), human.stance == Stance::TakeOver);
        }
        let Some(is_consistent) = is_consistent(tick, decision.lead) else { return };
        let is_sighting = self.learner.is_sighting();
        let is_consistent: Vec<bool> = is_consistent.collect();
        let prospects: Vec<Prospect> = tick.options.iter().map(|o| prospect(o.remaining)).collect();
        // only the count of steps matters: this learner's alpha and gamma are not used
        drop(self.learner.observe_walk(&prospects, &Ways::default(), is_consistent.iter().copied()));
        if is_sighting {
            self.sightings.push(Sighting { prospects, ways: episode.ways().clone(), is_consistent });
        }
    }

    /// The sightings so far.
    pub fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// The eta that agree with when the human took over, or did not; from 0 to infinity if the robot never
    /// led.
    pub fn etas(&self) -> [f64; 2] {
        self.learner.tolerance().tasks().last().copied().unwrap_or([0.0, f64::INFINITY])
    }
}

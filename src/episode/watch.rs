//! What can be seen of the human in an episode: the same as the robot of `--belief learn` sees.

use super::Episode;
use super::evaluated::prospect;
use super::learn::looks_like;
use crate::coordination::{Mode, misalignment};
use crate::human::Stance;
use crate::learning::{Learner, LearningError, Settings};
use crate::preference::{Belief, Prospect, Ways};

/// A look at a human who leads.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The options at this place.
    pub prospects: Vec<Prospect>,
    /// Which of them have become one way.
    pub ways: Ways,
    /// Whether a human on each option would walk as this human does.
    pub looks_like: Vec<bool>,
}

/// What was seen over an episode.
#[derive(Clone, Debug)]
pub struct Watch {
    looks: Vec<Look>,
    /// It says when to look, and what taking over says of eta.
    learner: Learner,
    /// Mode in the step before.
    mode: Option<Mode>,
}

impl Watch {
    /// Nothing is seen yet. phi(0) is that of the episode.
    ///
    /// # Errors
    /// [`LearningError`]: phi(0) or the settings are out of range.
    pub fn new(settings: Settings, initial_stubbornness: f64) -> Result<Self, LearningError> {
        let learner = Learner::new(settings, Belief::default(), 0.0, initial_stubbornness)?;
        Ok(Self { looks: Vec::new(), learner, mode: None })
    }

    /// Sees the step that the episode has just taken.
    pub fn see(&mut self, episode: &Episode) {
        let tick = episode.tick();
        let Some((human, decision)) = episode.decided() else { return };
        let was_led = self.mode.replace(tick.mode) == Some(Mode::RobotLed);
        if was_led {
            self.learner.see_led_step(misalignment(&tick.options), human.stance == Stance::TakeOver);
        }
        let Some(looks_like) = looks_like(tick, decision.lead) else { return };
        let is_look = self.learner.is_look();
        let looks_like: Vec<bool> = looks_like.collect();
        let prospects: Vec<Prospect> = tick.options.iter().map(|o| prospect(o.remaining)).collect();
        // only the count of steps matters: this learner's alpha and gamma are not used
        drop(self.learner.see_walk(&prospects, &Ways::default(), looks_like.iter().copied()));
        if is_look {
            self.looks.push(Look { prospects, ways: episode.ways().clone(), looks_like });
        }
    }

    /// The looks so far.
    pub fn looks(&self) -> &[Look] {
        &self.looks
    }

    /// The eta that agree with when the human took over, or did not; from 0 to infinity if the robot never
    /// led.
    pub fn etas(&self) -> [f64; 2] {
        self.learner.tolerance().tasks().last().copied().unwrap_or([0.0, f64::INFINITY])
    }
}

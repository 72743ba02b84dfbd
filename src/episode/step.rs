//! The loop: the paper's algorithm, one planning step at a time. Every value is computed once and passed on.
//!
//! [`Episode::step`] is the whole loop. Callers that look at the episode within a step call its parts in this
//! order: [`Episode::begin_step`], [`Episode::lead_step`], and [`Episode::carry_period`] until it returns false
//! (the last two are in `carry.rs`).

use super::evaluated::{Evaluated, Predicted};
use super::now::Now;
use super::{Episode, Outcome};
use crate::human::HumanDecision;
use crate::policy::Decision;

/// A step that has begun: its values before the robot's policy decides.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    /// D_o, S_o and J_o of every option.
    pub evaluated: Evaluated,
    /// P_o and J~_o of every option.
    pub predicted: Predicted,
    /// The human's option, stance, g(k) and phi(k).
    pub human: HumanDecision,
    /// phi(k) as the robot takes it: with what it has learned, if it learns.
    pub stubbornness: f64,
}

impl Episode<'_> {
    /// Takes one planning step. Returns the outcome once the episode has ended.
    pub fn step(&mut self) -> Option<Outcome> {
        let ended = self.begin_step();
        if ended.is_none() {
            let lead = self.ask_policy(); //                            mode, o*(k)         eq. (6)
            self.finish_step(&lead);
        }
        ended
    }

    /// Takes the first part of a step, up to the human's decision. Then the policy, or a caller in its place,
    /// decides by [`Episode::robot_view`]. Returns the outcome once the episode has ended. Does nothing if
    /// the step has begun.
    pub fn begin_step(&mut self) -> Option<Outcome> {
        if self.begun.is_some() || self.carried.is_some() {
            return None;
        }
        if let Some(outcome) = self.ended() {
            self.summary.outcome = outcome;
            return Some(outcome);
        }
        self.learn_from_walk();
        self.begun = Some(self.begin(self.now()));
        None
    }

    /// The values of a step before the robot's policy decides.
    pub(super) fn begin(&mut self, now: Now) -> Begun {
        let memory = std::mem::take(&mut self.memory);
        let (evaluated, predicted) = self.evaluate(now, memory); //        D_o, S_o, J_o, P_o, J~_o   eq. (1), (4), (6)
        let human = self.ask_human(now, &evaluated, &predicted.prior); //  o_h, g(k), phi(k)   eq. (3), (5)
        let stubbornness = self.learn_from_lead(now, &human, &predicted.prior);
        Begun { evaluated, predicted, human, stubbornness }
    }

    /// Takes the second part of a step that has begun, by the decision `lead`, or the rest of one that is
    /// being carried out. Does nothing if no step has begun.
    pub fn finish_step(&mut self, lead: &Decision) {
        let mut led = self.led(lead); //                                   the path
        let Some(carried) = &mut led else {
            while self.carry_period() {}
            return;
        };
        while self.carry_on(carried) {} //                                 q*, u, x            eq. (8), (7)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::EpisodeSettings;
    use crate::options::OptionSet;
    use crate::preference::Perception;
    use crate::world::{BUILT_IN_WORLDS, World};

    #[test]
    fn a_step_is_the_same_at_once_by_periods_and_finished_after_some_of_them() {
        let world = World::parse(BUILT_IN_WORLDS[0].name, BUILT_IN_WORLDS[0].text).unwrap();
        let options = OptionSet::new(&world, 10.0).unwrap();
        let settings = EpisodeSettings { control_period: Some(0.05), ..EpisodeSettings::default() };
        let count = settings.control_periods().unwrap();
        assert!(count > 2, "{count}");
        let begin = || Episode::new(&options, &settings, Perception { alpha: 0.7, gamma: 0.8 });
        let [mut at_once, mut parted] = [begin(), begin()];
        for k in 0..40 {
            assert_eq!(at_once.step(), None);
            assert_eq!(parted.begin_step(), None);
            let lead = parted.ask_policy();
            parted.lead_step(&lead);
            (0..k % (count + 1)).for_each(|_| _ = parted.carry_period());
            parted.finish_step(&lead);
            assert_eq!(parted.state().digest(), at_once.state().digest(), "step {k}");
            assert_eq!(parted.summary().steps, k as u64 + 1);
        }
    }
}

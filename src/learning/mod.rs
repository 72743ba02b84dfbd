//! The robot learns who it carries with: alpha, gamma and eta of one human, from what the human does.
//!
//! The model and its assumptions are in the book, `book/src/learning.md`.

mod tolerance;

pub use tolerance::{MAX_TASKS, Tolerance, TolerancePrior, discomfort_limit, eta_interval, standard_normal};

use crate::error::Error;
use crate::preference::{
    Belief, ChoiceDistribution, Learned, MAX_LAPSE_RATE, Perception, Posterior, Prospect, Ways,
};
use serde::{Deserialize, Serialize};

/// How the robot learns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LearningSettings {
    /// The probability that a sighting of the human, or a time of taking over, says nothing about this human.
    pub lapse_rate: f64,
    /// The probability, before every sighting, that alpha and gamma have changed.
    pub change_rate: f64,
    /// Number of steps under the human's lead from one sighting to the next.
    pub look_steps: u32,
    /// The prior of eta.
    pub tolerance: TolerancePrior,
}

impl Default for LearningSettings {
    fn default() -> Self {
        Self { lapse_rate: 0.02, change_rate: 0.001, look_steps: 10, tolerance: TolerancePrior::default() }
    }
}

/// A number of the settings that is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value}: it must be {expected}")]
pub struct LearningError {
    /// Its key.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// The values allowed.
    pub expected: &'static str,
}

impl From<LearningError> for Error {
    fn from(error: LearningError) -> Self {
        Self::new(error.to_string())
    }
}

fn check_rate(name: &'static str, value: f64) -> Result<(), LearningError> {
    match (0.0..=MAX_LAPSE_RATE).contains(&value) {
        true => Ok(()),
        false => Err(LearningError { name, value, expected: "at least 0 and at most 0.5" }),
    }
}

/// The likelihoods of a sighting if the human prefers each option: `is_consistent` says whether a human on it
/// would have moved so. A lapse is as likely as the share of options that are consistent.
pub fn likelihoods_of_sighting(
    is_consistent: impl Iterator<Item = bool>,
    lapse_rate: f64,
    likelihoods: &mut Vec<f64>,
) {
    likelihoods.clear();
    likelihoods.extend(is_consistent.map(|is| f64::from(u8::from(is))));
    let share = likelihoods.iter().sum::<f64>() / likelihoods.len() as f64;
    for likelihood in likelihoods {
        *likelihood = (1.0 - lapse_rate) * *likelihood + lapse_rate * share;
    }
}

impl LearningSettings {
    /// The least change rate: with it, the belief stays exact however often the human contradicts it.
    pub const MIN_CHANGE_RATE: f64 = 1e-4;

    /// The settings of a robot whose belief has this lapse rate. A belief without lapses says nothing about
    /// the rate.
    pub(crate) fn assuming(self, lapse_rate: f64) -> Self {
        if lapse_rate > 0.0 { Self { lapse_rate, ..self } } else { self }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`LearningError`], which names the first one out of its range.
    pub fn check(&self) -> Result<(), LearningError> {
        Tolerance::new(self.tolerance, self.lapse_rate)?;
        check_rate("change_rate", self.change_rate)?;
        if self.change_rate < Self::MIN_CHANGE_RATE {
            let (name, value) = ("change_rate", self.change_rate);
            return Err(LearningError { name, value, expected: "at least 0.0001 and at most 0.5" });
        }
        match self.look_steps {
            0 => Err(LearningError { name: "look_steps", value: 0.0, expected: "at least 1" }),
            _ => Ok(()),
        }
    }
}

/// The robot's belief about the human that it carries with, over one task or several.
#[derive(Clone, Debug)]
pub struct Learner {
    settings: LearningSettings,
    perception: Posterior,
    tolerance: Tolerance,
    /// ln(1 / phi(0)), and phi(0).
    limit: f64,
    initial_stubbornness: f64,
    /// g of the present task.
    discomfort: f64,
    has_taken_over: bool,
    /// Steps under the human's lead since the last sighting.
    steps_since_look: Option<u32>,
    likelihoods: Vec<f64>,
}

/// The state of a [`Learner`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnerState {
    perception: Learned,
    tasks: Vec<[f64; 2]>,
    discomfort: f64,
    has_taken_over: bool,
    steps_since_look: Option<u32>,
}

impl Learner {
    /// A robot that knows only `belief` and the prior of eta about the human. `risk_weight` is c_r (m),
    /// `initial_stubbornness` phi(0). The first task has begun.
    ///
    /// # Errors
    /// [`LearningError`]: a number of `settings`, or `risk_weight`, is out of its range.
    pub fn new(
        settings: LearningSettings,
        belief: Belief,
        risk_weight: f64,
        initial_stubbornness: f64,
    ) -> Result<Self, LearningError> {
        settings.check()?;
        let risk =
            |_| LearningError { name: "risk_weight_m", value: risk_weight, expected: "finite, at least 0" };
        let mut learner = Self {
            settings,
            perception: Posterior::new(belief, risk_weight).map_err(risk)?,
            tolerance: Tolerance::new(settings.tolerance, settings.lapse_rate)?,
            limit: discomfort_limit(initial_stubbornness),
            initial_stubbornness,
            discomfort: 0.0,
            has_taken_over: false,
            steps_since_look: None,
            likelihoods: Vec::new(),
        };
        learner.begin_task();
        Ok(learner)
    }

    /// Begins the next task with the same human.
    pub fn begin_task(&mut self) {
        (self.discomfort, self.has_taken_over, self.steps_since_look) = (0.0, false, None);
        self.tolerance.begin_task();
        self.tolerance.set_task([0.0, f64::INFINITY]);
    }

    /// A step under the robot's lead in which discomfort grows by `misaligned`, the sum of omega_o P_o of eq.
    /// (5), and the human takes over or not.
    pub fn observe_led_step(&mut self, misaligned: f64, takes_over: bool) {
        let before = self.discomfort;
        self.discomfort += misaligned;
        // phi(0) = 1: the first discomfort is enough for everybody
        if self.has_taken_over || self.limit <= 0.0 {
            return;
        }
        self.has_taken_over = takes_over;
        let says = match takes_over {
            // discomfort that did not grow explains no taking over
            true if self.discomfort > before => eta_interval(before, Some(self.discomfort), self.limit),
            true => return,
            false => eta_interval(self.discomfort, None, self.limit),
        };
        self.tolerance.set_task(says);
    }

    /// Whether a step under the human's lead, about to be reported, is a sighting.
    pub fn is_sighting(&self) -> bool {
        self.steps_since_look.is_none_or(|steps| steps + 1 >= self.settings.look_steps)
    }

    /// A step under the human's lead, from where the options were `prospects` with these `ways`.
    /// `is_consistent` says for each option whether a human on it would have moved as this human did.
    ///
    /// # Errors
    /// The human's action is impossible under the belief, which needs a lapse rate of 0.
    pub fn observe_walk(
        &mut self,
        prospects: &[Prospect],
        ways: &Ways,
        is_consistent: impl Iterator<Item = bool>,
    ) -> Result<(), Error> {
        if !self.is_sighting() {
            self.steps_since_look = self.steps_since_look.map(|steps| steps + 1);
            return Ok(());
        }
        self.steps_since_look = Some(0);
        self.observe_sighting(prospects, ways, is_consistent)
    }

    /// The human's answer: the option that the human would choose.
    ///
    /// # Errors
    /// As [`Learner::observe_walk`].
    pub fn observe_answer(
        &mut self,
        prospects: &[Prospect],
        ways: &Ways,
        option: usize,
    ) -> Result<(), Error> {
        let chosen = ways.representative(option);
        self.observe_sighting(prospects, ways, (0..prospects.len()).map(|o| ways.representative(o) == chosen))
    }

    /// A sighting of the human, at any step; otherwise as [`Learner::observe_walk`].
    ///
    /// # Errors
    /// As [`Learner::observe_walk`].
    pub fn observe_sighting(
        &mut self,
        prospects: &[Prospect],
        ways: &Ways,
        is_consistent: impl Iterator<Item = bool>,
    ) -> Result<(), Error> {
        likelihoods_of_sighting(is_consistent, self.settings.lapse_rate, &mut self.likelihoods);
        self.perception.mix_with_prior(self.settings.change_rate)?;
        self.perception.observe(prospects, ways, &self.likelihoods).map(drop)
    }

    /// P_o over what was learned.
    pub fn predict(&mut self, prospects: &[Prospect], ways: &Ways, choice: &mut ChoiceDistribution) {
        self.perception.predict_from(prospects, ways, choice);
    }

    /// J~_o over what was learned.
    pub fn expected_costs(&mut self, prospects: &[Prospect], costs: &mut Vec<f64>) {
        self.perception.expected_costs(prospects, costs);
    }

    /// The mean of phi(k), limited to 1, over what was learned about eta.
    pub fn stubbornness(&self) -> f64 {
        match self.has_taken_over {
            true => 1.0,
            false => self.tolerance.expected_stubbornness(self.initial_stubbornness, self.discomfort),
        }
    }

    /// The belief over alpha and gamma.
    pub fn perception(&self) -> &Posterior {
        &self.perception
    }

    /// The same, to compute figures of it.
    pub fn perception_mut(&mut self) -> &mut Posterior {
        &mut self.perception
    }

    /// The belief over eta.
    pub fn tolerance(&self) -> &Tolerance {
        &self.tolerance
    }

    /// The density of a human relative to the prior's.
    pub fn density(&self, perception: Perception) -> f64 {
        self.perception.density(perception)
    }

    /// The belief about alpha, gamma and eta, for [`Learner::restore`].
    pub fn state(&self) -> LearnerState {
        LearnerState {
            perception: self.perception.learned(),
            tasks: self.tolerance.tasks().to_vec(),
            discomfort: self.discomfort,
            has_taken_over: self.has_taken_over,
            steps_since_look: self.steps_since_look,
        }
    }

    /// Takes over what a learner with the same settings has learned. False if it does not fit.
    pub fn restore(&mut self, state: &LearnerState) -> bool {
        let fits = state.discomfort.is_finite()
            && !state.tasks.is_empty()
            && self.tolerance.restore(&state.tasks)
            && self.perception.restore(&state.perception);
        if fits {
            self.discomfort = state.discomfort;
            self.has_taken_over = state.has_taken_over;
            self.steps_since_look = state.steps_since_look;
        }
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::human_choice;

    const PROSPECTS: [Prospect; 4] = [
        Prospect::new(41.86, 0.66),
        Prospect::new(17.4, 0.363),
        Prospect::new(14.33, 0.547),
        Prospect::new(21.36, 0.247),
    ];

    fn learner() -> Learner {
        Learner::new(LearningSettings::default(), Belief::default(), 10.0, 0.1).unwrap()
    }

    #[test]
    fn closed_form_one_answer_is_bayes_rule_on_the_regions() {
        let (mut learner, mut before, mut after) =
            (learner(), ChoiceDistribution::default(), Default::default());
        learner.predict(&PROSPECTS, &Ways::default(), &mut before);
        learner.observe_answer(&PROSPECTS, &Ways::default(), 2).unwrap();
        learner.predict(&PROSPECTS, &Ways::default(), &mut after);
        let likelihood = |option| if option == 2 { 0.985 } else { 0.005 };
        let weights: Vec<f64> =
            before.probabilities().iter().enumerate().map(|(o, p)| p * likelihood(o)).collect();
        let wanted = ChoiceDistribution::from_weights(&weights).unwrap();
        for (found, wanted) in ChoiceDistribution::probabilities(&after).iter().zip(wanted.probabilities()) {
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }

    #[test]
    fn closed_form_a_sighting_of_what_all_options_share_says_nothing() {
        let mut learner = learner();
        learner.observe_walk(&PROSPECTS, &Ways::default(), [true; 4].into_iter()).unwrap();
        assert!(learner.perception_mut().estimate().information < 1e-9);
    }

    #[test]
    fn sightings_are_every_ten_steps() {
        let mut learner = learner();
        let mut sightings = Vec::new();
        for step in 0..25 {
            if learner.is_sighting() {
                sightings.push(step);
            }
            learner
                .observe_walk(&PROSPECTS, &Ways::default(), [false, true, true, false].into_iter())
                .unwrap();
        }
        assert_eq!(sightings, [0, 10, 20]);
    }

    #[test]
    fn closed_form_taking_over_bounds_eta_by_eq_5() {
        let mut learner = learner();
        for step in 0..=30 {
            learner.observe_led_step(0.7, step == 30);
        }
        let limit = discomfort_limit(0.1);
        let wanted = [21.0 / limit, 21.7 / limit];
        let found = learner.tolerance().tasks()[0];
        assert!((found[0] - wanted[0]).abs() < 1e-9 && (found[1] - wanted[1]).abs() < 1e-9, "{found:?}");
        assert_eq!(learner.stubbornness(), 1.0);
        // the next task: the human takes over at about the same discomfort
        learner.begin_task();
        assert!((learner.stubbornness() - 0.1).abs() < 1e-12);
        for _ in 0..29 {
            learner.observe_led_step(0.7, false);
        }
        let phi = 0.1 * crate::math::exp(20.3 / (21.35 / limit));
        assert!((learner.stubbornness() - phi).abs() < 0.02, "{} {phi}", learner.stubbornness());
    }

    #[test]
    fn a_human_who_changes_their_mind_is_followed() {
        let mut learner = learner();
        let humans = [(0.93, 0.55), (0.57, 1.05)].map(|(alpha, gamma)| Perception { alpha, gamma });
        let wants = humans.map(|human| human_choice(&PROSPECTS, 10.0, human, None));
        assert_ne!(wants[0], wants[1]);
        let mut choice = ChoiceDistribution::default();
        for option in wants {
            for _ in 0..8 {
                learner.observe_answer(&PROSPECTS, &Ways::default(), option).unwrap();
            }
            learner.predict(&PROSPECTS, &Ways::default(), &mut choice);
            assert!(choice.probabilities()[option] > 0.9, "{choice:?}");
        }
    }

    #[test]
    fn a_restored_learner_goes_on_with_the_same_bits() {
        let mut learner = learner();
        learner.observe_led_step(3.0, false);
        learner.observe_answer(&PROSPECTS, &Ways::default(), 3).unwrap();
        let mut restored = self::learner();
        assert!(restored.restore(&learner.state()));
        for learner in [&mut learner, &mut restored] {
            learner.observe_led_step(3.0, true);
            learner.observe_answer(&PROSPECTS, &Ways::default(), 1).unwrap();
        }
        assert_eq!(learner.state(), restored.state());
    }

    #[test]
    fn closed_form_bad_settings_are_refused_by_their_name() {
        let refused = |settings: LearningSettings| settings.check().unwrap_err().to_string();
        let fine = LearningSettings::default();
        assert!(refused(LearningSettings { lapse_rate: 0.6, ..fine }).starts_with("lapse_rate = 0.6"));
        assert!(refused(LearningSettings { change_rate: 0.0, ..fine }).contains("at least 0.0001"));
        assert!(refused(LearningSettings { look_steps: 0, ..fine }).starts_with("look_steps"));
        assert!(
            Learner::new(fine, Belief::default(), -1.0, 0.1)
                .unwrap_err()
                .to_string()
                .contains("risk_weight_m")
        );
    }
}

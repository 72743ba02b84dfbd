//! Warnings about a scenario, known before its episode.

use super::PreparedScenario;
use crate::preference::Perception;

/// alpha and gamma that experiments report for people, about: beyond them, a digit is probably mistyped.
const PLAUSIBLE: [f64; 2] = [0.2, 2.0];

impl PreparedScenario {
    /// Sentences about what a user may not have meant: alpha and gamma that no experiment found, a robot that
    /// is slower than the walk, and those of [`PreparedScenario::robot_warnings`].
    pub fn warnings(&self) -> Vec<String> {
        let Perception { alpha, gamma } = self.scenario().human;
        let [least, most] = PLAUSIBLE;
        let odd = [("alpha", alpha), ("gamma", gamma)];
        let odd = odd.into_iter().filter(|(_, value)| !(least..=most).contains(value));
        let odd = odd.map(|(name, value)| {
            format!("{name} = {value}: experiments find values from {least} to {most} for people")
        });
        odd.chain(self.slow_drive().map(|slow| slow.to_string())).chain(self.robot_warnings()).collect()
    }
}

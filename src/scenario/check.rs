//! The check of a scenario's numbers against the table of settings.

use super::{BELIEF_RATIONALITY, PERCEPTION, SETTINGS, Scenario, ScenarioError};
use crate::episode::PreferenceChange;
use crate::preference::Perception;

impl Scenario {
    /// Checks every number that parsing does not check.
    ///
    /// # Errors
    /// [`ScenarioError::Number`] or [`ScenarioError::Physics`], which names the key and the value.
    pub fn check(&self) -> Result<(), ScenarioError> {
        let bad = |key: String, value, expected: String| Err(ScenarioError::Number { key, value, expected });
        if let Some((key, value)) = bad_perception(&self.human) {
            return bad(format!("human.{key}"), value, PERCEPTION.to_string());
        }
        for setting in SETTINGS {
            if let Some(value) = setting.number_out_of_range(self) {
                return bad(setting.path.to_owned(), value, setting.expected());
            }
        }
        if let Some(value) =
            self.settings.predictor.rationality().filter(|_| self.settings.learning.is_some())
        {
            // the density of what is learned is constant on the regions of eq. (3)
            let expected = "left out, because this robot learns (belief_update = \"learn\"), which it does of humans who prefer the least cost";
            return bad(BELIEF_RATIONALITY.path.to_owned(), value, expected.to_owned());
        }
        self.check_control_period()?;
        if let Some(Err(e)) = self.settings.learning.map(|learning| learning.check()) {
            let key = format!("settings.learning.{}", e.name);
            return bad(key, e.value, e.expected.to_owned());
        }
        for (i, PreferenceChange { step, perception }) in self.changes.iter().enumerate() {
            if let Some((key, value)) = bad_perception(perception) {
                let key = format!("change {}, at step {step}: {key}", i + 1);
                return bad(key, value, PERCEPTION.to_string());
            }
        }
        Ok(self.plant.physics().map_or(Ok(()), |physics| physics.check())?)
    }
}

impl Scenario {
    /// The control period divides the planning step and is no shorter than a physics step.
    fn check_control_period(&self) -> Result<(), ScenarioError> {
        let (step, value) = (self.settings.planning_step, self.settings.control_period());
        let shortest = self.plant.physics().map_or(0.0, |physics| physics.step());
        let expected = if self.settings.control_periods().is_none() {
            format!(
                "a whole fraction of planning_step_s = {step}, such as {step}, {} or {}",
                step / 2.0,
                step / 4.0
            )
        } else if value < shortest * (1.0 - 1e-9) {
            format!("at least a physics step of {shortest} s")
        } else {
            return Ok(());
        };
        Err(ScenarioError::Number { key: "settings.control_period_s".to_owned(), value, expected })
    }
}

fn bad_perception(perception: &Perception) -> Option<(&'static str, f64)> {
    let values = [("alpha", perception.alpha), ("gamma", perception.gamma)];
    values.into_iter().find(|(_, value)| !PERCEPTION.contains(*value))
}

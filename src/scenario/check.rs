//! The check of a scenario's numbers against the table of settings.

use super::{BELIEF_RATIONALITY, PERCEPTION, SETTINGS, Scenario};
use crate::episode::PreferenceChange;
use crate::error::{Error, Place};
use crate::preference::Perception;

impl Scenario {
    /// Checks every number that parsing does not check.
    ///
    /// # Errors
    /// The key and the value of the first one that is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        let bad = |key: &str, value, expected: &str| {
            Err(Error::number(Place::file("scenario"), key, value, expected))
        };
        if let Some((key, value)) = bad_perception(&self.human) {
            return bad(&format!("human.{key}"), value, &PERCEPTION.to_string());
        }
        for setting in SETTINGS {
            if let Some(value) = setting.number_out_of_range(self) {
                return bad(setting.path, value, &setting.expected().to_string());
            }
        }
        if let Some(value) =
            self.settings.predictor.rationality().filter(|_| self.settings.learning.is_some())
        {
            // the density of what is learned is constant on the regions of eq. (3)
            let expected = "left out, because this robot learns (belief_update = \"learn\"), which it does of humans who prefer the least cost";
            return bad(BELIEF_RATIONALITY.path, value, expected);
        }
        self.check_control_period()?;
        if let Some(Err(e)) = self.settings.learning.map(|learning| learning.check()) {
            return bad(&format!("settings.learning.{}", e.name), e.value, e.expected);
        }
        for (i, PreferenceChange { step, perception }) in self.changes.iter().enumerate() {
            if let Some((key, value)) = bad_perception(perception) {
                let key = format!("change {}, at step {step}: {key}", i + 1);
                return bad(&key, value, &PERCEPTION.to_string());
            }
        }
        self.plant.physics().map_or(Ok(()), |physics| physics.check())
    }
}

impl Scenario {
    /// The control period divides the planning step and is no shorter than a physics step.
    fn check_control_period(&self) -> Result<(), Error> {
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
        Err(Error::number(Place::file("scenario"), "settings.control_period_s", value, &expected))
    }
}

fn bad_perception(perception: &Perception) -> Option<(&'static str, f64)> {
    let values = [("alpha", perception.alpha), ("gamma", perception.gamma)];
    values.into_iter().find(|(_, value)| !PERCEPTION.contains(*value))
}

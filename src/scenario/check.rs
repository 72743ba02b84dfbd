//! The check of a scenario's numbers against the table of settings.

use super::{PERCEPTION, SETTINGS, Scenario};
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
                return bad(setting.path, value, &setting.expected());
            }
        }
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

fn bad_perception(perception: &Perception) -> Option<(&'static str, f64)> {
    let values = [("alpha", perception.alpha), ("gamma", perception.gamma)];
    values.into_iter().find(|(_, value)| !PERCEPTION.contains(*value))
}

//! The ranges of a scenario's numbers.

use super::{Carrier, Scenario, ScenarioError};
use crate::episode::PreferenceChange;

/// A key, its value, the values allowed in words, and whether it is one of them.
type Number = (&'static str, f64, &'static str, fn(f64) -> bool);

const PERCEPTION: &str = "a number greater than 0";
const POSITIVE: &str = "a number greater than 0 and at most 1000000";
const NOT_NEGATIVE: &str = "a number from 0 to 1000000";

fn is_perception(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value <= 1e6
}

fn is_not_negative(value: f64) -> bool {
    (0.0..=1e6).contains(&value)
}

impl Scenario {
    /// Checks every number that is not checked where it is read.
    ///
    /// # Errors
    /// [`ScenarioError::Number`], [`ScenarioError::Change`] or [`ScenarioError::Physics`], which names the key and the value.
    pub fn check(&self) -> Result<(), ScenarioError> {
        let (human, settings) = (&self.human, &self.settings);
        let coordination = &settings.coordination;
        first_bad(&[
            ("human.alpha", human.alpha, PERCEPTION, is_perception),
            ("human.gamma", human.gamma, PERCEPTION, is_perception),
            (
                "settings.predictor.risk_weight_m",
                settings.predictor.risk_weight(),
                NOT_NEGATIVE,
                is_not_negative,
            ),
            (
                "settings.coordination.initial_stubbornness",
                coordination.initial_stubbornness,
                "a number greater than 0 and at most 1",
                |v| v > 0.0 && v <= 1.0,
            ),
            ("settings.coordination.eta", coordination.eta, POSITIVE, is_positive),
            ("settings.period_s", settings.period, "a number from 0.01 to 60", |v| {
                (0.01..=60.0).contains(&v)
            }),
            ("settings.speed_m_per_s", settings.speed, "a number from 0.001 to 10", |v| {
                (0.001..=10.0).contains(&v)
            }),
            (
                "settings.yaw_rate_rad_per_s",
                settings.yaw_rate,
                "a number greater than 0 and at most 1000",
                |v| v > 0.0 && v <= 1000.0,
            ),
        ])?;
        self.check_changes()?;
        if let Some(carrier) = self.plant.carrier() {
            carrier.check()?;
        }
        if let Some(physics) = self.plant.physics() {
            physics.check()?;
        }
        Ok(())
    }

    fn check_changes(&self) -> Result<(), ScenarioError> {
        for (i, PreferenceChange { step, perception }) in self.changes.iter().enumerate() {
            let values = [("alpha", perception.alpha), ("gamma", perception.gamma)];
            if let Some((key, value)) = values.into_iter().find(|(_, value)| !is_perception(*value)) {
                let (number, step) = (i + 1, *step);
                return Err(ScenarioError::Change { number, step, key, value, expected: PERCEPTION });
            }
        }
        Ok(())
    }
}

impl Carrier {
    fn check(&self) -> Result<(), ScenarioError> {
        let control = &self.control;
        first_bad(&[
            ("control.state_weight", control.state_weight, POSITIVE, is_positive),
            ("control.input_weight", control.input_weight, POSITIVE, is_positive),
            ("control.pose_weight", control.pose_weight, NOT_NEGATIVE, is_not_negative),
            (
                "control.direction_concentration",
                control.direction_concentration,
                NOT_NEGATIVE,
                is_not_negative,
            ),
        ])
    }
}

fn first_bad(numbers: &[Number]) -> Result<(), ScenarioError> {
    match numbers.iter().find(|(_, value, _, is_good)| !is_good(*value)) {
        None => Ok(()),
        Some(&(key, value, expected, _)) => Err(ScenarioError::Number { key, value, expected }),
    }
}

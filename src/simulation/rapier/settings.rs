//! Settings of the physical plant's solver and of its human, with tested default values.

use super::PhysicsError;
use serde::{Deserialize, Serialize};

/// The largest number of solver iterations.
pub(super) const MOST_ITERATIONS: usize = 1000;

/// Settings of the solver and limits of robot and human.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicsSettings {
    /// Physics steps per second of simulated time, Hz. A control period has `round(period * rate_hz)` of
    /// them.
    pub rate_hz: f64,
    /// Solver iterations over all constraints in a step: the base's motors, the grips and contacts. The arm
    /// is solved exactly. With four iterations, forces are within 1e-3 N of those with a hundred, and within
    /// 0.02 N for an object of half a kilogram (tested).
    pub solver_iterations: usize,
    /// Largest acceleration of a wheel's rim, m/s^2, given the wheels' motors and the robot's mass.
    #[serde(rename = "rim_acceleration_m_per_s2")]
    pub rim_acceleration: f64,
    /// The human.
    pub human: HumanSettings,
}

impl Default for PhysicsSettings {
    fn default() -> Self {
        Self { rate_hz: 240.0, solver_iterations: 4, rim_acceleration: 1.5, human: HumanSettings::default() }
    }
}

/// Motion of the human's hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HumanSettings {
    /// Largest speed of the hand, m/s.
    #[serde(rename = "speed_limit_m_per_s")]
    pub speed_limit: f64,
    /// Largest acceleration of the hand, m/s^2.
    #[serde(rename = "acceleration_limit_m_per_s2")]
    pub acceleration_limit: f64,
    /// Lateral sway amplitude of a walking human's hand, m.
    #[serde(rename = "sway_lateral_m")]
    pub sway_lateral: f64,
    /// Vertical sway amplitude, m.
    #[serde(rename = "sway_vertical_m")]
    pub sway_vertical: f64,
    /// Frequency of the lateral sway, Hz. The vertical sway is twice as fast.
    #[serde(rename = "step_frequency_hz")]
    pub step_frequency: f64,
}

impl Default for HumanSettings {
    fn default() -> Self {
        Self {
            speed_limit: 1.0,
            acceleration_limit: 1.5,
            sway_lateral: 0.01,
            sway_vertical: 0.005,
            step_frequency: 0.9,
        }
    }
}

impl HumanSettings {
    /// The same human without sway.
    pub fn steady(self) -> Self {
        Self { sway_lateral: 0.0, sway_vertical: 0.0, ..self }
    }
}

impl PhysicsSettings {
    /// Length of a physics step, s.
    pub fn step(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Checks the ranges. Errors use the names of the settings in files.
    pub(crate) fn check(&self) -> Result<(), PhysicsError> {
        let human = &self.human;
        let ranges = [
            ("rate_hz", self.rate_hz, 60.0, 10_000.0),
            ("solver_iterations", self.solver_iterations as f64, 1.0, MOST_ITERATIONS as f64),
            ("rim_acceleration_m_per_s2", self.rim_acceleration, 0.01, 1000.0),
            ("human.speed_limit_m_per_s", human.speed_limit, 0.01, 10.0),
            ("human.acceleration_limit_m_per_s2", human.acceleration_limit, 0.01, 100.0),
            ("human.sway_lateral_m", human.sway_lateral, 0.0, 0.2),
            ("human.sway_vertical_m", human.sway_vertical, 0.0, 0.2),
            ("human.step_frequency_hz", human.step_frequency, 0.01, 10.0),
        ];
        match ranges.into_iter().find(|(_, value, least, most)| !(least..=most).contains(&value)) {
            Some((field, value, least, most)) => Err(PhysicsError::Setting { field, value, least, most }),
            None => Ok(()),
        }
    }
}

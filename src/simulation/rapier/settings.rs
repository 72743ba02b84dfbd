//! Settings of the physical plant's solver and of its human, with tested default values.

use crate::error::{Error, Place};
use serde::{Deserialize, Serialize};

/// Settings of the solver and limits of robot and human.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicsSettings {
    /// Physics steps per second of simulated time, Hz. A control period has a whole number of them; what
    /// remains goes into the next.
    pub rate_hz: f64,
    /// Solver iterations over all constraints in a step: the grips and contacts. Arm and base are solved
    /// exactly. With twelve iterations at 100 Hz, forces are within 1e-3 N of those with a hundred, and within
    /// 0.02 N for an object of half a kilogram (tested); they take 6 % longer than four, with which a light
    /// object's forces are off by 0.3 N.
    pub solver_iterations: usize,
    /// Largest acceleration of a wheel's rim, m/s^2, given the wheels' motors and the robot's mass.
    #[serde(rename = "rim_acceleration_m_per_s2")]
    pub rim_acceleration: f64,
    /// Linear stiffness of the gripper's hold on the object, N/m. Its angular stiffness is 0.05 m^2 times as
    /// much; its damping is critical for the load at one end.
    #[serde(
        rename = "gripper_stiffness_n_per_m",
        default = "gripper_stiffness",
        skip_serializing_if = "is_gripper_stiffness"
    )]
    pub gripper_stiffness: f64,
    /// The human.
    pub human: HumanSettings,
}

impl Default for PhysicsSettings {
    fn default() -> Self {
        Self {
            rate_hz: 100.0,
            solver_iterations: 12,
            rim_acceleration: 1.5,
            gripper_stiffness: gripper_stiffness(),
            human: HumanSettings::default(),
        }
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
    /// Linear stiffness of the hand's hold on the object, N/m: by default that of the arm of a walker. Its
    /// angular stiffness is 1/120 m^2 times as much; its damping is critical for the load at one end.
    #[serde(
        rename = "hand_stiffness_n_per_m",
        default = "hand_stiffness",
        skip_serializing_if = "is_hand_stiffness"
    )]
    pub hand_stiffness: f64,
}

// scenarios from before these settings do not have them, and a default value is not written
fn gripper_stiffness() -> f64 {
    20_000.0
}

fn is_gripper_stiffness(stiffness: &f64) -> bool {
    *stiffness == gripper_stiffness()
}

fn hand_stiffness() -> f64 {
    1200.0
}

fn is_hand_stiffness(stiffness: &f64) -> bool {
    *stiffness == hand_stiffness()
}

impl Default for HumanSettings {
    fn default() -> Self {
        Self {
            speed_limit: 1.0,
            acceleration_limit: 1.5,
            sway_lateral: 0.01,
            sway_vertical: 0.005,
            step_frequency: 0.9,
            hand_stiffness: hand_stiffness(),
        }
    }
}

impl HumanSettings {
    /// Range of the speed limit, m/s.
    pub const SPEED_LIMITS: [f64; 2] = [0.01, 10.0];
    /// Range of the acceleration limit, m/s^2.
    pub const ACCELERATION_LIMITS: [f64; 2] = [0.01, 100.0];
    /// Range of the amplitudes of the sway, m.
    pub const SWAYS: [f64; 2] = [0.0, 0.1];
    /// Range of the step frequency, Hz.
    pub const STEP_FREQUENCIES: [f64; 2] = [0.01, 10.0];
    /// Range of the hand's stiffness, N/m.
    pub const HAND_STIFFNESSES: [f64; 2] = [100.0, 20_000.0];

    /// The same human without sway.
    pub fn steady(self) -> Self {
        Self { sway_lateral: 0.0, sway_vertical: 0.0, ..self }
    }
}

impl PhysicsSettings {
    /// Range of the physics steps per second, Hz.
    pub const RATES: [f64; 2] = [60.0, 10_000.0];
    /// The largest number of solver iterations.
    pub const MAX_ITERATIONS: usize = 1000;
    /// Range of the largest acceleration of a rim, m/s^2.
    pub const RIM_ACCELERATIONS: [f64; 2] = [0.01, 1000.0];
    /// Range of the gripper's stiffness, N/m.
    pub const GRIPPER_STIFFNESSES: [f64; 2] = [1000.0, 200_000.0];

    /// Length of a physics step, s.
    pub fn step(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Checks the ranges. Errors use the names of the settings in files.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let human = &self.human;
        let settings = [
            ("rate_hz", self.rate_hz, Self::RATES),
            ("solver_iterations", self.solver_iterations as f64, [1.0, Self::MAX_ITERATIONS as f64]),
            ("rim_acceleration_m_per_s2", self.rim_acceleration, Self::RIM_ACCELERATIONS),
            ("gripper_stiffness_n_per_m", self.gripper_stiffness, Self::GRIPPER_STIFFNESSES),
            ("human.speed_limit_m_per_s", human.speed_limit, HumanSettings::SPEED_LIMITS),
            (
                "human.acceleration_limit_m_per_s2",
                human.acceleration_limit,
                HumanSettings::ACCELERATION_LIMITS,
            ),
            ("human.sway_lateral_m", human.sway_lateral, HumanSettings::SWAYS),
            ("human.sway_vertical_m", human.sway_vertical, HumanSettings::SWAYS),
            ("human.step_frequency_hz", human.step_frequency, HumanSettings::STEP_FREQUENCIES),
            ("human.hand_stiffness_n_per_m", human.hand_stiffness, HumanSettings::HAND_STIFFNESSES),
        ];
        match settings.into_iter().find(|(_, value, [least, most])| !(least..=most).contains(&value)) {
            Some((key, value, [least, most])) => {
                Err(Error::number(Place::file("physics"), key, value, &format!("from {least} to {most}")))
            }
            None => Ok(()),
        }
    }
}

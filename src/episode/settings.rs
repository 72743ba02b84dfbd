//! What an episode is run with: belief, coordination, method, period, speed; documented defaults.

use crate::coordination;
use crate::policy::Method;
use crate::preference::Predictor;
use serde::{Deserialize, Serialize};

/// Everything about an episode but the world and the human.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What the robot believes of the human's (alpha, gamma), and c_r.
    pub predictor: Predictor,
    /// phi(0) and eta.
    pub coordination: coordination::Settings,
    /// How the team decides who leads.
    pub method: Method,
    /// Control period, s: one planning step k.
    #[serde(rename = "period_s")]
    pub period: f64,
    /// Walking speed of the team, m/s.
    #[serde(rename = "speed_m_per_s")]
    pub speed: f64,
    /// The fastest the human turns, rad/s: the reference's yaw follows the path's tangent no faster.
    #[serde(rename = "yaw_rate_rad_per_s")]
    pub yaw_rate: f64,
    /// Ticks after which the episode ends without arrival; by default ten times what the longest option takes.
    pub tick_limit: Option<u64>,
    /// Whether P_o is also evaluated while the human leads. A robot needs it then, and makes sure of it; the planning level does not, but
    /// ticks that are looked at do.
    pub predict_while_human_leads: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            predictor: Predictor::default(),
            coordination: coordination::Settings::default(),
            method: Method::MUTUAL,
            period: 0.2,
            speed: 0.5,
            yaw_rate: 0.8,
            tick_limit: None,
            predict_while_human_leads: true,
        }
    }
}

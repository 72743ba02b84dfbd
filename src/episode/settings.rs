//! The settings of an episode: belief, coordination, method, period and speed, with documented defaults.

use crate::coordination;
use crate::learning;
use crate::policy::Method;
use crate::preference::Predictor;
use crate::team::Pace;
use serde::{Deserialize, Serialize};

/// The settings of an episode, apart from the world and the human.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EpisodeSettings {
    /// The robot's belief about the human's (alpha, gamma), and c_r.
    pub predictor: Predictor,
    /// phi(0) and eta.
    pub coordination: coordination::StubbornnessSettings,
    /// The method of deciding who leads.
    pub method: Method,
    /// Number of the option on which the robot leads, from 1, whatever the human does: that of a stimulus. By
    /// default o* of eq. (6).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_option: Option<u64>,
    /// Planning step, s: phi, g, J and sightings of the human count in it. In a scenario's text its key is
    /// `period_s`, as before it was told apart from the control period.
    #[serde(rename = "period_s", alias = "planning_step_s")]
    pub planning_step: f64,
    /// Control period of eqs. (7) and (8), s, a whole fraction of the planning step; by default as long.
    #[serde(rename = "control_period_s", default, skip_serializing_if = "Option::is_none")]
    pub control_period: Option<f64>,
    /// Walking speed of the team, m/s.
    #[serde(rename = "speed_m_per_s")]
    pub speed: f64,
    /// Largest yaw rate of the human, rad/s: the reference's yaw follows the path's tangent no faster.
    #[serde(rename = "yaw_rate_rad_per_s")]
    pub yaw_rate: f64,
    /// Number of ticks after which the episode ends without arrival; by default ten times those of the
    /// longest option.
    pub tick_limit: Option<u64>,
    /// Whether P_o is also evaluated while the human leads. A robot needs it and enables it. The planning
    /// level does not need it, except in ticks that are displayed.
    pub predict_while_human_leads: bool,
    /// How the robot learns alpha, gamma and eta of the human; without it, it keeps its prior and knows eta,
    /// as in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning: Option<learning::LearningSettings>,
}

impl Default for EpisodeSettings {
    fn default() -> Self {
        Self {
            predictor: Predictor::default(),
            coordination: coordination::StubbornnessSettings::default(),
            method: Method::MUTUAL,
            lead_option: None,
            planning_step: 0.2,
            control_period: None,
            speed: 0.5,
            yaw_rate: 0.8,
            tick_limit: None,
            predict_while_human_leads: true,
            learning: None,
        }
    }
}

impl EpisodeSettings {
    /// Control period, s.
    pub fn control_period(&self) -> f64 {
        self.control_period.unwrap_or(self.planning_step)
    }

    /// Number of control periods in a planning step; `None` if they do not fill it.
    pub fn control_periods(&self) -> Option<u32> {
        let count = (self.planning_step / self.control_period()).round();
        let fills = (count * self.control_period() - self.planning_step).abs() <= 1e-9 * self.planning_step;
        (count >= 1.0 && fills).then_some(count as u32)
    }

    /// The team's pace.
    pub fn pace(&self) -> Pace {
        let Self { planning_step: step, speed, yaw_rate, .. } = *self;
        Pace { step, period: self.control_period(), speed, yaw_rate }
    }

    /// The learner of these settings, if the robot learns.
    pub(super) fn learner(&self) -> Option<Box<learning::Learner>> {
        let (predictor, phi) = (&self.predictor, self.coordination.initial_stubbornness);
        let (belief, risk_weight) = (predictor.belief().clone(), predictor.risk_weight());
        let learner = learning::Learner::new(self.learning?, belief, risk_weight, phi);
        Some(Box::new(learner.expect("learning settings are within their ranges")))
    }
}

//! Choice probabilities and option costs in; stubbornness phi(k), the mode, and the robot's choice of eq. (6) out.

use crate::math;
use crate::options::Waypoint;
use serde::{Deserialize, Serialize};

/// Who leads the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// phi(k) <= 1: the robot chooses the path.
    RobotLed,
    /// phi(k) > 1: the robot follows the human.
    HumanLed,
}

/// How the team decides who leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The paper's: the robot leads until stubbornness passes 1, then the human.
    Mutual,
    /// The baseline of Table II: the human leads from start to end, on the option preferred at the start.
    WithoutModel,
    /// The human leads from start to end, choosing anew at every step: the situation of Table III.
    HumanLed,
    /// The baseline of hypothesis H2 as worded: the robot leads from start to end.
    RobotLed,
}

impl Method {
    /// Name, as in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mutual => "mutual",
            Self::WithoutModel => "without-model",
            Self::HumanLed => "human-led",
            Self::RobotLed => "robot-led",
        }
    }
}

/// Parameters of the stubbornness measure, eq. (5).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// phi(0), in (0, 1].
    pub initial_stubbornness: f64,
    /// eta > 0: the larger, the more tolerant the human.
    pub eta: f64,
}

impl Default for Settings {
    /// phi(0) = 0.1 (open in the paper), eta = 10.5 (the paper's medium participant).
    fn default() -> Self {
        Self { initial_stubbornness: 0.1, eta: 10.5 }
    }
}

/// The stubbornness of the human and the mode that follows from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coordinator {
    settings: Settings,
    method: Method,
    discomfort: f64,
    mode: Mode,
}

impl Coordinator {
    /// At the start: g(0) = 0.
    pub fn new(settings: Settings, method: Method) -> Self {
        let mode = match method {
            Method::WithoutModel | Method::HumanLed => Mode::HumanLed,
            Method::Mutual | Method::RobotLed => Mode::RobotLed,
        };
        Self { settings, method, discomfort: 0.0, mode }
    }

    /// One step of eq. (5): while the robot leads, g(k) = g(k-1) + sum_o omega_o(k) P_o(k), where `misaligned` is that sum; then the mode.
    /// The transition happens once. (Sec. IV-B.2)
    pub fn accumulate(&mut self, misaligned: f64) {
        if self.mode == Mode::HumanLed {
            return;
        }
        self.discomfort += misaligned;
        if self.method == Method::Mutual && self.stubbornness() > 1.0 {
            self.mode = Mode::HumanLed;
        }
    }

    /// g(k), the accumulated discomfort.
    pub fn discomfort(&self) -> f64 {
        self.discomfort
    }

    /// phi(k) = phi(0) exp(g(k) / eta), eq. (5).
    pub fn stubbornness(&self) -> f64 {
        self.settings.initial_stubbornness * math::exp(self.discomfort / self.settings.eta)
    }

    /// Who leads now.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// How the team decides who leads.
    pub fn method(&self) -> Method {
        self.method
    }
}

/// omega_o(k) = 1 (Sec. IV-B.1): the team moves toward an opening, or the target, that is not the next one on the option.
pub fn is_misaligned(team: Waypoint, option: Waypoint) -> bool {
    team != option
}

/// o*(k) of eq. (6): the least (1 - phi) J_o + phi J~_o over pairs (J_o, J~_o) in metres. Ties go to `current`, then to the lower index.
///
/// DEVIATION (eq. 6): phi is held at 1 from above. With the mode transition phi never exceeds 1 here; a robot that leads to the end would
/// otherwise weigh its own cost negatively. No costs: option 0.
pub fn robot_choice(
    costs: impl Iterator<Item = (f64, f64)>,
    stubbornness: f64,
    current: Option<usize>,
) -> usize {
    let phi = stubbornness.min(1.0);
    let weighed = costs.map(|(objective, expected)| (1.0 - phi) * objective + phi * expected);
    let mut best = (0, f64::INFINITY);
    for (option, cost) in weighed.enumerate() {
        if cost < best.1 || (cost == best.1 && current == Some(option)) {
            best = (option, cost);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_stubbornness_passes_one_at_eta_ln_ten() {
        let settings = Settings { initial_stubbornness: 0.1, eta: 5.0 };
        let mut c = Coordinator::new(settings, Method::Mutual);
        let threshold = 5.0 * math::ln(10f64);
        c.accumulate(threshold - 1e-9);
        assert_eq!(c.mode(), Mode::RobotLed);
        c.accumulate(2e-9);
        assert_eq!(c.mode(), Mode::HumanLed);
        let at_transition = c.stubbornness();
        c.accumulate(1.0);
        assert_eq!(c.stubbornness(), at_transition, "g grows only while the robot leads");
    }

    #[test]
    fn closed_form_a_robot_that_always_leads_never_hands_over() {
        let mut c = Coordinator::new(Settings::default(), Method::RobotLed);
        c.accumulate(1e3);
        assert!(c.stubbornness() > 1.0);
        assert_eq!(c.mode(), Mode::RobotLed);
    }

    #[test]
    fn closed_form_eq_6_moves_from_objective_to_expected_cost() {
        let costs = [(1.0, 5.0), (3.0, 2.0)];
        assert_eq!(robot_choice(costs.into_iter(), 0.1, None), 0);
        assert_eq!(robot_choice(costs.into_iter(), 0.9, None), 1);
        // above 1 the robot's own cost must not count negatively: 9 and 2 would tie-break wrongly
        assert_eq!(robot_choice([(1.0, 5.0), (30.0, 5.5)].into_iter(), 3.0, None), 0);
    }

    #[test]
    fn closed_form_ties_stay_with_the_option_under_way() {
        let costs = [(1.0, 1.0), (1.0, 1.0), (2.0, 2.0)];
        assert_eq!(robot_choice(costs.into_iter(), 0.5, None), 0);
        assert_eq!(robot_choice(costs.into_iter(), 0.5, Some(1)), 1);
        assert_eq!(robot_choice(costs.into_iter(), 0.5, Some(2)), 0);
    }
}

//! Mutual adaptation (Sec. IV-B): the stubbornness measure phi(k) of eq. (5), the two modes, and the robot's
//! choice of eq. (6).

use crate::math;
use crate::options::{Remaining, Waypoint};
use serde::{Deserialize, Serialize};

/// The human takes the lead when phi exceeds this. (Sec. IV-B.2)
pub const STUBBORNNESS_THRESHOLD: f64 = 1.0;

/// Who leads the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// phi(k) <= 1: the robot chooses the path.
    RobotLed,
    /// phi(k) > 1: the robot follows the human.
    HumanLed,
}

impl Mode {
    /// Name, as in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Self::RobotLed => "robot-led",
            Self::HumanLed => "human-led",
        }
    }
}

/// Parameters of the stubbornness measure, eq. (5).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StubbornnessSettings {
    /// phi(0), in (0, 1].
    pub initial_stubbornness: f64,
    /// eta > 0: the larger, the more tolerant the human.
    pub eta: f64,
}

impl Default for StubbornnessSettings {
    /// phi(0) = 0.1 (open in the paper), eta = 10.5 (the paper's medium participant).
    fn default() -> Self {
        Self { initial_stubbornness: 0.1, eta: 10.5 }
    }
}

/// The stubbornness measure of eq. (5). Discomfort accumulates while the team walks another path than the
/// human would.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stubbornness {
    settings: StubbornnessSettings,
    discomfort: f64,
}

impl Stubbornness {
    /// The measure at the start: g(0) = 0.
    pub fn new(settings: StubbornnessSettings) -> Self {
        Self { settings, discomfort: 0.0 }
    }

    /// One step under the robot's lead: g(k) = g(k-1) + sum_o omega_o(k) P_o(k), where `misaligned` is that
    /// sum.
    pub fn accumulate(&mut self, misaligned: f64) {
        self.discomfort += misaligned;
    }

    /// g(k), the accumulated discomfort.
    pub fn discomfort(&self) -> f64 {
        self.discomfort
    }

    /// phi(k) = phi(0) exp(g(k) / eta), eq. (5).
    pub fn measure(&self) -> f64 {
        self.settings.initial_stubbornness * math::exp(self.discomfort / self.settings.eta)
    }

    /// Whether phi(k) > 1: the human takes the lead. (Sec. IV-B.2)
    pub fn is_exhausted(&self) -> bool {
        self.measure() > STUBBORNNESS_THRESHOLD
    }
}

/// One option from where the team is, eq. (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptionCost {
    /// D_o, S_o and the next waypoint.
    pub remaining: Remaining,
    /// J_o, m.
    pub objective: f64,
    /// omega_o: whether the team's next waypoint differs from this option's.
    pub misaligned: bool,
}

impl OptionCost {
    /// The option with its P_o and J~_o; NaN where one was not evaluated.
    pub fn predicted(&self, probability: f64, expected: f64) -> OptionTick {
        let Self { remaining, objective, misaligned } = *self;
        OptionTick { remaining, objective, expected, probability, misaligned }
    }
}

/// One option in one planning step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptionTick {
    /// D_o, S_o and the next waypoint.
    pub remaining: Remaining,
    /// J_o, eq. (1), m.
    pub objective: f64,
    /// J~_o, the expected subjective cost of eq. (6), cost units: the mean over the robot's belief. NaN
    /// unless the robot leads.
    pub expected: f64,
    /// P_o, eq. (4); NaN where it was not evaluated.
    pub probability: f64,
    /// omega_o: whether the team's next waypoint differs from this option's.
    pub misaligned: bool,
}

impl OptionTick {
    /// The option without P_o and J~_o.
    pub(crate) fn cost(&self) -> OptionCost {
        let Self { remaining, objective, misaligned, .. } = *self;
        OptionCost { remaining, objective, misaligned }
    }
}

/// sum_o omega_o(k) P_o(k) of eq. (5): the probability that the human would walk another path.
pub fn misalignment(options: &[OptionTick]) -> f64 {
    options.iter().filter(|option| option.misaligned).map(|option| option.probability).sum()
}

/// omega_o(k) = 1 (Sec. IV-B.1): the team moves toward an opening, or the target, that is not the next one on
/// the option.
pub fn is_misaligned(team: Waypoint, option: Waypoint) -> bool {
    team != option
}

/// o*(k) of eq. (6): the least (1 - phi) J_o + phi J~_o over pairs (J_o, J~_o) in metres. Ties go to
/// `current`, then to the lower index. Without costs, option 0.
///
/// DEVIATION (eq. 6): phi is limited to 1. With the mode transition phi never exceeds 1 here; a robot that
/// leads to the end would otherwise give its own cost a negative weight.
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
        let mut s = Stubbornness::new(StubbornnessSettings { initial_stubbornness: 0.1, eta: 5.0 });
        s.accumulate(5.0 * math::ln(10.0) - 1e-9);
        assert!(!s.is_exhausted());
        s.accumulate(2e-9);
        assert!(s.is_exhausted());
    }

    #[test]
    fn closed_form_eq_6_moves_from_objective_to_expected_cost() {
        let costs = [(1.0, 5.0), (3.0, 2.0)];
        assert_eq!(robot_choice(costs.into_iter(), 0.1, None), 0);
        assert_eq!(robot_choice(costs.into_iter(), 0.9, None), 1);
        // above 1 the robot's own cost must not have a negative weight: 9 and 2 would break the tie wrongly
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

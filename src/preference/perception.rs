//! Objective cost, subjective cost and a human's choice, from the remaining length and risk of options.

use crate::math;
use serde::{Deserialize, Serialize};

/// The remaining length and risk of an option.
///
/// Meant for `length >= 0` and `risk` in `[0, 1]`. Values outside are clamped to the nearest bound, NaN to
/// the worse one (infinitely long, certain collision), so that no input can make a choice undefined.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Prospect {
    /// Remaining path length `D_o`, metres.
    pub length: f64,
    /// Remaining collision risk `S_o`, a fraction in `[0, 1]`.
    pub risk: f64,
}

impl Prospect {
    /// An option with `length` metres and collision risk `risk` left.
    pub const fn new(length: f64, risk: f64) -> Self {
        Self { length, risk }
    }

    /// The same option with both numbers clamped to their domain (see the type's documentation).
    pub(super) fn clamped(self) -> Self {
        let length = if self.length.is_nan() { f64::INFINITY } else { self.length.max(0.0) };
        let risk = if self.risk.is_nan() { 1.0 } else { self.risk.clamp(0.0, 1.0) };
        Self { length, risk }
    }
}

/// The largest alpha or gamma. Far beyond it, costs are no longer numbers, and integrals over a belief take
/// forever.
pub const MAX_PERCEPTION: f64 = 10.0;

/// One human's perception of distance and risk. Both parameters are positive and dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perception {
    /// Distance perception: below 1, long distances feel shorter than they are.
    pub alpha: f64,
    /// Risk perception: below 1, small risks are overweighted and large ones underweighted.
    pub gamma: f64,
}

/// Perceived risk `S^ = exp(-(-ln S)^gamma)` (Prelec; Sec. III-B), a fraction.
///
/// The limits are exact: `S = 0` gives 0 and `S = 1` gives 1.
///
/// ```
/// use cocarry::preference::perceived_risk;
/// assert_eq!(perceived_risk(0.0, 0.5), 0.0);
/// assert_eq!(perceived_risk(1.0, 0.5), 1.0);
/// assert!(perceived_risk(0.01, 0.5) > 0.01);
/// ```
pub fn perceived_risk(risk: f64, gamma: f64) -> f64 {
    math::exp(-math::pow(-math::ln(risk), gamma))
}

/// Perceived distance `D^ = D^alpha` (Stevens; Sec. III-B) of `length` metres; 0 at length 0.
pub fn perceived_distance(length: f64, alpha: f64) -> f64 {
    math::pow(length, alpha)
}

/// Objective cost `J = D + c_r S` (eq. 1), metres, with the risk weight `c_r` in metres.
pub fn objective_cost(prospect: Prospect, risk_weight: f64) -> f64 {
    prospect.length + risk_weight * prospect.risk
}

/// Subjective cost `J^ = D^alpha + c_r exp(-(-ln S)^gamma)` (eq. 2) with the risk weight `c_r`.
pub fn subjective_cost(prospect: Prospect, risk_weight: f64, perception: Perception) -> f64 {
    let Prospect { length, risk } = prospect.clamped();
    perceived_distance(length, perception.alpha) + risk_weight * perceived_risk(risk, perception.gamma)
}

/// The option the human prefers, `o_h = argmin_o J^_o(alpha, gamma)` (eq. 3), as an index into `prospects`.
///
/// Ties go to `current`, the option being executed, if it is among the best, else to the lower index. Without
/// options the answer is 0.
pub fn human_choice(
    prospects: &[Prospect],
    risk_weight: f64,
    perception: Perception,
    current: Option<usize>,
) -> usize {
    let cost = |option: usize| subjective_cost(prospects[option], risk_weight, perception);
    cheapest(prospects.len(), current, cost)
}

/// The perceived risks of options, kept from step to step: the remaining risk of an option changes at openings
/// only. Costs and choices are those of [`subjective_cost`] and [`human_choice`], to the bit.
#[derive(Clone, Debug, Default)]
pub(crate) struct PerceivedRisks {
    /// By option, the risk and the gamma of the last call, and the perceived risk.
    known: Vec<[f64; 3]>,
}

impl PerceivedRisks {
    /// [`subjective_cost`] of this option.
    pub fn subjective_cost(
        &mut self,
        option: usize,
        prospect: Prospect,
        risk_weight: f64,
        Perception { alpha, gamma }: Perception,
    ) -> f64 {
        let Prospect { length, risk } = prospect.clamped();
        if self.known.len() <= option {
            // NaN differs from every risk
            self.known.resize(option + 1, [f64::NAN; 3]);
        }
        let known = &mut self.known[option];
        if known[0] != risk || known[1] != gamma {
            *known = [risk, gamma, perceived_risk(risk, gamma)];
        }
        perceived_distance(length, alpha) + risk_weight * known[2]
    }

    /// [`human_choice`] among these options.
    pub fn human_choice(
        &mut self,
        prospects: &[Prospect],
        risk_weight: f64,
        perception: Perception,
        current: Option<usize>,
    ) -> usize {
        let cost = |option: usize| self.subjective_cost(option, prospects[option], risk_weight, perception);
        cheapest(prospects.len(), current, cost)
    }
}

/// The option of least cost among so many: of several, `current`, or else the first. 0 without options.
pub(super) fn cheapest(options: usize, current: Option<usize>, mut cost: impl FnMut(usize) -> f64) -> usize {
    if options == 0 {
        return 0;
    }
    let first = current.filter(|&option| option < options).unwrap_or(0);
    let (mut best, mut lowest) = (first, cost(first));
    // Strictly better only: the option compared first keeps a tie.
    for option in (0..options).filter(|&option| option != first) {
        let candidate = cost(option);
        if candidate < lowest {
            (best, lowest) = (option, candidate);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_perceived_risk_has_its_limits_and_fixed_point() {
        for gamma in [0.3, 0.5, 1.0, 1.1, 3.0] {
            assert_eq!(perceived_risk(0.0, gamma), 0.0);
            assert_eq!(perceived_risk(1.0, gamma), 1.0);
            let fixed = math::exp(-1.0f64);
            assert!((perceived_risk(fixed, gamma) - fixed).abs() < 1e-15);
        }
        assert!((perceived_risk(0.37, 1.0) - 0.37).abs() < 1e-15);
        assert!(perceived_risk(0.01, 0.6) > 0.01 && perceived_risk(0.9, 0.6) < 0.9);
    }

    #[test]
    fn closed_form_objective_is_subjective_at_unit_perception() {
        let option = Prospect::new(14.33, 0.5474);
        let unit = Perception { alpha: 1.0, gamma: 1.0 };
        assert!((objective_cost(option, 10.0) - subjective_cost(option, 10.0, unit)).abs() < 1e-13);
        assert!((objective_cost(option, 10.0) - 19.804).abs() < 1e-12);
    }

    #[test]
    fn property_perceived_risks_that_are_kept_give_the_same_costs_and_choices() {
        let mut kept = PerceivedRisks::default();
        for k in 0..500 {
            let turn = |every: i32| f64::from(k / every % 7) / 6.0;
            let perception = Perception { alpha: 0.55 + 0.4 * turn(5), gamma: 0.5 + 0.6 * turn(11) };
            let length = |o: i32| f64::from((k * (o + 3)) % 37) - 0.5;
            let risk = |o: i32| if k % 50 == o { f64::NAN } else { turn(17 + o) };
            let options: Vec<Prospect> = (0..4).map(|o| Prospect::new(length(o), risk(o))).collect();
            let found = kept.human_choice(&options, 10.0, perception, Some(2));
            assert_eq!(found, human_choice(&options, 10.0, perception, Some(2)), "{k}");
            for (o, option) in options.iter().enumerate() {
                let [found, wanted] = [
                    kept.subjective_cost(o, *option, 10.0, perception),
                    subjective_cost(*option, 10.0, perception),
                ];
                assert_eq!(found.to_bits(), wanted.to_bits(), "{k}, {option:?}");
            }
        }
    }

    #[test]
    fn closed_form_ties_go_to_the_current_option_then_to_the_lower_index() {
        let option = Prospect::new(10.0, 0.4);
        let worse = Prospect::new(10.1, 0.4);
        let perception = Perception { alpha: 0.7, gamma: 0.8 };
        let options = [worse, option, option, option];
        assert_eq!(human_choice(&options, 10.0, perception, None), 1);
        assert_eq!(human_choice(&options, 10.0, perception, Some(3)), 3);
        assert_eq!(human_choice(&options, 10.0, perception, Some(0)), 1);
        assert_eq!(human_choice(&options, 10.0, perception, Some(17)), 1);
        assert_eq!(human_choice(&[], 10.0, perception, None), 0);
    }

    #[test]
    fn closed_form_nonsense_options_are_never_preferred() {
        let perception = Perception { alpha: 0.7, gamma: 0.8 };
        let options = [Prospect::new(f64::NAN, 0.0), Prospect::new(5.0, f64::NAN), Prospect::new(5.0, 0.99)];
        assert_eq!(human_choice(&options, 10.0, perception, Some(0)), 2);
    }
}

//! Other perceptions of risk that the literature on route choice compares, next to that of Stevens and Prelec.
//!
//! Each takes an option as a lottery: the length D is lost for sure, and c_r on top of it with probability S.
//! An option has one cost for every human, whose parameters are uniform on ranges, and humans prefer the
//! option of least cost. Without any distortion each cost is D + c_r S, eq. (1).
//!
//! ```
//! use cocarry::preference::{CONDITIONAL_VALUE_AT_RISK, Prospect, RiskPerception};
//!
//! let options = [Prospect::new(17.4, 0.36), Prospect::new(14.3, 0.55), Prospect::new(21.4, 0.25)];
//! let shares = CONDITIONAL_VALUE_AT_RISK.probabilities(&options, 10.0);
//! assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
//! ```

mod cumulative_prospect;
mod expected_risk;
mod stevens_prelec;
mod value_at_risk;

pub use cumulative_prospect::CUMULATIVE_PROSPECT;
pub use expected_risk::EXPECTED_RISK;
pub use stevens_prelec::StevensPrelec;
pub use value_at_risk::CONDITIONAL_VALUE_AT_RISK;

use super::perception::cheapest;
use super::ties::Ties;
use super::{Prospect, Ways};
use std::collections::BTreeMap;

/// The perceptions of risk next to the paper's.
pub const ALTERNATIVES: [&dyn RiskPerception; 3] =
    [&CUMULATIVE_PROSPECT, &CONDITIONAL_VALUE_AT_RISK, &EXPECTED_RISK];

/// Values of the second parameter at which the choices along the first one are found.
const ROWS: usize = 64;

/// Equal parts of the first parameter's range whose ends are compared.
const PARTS: usize = 16;

/// The width, of a range of 1, up to which the ends of a choice are searched for.
const WIDTH: f64 = 1e-7;

/// The least and largest value of a parameter that a person may have.
#[derive(Clone, Copy, Debug)]
pub struct RiskParameter {
    /// Name.
    pub name: &'static str,
    /// Ends of the range; people are uniform on it.
    pub range: [f64; 2],
    /// A value to show, of the source where it has one.
    pub example: f64,
}

/// The people who prefer the same option in each of several situations.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceGroup {
    /// Their share of all people, from 0 to 1.
    pub share: f64,
    /// By situation and option, the probability that they prefer it: 1, or equal parts where options are tied.
    pub preferred: Vec<Vec<f64>>,
}

/// How people perceive the length and the risk of options.
pub trait RiskPerception: std::fmt::Debug + Send + Sync {
    /// Name, as in `cvar`.
    fn name(&self) -> &'static str;

    /// The parameters in which people differ: none, one or two.
    fn parameters(&self) -> &[RiskParameter];

    /// The cost of an option of finite length to a person with these parameters. `prospect` is in its domain.
    fn perceived_cost(&self, prospect: Prospect, risk_weight: f64, parameters: &[f64]) -> f64;

    /// The parameters of the people at these quantiles, one for each parameter, or only one with
    /// [`RiskPerception::breaks`].
    fn at(&self, quantiles: &[f64]) -> Vec<f64> {
        let between = |(parameter, u): (&RiskParameter, &f64)| {
            let [low, high] = parameter.range;
            low + u * (high - low)
        };
        self.parameters().iter().zip(quantiles).map(between).collect()
    }

    /// All quantiles between which nobody's choice changes, where they have a closed form.
    fn breaks(&self, prospects: &[Prospect], risk_weight: f64) -> Option<Vec<f64>> {
        let _ = (prospects, risk_weight);
        None
    }

    /// The groups of people who make the same choices in all `situations`, in a fixed order; their shares sum
    /// to 1.
    ///
    /// Exact with [`RiskPerception::breaks`]. Without, the choices along the first parameter are found by
    /// bisection, at 64 values of the second one; in the paper's environments, with c_r = 20,
    /// 40 and 80 m, probabilities differ by less than 4e-4 from those with 2048 values.
    fn groups(&self, situations: &[&[Prospect]], risk_weight: f64) -> Vec<ChoiceGroup> {
        groups_in_rows(self, situations, risk_weight, ROWS)
    }

    /// P_o: the share of people who prefer each option.
    fn probabilities(&self, prospects: &[Prospect], risk_weight: f64) -> Vec<f64> {
        let mut sum = vec![0.0; prospects.len()];
        for group in self.groups(&[prospects], risk_weight) {
            sum.iter_mut().zip(&group.preferred[0]).for_each(|(sum, part)| *sum += group.share * part);
        }
        sum
    }

    /// The option of least cost, as an index: of several, `current`, or else the first. 0 without options.
    fn choice(
        &self,
        prospects: &[Prospect],
        risk_weight: f64,
        parameters: &[f64],
        current: Option<usize>,
    ) -> usize {
        cheapest(prospects.len(), current, |option| match prospects[option].clamped() {
            Prospect { length: f64::INFINITY, .. } => f64::INFINITY,
            prospect => self.perceived_cost(prospect, risk_weight, parameters),
        })
    }
}

/// The choices in all situations of the person at these quantiles.
fn choices(
    perception: &(impl RiskPerception + ?Sized),
    situations: &[&[Prospect]],
    risk_weight: f64,
    quantiles: &[f64],
) -> Vec<usize> {
    let parameters = perception.at(quantiles);
    situations.iter().map(|prospects| perception.choice(prospects, risk_weight, &parameters, None)).collect()
}

/// [`RiskPerception::groups`], with the choices at so many values of the second parameter.
fn groups_in_rows(
    perception: &(impl RiskPerception + ?Sized),
    situations: &[&[Prospect]],
    risk_weight: f64,
    rows: usize,
) -> Vec<ChoiceGroup> {
    let choose = |quantiles: &[f64]| choices(perception, situations, risk_weight, quantiles);
    let people = People { situations, choose: &choose };
    let mut shares: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
    let known = situations.iter().map(|prospects| perception.breaks(prospects, risk_weight));
    match (known.collect::<Option<Vec<_>>>(), perception.parameters()) {
        (Some(breaks), _) => people.between(breaks.concat(), &mut shares),
        (None, [_]) => people.along(&[], 1.0, &mut shares),
        (None, _) => {
            for row in 0..rows {
                people.along(&[(row as f64 + 0.5) / rows as f64], 1.0 / rows as f64, &mut shares);
            }
        }
    }
    shares.into_iter().map(|(choices, share)| people.group(&choices, share)).collect()
}

/// People in some situations, by the quantiles of their parameters.
struct People<'a> {
    situations: &'a [&'a [Prospect]],
    choose: &'a dyn Fn(&[f64]) -> Vec<usize>,
}

impl People<'_> {
    /// Adds the people between breaks, whose choices are those in the middle.
    fn between(&self, mut breaks: Vec<f64>, shares: &mut BTreeMap<Vec<usize>, f64>) {
        breaks.retain(|u| *u > 0.0 && *u < 1.0);
        breaks.extend([0.0, 1.0]);
        breaks.sort_unstable_by(f64::total_cmp);
        for ends in breaks.windows(2).filter(|ends| ends[1] > ends[0]) {
            *shares.entry((self.choose)(&[0.5 * (ends[0] + ends[1])])).or_default() += ends[1] - ends[0];
        }
    }

    /// Adds the people along the first parameter, with these quantiles of the others; together they are
    /// `weight`.
    fn along(&self, others: &[f64], weight: f64, shares: &mut BTreeMap<Vec<usize>, f64>) {
        let choose = |u: f64| (self.choose)(&[&[u], others].concat());
        let mut ends = vec![(1.0, choose(1.0))];
        ends.extend((0..PARTS).rev().map(|part| part as f64 / PARTS as f64).map(|u| (u, choose(u))));
        let (mut from, mut chosen) = ends.pop().expect("there is a first end");
        // the next end is the last: halves are added before it
        while let Some((to, next)) = ends.pop() {
            if next != chosen && to - from > WIDTH {
                let middle = 0.5 * (from + to);
                ends.push((to, next));
                ends.push((middle, choose(middle)));
                continue;
            }
            *shares.entry(chosen).or_default() += weight * (to - from);
            (from, chosen) = (to, next);
        }
    }

    fn group(&self, choices: &[usize], share: f64) -> ChoiceGroup {
        let mut ties = Ties::default();
        let preferred = self.situations.iter().zip(choices).map(|(prospects, &chosen)| {
            let mut masses = vec![0.0; prospects.len()];
            if !masses.is_empty() {
                ties.find(prospects, &Ways::default(), true);
                masses[ties.leader(chosen)] = 1.0;
                ties.share(&mut masses);
            }
            masses
        });
        ChoiceGroup { share, preferred: preferred.collect() }
    }
}

#[cfg(test)]
mod tests;

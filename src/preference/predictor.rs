//! The probability of every option (eq. 4) and its expected subjective cost (eq. 6), from prospects and a
//! belief.

use super::curve::{Curve, pareto_front};
use super::expectation::{Nodes, uniform_perceived_length};
use super::softmax::{self, Choice, Softmax};
use super::strips::{Domain, Strips};
use super::ties::Ties;
use super::{
    Belief, ChoiceDistribution, MAX_RATIONALITY, Perception, Prospect, SampleSet, Ways, check_lapse_rate,
    human_choice, subjective_cost,
};
use crate::error::Error;
use serde::{Deserialize, Serialize};

/// A predictor of a human's choice from a belief over the human's perception.
///
/// Probabilities of an independent belief are exact up to an absolute error of 1e-9. For each `gamma`, the
/// predictor solves for the parts of the range of `alpha` in which each option is the cheapest, and
/// integrates their probabilities over `gamma` piece by piece. An empirical belief is summed sample by
/// sample. With a lapse rate l, the human takes any of the n options with probability l / n, whatever they
/// prefer. With a rationality beta, humans choose an option with probability proportional to exp(-beta J^_o)
/// in place of eq. (3), as [`Boltzmann`](crate::human::Boltzmann) humans do. The predictor owns all working
/// memory: once warm, a call with no more options than before allocates nothing. Equal calls give equal bits.
///
/// It is serialised as belief, risk weight, lapse rate and rationality, and two predictors with the same ones
/// are equal.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Basis", into = "Basis")]
pub struct Predictor {
    belief: Belief,
    risk_weight: f64,
    lapse_rate: f64,
    rationality: Option<f64>,
    model: PredictorModel,
    ties: Ties,
    masses: Vec<f64>,
}

/// The data that defines a predictor.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Basis {
    risk_weight_m: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    lapse_rate: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rationality: Option<f64>,
    belief: Belief,
}

fn is_zero(rate: &f64) -> bool {
    *rate == 0.0
}

impl From<Predictor> for Basis {
    fn from(predictor: Predictor) -> Self {
        let Predictor { belief, risk_weight, lapse_rate, rationality, .. } = predictor;
        Self { risk_weight_m: risk_weight, lapse_rate, rationality, belief }
    }
}

impl TryFrom<Basis> for Predictor {
    type Error = Error;

    fn try_from(basis: Basis) -> Result<Self, Error> {
        let mut predictor = Self::new(basis.belief, basis.risk_weight_m)?;
        predictor.set_lapse_rate(basis.lapse_rate)?;
        predictor.set_rationality(basis.rationality)?;
        Ok(predictor)
    }
}

impl PartialEq for Predictor {
    fn eq(&self, other: &Self) -> bool {
        self.belief == other.belief
            && self.risk_weight == other.risk_weight
            && self.lapse_rate == other.lapse_rate
            && self.rationality == other.rationality
    }
}

#[derive(Debug, Clone)]
enum PredictorModel {
    Independent(Box<Independent>),
    Samples(SampleSet),
}

#[derive(Debug, Clone)]
struct Independent {
    domain: Domain,
    /// Nodes over `alpha` where there is no closed form.
    alpha_nodes: Option<Nodes>,
    gamma_nodes: Nodes,
    /// By option, the risk of the last call and its mean perception. The remaining risk of an option changes
    /// at openings only.
    perceived_risks: Vec<(f64, f64)>,
    front: Vec<Curve>,
    strips: Strips,
    /// With a rationality.
    choices: Vec<Choice>,
    softmax: Softmax,
}

/// The weight c_r of risk against distance that the paper fits to its participants, m (Sec. V-A).
pub const RISK_WEIGHT: f64 = 10.0;

impl Default for Predictor {
    /// The paper's belief and risk weight.
    fn default() -> Self {
        Self::new(Belief::default(), RISK_WEIGHT).expect("the paper's parameters are valid")
    }
}

impl Predictor {
    /// A predictor for a belief and the weight `c_r` of risk in eq. 2 (finite, not negative; the paper fits
    /// 10).
    pub fn new(belief: Belief, risk_weight: f64) -> Result<Self, Error> {
        check(risk_weight)?;
        let model = match &belief {
            Belief::Independent { alpha, gamma } => PredictorModel::Independent(Box::new(Independent {
                domain: Domain {
                    alpha: *alpha,
                    alpha_panels: alpha.panels(),
                    gamma: *gamma,
                    gamma_panels: gamma.panels(),
                },
                alpha_nodes: alpha.normal_shape().map(|_| Nodes::new(alpha)),
                gamma_nodes: Nodes::new(gamma),
                perceived_risks: Vec::new(),
                front: Vec::new(),
                strips: Strips::new(),
                choices: Vec::new(),
                softmax: Softmax::new(),
            })),
            Belief::Samples(set) => PredictorModel::Samples(set.clone()),
        };
        let (ties, masses) = (Ties::default(), Vec::new());
        Ok(Self { belief, risk_weight, lapse_rate: 0.0, rationality: None, model, ties, masses })
    }

    /// The robot's belief.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The weight `c_r` of perceived risk.
    pub fn risk_weight(&self) -> f64 {
        self.risk_weight
    }

    /// Changes the weight `c_r`.
    ///
    /// # Errors
    /// The weight is negative or not finite.
    pub fn set_risk_weight(&mut self, risk_weight: f64) -> Result<(), Error> {
        check(risk_weight)?;
        self.risk_weight = risk_weight;
        Ok(())
    }

    /// The lapse rate l: the probability that the human takes any option. 0 unless it was set.
    pub fn lapse_rate(&self) -> f64 {
        self.lapse_rate
    }

    /// Changes the lapse rate.
    ///
    /// # Errors
    /// The rate is not from 0 to [`MAX_LAPSE_RATE`](super::MAX_LAPSE_RATE).
    pub fn set_lapse_rate(&mut self, lapse_rate: f64) -> Result<(), Error> {
        check_lapse_rate(lapse_rate)?;
        self.lapse_rate = lapse_rate;
        Ok(())
    }

    /// The rationality beta of the humans; `None` if they prefer the least subjective cost, eq. (3).
    pub fn rationality(&self) -> Option<f64> {
        self.rationality
    }

    /// Changes the rationality.
    ///
    /// # Errors
    /// The rationality is not greater than 0 and at most [`MAX_RATIONALITY`].
    pub fn set_rationality(&mut self, rationality: Option<f64>) -> Result<(), Error> {
        match rationality {
            Some(value) if !(value > 0.0 && value <= MAX_RATIONALITY) => {
                let sentence = "must be a number greater than 0 and at most";
                Err(Error::new(format!("rationality {value} {sentence} {MAX_RATIONALITY}")))
            }
            _ => {
                self.rationality = rationality;
                Ok(())
            }
        }
    }

    /// Probability `P'_o = (1 - l) P_o + l / n` that the human takes each of n options, into `choice`. `P_o` is
    /// the probability that the option has the lowest subjective cost (eq. 4), or the mean of Boltzmann's
    /// probabilities with a rationality, and l the lapse rate.
    ///
    /// Options tied in length and risk share their probability equally. Without options `choice` is left empty.
    pub fn predict(&mut self, prospects: &[Prospect], choice: &mut ChoiceDistribution) {
        self.predict_from(prospects, &Ways::default(), choice);
    }

    /// [`Predictor::predict`] during an episode, in which several options may have become one way. They are one
    /// choice: `P_o` is that of the option that represents them.
    pub fn predict_from(&mut self, prospects: &[Prospect], ways: &Ways, choice: &mut ChoiceDistribution) {
        self.masses.clear();
        self.masses.resize(prospects.len(), 0.0);
        let risk_matters = self.risk_weight > 0.0;
        self.ties.find(prospects, ways, risk_matters);
        match (&mut self.model, self.rationality) {
            (PredictorModel::Samples(set), Some(beta)) => {
                for sample in set.samples() {
                    softmax::add_sample(sample, &self.ties, self.risk_weight, beta, &mut self.masses);
                }
            }
            (PredictorModel::Independent(model), Some(beta)) => {
                model.choices.clear();
                let ways = |leader| self.ties.ways(leader);
                let reachable = self.ties.leaders().filter(|(_, prospect)| prospect.length.is_finite());
                model.choices.extend(reachable.map(|(o, prospect)| (Curve::new(o, prospect), ways(o))));
                let scales = [beta, beta * self.risk_weight];
                model.softmax.integrate(&model.choices, scales, &model.domain, &mut self.masses);
            }
            (PredictorModel::Samples(set), None) => {
                for sample in set.samples().iter().filter(|_| !prospects.is_empty()) {
                    let chosen = human_choice(prospects, self.risk_weight, sample.perception, None);
                    self.masses[self.ties.leader(chosen)] += sample.weight;
                }
            }
            (PredictorModel::Independent(model), None) => {
                pareto_front(&self.ties, risk_matters, &mut model.front);
                model.strips.nodes = 0;
                if let [only] = model.front.as_slice() {
                    self.masses[only.option] = 1.0;
                } else if !model.front.is_empty() {
                    model.strips.integrate(&model.front, self.risk_weight, &model.domain, &mut self.masses);
                }
            }
        }
        self.ties.share(&mut self.masses);
        if !choice.set_masses(&self.masses) {
            // This happens only for lengths whose powers overflow; the choice at the middle of the belief is
            // still defined.
            let chosen = human_choice(prospects, self.risk_weight, self.middle(), None);
            choice.set_certain(prospects.len(), ways.representative(chosen));
        }
        choice.add_lapses(self.lapse_rate);
    }

    /// Expected subjective cost `J~_o = E[D_o^alpha] + c_r E[exp(-(-ln S_o)^gamma)]` of each option (eq. 6),
    /// into `costs`.
    pub fn expected_costs(&mut self, prospects: &[Prospect], costs: &mut Vec<f64>) {
        costs.clear();
        let risk_weight = self.risk_weight;
        match &mut self.model {
            PredictorModel::Samples(set) => costs.extend(prospects.iter().map(|prospect| -> f64 {
                let cost = |perception| subjective_cost(*prospect, risk_weight, perception);
                set.samples().iter().map(|sample| sample.weight * cost(sample.perception)).sum()
            })),
            PredictorModel::Independent(model) => {
                // NaN differs from every risk
                model.perceived_risks.resize(prospects.len(), (f64::NAN, f64::NAN));
                costs.extend(prospects.iter().zip(&mut model.perceived_risks).map(|(prospect, known)| {
                    let Prospect { length, risk } = prospect.clamped();
                    let alpha = &model.domain.alpha;
                    let perceived_length = match &model.alpha_nodes {
                        Some(nodes) => nodes.perceived_length(length),
                        None => uniform_perceived_length(length, alpha.lower(), alpha.upper()),
                    };
                    if known.0 != risk {
                        *known = (risk, model.gamma_nodes.perceived_risk(risk));
                    }
                    perceived_length + risk_weight * known.1
                }));
            }
        }
    }

    /// Number of values of `gamma` at which the last [`predict`](Self::predict) evaluated all options; 0 for
    /// samples.
    pub fn nodes_evaluated(&self) -> u64 {
        match &self.model {
            PredictorModel::Independent(model) => model.strips.nodes,
            PredictorModel::Samples(_) => 0,
        }
    }

    /// A perception in the middle of the belief.
    fn middle(&self) -> Perception {
        match &self.belief {
            Belief::Independent { alpha, gamma } => {
                Perception { alpha: alpha.quantile(0.5), gamma: gamma.quantile(0.5) }
            }
            Belief::Samples(set) => set.samples()[0].perception,
        }
    }
}

pub(super) fn check(risk_weight: f64) -> Result<(), Error> {
    match risk_weight >= 0.0 && risk_weight.is_finite() {
        true => Ok(()),
        false => {
            let sentence = format!("risk weight c_r = {risk_weight} m must be finite and not negative");
            Err(Error::new(sentence))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Initial values of the first calibration of the paper's four environments: lengths in metres and risks,
    /// rounded to four digits.
    const ENVIRONMENTS: [[(f64, f64); 4]; 4] = [
        [(41.8638, 0.6598), (17.4006, 0.3626), (14.3308, 0.5474), (21.3552, 0.2474)],
        [(12.7239, 0.9737), (14.2601, 0.9332), (23.0, 0.9131), (19.3294, 0.7824)],
        [(31.0082, 0.2019), (15.4348, 0.5423), (17.7575, 0.4069), (36.1109, 0.6077)],
        [(18.0658, 0.456), (28.5424, 0.2021), (13.3412, 0.6894), (18.0649, 0.456)],
    ];

    #[test]
    fn paper_table_1_model_column() {
        // Options 1 and 4 of Environment 4 are equal to four digits, so that only their sum is defined by
        // these numbers.
        let expected = [
            [0.0, 39.8, 35.4, 24.8],
            [51.6, 8.7, 0.0, 39.7],
            [2.8, 36.6, 60.5, 0.0],
            [36.0, 18.6, 45.5, 0.0],
        ];
        let mut predictor = Predictor::new(Belief::default(), 10.0).unwrap();
        let mut choice = ChoiceDistribution::default();
        for (number, (options, expected)) in ENVIRONMENTS.iter().zip(expected).enumerate() {
            let options = options.map(|(length, risk)| Prospect::new(length, risk));
            predictor.predict(&options, &mut choice);
            let mut percent: Vec<f64> = choice.probabilities().iter().map(|p| 100.0 * p).collect();
            if number == 3 {
                percent[0] += std::mem::take(&mut percent[3]);
            }
            for (found, wanted) in percent.iter().zip(expected) {
                assert!(
                    (found - wanted).abs() < 0.1,
                    "environment {}: {percent:?}, not {expected:?}",
                    number + 1
                );
            }
        }
    }
}

//! The options from where the team is, eq. (1), and what the human may prefer among them, eqs. (4) and (6).

use super::Episode;
use super::now::Now;
use super::places::Places;
use crate::coordination::{Mode, OptionCost, OptionTick, is_misaligned};
use crate::learning::Learner;
use crate::options::{OptionSet, Progress, Remaining, Waypoint};
use crate::preference::{ChoiceDistribution, Predictor, Prospect, Ways, objective_cost};
use serde::{Deserialize, Serialize};

/// The length (m) at which predictions cap an option, also one without a path. It is far beyond what a human
/// would choose.
const MAX_LENGTH_M: f64 = 1e6;

/// Remaining length and risk of every option from the team's position, in the order of the option set.
pub fn prospects(options: &OptionSet, progress: &Progress) -> Vec<Prospect> {
    options.all_remaining(progress).map(prospect).collect()
}

pub(super) fn prospect(remaining: Remaining) -> Prospect {
    Prospect { length: remaining.length.min(MAX_LENGTH_M), risk: remaining.risk }
}

/// Every option from where the team is.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluated {
    /// D_o and S_o, as humans and predictions take them.
    pub prospects: Vec<Prospect>,
    /// Which options have become one way.
    pub ways: Ways,
    /// D_o, S_o, J_o and omega_o.
    pub costs: Vec<OptionCost>,
}

impl Evaluated {
    /// Takes over known options.
    fn take_over(&mut self, options: &[OptionTick], ways: &Ways) {
        self.prospects.clear();
        self.prospects.extend(options.iter().map(|option| prospect(option.remaining)));
        self.ways.clone_from(ways);
        self.costs.clear();
        self.costs.extend(options.iter().map(OptionTick::cost));
    }

    /// Evaluates the options of a team that walks `toward` a waypoint on the option executed, none before the
    /// first step.
    fn fill(
        &mut self,
        options: &OptionSet,
        progress: &Progress,
        risk_weight: f64,
        toward: Option<Waypoint>,
        executed: Option<usize>,
    ) {
        let Self { prospects, ways, costs } = self;
        prospects.clear();
        costs.clear();
        for remaining in options.all_remaining(progress) {
            let prospect = prospect(remaining);
            let misaligned = toward.is_some_and(|toward| is_misaligned(toward, remaining.next));
            prospects.push(prospect);
            costs.push(OptionCost {
                remaining,
                objective: objective_cost(prospect, risk_weight),
                misaligned,
            });
        }
        ways.find(prospects.len(), executed, |a, b| {
            prospects[a] == prospects[b] && options.lead_the_same_way(progress, a, b)
        });
    }
}

/// The prediction of a distribution of (alpha, gamma) for the options.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Prediction {
    /// P_o; empty where it was not asked.
    pub choice: ChoiceDistribution,
    /// The options with P_o and J~_o.
    pub options: Vec<OptionTick>,
    expected: Vec<f64>,
}

/// The parts of a prediction that are needed.
#[derive(Clone, Copy)]
struct Asked {
    /// P_o, eq. (4).
    pub choice: bool,
    /// J~_o, eq. (6).
    pub expected: bool,
}

/// The distribution of (alpha, gamma) that predicts.
enum By<'p> {
    /// The belief before the episode, which the human's discomfort follows, eq. (5).
    Prior(&'p mut Predictor),
    /// The learned belief, which the robot's choices follow, eqs. (6) and (8), and its lapse rate.
    Learned(&'p mut Learner, f64),
}

impl Prediction {
    /// Whether it has as many numbers as another one.
    pub fn is_like(&self, other: &Self) -> bool {
        let numbers = |it: &Self| [it.choice.len(), it.options.len(), it.expected.len()];
        numbers(self) == numbers(other)
    }

    /// Takes over the prediction of known options.
    fn take_over(&mut self, known: &[OptionTick], asked: Asked) {
        let Self { choice, options, expected } = self;
        options.clear();
        options.extend_from_slice(known);
        let known = |is_asked: bool| if is_asked { known } else { &[] };
        choice.take_over(known(asked.choice).iter().map(|option| option.probability));
        expected.clear();
        expected.extend(known(asked.expected).iter().map(|option| option.expected));
    }

    /// Predicts for these options.
    fn fill(&mut self, evaluated: &Evaluated, by: By, asked: Asked) {
        let Self { choice, options, expected } = self;
        let (prospects, ways) = (&evaluated.prospects, &evaluated.ways);
        choice.clear();
        expected.clear();
        match by {
            By::Prior(prior) => {
                if asked.choice {
                    prior.predict_from(prospects, ways, choice);
                }
                if asked.expected {
                    prior.expected_costs(prospects, expected);
                }
            }
            By::Learned(learner, lapse_rate) => {
                if asked.choice {
                    learner.predict(prospects, ways, choice);
                    choice.add_lapses(lapse_rate);
                }
                if asked.expected {
                    learner.expected_costs(prospects, expected);
                }
            }
        }
        options.clear();
        let value = |of: &[f64], o: usize| of.get(o).copied().unwrap_or(f64::NAN);
        let costs = evaluated.costs.iter().enumerate();
        options.extend(costs.map(|(o, c)| c.predicted(value(choice.probabilities(), o), value(expected, o))));
    }
}

/// The probabilities of the options, by the belief of the robot and by the prior.
#[derive(Clone, Debug, Default)]
pub(super) struct Predicted {
    /// By the prior, which the human's discomfort follows, eq. (5).
    pub prior: Prediction,
    /// By what the robot has learned, if it learns: its choices, eqs. (6) and (8), follow that.
    pub learned: Option<Prediction>,
}

impl Predicted {
    /// The prediction that the robot acts on.
    pub fn robots(&self) -> &Prediction {
        self.learned.as_ref().unwrap_or(&self.prior)
    }

    /// The options of that prediction.
    pub fn options(&mut self) -> &mut Vec<OptionTick> {
        &mut self.learned.as_mut().unwrap_or(&mut self.prior).options
    }
}

impl Episode<'_> {
    /// The options from where the team is, and the probabilities with which the human may prefer them. `memory`
    /// is used again.
    pub(super) fn evaluate(&mut self, now: Now, memory: (Evaluated, Predicted)) -> (Evaluated, Predicted) {
        let (mut evaluated, Predicted { mut prior, mut learned }) = memory;
        let expected = now.mode == Mode::RobotLed || self.policy.predicts();
        let choice = expected || self.controller.anticipates() || self.settings.predict_while_human_leads;
        let asked = Asked { choice, expected };
        let key = &mut self.place_key;
        if self.places.is_some() {
            Places::key(key, &self.progress, now.executed, [choice, expected]);
        }
        let mut take = |options: &[OptionTick], ways: &Ways| {
            evaluated.take_over(options, ways);
            prior.take_over(options, asked);
        };
        let is_known = self.places.as_ref().is_some_and(|places| places.find(key, &mut take));
        if !is_known {
            // g(0) = 0: before the first step the team has no next waypoint
            let toward = now.executed.map(|executed| self.options.next(&self.progress, executed));
            let risk_weight = self.predictor.risk_weight();
            evaluated.fill(self.options, &self.progress, risk_weight, toward, now.executed);
            prior.fill(&evaluated, By::Prior(&mut self.predictor), asked);
            if let Some(places) = &self.places {
                places.keep(key, &prior.options, &evaluated.ways);
            }
        }
        if let Some(learner) = self.learner.as_deref_mut() {
            let by = By::Learned(learner, self.predictor.lapse_rate());
            learned.get_or_insert_default().fill(&evaluated, by, asked);
        }
        (evaluated, Predicted { prior, learned })
    }
}

//! The options from where the team is, eq. (1), and what the human may prefer among them, eqs. (4) and (6).

use super::Episode;
use super::now::Now;
use crate::coordination::{Mode, OptionCost, OptionTick, is_misaligned};
use crate::learning::Learner;
use crate::options::{OptionSet, Progress, Remaining, Waypoint};
use crate::preference::{ChoiceDistribution, Predictions, Predictor, Prospect, Ways, objective_cost};
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
    /// The options of a team that walks `toward` a waypoint on the option executed, none before the first
    /// step. `memory` is used again.
    fn at(
        options: &OptionSet,
        progress: &Progress,
        risk_weight: f64,
        toward: Option<Waypoint>,
        executed: Option<usize>,
        memory: Self,
    ) -> Self {
        let Self { mut prospects, mut ways, mut costs } = memory;
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
        Self { prospects, ways, costs }
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
    /// Memory for the search among known predictions.
    #[serde(skip)]
    key: Vec<u64>,
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
    /// The belief before the episode, which the human's discomfort follows, eq. (5), and what it gave in other
    /// episodes.
    Prior(&'p mut Predictor, Option<&'p Predictions>),
    /// The learned belief, which the robot's choices follow, eqs. (6) and (8), and its lapse rate.
    Learned(&'p mut Learner, f64),
}

impl Prediction {
    /// Whether it has as many numbers as another one.
    pub fn is_like(&self, other: &Self) -> bool {
        let numbers = |it: &Self| [it.choice.len(), it.options.len(), it.expected.len()];
        numbers(self) == numbers(other)
    }

    /// The prediction for these options. `memory` is used again.
    fn of(evaluated: &Evaluated, mut by: By, asked: Asked, memory: Self) -> Self {
        let Self { mut choice, mut options, mut expected, mut key } = memory;
        let (prospects, ways) = (&evaluated.prospects, &evaluated.ways);
        choice.clear();
        expected.clear();
        match &mut by {
            By::Prior(prior, Some(known)) if asked.choice => {
                let expected = asked.expected.then_some(&mut expected);
                known.predict(prior, (prospects, ways), &mut key, &mut choice, expected);
            }
            By::Prior(prior, _) if asked.choice => prior.predict_from(prospects, ways, &mut choice),
            By::Learned(learner, lapse_rate) if asked.choice => {
                learner.predict(prospects, ways, &mut choice);
                choice.add_lapses(*lapse_rate);
            }
            _ => {}
        }
        match &mut by {
            By::Prior(_, Some(_)) if asked.choice => {}
            By::Prior(prior, _) if asked.expected => prior.expected_costs(prospects, &mut expected),
            By::Learned(learner, _) if asked.expected => learner.expected_costs(prospects, &mut expected),
            _ => {}
        }
        options.clear();
        let value = |of: &[f64], o: usize| of.get(o).copied().unwrap_or(f64::NAN);
        let costs = evaluated.costs.iter().enumerate();
        options
            .extend(costs.map(|(o, c)| c.predicted(value(choice.probabilities(), o), value(&expected, o))));
        Self { choice, options, expected, key }
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
    /// The options from where the team is.
    pub(super) fn evaluate(&self, now: Now, memory: Evaluated) -> Evaluated {
        // g(0) = 0: before the first step the team has no next waypoint
        let toward = now.executed.map(|executed| self.options.next(&self.progress, executed));
        let risk_weight = self.predictor.risk_weight();
        Evaluated::at(self.options, &self.progress, risk_weight, toward, now.executed, memory)
    }

    /// The probabilities of the options that the human may prefer.
    pub(super) fn predict(&mut self, now: Now, evaluated: &Evaluated, memory: Predicted) -> Predicted {
        let expected = now.mode == Mode::RobotLed || self.policy.predicts();
        let choice = expected || self.controller.anticipates() || self.settings.predict_while_human_leads;
        let (asked, lapse_rate) = (Asked { choice, expected }, self.predictor.lapse_rate());
        let Predicted { prior, learned } = memory;
        let by = By::Prior(&mut self.predictor, self.predictions.as_deref());
        let prior = Prediction::of(evaluated, by, asked, prior);
        let learned = self.learner.as_deref_mut().map(|learner| {
            Prediction::of(evaluated, By::Learned(learner, lapse_rate), asked, learned.unwrap_or_default())
        });
        Predicted { prior, learned }
    }
}

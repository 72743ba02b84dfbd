//! How well answers follow the paper's perception of risk and others: each is fitted to all worlds but one, and
//! predicts the answers there.

use super::evidence::{answered, likelihoods};
use super::held_out::{Score, score};
use super::inputs::{InferenceModel, InferenceSettings};
use crate::fit::Answers;
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::math;
use cocarry::preference::{ALTERNATIVES, ChoiceGroup, Prospect, RiskPerception, StevensPrelec};
use serde::Serialize;

/// c_r that are tried: the given one times 2^(i/3), for i from minus to plus this number.
const STEPS: i32 = 12;

/// The number of c_r that are tried.
const WEIGHTS: usize = 2 * STEPS as usize + 1;

/// How well one perception of risk predicts answers in held-out worlds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PerceptionScore {
    /// The perception.
    pub perception: String,
    /// The parameters in which people differ, with the ends of their ranges.
    pub parameters: Vec<(String, [f64; 2])>,
    /// Predicted by each participant's posterior from the other worlds, with the given c_r.
    pub posterior: Score,
    /// Predicted by the shares of all people, with the given c_r.
    pub prior: Score,
    /// As `posterior`, with the c_r under which everybody's answers in the other worlds are most probable.
    pub fitted_posterior: Score,
    /// As `prior`, with the same c_r.
    pub fitted_prior: Score,
    /// Least and largest c_r of these fits, m; they are the given one times 2^(i/3), from a sixteenth to 16
    /// times it.
    pub fitted_risk_weights: [f64; 2],
}

/// People who make the same choices in all worlds, with one c_r.
struct Fitted {
    risk_weight: f64,
    groups: Vec<ChoiceGroup>,
    /// By participant, world and group, the likelihood of the answer; none where there is no answer.
    likelihoods: Vec<Vec<Option<Vec<f64>>>>,
}

impl Fitted {
    fn new(risk_weight: f64, groups: Vec<ChoiceGroup>, answers: &Answers, lapse_rate: f64) -> Self {
        let of = |shares: &Vec<f64>, w: usize| -> Vec<f64> {
            let by_option = likelihoods(shares, lapse_rate);
            let mean =
                |group: &ChoiceGroup| group.preferred[w].iter().zip(&by_option).map(|(p, l)| p * l).sum();
            groups.iter().map(mean).collect()
        };
        let likelihoods = answers.shares.iter().map(|worlds| {
            let worlds = worlds.iter().enumerate();
            worlds.map(|(w, shares)| shares.as_ref().map(|shares| of(shares, w))).collect()
        });
        let likelihoods = likelihoods.collect();
        Self { risk_weight, groups, likelihoods }
    }

    /// The shares of the groups times the likelihoods of a participant's answers in all worlds but one.
    fn weights(&self, participant: usize, held_out: usize) -> Vec<f64> {
        let mut weights: Vec<f64> = self.groups.iter().map(|group| group.share).collect();
        let answered = self.likelihoods[participant].iter().enumerate().filter(|(w, _)| *w != held_out);
        for own in answered.filter_map(|(_, own)| own.as_ref()) {
            weights.iter_mut().zip(own).for_each(|(weight, likelihood)| *weight *= likelihood);
        }
        weights
    }

    /// The logarithm of the probability of everybody's answers in all worlds but one.
    fn evidence(&self, held_out: usize) -> f64 {
        let of = |p: usize| math::ln(self.weights(p, held_out).iter().sum());
        (0..self.likelihoods.len()).map(of).sum()
    }

    /// The probability of each answer in a world for people of these weights; that nobody gives any if all
    /// are 0.
    fn predicted(&self, weights: &[f64], world: usize, lapse_rate: f64) -> Vec<f64> {
        let total: f64 = weights.iter().sum();
        let options = self.groups.first().map_or(0, |group| group.preferred[world].len());
        let of = |o: usize| -> f64 {
            let preferred =
                self.groups.iter().zip(weights).map(|(group, weight)| weight * group.preferred[world][o]);
            preferred.sum::<f64>() / total
        };
        match total > 0.0 {
            true => answered(&(0..options).map(of).collect::<Vec<_>>(), lapse_rate),
            false => vec![0.0; options],
        }
    }
}

/// The number of units of work of [`compare_perceptions`], for progress.
pub const PERCEPTION_UNITS: usize = (1 + ALTERNATIVES.len()) * WEIGHTS;

/// Compares the belief's perception and the alternatives on held-out worlds, best first by the score of the
/// posterior with a fitted c_r. Empty with fewer than two worlds.
///
/// # Errors
/// c_r is 0: no perception of risk matters.
pub fn compare_perceptions(
    answers: &Answers,
    model: &InferenceModel,
    settings: &InferenceSettings,
    on_done: OnDone,
) -> Result<Vec<PerceptionScore>, Error> {
    let worlds = answers.situations.len();
    if worlds < 2 {
        return Ok(Vec::new());
    }
    if model.risk_weight <= 0.0 {
        return Err(Error::new(format!(
            "risk weight c_r = {} m: perceptions of risk are compared by what risk costs; it must be greater than 0",
            model.risk_weight
        )));
    }
    let situations: Vec<&[Prospect]> = answers.situations.iter().map(|s| s.prospects.as_slice()).collect();
    let paper = StevensPrelec::new(model.belief.clone());
    let perceptions: Vec<&dyn RiskPerception> =
        [&paper as &dyn RiskPerception].into_iter().chain(ALTERNATIVES).collect();
    let all = in_parallel(perceptions.len() * WEIGHTS, on_done, |i| {
        let step = (i % WEIGHTS) as i32 - STEPS;
        let risk_weight = model.risk_weight * math::pow(2.0, f64::from(step) / 3.0);
        let groups = perceptions[i / WEIGHTS].groups(&situations, risk_weight);
        Fitted::new(risk_weight, groups, answers, settings.lapse_rate)
    });
    let mut rows: Vec<PerceptionScore> = perceptions
        .iter()
        .zip(all.chunks(WEIGHTS))
        .map(|(p, fitted)| row(*p, fitted, answers, settings))
        .collect();
    let best = |row: &PerceptionScore| row.fitted_posterior.log_score.unwrap_or(f64::NEG_INFINITY);
    rows.sort_by(|a, b| best(b).total_cmp(&best(a)));
    Ok(rows)
}

fn row(
    perception: &dyn RiskPerception,
    all: &[Fitted],
    answers: &Answers,
    settings: &InferenceSettings,
) -> PerceptionScore {
    let given = &all[STEPS as usize];
    // by posterior and prior with the given c_r, then with the fitted one
    let mut predictions: [Vec<(&[f64], Vec<f64>)>; 4] = Default::default();
    let mut ends = [f64::INFINITY, 0.0];
    for w in 0..answers.situations.len() {
        let mut best = (given, given.evidence(w));
        for other in all {
            let evidence = other.evidence(w);
            if evidence > best.1 {
                best = (other, evidence);
            }
        }
        let fitted = best.0;
        ends = [ends[0].min(fitted.risk_weight), ends[1].max(fitted.risk_weight)];
        for (p, worlds) in answers.shares.iter().enumerate() {
            let Some(shares) = &worlds[w] else { continue };
            for (which, of) in [given, fitted].into_iter().enumerate() {
                let everybody: Vec<f64> = of.groups.iter().map(|group| group.share).collect();
                let by = [of.weights(p, w), everybody];
                for (kind, weights) in by.iter().enumerate() {
                    predictions[2 * which + kind]
                        .push((shares, of.predicted(weights, w, settings.lapse_rate)));
                }
            }
        }
    }
    let [posterior, prior, fitted_posterior, fitted_prior] =
        predictions.map(|all| score(all.iter().map(|(shares, predicted)| (*shares, predicted.as_slice()))));
    let parameters = perception.parameters().iter().map(|p| (p.name.to_owned(), p.range));
    PerceptionScore {
        perception: perception.name().to_owned(),
        parameters: parameters.collect(),
        posterior,
        prior,
        fitted_posterior,
        fitted_prior,
        fitted_risk_weights: ends,
    }
}

//! Inference of a population from mean answers of many people, where the answers of each are not known.
//!
//! The percentages are taken as numbers of choices: as many people as there are, each choosing one option.

use super::evidence::Perceived;
use super::inputs::{InferenceModel, InferenceSettings};
use super::population::{Grid, Population, weights};
use crate::fit::Answers;
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::error::Place;
use cocarry::math;
use cocarry::preference::{Belief, Marginal, Ways, with_lapses};
use serde::Serialize;

/// The population inferred from mean answers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Means {
    /// The population of alpha and gamma.
    pub population: Population,
    /// All options.
    pub rows: Vec<MeansRow>,
}

/// The mean answers for an option, and the model's, percent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeansRow {
    /// World.
    pub world: String,
    /// Option, by name.
    pub option: String,
    /// Mean answer.
    pub answered_percent: f64,
    /// Mean over the posterior populations, lapses included.
    pub posterior_percent: f64,
    /// Mean over the prior populations, lapses included.
    pub prior_percent: f64,
}

/// Infers the population from mean answers of `people` persons; each participant of the file is such a mean.
///
/// # Errors
/// The belief is samples, or no population gives these answers without lapses.
pub fn infer_means(
    answers: &Answers,
    people: u64,
    model: &InferenceModel,
    settings: &InferenceSettings,
    on_done: OnDone,
) -> Result<Means, Error> {
    let [alphas, gammas] = model.belief.ranges();
    let [alpha, gamma] = [Marginal::uniform(alphas[0], alphas[1])?, Marginal::uniform(gammas[0], gammas[1])?];
    let prior = Perceived::new(&Belief::Independent { alpha, gamma }, model.risk_weight)?;
    let grid = Grid::new([alphas, gammas])?;
    let worlds = &answers.situations;
    let options: Vec<(usize, usize)> =
        worlds.iter().enumerate().flat_map(|(w, s)| (0..s.options.len()).map(move |o| (w, o))).collect();
    // P_o of every population
    let preferred = in_parallel(options.len(), on_done, |i| {
        let (w, o) = options[i];
        let is_own: Vec<f64> =
            (0..worlds[w].options.len()).map(|other| f64::from(u8::from(other == o))).collect();
        let mut own = prior.clone();
        match own.learn(&worlds[w].prospects, &Ways::default(), &is_own) {
            false => vec![0.0; grid.len()],
            true => {
                let share = math::exp(own.log_evidence);
                let steps = grid.steps(|gamma| own.posterior.steps_at(gamma));
                grid.integrals(&steps).iter().map(|value| (share * value).clamp(0.0, 1.0)).collect()
            }
        }
    });
    let probability = |i: usize, node: usize| {
        with_lapses(preferred[i][node], settings.lapse_rate, worlds[options[i].0].options.len())
    };
    let answered: Vec<(f64, f64)> = options
        .iter()
        .map(|&(w, o)| {
            let all = answers.shares.iter().filter_map(|shares| shares[w].as_ref());
            (all.clone().map(|shares| shares[o]).sum(), all.count() as f64)
        })
        .collect();
    let log = |node: usize| -> f64 {
        let terms = answered.iter().enumerate().filter(|(_, (sum, _))| *sum > 0.0);
        terms.map(|(i, (sum, _))| people as f64 * sum * math::ln(probability(i, node))).sum()
    };
    let logs: Vec<f64> = (0..grid.len()).map(log).collect();
    let Some((weights, evidence)) = weights(&logs) else {
        return Err(Error::at(
            Place::file(&answers.file),
            "no population gives these mean answers without lapses: an option was chosen that no alpha and gamma of the belief prefers; give a --lapse-rate above 0",
        ));
    };
    let even = 1.0 / grid.len() as f64;
    let row = |i: usize| {
        let (w, o) = options[i];
        let mean = |weight: &dyn Fn(usize) -> f64| -> f64 {
            100.0 * (0..grid.len()).map(|node| weight(node) * probability(i, node)).sum::<f64>()
        };
        MeansRow {
            world: worlds[w].world.clone(),
            option: worlds[w].options[o].clone(),
            answered_percent: 100.0 * answered[i].0 / answered[i].1,
            posterior_percent: mean(&|node| weights[node]),
            prior_percent: mean(&|_| even),
        }
    };
    let rows = (0..options.len()).map(row).collect();
    Ok(Means { population: Population::new(&grid, &weights, evidence), rows })
}

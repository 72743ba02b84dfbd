//! How well answers in one world are predicted from the answers in the others, and whether there are as many
//! answers for every option as predicted.

use super::evidence::{Perceived, answered, predicted};
use super::inputs::{InferenceModel, InferenceSettings};
use crate::fit::{Answers, RiskWeightSettings, fit_risk_weight};
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::math;
use cocarry::preference::Predictor;
use serde::Serialize;

/// How well answers were predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Score {
    /// Mean logarithm of the probability of an answer, nats; `None` if an answer had probability 0.
    pub log_score: Option<f64>,
    /// Share of answers whose largest percentage is that of the most probable option.
    pub hits: f64,
}

/// How well the answers in one world, or in all, were predicted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// The world; `None` for all.
    pub world: Option<String>,
    /// Number of answers.
    pub answers: usize,
    /// Predicted by the participant's posterior from the other worlds.
    pub posterior: Score,
    /// Predicted by the belief alone.
    pub prior: Score,
    /// Predicted by c_r and lapse rate of the largest likelihood for everyone in the other worlds; `None` if
    /// these do not determine c_r.
    pub fit: Option<Score>,
}

/// Answers for an option, and what was predicted from other worlds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OptionCheck {
    /// World.
    pub world: String,
    /// Option, by name.
    pub option: String,
    /// The sum of the participants' shares.
    pub observed: f64,
    /// The sum of the predicted probabilities.
    pub expected: f64,
    /// The probability of fewer choices than observed, plus half that of as many.
    pub rank: f64,
    /// The probability of so few or so many: twice the smaller tail.
    pub p_value: f64,
}

/// One answer and what was predicted: by posterior, prior and fit.
struct Predicted {
    world: usize,
    shares: Vec<f64>,
    by: [Option<Vec<f64>>; 3],
}

/// Holds out every world in turn.
pub(super) fn held_out(
    answers: &Answers,
    prior: &Perceived,
    model: &InferenceModel,
    settings: &InferenceSettings,
    on_done: OnDone,
) -> Result<(Vec<HeldOut>, Vec<OptionCheck>), Error> {
    let worlds = answers.situations.len();
    let fits = in_parallel(worlds, on_done, |w| fitted(answers, model, w));
    let lapse_rate = settings.lapse_rate;
    let of = |p: usize| -> Result<Vec<Predicted>, Error> {
        let mut all = Vec::new();
        for (w, shares) in answers.shares[p].iter().enumerate() {
            let Some(shares) = shares.clone() else { continue };
            let situation = &answers.situations[w];
            let by = |mut known: Perceived| answered(&predicted(&mut known.posterior, situation), lapse_rate);
            let others = prior.after(answers, p, Some(w), lapse_rate)?;
            let by = [Some(by(others)), Some(by(prior.clone())), fits[w].clone()];
            all.push(Predicted { world: w, shares, by });
        }
        Ok(all)
    };
    let people = in_parallel(answers.participants.len(), on_done, of);
    let people: Vec<Vec<Predicted>> = people.into_iter().collect::<Result<_, _>>()?;
    let all: Vec<&Predicted> = people.iter().flatten().collect();
    let mut rows = Vec::new();
    let mut checks = Vec::new();
    for (w, situation) in answers.situations.iter().enumerate() {
        let own: Vec<&Predicted> = all.iter().copied().filter(|p| p.world == w).collect();
        rows.push(row(Some(situation.world.clone()), &own));
        for (o, option) in situation.options.iter().enumerate() {
            let probabilities: Vec<f64> = own.iter().filter_map(|p| Some(p.by[0].as_ref()?[o])).collect();
            let observed: f64 = own.iter().map(|p| p.shares[o]).sum();
            let rank = rank(&probabilities, observed);
            checks.push(OptionCheck {
                world: situation.world.clone(),
                option: option.clone(),
                observed,
                expected: probabilities.iter().sum(),
                rank,
                p_value: (2.0 * rank.min(1.0 - rank)).clamp(0.0, 1.0),
            });
        }
    }
    rows.push(row(None, &all));
    Ok((rows, checks))
}

/// The probabilities in a held-out world of c_r and lapse rate fitted to the other worlds.
fn fitted(answers: &Answers, model: &InferenceModel, world: usize) -> Option<Vec<f64>> {
    let held_out = answers.situations[world].world.clone();
    let settings = RiskWeightSettings {
        resamples: 0,
        held_out: vec![held_out.clone()],
        ..RiskWeightSettings::default()
    };
    let predictor = Predictor::new(model.belief.clone(), model.risk_weight).ok()?;
    let fit = fit_risk_weight(answers, &predictor, &settings, &|| ()).ok()?;
    let rows = fit.rows.iter().filter(|row| row.world == held_out);
    let preferred: Vec<f64> = rows.map(|row| 0.01 * row.likelihood_percent).collect();
    Some(answered(&preferred, fit.likelihood.lapse.expect("the likelihood estimates the lapse rate")))
}

/// The score of answers, each with the probabilities that were predicted for it.
pub(super) fn score<'a>(answers: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> Score {
    let (mut sum, mut hits, mut count) = (0.0, 0.0, 0);
    for (shares, probabilities) in answers {
        let terms = shares.iter().zip(probabilities).filter(|(share, _)| **share > 0.0);
        sum += terms.map(|(share, p)| share * math::ln(*p)).sum::<f64>();
        hits += hit(shares, probabilities);
        count += 1;
    }
    let n = f64::from(count.max(1));
    Score { log_score: (sum / n).is_finite().then_some(sum / n), hits: hits / n }
}

fn row(world: Option<String>, all: &[&Predicted]) -> HeldOut {
    let scored = |by: usize| -> Option<Score> {
        let pairs = all.iter().map(|one| Some((one.shares.as_slice(), one.by[by].as_deref()?)));
        Some(score(pairs.collect::<Option<Vec<_>>>()?.into_iter()))
    };
    HeldOut {
        world,
        answers: all.len(),
        posterior: scored(0).unwrap_or_default(),
        prior: scored(1).unwrap_or_default(),
        fit: scored(2),
    }
}

/// Whether the most probable option has the largest share: a part where several have it.
fn hit(shares: &[f64], probabilities: &[f64]) -> f64 {
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let [share, probability] = [most(shares), most(probabilities)];
    let likeliest: Vec<usize> = (0..shares.len()).filter(|&o| probabilities[o] == probability).collect();
    let right = likeliest.iter().filter(|&&o| shares[o] == share).count();
    right as f64 / likeliest.len().max(1) as f64
}

/// The probability of fewer choices than `observed`, plus half that of as many, if each person chooses the
/// option with their own probability. Between whole numbers it is interpolated.
fn rank(probabilities: &[f64], observed: f64) -> f64 {
    let mut counts = vec![1.0];
    for p in probabilities {
        counts.push(0.0);
        for n in (0..counts.len()).rev() {
            let fewer = if n > 0 { counts[n - 1] } else { 0.0 };
            counts[n] = (1.0 - p) * counts[n] + p * fewer;
        }
    }
    let at = |n: usize| -> f64 {
        counts.iter().take(n).sum::<f64>() + 0.5 * counts.get(n).copied().unwrap_or_default()
    };
    let below = observed.max(0.0).floor() as usize;
    let part = observed - below as f64;
    (1.0 - part) * at(below) + part * at(below + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_ranks_of_counts() {
        // binomial with 3 and 1/2: 1, 3, 3, 1 eighths
        let even = [0.5; 3];
        for (observed, wanted) in [(0.0, 0.0625), (1.0, 0.3125), (1.5, 0.5), (3.0, 0.9375)] {
            assert!((rank(&even, observed) - wanted).abs() < 1e-12, "{observed}");
        }
        // certain: 0 and 1
        assert!((rank(&[1.0, 0.0], 1.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn closed_form_hits_and_ties() {
        assert_eq!(hit(&[0.0, 1.0], &[0.4, 0.6]), 1.0);
        assert_eq!(hit(&[1.0, 0.0], &[0.4, 0.6]), 0.0);
        assert_eq!(hit(&[1.0, 0.0, 0.0], &[0.4, 0.4, 0.2]), 0.5);
        assert_eq!(hit(&[0.5, 0.5], &[0.4, 0.6]), 1.0);
    }
}

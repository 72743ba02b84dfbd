//! The risk weight c_r that fits participants' percentages best, by least squares and by likelihood.
//!
//! *Least squares*, as in the paper: squared differences between the mean percentages of all participants and
//! P_o, with equal weights for all options of all worlds.
//!
//! *Likelihood*: an answer is taken as one choice, distributed over the options as the participant says (the
//! multinomial log-likelihood, sum of share times ln q_o). Percentages of 0 are common, which a Dirichlet
//! density does not allow. P_o is exactly 0 for options that another one beats in both length and risk,
//! although people give them some percent. The model is therefore q_o = (1 - lapse) P_o + lapse / options:
//! with probability `lapse`, fitted along with c_r, an answer does not come from the model.
//!
//! The likelihood may not determine c_r: with one world of two options, a larger c_r with more lapses gives
//! the same probabilities. [`Estimate::undetermined`] is the range of such c_r; of these, the estimate has
//! the fewest lapses.

use super::Answers;
use super::minimum::{least, level, refined, scanned, valleys};
use crate::parallel::{OnDone, in_parallel};
use crate::statistics;
use cocarry::Error;
use cocarry::error::Place;
use cocarry::math;
use cocarry::preference::{ChoiceDistribution, Predictor};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The difference (percentage points) of root mean square errors up to which a c_r fits nearly as well as the
/// best one.
pub const CELL_ERROR: f64 = 0.5;

/// The limitation of least squares, reported with every c_r that they give.
pub const LEAST_SQUARES_CAUTION: &str = "Least squares assume that every answer follows the model. Answers that do not (lapses) bias c_r, and the interval does not \
     include that bias. The likelihood estimates the share of lapses along with c_r and is recommended.";

/// The difference of log-likelihoods, per answer, up to which two values of c_r are equally likely: rounding.
const EQUALLY_LIKELY: f64 = 1e-10;

/// The lapse rate from which on answers tell nothing of c_r: it is shown as 100.0 %.
const ALL_LAPSES: f64 = 0.9995;
/// The width of an interval, as a share of c_r, up to which all resamples gave one c_r: c_r is found to a
/// millionth.
const ONE_VALUE: f64 = 1e-5;

/// Settings of the fit of c_r.
#[derive(Clone, Debug)]
pub struct RiskWeightSettings {
    /// Range of c_r, m.
    pub range: [f64; 2],
    /// Number of bootstrap resamples of the participants.
    pub resamples: usize,
    /// Seed of the resampling.
    pub seed: u64,
    /// Worlds whose answers are held out of the fit, by their names in the file.
    pub held_out: Vec<String>,
}

impl Default for RiskWeightSettings {
    fn default() -> Self {
        Self { range: [0.1, 1000.0], resamples: 1000, seed: 0, held_out: Vec::new() }
    }
}

/// A fitted c_r.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// c_r, m. Of equally likely ones, the one with the fewest lapses.
    #[serde(rename = "risk_weight_m")]
    pub risk_weight: f64,
    /// The least and the largest c_r that are as likely as `risk_weight`, each with its own lapse, m: the
    /// answers do not determine c_r. `None` where one c_r is the likeliest, and for least squares.
    #[serde(rename = "undetermined_m")]
    pub undetermined: Option<[f64; 2]>,
    /// Its 95 % bootstrap interval over participants, m; `None` for a single participant, where c_r is
    /// undetermined, and where all resamples have the same c_r.
    #[serde(rename = "interval_m")]
    pub interval: Option<[f64; 2]>,
    /// Share of answers that do not come from the model; `None` for least squares.
    pub lapse: Option<f64>,
    /// Whether c_r is at an end of its range, so that the answers do not bound it.
    pub is_at_end: bool,
    /// Other local optima of the criterion, m, best first.
    #[serde(rename = "other_optima_m")]
    pub other_optima: Vec<f64>,
    /// Errors in the fitted worlds.
    pub fitted: Errors,
    /// Errors in the held-out worlds; `None` without any.
    pub held_out: Option<Errors>,
}

/// Differences between P_o and mean answers, percentage points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square.
    pub rms: f64,
    /// Mean absolute value.
    pub mean_absolute: f64,
    /// Largest absolute value.
    pub largest: f64,
}

/// Answers and fits of an option, percent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedOption {
    /// World, by its name in the file.
    pub world: String,
    /// Whether the world was held out.
    pub is_held_out: bool,
    /// Option, by name.
    pub option: String,
    /// Answers of the participants who were asked.
    pub answers_percent: Vec<f64>,
    /// Mean answer.
    pub mean_percent: f64,
    /// P_o with c_r by least squares.
    pub least_squares_percent: f64,
    /// P_o with c_r by likelihood (without lapses).
    pub likelihood_percent: f64,
}

/// The fit of c_r.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RiskWeightFit {
    /// The estimate by least squares.
    pub least_squares: Estimate,
    /// The estimate by likelihood.
    pub likelihood: Estimate,
    /// The smallest and the largest c_r whose rms error in the fitted worlds is at most [`CELL_ERROR`] above
    /// the minimum, m.
    #[serde(rename = "nearly_as_good_m")]
    pub nearly_as_good: [f64; 2],
    /// c_r (m) and the rms error in the fitted worlds, percentage points.
    pub curve: Vec<(f64, f64)>,
    /// All options.
    pub rows: Vec<FittedOption>,
}

impl RiskWeightFit {
    /// Whether the likelihood determines c_r. Only then is its estimate recommended.
    pub fn is_determined(&self) -> bool {
        self.likelihood.undetermined.is_none()
    }

    /// The limitation of the estimates, in sentences that end with a period and a blank.
    pub fn caution(&self) -> String {
        match self.likelihood.undetermined {
            Some(_) if self.likelihood.lapse.is_some_and(|lapse| lapse >= ALL_LAPSES) => {
                "The likelihood does not determine c_r: with a lapse rate of 100 %, no answer comes from the model, whatever c_r is. None is recommended.".to_owned()
            }
            None => LEAST_SQUARES_CAUTION.to_owned(),
            Some([low, high]) => format!(
                "The likelihood does not determine c_r: every c_r from {low:.2} to {high:.2} m, with its own lapse, is equally likely. The one shown has the fewest \
                 lapses; none is recommended. Answers in more worlds, or in worlds with more options, separate c_r from lapses."
            ),
        }
    }
}

/// The c_r of the largest likelihood.
struct Likeliest {
    risk_weight: f64,
    lapse: f64,
    /// The ends of the range of equally likely c_r, if there is more than one.
    undetermined: Option<[f64; 2]>,
    /// The negative log-likelihoods at the values tried.
    losses: Vec<f64>,
}

/// P_o at the values of c_r tried.
struct ChoiceModel<'a> {
    answers: &'a Answers,
    /// The fitted worlds.
    fitted: Vec<usize>,
    scanned: Vec<f64>,
    /// P_o by value tried, world and option.
    probabilities: Vec<Vec<Vec<f64>>>,
}

/// The sum of the answers to each world; a resample counts some participants several times.
struct Weights {
    /// Sums by world and option.
    sums: Vec<Vec<f64>>,
    /// Number of answers by world.
    counts: Vec<f64>,
}

/// Fits c_r with the predictor's belief. The predictor's own c_r has no effect.
///
/// # Errors
/// A held-out world has no answers, no world is left to fit, or the answers are independent of
/// c_r.
pub fn fit_risk_weight(
    answers: &Answers,
    predictor: &Predictor,
    settings: &RiskWeightSettings,
    on_done: OnDone,
) -> Result<RiskWeightFit, Error> {
    let fitted = fitted_worlds(answers, &settings.held_out)?;
    let mut predictor = predictor.clone();
    let scanned = scanned(settings.range);
    let probabilities = scanned.iter().map(|c| {
        (0..answers.situations.len()).map(|w| probabilities(answers, &mut predictor, w, *c)).collect()
    });
    let model = ChoiceModel { answers, fitted, probabilities: probabilities.collect(), scanned };
    if model.is_flat() {
        let [lower, upper] = settings.range;
        let sentence = format_args!(
            "the answers do not determine c_r: in every fitted world, P_o is the same for all c_r from {lower} to {upper} m"
        );
        return Err(Error::at(Place::file(&answers.file), sentence));
    }
    let everyone: Vec<usize> = (0..answers.participants.len()).collect();
    let weights = Weights::of(answers, &everyone);
    let samples = bootstrap(&model, &predictor, settings, on_done);

    let (by_squares, squares) = model.least_squares(&weights, &mut predictor);
    let likeliest = model.maximum_likelihood(&weights, &mut predictor);
    let estimate = |found: &Likeliest, lapse, samples: Vec<f64>, predictor: &mut Predictor| {
        let &Likeliest { risk_weight, undetermined, ref losses, .. } = found;
        let errors = |held_out: bool| model.errors(&weights, predictor, risk_weight, held_out);
        let [fitted, held_out] = [false, true].map(errors);
        let best = least(losses);
        let is_other = |i: &usize| {
            *i != best && undetermined.is_none_or(|[low, high]| !(low..=high).contains(&model.scanned[*i]))
        };
        let mut others: Vec<usize> = valleys(losses).into_iter().filter(is_other).collect();
        others.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        Estimate {
            risk_weight,
            undetermined,
            interval: if undetermined.is_some() { None } else { interval(samples) },
            lapse,
            is_at_end: undetermined.is_none() && (best == 0 || best + 1 == losses.len()),
            other_optima: others.into_iter().map(|i| model.scanned[i]).collect(),
            fitted: fitted.unwrap_or(Errors { rms: 0.0, mean_absolute: 0.0, largest: 0.0 }),
            held_out,
        }
    };
    let (by_square, by_chance): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
    let by_squares = Likeliest { risk_weight: by_squares, lapse: 0.0, undetermined: None, losses: squares };
    let least_squares = estimate(&by_squares, None, by_square, &mut predictor);
    let likelihood = estimate(&likeliest, Some(likeliest.lapse), by_chance, &mut predictor);

    let rms: Vec<f64> = by_squares.losses.iter().map(|s| 100.0 * s.sqrt()).collect();
    let good = |i: &usize| rms[*i] <= least_squares.fitted.rms + CELL_ERROR;
    let mut indices = 0..rms.len();
    let [first, last] = [indices.clone().find(good), indices.rfind(good)];
    let end = |index: Option<usize>| index.map_or(least_squares.risk_weight, |i| model.scanned[i]);
    let nearly_as_good =
        [end(first).min(least_squares.risk_weight), end(last).max(least_squares.risk_weight)];
    Ok(RiskWeightFit {
        rows: model.rows(&mut predictor, least_squares.risk_weight, likelihood.risk_weight),
        curve: model.scanned.iter().copied().zip(rms.iter().copied()).collect(),
        nearly_as_good,
        least_squares,
        likelihood,
    })
}

fn fitted_worlds(answers: &Answers, held_out: &[String]) -> Result<Vec<usize>, Error> {
    let worlds: Vec<&String> = answers.situations.iter().map(|s| &s.world).collect();
    let wrong = |reason: String| Error::at(Place::file(&answers.file), reason);
    if let Some(unknown) = held_out.iter().find(|name| !worlds.contains(name)) {
        let known: Vec<_> = worlds.iter().map(|name| name.as_str()).collect();
        return Err(wrong(format!(
            "cannot hold out {unknown}, which has no answers; expected one of: {}",
            known.join(", ")
        )));
    }
    let fitted: Vec<usize> = (0..worlds.len()).filter(|&w| !held_out.contains(worlds[w])).collect();
    match fitted.is_empty() {
        true => Err(wrong("all worlds are held out; at least one must be left to fit c_r".to_owned())),
        false => Ok(fitted),
    }
}

/// c_r by either method for resamples of the participants; `None` if there is only one participant.
fn bootstrap(
    model: &ChoiceModel,
    predictor: &Predictor,
    settings: &RiskWeightSettings,
    on_done: OnDone,
) -> Vec<(f64, f64)> {
    let n = model.answers.participants.len();
    if n < 2 {
        return Vec::new();
    }
    let samples = in_parallel(settings.resamples, on_done, |i| {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(i as u64);
        let drawn: Vec<usize> = (0..n).map(|_| rng.random_range(0..n)).collect();
        let weights = Weights::of(model.answers, &drawn);
        // the resampled participants may not have been asked about any fitted world
        let is_some = model.fitted.iter().any(|&w| weights.counts[w] > 0.0);
        let mut predictor = predictor.clone();
        is_some.then(|| {
            let (by_squares, _) = model.least_squares(&weights, &mut predictor);
            (by_squares, model.maximum_likelihood(&weights, &mut predictor).risk_weight)
        })
    });
    samples.into_iter().flatten().collect()
}

/// The central 95 %, if the samples differ.
fn interval(samples: Vec<f64>) -> Option<[f64; 2]> {
    statistics::quantiles(samples, [0.025, 0.975]).filter(|[low, high]| high - low > ONE_VALUE * high)
}

fn probabilities(answers: &Answers, predictor: &mut Predictor, world: usize, c_r: f64) -> Vec<f64> {
    let mut choice = ChoiceDistribution::default();
    // the range has been checked, so every number in it is a valid weight
    if predictor.set_risk_weight(c_r).is_ok() {
        predictor.predict(&answers.situations[world].prospects, &mut choice);
    }
    choice.probabilities().to_vec()
}

impl Weights {
    fn of(answers: &Answers, participants: &[usize]) -> Self {
        let mut sums: Vec<Vec<f64>> = answers.situations.iter().map(|s| vec![0.0; s.options.len()]).collect();
        let mut counts = vec![0.0; sums.len()];
        for &p in participants {
            for (w, shares) in answers.shares[p].iter().enumerate() {
                let Some(shares) = shares else { continue };
                counts[w] += 1.0;
                sums[w].iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
            }
        }
        Self { sums, counts }
    }

    fn means(&self, world: usize) -> impl Iterator<Item = f64> {
        self.sums[world].iter().map(move |sum| sum / self.counts[world])
    }
}

impl ChoiceModel<'_> {
    fn is_flat(&self) -> bool {
        let first = &self.probabilities[0];
        self.probabilities.iter().all(|p| self.fitted.iter().all(|&w| p[w] == first[w]))
    }

    /// Mean square of the differences between P_o and mean answers, over the options of all fitted worlds
    /// with answers.
    fn square<'p>(&self, weights: &Weights, p: impl Fn(usize) -> &'p [f64]) -> f64 {
        let (mut sum, mut n) = (0.0, 0);
        for &w in self.fitted.iter().filter(|&&w| weights.counts[w] > 0.0) {
            sum += p(w).iter().zip(weights.means(w)).map(|(p, mean)| math::squared(p - mean)).sum::<f64>();
            n += p(w).len();
        }
        sum / n as f64
    }

    fn at(&self, predictor: &mut Predictor, c_r: f64) -> Vec<Vec<f64>> {
        let worlds = 0..self.answers.situations.len();
        let of = |w: usize| match self.fitted.contains(&w) {
            true => probabilities(self.answers, predictor, w, c_r),
            false => Vec::new(),
        };
        worlds.map(of).collect()
    }

    /// c_r, and the mean squares at the values tried.
    fn least_squares(&self, weights: &Weights, predictor: &mut Predictor) -> (f64, Vec<f64>) {
        let squares: Vec<f64> = self.probabilities.iter().map(|p| self.square(weights, |w| &p[w])).collect();
        let c_r = refined(&self.scanned, least(&squares), |c| {
            let p = self.at(predictor, c);
            self.square(weights, |w| &p[w])
        });
        (c_r, squares)
    }

    /// c_r with its lapse; of equally likely ones, the one with the fewest lapses.
    fn maximum_likelihood(&self, weights: &Weights, predictor: &mut Predictor) -> Likeliest {
        let losses: Vec<f64> =
            self.probabilities.iter().map(|p| self.with_best_lapse(weights, |w| &p[w]).1).collect();
        let mut at = |c_r: f64| {
            let p = self.at(predictor, c_r);
            self.with_best_lapse(weights, |w| &p[w])
        };
        let mut risk_weight = refined(&self.scanned, least(&losses), |c| at(c).1);
        let (mut lapse, loss) = at(risk_weight);
        let answers: f64 = self.fitted.iter().map(|&w| weights.counts[w]).sum();
        let limit = loss + EQUALLY_LIKELY * answers;
        let undetermined = level(&self.scanned, &losses, limit, |c| at(c).1);
        if let Some(ends) = undetermined {
            let equal = self.scanned.iter().zip(&losses).filter(|(_, loss)| **loss <= limit);
            for c_r in ends.into_iter().chain(equal.map(|(c_r, _)| *c_r)) {
                let (fewer, _) = at(c_r);
                if fewer < lapse {
                    (risk_weight, lapse) = (c_r, fewer);
                }
            }
        }
        if lapse >= ALL_LAPSES {
            let ends = [self.scanned[0], self.scanned[self.scanned.len() - 1]];
            return Likeliest { risk_weight, lapse, undetermined: Some(ends), losses };
        }
        Likeliest { risk_weight, lapse, undetermined, losses }
    }

    /// The lapse from 0 to 1 of the largest likelihood, and the negative log-likelihood at it.
    fn with_best_lapse<'p>(&self, weights: &Weights, p: impl Fn(usize) -> &'p [f64]) -> (f64, f64) {
        // share, P_o, and the probability of the option in a lapse
        let terms: Vec<(f64, f64, f64)> = self
            .fitted
            .iter()
            .flat_map(|&w| {
                let even = 1.0 / p(w).len() as f64;
                weights.sums[w].iter().zip(p(w)).map(move |(sum, p)| (*sum, *p, even))
            })
            .filter(|(sum, _, _)| *sum > 0.0)
            .collect();
        // the log-likelihood is concave in the lapse
        let slope = |lapse: f64| -> f64 {
            terms.iter().map(|(sum, p, even)| sum * (even - p) / ((1.0 - lapse) * p + lapse * even)).sum()
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if slope(middle) > 0.0 { low = middle } else { high = middle }
        }
        let lapse = if low == 0.0 { 0.0 } else { (low + high) / 2.0 };
        let loss = |lapse: f64| -> f64 {
            terms.iter().map(|(sum, p, even)| -sum * math::ln((1.0 - lapse) * p + lapse * even)).sum()
        };
        (lapse, loss(lapse))
    }

    fn errors(
        &self,
        weights: &Weights,
        predictor: &mut Predictor,
        c_r: f64,
        held_out: bool,
    ) -> Option<Errors> {
        let worlds = (0..self.answers.situations.len()).filter(|w| self.fitted.contains(w) != held_out);
        let off: Vec<f64> = worlds
            .flat_map(|w| {
                let p = probabilities(self.answers, predictor, w, c_r);
                let means = weights.means(w).collect::<Vec<_>>();
                p.into_iter().zip(means).map(|(p, mean)| 100.0 * (p - mean).abs())
            })
            .collect();
        let n = off.len() as f64;
        (!off.is_empty()).then(|| Errors {
            rms: (off.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            mean_absolute: off.iter().sum::<f64>() / n,
            largest: off.iter().copied().fold(0.0, f64::max),
        })
    }

    fn rows(&self, predictor: &mut Predictor, by_squares: f64, by_likelihood: f64) -> Vec<FittedOption> {
        let mut rows = Vec::new();
        for (w, situation) in self.answers.situations.iter().enumerate() {
            let [squares, likelihood] =
                [by_squares, by_likelihood].map(|c| probabilities(self.answers, predictor, w, c));
            for (o, option) in situation.options.iter().enumerate() {
                let asked = self.answers.shares.iter().filter_map(|shares| shares[w].as_ref());
                let answers: Vec<f64> = asked.map(|shares| 100.0 * shares[o]).collect();
                rows.push(FittedOption {
                    world: situation.world.clone(),
                    is_held_out: !self.fitted.contains(&w),
                    option: option.clone(),
                    mean_percent: answers.iter().sum::<f64>() / answers.len() as f64,
                    answers_percent: answers,
                    least_squares_percent: 100.0 * squares[o],
                    likelihood_percent: 100.0 * likelihood[o],
                });
            }
        }
        rows
    }
}

//! Inference of alpha, gamma and eta from participants' answers and switches: the exact posterior of every
//! participant, a population, and how well answers are predicted.
//!
//! The model and its assumptions are in the book, `book/src/participants.md`.

mod arviz;
mod chosen;
mod draws;
mod evidence;
mod held_out;
mod inputs;
mod means;
mod perceptions;
mod population;

pub use chosen::{ChoiceEvidence, ChosenWorlds};
pub use draws::{CHAINS, Draws};
pub use held_out::{HeldOut, OptionCheck, Score};
pub use inputs::{InferenceModel, InferenceSettings, Switches, Walk};
pub use means::{Means, MeansRow, infer_means};
pub use perceptions::{PERCEPTION_UNITS, PerceptionScore, compare_perceptions};
pub use population::{Figure, Population, QUANTITIES};

use super::{Answers, EtaFit, Set, fit_eta};
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::learning::Tolerance;
use cocarry::preference::Belief;
use draws::{DrawSource, People, PersonDraws};
use evidence::Perceived;
use population::Grid;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// The posterior of one participant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Person {
    /// The participant.
    pub participant: String,
    /// Number of answers.
    pub answers: usize,
    /// Number of sightings in recorded walks.
    pub sightings: usize,
    /// alpha, from this participant's answers alone.
    pub alpha: Figure,
    /// gamma, from this participant's answers alone.
    pub gamma: Figure,
    /// Correlation of alpha and gamma.
    pub correlation: f64,
    /// Relative entropy of (alpha, gamma) to the belief, nats.
    pub information: f64,
    /// The logarithm of the probability of the answers under the belief.
    pub log_evidence: f64,
    /// alpha and gamma within the population, from everybody's answers (draws); `None` without a population.
    pub within_population: Option<[Figure; 2]>,
    /// Number of episodes with a robot that leads.
    pub episodes: usize,
    /// eta, from this participant's switches alone; `None` without switches.
    pub eta: Option<Figure>,
}

/// The result of an inference.
#[derive(Clone, Debug)]
pub struct Inference {
    /// The participants, in the order of the files.
    pub people: Vec<Person>,
    /// The population of alpha and gamma; `None` with one participant, or where the belief is samples.
    pub population: Option<Population>,
    /// The log-normal population of eta, as `fit eta` has it.
    pub tolerances: Option<EtaFit>,
    /// Predictions of held-out worlds, one row for each and one for all; empty with fewer than two worlds.
    pub held_out: Vec<HeldOut>,
    /// Answers for every option against the predictions; empty with fewer than two worlds.
    pub checks: Vec<OptionCheck>,
    /// Draws from the posterior: with a population, from that of the population and everybody in it. None of
    /// people without [`InferenceSettings::keeps_draws`].
    pub posterior: Draws,
    /// Draws from the prior; empty without [`InferenceSettings::keeps_draws`].
    pub prior: Draws,
}

/// Infers alpha, gamma and eta from answers, switches, or both.
///
/// # Errors
/// Answers or switches contradict each other and there are no lapses; numbers out of range.
pub fn infer(
    answers: Option<&Answers>,
    switches: Option<Switches>,
    walks: &[Walk],
    model: &InferenceModel,
    settings: &InferenceSettings,
    on_done: OnDone,
) -> Result<Inference, Error> {
    let prior = Perceived::new(&model.belief, model.risk_weight)?;
    Tolerance::new(settings.tolerance, settings.lapse_rate)?;
    let mut names: Vec<&String> = answers.iter().flat_map(|answers| &answers.participants).collect();
    let watched = switches.iter().flat_map(|s| s.switches).map(|switch| &switch.participant);
    let mut known: BTreeSet<&String> = names.iter().copied().collect();
    names.extend(watched.chain(walks.iter().map(|walk| &walk.participant)).filter(|name| known.insert(name)));
    let perceived = |p: usize| -> Result<Perceived, Error> {
        let mut perceived = match answers {
            Some(answers) if p < answers.participants.len() => {
                prior.after(answers, p, None, settings.lapse_rate)?
            }
            _ => prior.clone(),
        };
        for walk in walks.iter().filter(|walk| walk.participant == *names[p]) {
            perceived.observe(walk, settings.lapse_rate)?;
        }
        Ok(perceived)
    };
    let people: Vec<Perceived> =
        in_parallel(names.len(), on_done, perceived).into_iter().collect::<Result<_, _>>()?;
    // the sets of eta of a participant's episodes with a robot that leads
    let switched = switches.iter().flat_map(|s| s.switches).map(|s| (&s.participant, s.etas.clone()));
    let is_led = |walk: &&Walk| walk.etas != [0.0, f64::INFINITY];
    let walked = walks.iter().filter(is_led).map(|walk| (&walk.participant, vec![walk.etas]));
    let mut episodes: BTreeMap<&String, Vec<Set>> = BTreeMap::new();
    switched.chain(walked).for_each(|(name, set)| episodes.entry(name).or_default().push(set));
    let own = |name: &String| episodes.get(name).map_or(&[][..], Vec::as_slice);
    let has_episodes = !episodes.is_empty();
    let file = switches.map(|s| s.file).or(walks.first().map(|walk| walk.file.as_str())).unwrap_or_default();
    let tolerances: Vec<Tolerance> = match has_episodes {
        false => Vec::new(),
        true => names
            .iter()
            .map(|name| evidence::tolerance(file, name, own(name).to_vec(), settings))
            .collect::<Result<_, _>>()?,
    };
    let grid = Grid::new(model.belief.ranges())?;
    let is_sampled = matches!(model.belief, Belief::Samples(_));
    let is_asked = people.iter().any(|person| person.answers + person.sightings > 0);
    let has_population = settings.has_population && is_asked && names.len() > 1 && !is_sampled;
    let weighed = has_population.then(|| weighed(&grid, &people, on_done)).flatten();
    let source = DrawSource {
        belief: &model.belief,
        people: People::Each(&people),
        tolerances: &tolerances,
        tolerance: settings.tolerance,
        weights: weighed.as_ref().map(|(weights, _)| weights.as_slice()),
        grid: &grid,
    };
    let drawn = |values: &Vec<f64>| {
        let weight = 1.0 / values.len() as f64;
        Figure::of(values.iter().map(|value| (*value, weight)).collect())
    };
    let keeps = settings.keeps_draws;
    let mut within_population = Vec::new();
    let mut posterior = Draws::default();
    if keeps || weighed.is_some() {
        let mut kept = [Vec::new(), Vec::new()];
        let drawn_of = |[alpha, gamma, _]: PersonDraws| {
            within_population.extend(weighed.as_ref().map(|_| [drawn(&alpha), drawn(&gamma)]));
            if keeps {
                kept.iter_mut().zip([alpha, gamma]).for_each(|(all, own)| all.push(own));
            }
        };
        posterior = source.draws(settings.draws, settings.seed, 0, drawn_of);
        [posterior.alpha, posterior.gamma] = kept;
        posterior.eta = if keeps { source.etas(settings.draws, settings.seed, 0) } else { Vec::new() };
    }
    let prior_draws = if keeps { prior_draws(&source, &prior, settings)? } else { Draws::default() };
    let population = weighed.as_ref().map(|(weights, evidence)| Population::new(&grid, weights, *evidence));
    let is_compared = answers.is_some_and(|answers| answers.situations.len() > 1);
    let (held_out, checks) = match answers.filter(|_| is_compared) {
        Some(answers) => held_out::held_out(answers, &prior, model, settings, on_done)?,
        None => (Vec::new(), Vec::new()),
    };
    let mut all = people;
    let people = names.iter().zip(&mut all).enumerate().map(|(p, (name, known))| {
        let estimate = known.posterior.estimate();
        let [variance_alpha, covariance, variance_gamma] = estimate.covariance;
        let figure = |which: usize, variance: f64| {
            let moments = [estimate.mean[which], variance.max(0.0).sqrt()];
            Figure::new(moments, |share| known.posterior.quantile(which, share))
        };
        Person {
            participant: (*name).clone(),
            answers: known.answers,
            sightings: known.sightings,
            alpha: figure(0, variance_alpha),
            gamma: figure(1, variance_gamma),
            correlation: covariance / (variance_alpha * variance_gamma).sqrt(),
            information: estimate.information,
            log_evidence: known.log_evidence,
            within_population: within_population.get(p).copied(),
            episodes: own(name).len(),
            eta: tolerances.get(p).filter(|_| !own(name).is_empty()).map(|tolerance| {
                let [mean, variance] = tolerance.moments();
                Figure::new([mean, variance.sqrt()], |share| tolerance.quantile(share))
            }),
        }
    });
    Ok(Inference {
        people: people.collect(),
        population,
        tolerances: switches.map(|s| fit_eta(s.switches)),
        held_out,
        checks,
        posterior,
        prior: prior_draws,
    })
}

/// People whose integrals are in memory at a time: half a megabyte each.
const AT_ONCE: usize = 32;

/// The probabilities of the populations, and the logarithm of the evidence.
fn weighed(grid: &Grid, people: &[Perceived], on_done: OnDone) -> Option<(Vec<f64>, f64)> {
    let mut logs = vec![0.0; grid.len()];
    for people in people.chunks(AT_ONCE) {
        let integrals = in_parallel(people.len(), on_done, |p| {
            let mut values = grid.integrals(&grid.steps(|gamma| people[p].posterior.steps_at(gamma)));
            values.iter_mut().for_each(|value| *value = cocarry::math::ln(value.max(0.0)));
            values
        });
        for one in integrals {
            logs.iter_mut().zip(one).for_each(|(sum, log)| *sum += log);
        }
    }
    let evidence: f64 = people.iter().map(|person| person.log_evidence).sum();
    logs.iter_mut().for_each(|log| *log += evidence);
    population::weights(&logs)
}

/// Draws from the same model without any answers and switches.
fn prior_draws(source: &DrawSource, prior: &Perceived, settings: &InferenceSettings) -> Result<Draws, Error> {
    let tolerance = Tolerance::new(source.tolerance, settings.lapse_rate)?;
    let tolerances = vec![tolerance; source.tolerances.len()];
    let even = vec![1.0 / source.grid.len() as f64; source.grid.len()];
    let source = DrawSource {
        people: People::Equal(prior, source.people.len()),
        tolerances: &tolerances,
        weights: source.weights.map(|_| even.as_slice()),
        ..*source
    };
    let mut kept = [Vec::new(), Vec::new()];
    let mut draws = source.draws(settings.draws, settings.seed, 1, |[alpha, gamma, _]| {
        kept.iter_mut().zip([alpha, gamma]).for_each(|(all, own)| all.push(own));
    });
    [draws.alpha, draws.gamma] = kept;
    draws.eta = source.etas(settings.draws, settings.seed, 1);
    Ok(draws)
}

#[cfg(test)]
mod tests;

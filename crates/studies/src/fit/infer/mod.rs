//! What participants' answers and switches say of alpha, gamma and eta: the exact posterior of every
//! participant, a population, and how well answers are predicted.
//!
//! The model and its assumptions are in the book, `book/src/participants.md`.

mod arviz;
mod draws;
mod evidence;
mod held_out;
mod inputs;
mod means;
mod population;

pub use draws::{CHAINS, Draws};
pub use held_out::{HeldOut, OptionCheck, Score};
pub use inputs::{Model, Settings, Switches, Walk};
pub use means::{Means, MeansRow, infer_means};
pub use population::{Figure, Population, QUANTITIES};

use super::{Answers, EtaFit, FitError, Set, fit_eta};
use crate::parallel::{OnDone, in_parallel};
use cocarry::learning::Tolerance;
use cocarry::preference::Belief;
use draws::Source;
use evidence::{Kept, Perceived};
use population::Grid;
use serde::Serialize;

/// What is known of one participant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Person {
    /// The participant.
    pub participant: String,
    /// Number of answers.
    pub answers: usize,
    /// Number of looks at recorded walks.
    pub looks: usize,
    /// alpha, from the own answers alone.
    pub alpha: Figure,
    /// gamma, from the own answers alone.
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
    /// eta, from the own switches alone; `None` without switches.
    pub eta: Option<Figure>,
}

/// What was inferred.
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
    /// Draws from the posterior: with a population, from that of the population and everybody in it. Those of
    /// people are there if they were to be kept.
    pub posterior: Draws,
    /// Draws from the prior; empty unless they were to be kept.
    pub prior: Draws,
}

/// Infers alpha, gamma and eta from answers, switches, or both.
///
/// # Errors
/// [`FitError`]: answers or switches contradict each other and there are no lapses; numbers out of range.
pub fn infer(
    answers: Option<&Answers>,
    switches: Option<Switches>,
    walks: &[Walk],
    model: &Model,
    settings: &Settings,
    on_done: OnDone,
) -> Result<Inference, FitError> {
    let prior = Perceived::new(&model.belief, model.risk_weight)?;
    Tolerance::new(settings.tolerance, settings.lapse_rate)?;
    let mut names: Vec<&String> = answers.iter().flat_map(|answers| &answers.participants).collect();
    let watched = switches.iter().flat_map(|s| s.switches).map(|switch| &switch.participant);
    for name in watched.chain(walks.iter().map(|walk| &walk.participant)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let perceived = |p: usize| -> Result<Known, FitError> {
        let mut perceived = match answers {
            Some(answers) if p < answers.participants.len() => {
                prior.after(answers, p, None, settings.lapse_rate)?
            }
            _ => prior.clone(),
        };
        for walk in walks.iter().filter(|walk| walk.participant == *names[p]) {
            perceived.see(walk, settings.lapse_rate)?;
        }
        Ok(Known::of(names[p], perceived))
    };
    let people: Vec<Known> =
        in_parallel(names.len(), on_done, perceived).into_iter().collect::<Result<_, _>>()?;
    // the sets of eta of a participant's episodes with a robot that leads
    let own = |name: &String| -> Vec<Set> {
        let switched = switches.iter().flat_map(|s| s.switches).filter(|s| s.participant == *name);
        let is_led = |walk: &&Walk| walk.participant == *name && walk.etas != [0.0, f64::INFINITY];
        let walked = walks.iter().filter(is_led).map(|walk| vec![walk.etas]);
        switched.map(|s| s.etas.clone()).chain(walked).collect()
    };
    let has_episodes = names.iter().any(|name| !own(name).is_empty());
    let file = switches.map(|s| s.file).or(walks.first().map(|walk| walk.file.as_str())).unwrap_or_default();
    let tolerances: Vec<Tolerance> = match has_episodes {
        false => Vec::new(),
        true => names
            .iter()
            .map(|name| evidence::tolerance(file, name, own(name), settings))
            .collect::<Result<_, _>>()?,
    };
    let grid = Grid::new(model.belief.ranges())?;
    let is_sampled = matches!(model.belief, Belief::Samples(_));
    let is_asked = people.iter().any(|known| known.kept.answers + known.kept.looks > 0);
    let has_population = settings.has_population && is_asked && names.len() > 1 && !is_sampled;
    let weighed = has_population.then(|| weighed(&grid, &people, &prior, on_done)).flatten();
    let crowd = weighed.as_ref().map(|(weights, _)| weights.as_slice());
    let source = Source {
        belief: &model.belief,
        grid: &grid,
        crowd,
        length: settings.draws,
        seed: settings.seed,
        set: 0,
    };
    let nodes = source.nodes();
    let mut posterior = Draws::new(&source, &nodes);
    let mut found = Vec::with_capacity(people.len());
    // somebody's draws take more room than all else that is known of them
    for (block, people) in people.chunks(BLOCK).enumerate() {
        let drawn = in_parallel(people.len(), &|| (), |i| {
            let (p, known) = (block * BLOCK + i, &people[i]);
            let draws = source.person(p, &known.kept.restored(&prior), tolerances.get(p), &nodes);
            let figures = crowd.map(|_| [&draws.alpha, &draws.gamma].map(|values| Figure::of_draws(values)));
            (figures, settings.keeps_draws.then_some(draws))
        });
        for (known, (within_population, draws)) in people.iter().zip(drawn) {
            found.push(Person { within_population, ..known.person.clone() });
            draws.into_iter().for_each(|draws| posterior.add(draws));
        }
    }
    let population = weighed.as_ref().map(|(weights, evidence)| Population::new(&grid, weights, *evidence));
    let is_compared = answers.is_some_and(|answers| answers.situations.len() > 1);
    let (held_out, checks) = match answers.filter(|_| is_compared) {
        Some(answers) => held_out::held_out(answers, &prior, model, settings, on_done)?,
        None => (Vec::new(), Vec::new()),
    };
    for (p, (person, name)) in found.iter_mut().zip(&names).enumerate() {
        person.episodes = own(name).len();
        person.eta = tolerances.get(p).filter(|_| person.episodes > 0).map(|tolerance| {
            let [mean, variance] = tolerance.moments();
            Figure::new([mean, variance.sqrt()], |share| tolerance.quantile(share))
        });
    }
    let prior = match settings.keeps_draws {
        true => prior_draws(&source, &prior, found.len(), !tolerances.is_empty(), settings)?,
        false => Draws::default(),
    };
    Ok(Inference {
        people: found,
        population,
        tolerances: switches.map(|s| fit_eta(s.switches)),
        held_out,
        checks,
        posterior,
        prior,
    })
}

/// Number of people of whom all that is computed is held at a time.
const BLOCK: usize = 64;

/// What is known of a participant by their own answers and walks.
struct Known {
    kept: Kept,
    /// Without eta and the population.
    person: Person,
}

impl Known {
    fn of(name: &str, mut perceived: Perceived) -> Self {
        let estimate = perceived.posterior.estimate();
        let [variance_alpha, covariance, variance_gamma] = estimate.covariance;
        let figure = |which: usize, variance: f64| {
            let moments = [estimate.mean[which], variance.max(0.0).sqrt()];
            Figure::new(moments, |share| perceived.posterior.quantile(which, share))
        };
        let person = Person {
            participant: name.to_owned(),
            answers: perceived.answers,
            looks: perceived.looks,
            alpha: figure(0, variance_alpha),
            gamma: figure(1, variance_gamma),
            correlation: covariance / (variance_alpha * variance_gamma).sqrt(),
            information: estimate.information,
            log_evidence: perceived.log_evidence,
            within_population: None,
            episodes: 0,
            eta: None,
        };
        Self { kept: perceived.kept(), person }
    }
}

/// The probabilities of the populations, and the logarithm of the evidence.
fn weighed(grid: &Grid, people: &[Known], prior: &Perceived, on_done: OnDone) -> Option<(Vec<f64>, f64)> {
    let evidence: f64 = people.iter().map(|known| known.kept.log_evidence).sum();
    let mut logs = vec![0.0; grid.len()];
    for people in people.chunks(BLOCK) {
        let integrals = in_parallel(people.len(), on_done, |p| {
            let person = people[p].kept.restored(prior);
            grid.integrals(&grid.steps(|gamma| person.posterior.steps_at(gamma)))
        });
        for own in integrals {
            logs.iter_mut().zip(own).for_each(|(log, value)| *log += cocarry::math::ln(value.max(0.0)));
        }
    }
    population::weights(&logs.into_iter().map(|log| log + evidence).collect::<Vec<_>>())
}

/// Draws from the same model without any answers and switches.
fn prior_draws(
    source: &Source,
    prior: &Perceived,
    people: usize,
    has_tolerances: bool,
    settings: &Settings,
) -> Result<Draws, FitError> {
    let tolerance = Tolerance::new(settings.tolerance, settings.lapse_rate)?;
    let even = vec![1.0 / source.grid.len() as f64; source.grid.len()];
    let source = Source { crowd: source.crowd.map(|_| even.as_slice()), set: 1, ..*source };
    let nodes = source.nodes();
    let mut draws = Draws::new(&source, &nodes);
    let tolerance = has_tolerances.then_some(&tolerance);
    in_parallel(people, &|| (), |p| source.person(p, prior, tolerance, &nodes))
        .into_iter()
        .for_each(|person| draws.add(person));
    Ok(draws)
}

#[cfg(test)]
mod tests;

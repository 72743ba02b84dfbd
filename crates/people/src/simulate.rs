//! Simulated participants, who answer as the model says, through the store that people's answers go through.

use crate::digest::sha256;
use crate::order::{Trial, orders};
use crate::store::{Begin, Chunk, Store, StoreError, whole_digest};
use crate::study::{PeopleStudy, ScaleKind, StudyWorld};
use cocarry::coordination;
use cocarry::episode::EpisodeSettings;
use cocarry::learning::{TolerancePrior, discomfort_limit};
use cocarry::preference::{Marginal, Perception, RISK_WEIGHT, human_choice};
use cocarry_studies::fit::Guidance;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// The population of `docs/data/simulated-answers.csv`: mean and standard deviation of alpha and gamma on the
/// belief's ranges. eta has the prior of a robot that learns: median 10.5, and a factor of 1.65 for its
/// standard deviation.
const ALPHA: [f64; 4] = [0.68, 0.08, 0.55, 0.95];
const GAMMA: [f64; 4] = [0.85, 0.15, 0.5, 1.1];
/// The probability of an answer that says nothing.
const LAPSE_RATE: f64 = 0.05;

/// What a simulated participant is.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The pseudonym.
    pub participant: String,
    /// alpha and gamma.
    pub perception: Perception,
    /// eta, in planning steps.
    pub eta: f64,
}

/// Lets `count` participants, drawn from a seed, answer into a store. The same seed again changes nothing.
///
/// # Errors
/// The store cannot be written, or has no place for as many.
pub fn simulate(
    study: &PeopleStudy,
    digest: &str,
    store: &mut Store,
    count: u64,
    seed: u64,
) -> Result<Vec<Truth>, StoreError> {
    let orders = orders(study);
    let mut truths = Vec::new();
    for person in 0..count {
        let key = sha256(format!("simulated {seed} {person}").as_bytes());
        let begin = Begin { key: &key, platform_ids: &[], study: digest, participants: count, now: 0 };
        let session = store.begin(&begin)?;
        let trials = &orders[session.place as usize % orders.len()];
        let Answers { perception, eta, pages } = answers(study, trials, seed, person);
        let mut chunks = Vec::new();
        for ((trial, page), mut data) in (0..).zip(trials).zip(pages) {
            if *page == Trial::Consent {
                data["order"] = json!(session.place as usize % orders.len() + 1);
            }
            let body = json!([{ "kind": "done", "at_ms": 0, "data": data }]).to_string();
            let sha256 = sha256(body.as_bytes());
            store.put(&key, &Chunk { trial, number: 0, sha256: &sha256, body: &body }, 0)?;
            chunks.push((trial, 0, sha256));
        }
        store.finish(&key, &whole_digest(&chunks), None, 0)?;
        truths.push(Truth { participant: session.participant, perception, eta });
    }
    Ok(truths)
}

/// What a simulated participant is, and what the page of each trial would record.
pub(crate) struct Answers {
    pub perception: Perception,
    pub eta: f64,
    pub pages: Vec<Value>,
}

/// The answers of a participant to whom these trials come.
pub(crate) fn answers(study: &PeopleStudy, trials: &[Trial], seed: u64, person: u64) -> Answers {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(person);
    let (perception, eta) = drawn(&mut rng);
    let pages = trials.iter().map(|page| answer(study, page, perception, eta, &mut rng)).collect();
    Answers { perception, eta, pages }
}

/// alpha and gamma, and eta, of a participant.
pub(crate) fn drawn(rng: &mut ChaCha8Rng) -> (Perception, f64) {
    let [alpha, gamma] = [ALPHA, GAMMA].map(|[mean, std, lower, upper]| {
        Marginal::truncated_normal(mean, std, lower, upper).expect("the ranges are not empty").sample(rng)
    });
    (Perception { alpha, gamma }, TolerancePrior::default().sample(rng))
}

/// The option that a participant chooses in a world; now and then any.
pub(crate) fn chosen(world: &StudyWorld, perception: Perception, rng: &mut ChaCha8Rng) -> usize {
    let lapse = rng.random_bool(LAPSE_RATE).then(|| rng.random_range(0..world.options.len()));
    lapse.unwrap_or_else(|| human_choice(&world.prospects, RISK_WEIGHT, perception, None))
}

/// What the page would record at the end of a trial. Simulated participants do not carry.
fn answer(
    study: &PeopleStudy,
    page: &Trial,
    perception: Perception,
    eta: f64,
    rng: &mut ChaCha8Rng,
) -> Value {
    match *page {
        Trial::Consent => json!({ "task": "consent", "version": study.consent[0] }),
        Trial::Instructions { .. } => json!({ "task": "instructions" }),
        Trial::Percentages { world, practice } => {
            let world = &study.worlds[world];
            let chosen = chosen(world, perception, rng);
            let percent = |(o, name): (usize, &String)| json!([name, if o == chosen { 100 } else { 0 }]);
            let percent: Vec<Value> = world.options.iter().enumerate().map(percent).collect();
            json!({
                "task": "percentages", "world": world.name, "practice": practice, "percent": percent, "ms": 0,
                "hidden_ms": 0,
            })
        }
        Trial::Switch { world, option, repetition, practice } => {
            let world = &study.worlds[world];
            let step = switch(world, option, eta);
            json!({
                "task": "switch", "world": world.name, "option": world.options[option], "practice": practice,
                "repetition": repetition,
                "step": step, "ms": step.map(|step| 1000.0 * EpisodeSettings::default().planning_step * step as f64),
                "frame": null, "plays": 1, "stalls": 0, "longest_frame_ms": 0,
            })
        }
        Trial::Carry { .. } => json!({ "task": "instructions" }),
        Trial::Question { question } => {
            let question = &study.questions[question];
            json!({ "task": "question", "text": question.text, "answers": [question.answers[question.right]], "right": true })
        }
        Trial::Scale { scale } => {
            let scale = &study.scales[scale];
            let middle = match scale.kind {
                ScaleKind::NasaTlx => 50,
                ScaleKind::Likert | ScaleKind::Fluency => scale.points.div_ceil(2),
            };
            let answers: Vec<Value> = scale.items().iter().map(|item| json!([item, middle])).collect();
            json!({ "task": "scale", "name": scale.name, "answers": answers })
        }
    }
}

/// The step at which a human of this eta stops following a robot that walks an option: where phi(k) exceeds 1.
fn switch(world: &StudyWorld, option: usize, eta: f64) -> Option<u64> {
    stop(&Guidance::along_option(&world.set, &EpisodeSettings::default(), option)?, eta)
}

/// The same on a walk.
pub(crate) fn stop(walk: &Guidance, eta: f64) -> Option<u64> {
    let Guidance::Option { discomfort, .. } = walk else { return None };
    let limit = eta * discomfort_limit(coordination::StubbornnessSettings::default().initial_stubbornness);
    discomfort.iter().position(|g| *g > limit).map(|step| step as u64)
}

//! What comes out of a study: a document with tables and pictures, from the tables that `collect` writes.
//!
//! ```text
//! tables -> groups (all, without flagged) -> choices, eta, posterior, methods -> headlines -> Document
//! ```

mod choices;
mod groups;
mod headlines;
mod methods;
mod participants;
mod posterior;
mod read;
#[cfg(test)]
mod tests;
mod tolerance;

pub use read::{Carried, MEASURES, Measure, StudyPerson, StudyTables};

use choices::Choices;
use cocarry::Error;
use cocarry::episode::EpisodeSettings;
use cocarry::preference::RISK_WEIGHT;
use cocarry_studies::fit::{
    Answers, EtaFit, Inference, InferenceModel, InferenceSettings, Switch, Switches, fit_eta, infer,
};
use cocarry_studies::parallel::OnDone;
use cocarry_studies::report::{Block, Document};
use cocarry_studies::table::escaped;
use groups::{AnalysedGroup, groups};
use methods::Comparison;

/// The number of participants that an interval over them, or a test, needs: with 5 pairs, not even the
/// extreme outcome of a sign test has a p-value below 0.05.
pub const MIN_PEOPLE: usize = 6;
/// The largest number of participants of a picture.
const MAX_DRAWN: usize = 60;

/// Settings of a report.
#[derive(Clone, Copy, Debug)]
pub struct ReportSettings {
    /// Draws of each of four chains of the inference.
    pub draws: usize,
    /// Number of bootstrap resamples.
    pub resamples: usize,
    /// Seed of draws and resamples.
    pub seed: u64,
}

/// The answers and switches of those who finished, matched with their worlds.
#[derive(Clone, Debug, Default)]
pub struct Matched {
    /// The answers; `None` if there are none.
    pub answers: Option<Answers>,
    /// The file of the switches, and the switches.
    pub switches: Option<(String, Vec<Switch>)>,
}

/// What is found of a group of participants.
struct Analysis {
    people: usize,
    answers: usize,
    choices: Option<Choices>,
    eta: Option<EtaFit>,
    inference: Option<Inference>,
    comparisons: Vec<Comparison>,
}

/// The units of work of a report, for a progress bar.
pub fn report_units(tables: &StudyTables, matched: &Matched, settings: &ReportSettings) -> usize {
    let answered = matched.answers.as_ref().map_or(0, |answers| answers.participants.len());
    groups(&tables.people).len() * (3 * answered + settings.resamples)
}

/// The report. Equal tables and settings give equal bytes, on any number of threads.
///
/// # Errors
/// Answers or switches that contradict the model's ranges; a number that cannot be drawn.
pub fn report(
    tables: &StudyTables,
    matched: &Matched,
    settings: &ReportSettings,
    on_done: OnDone,
) -> Result<Document, Error> {
    let analysed = |group: AnalysedGroup| {
        let analysis = analysis(&group.members, tables, matched, settings, on_done)?;
        Ok::<_, Error>((group, analysis))
    };
    let groups: Vec<(AnalysedGroup, Analysis)> =
        groups(&tables.people).into_iter().map(analysed).collect::<Result<_, _>>()?;
    let all = &groups[0].1;
    let absent = |what: &str| vec![Block::Text(format!("Absent: {what}"))];
    let choices = match &all.choices {
        Some(choices) => choices::blocks(choices, all.answers, settings.resamples, settings.seed)?,
        None => absent("nobody who finished has given percentages."),
    };
    let members = &groups[0].0.members;
    let eta = match &all.eta {
        Some(fit) => tolerance::blocks(fit, &switches_of(matched, members))?,
        None => absent("nobody who finished has watched a robot that leads."),
    };
    let posterior = match &all.inference {
        Some(inference) => posterior::blocks(inference, &inference_settings(settings))?,
        None => absent("there are neither percentages nor watched walks."),
    };
    let carried: Vec<_> = tables.carried.iter().collect();
    let methods = match carried.is_empty() {
        true => absent("nobody who finished has carried, so there are no methods to compare."),
        false => methods::blocks(&carried, &all.comparisons)?,
    };
    let sections = [
        ("Participants", participants::blocks(&tables.people)),
        ("With and without flagged participants", vec![Block::Table(headlines::table(&groups))]),
        ("Choices between options", choices),
        ("Tolerance: when they would stop following", eta),
        ("Posterior of people and population", posterior),
        ("Methods of the robot", methods),
    ];
    let sections = sections.into_iter().map(|(title, blocks)| (title.to_owned(), blocks)).collect();
    Ok(Document::new(&opening(&tables.title), sections))
}

fn opening(title: &str) -> String {
    format!(
        "# {}\n\nWhat came out of this study, by `cocarry` {}. **A mouse is not a beam in the hands**: the page measures choices and their timing, not forces on people.\n\n",
        escaped(title),
        env!("CARGO_PKG_VERSION"),
    )
}

fn inference_settings(settings: &ReportSettings) -> InferenceSettings {
    let ReportSettings { draws, seed, .. } = *settings;
    InferenceSettings { draws, seed, keeps_draws: false, ..InferenceSettings::default() }
}

/// The answers of these participants.
fn answers_of(answers: &Answers, members: &[String]) -> Answers {
    let is_own = |at: &usize| is_in(members, &answers.participants[*at]);
    let at: Vec<usize> = (0..answers.participants.len()).filter(is_own).collect();
    Answers {
        participants: at.iter().map(|at| answers.participants[*at].clone()).collect(),
        shares: at.iter().map(|at| answers.shares[*at].clone()).collect(),
        ..answers.clone()
    }
}

fn switches_of(matched: &Matched, members: &[String]) -> Vec<Switch> {
    let all = matched.switches.iter().flat_map(|(_, switches)| switches);
    all.filter(|switch| is_in(members, &switch.participant)).cloned().collect()
}

/// Whether somebody is among members, which are sorted.
fn is_in(members: &[String], participant: &str) -> bool {
    members.binary_search_by(|member| member.as_str().cmp(participant)).is_ok()
}

/// What is found of these participants.
fn analysis(
    members: &[String],
    tables: &StudyTables,
    matched: &Matched,
    settings: &ReportSettings,
    on_done: OnDone,
) -> Result<Analysis, Error> {
    let answers = matched.answers.as_ref().map(|answers| answers_of(answers, members));
    let answers = answers.filter(|answers| !answers.participants.is_empty());
    let switches = switches_of(matched, members);
    let file = matched.switches.as_ref().map_or("", |(file, _)| file.as_str());
    let switched = (!switches.is_empty()).then_some(Switches { file, switches: &switches });
    let inference = match answers.is_some() || switched.is_some() {
        false => None,
        true => {
            let belief = EpisodeSettings::default().predictor.belief().clone();
            let model = InferenceModel { belief, risk_weight: RISK_WEIGHT };
            Some(infer(answers.as_ref(), switched, &[], &model, &inference_settings(settings), on_done)?)
        }
    };
    let carried: Vec<_> = tables.carried.iter().filter(|row| is_in(members, &row.participant)).collect();
    Ok(Analysis {
        people: members.len(),
        answers: answers.as_ref().map_or(0, |answers| answers.participants.len()),
        choices: answers
            .as_ref()
            .map(|answers| choices::choices(answers, settings.resamples, settings.seed, on_done)),
        eta: (!switches.is_empty()).then(|| fit_eta(&switches)),
        inference,
        comparisons: methods::comparisons(&carried),
    })
}

/// Why something that needs more participants is absent.
fn too_few(people: usize, what: &str) -> String {
    let noun = if people == 1 { "participant" } else { "participants" };
    format!("Absent: {what}. {people} {noun} are too few: it needs at least {MIN_PEOPLE}.")
}

//! The tables of a study: what `cocarry fit` and `cocarry infer` read, who took part, and what every column
//! means.

pub(crate) mod flags;
mod groups;
mod tables;
#[cfg(test)]
mod tests;

use crate::carry::carry_scenario;
use crate::order::{Trial, orders};
use crate::store::StoredSession;
use crate::study::{PeopleStudy, SUBSCALES, ScaleKind, StudyWorld};
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::{EpisodeLog, Scenario};
use cocarry_studies::fit::{Executed, Guidance, Switch as Episode};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeSet;
pub use tables::carries_table;
use tables::{ANSWERS, PARTICIPANTS, RESPONSES, SWITCHES, Table, dictionary, readme};

/// A percentage above which an answer for an option that is both longer and riskier than another is flagged.
const MAX_DOMINATED_PERCENT: f64 = 20.0;
/// The largest distance of the sum of percentages from 100.
const SUM_TOLERANCE: f64 = 1e-6;

/// The tables, and what is not in them.
#[derive(Clone, Debug)]
pub struct Collected {
    /// Names and contents of the files; a name may have a folder.
    pub files: Vec<(String, Vec<u8>)>,
    /// The episodes in which participants carried.
    pub carries: Vec<CollectedCarry>,
    /// What was left out, and why: one sentence each.
    pub left_out: Vec<String>,
    /// The number of participants in the tables.
    pub participants: usize,
}

/// What the page records at the end of a trial.
#[derive(Deserialize)]
#[serde(tag = "task", rename_all = "lowercase")]
enum Done {
    Consent { version: String, order: usize },
    Instructions {},
    Percentages(Percentages),
    Switch(Switch),
    Carry(Carry),
    Question { text: String, answers: Vec<String>, right: bool },
    Scale { name: String, answers: Vec<(String, f64)> },
}

#[derive(Deserialize)]
struct Percentages {
    world: String,
    practice: bool,
    percent: Vec<(String, f64)>,
    ms: f64,
    hidden_ms: f64,
}

#[derive(Deserialize)]
struct Switch {
    world: String,
    option: String,
    practice: bool,
    repetition: u64,
    step: Option<u64>,
    ms: Option<f64>,
    frame: Option<u64>,
    plays: u64,
    stalls: u64,
}

#[derive(Deserialize)]
struct Carry {
    world: String,
    method: String,
    practice: bool,
    log: String,
    stalls: u64,
    lost_s: f64,
}

/// An episode in which a participant carried, to be run again.
#[derive(Clone, Debug)]
pub struct CollectedCarry {
    /// The pseudonym.
    pub participant: String,
    /// The number of the page, from 1.
    pub page: u32,
    /// The world, by its name in tables.
    pub world: String,
    /// The method of the robot.
    pub method: String,
    /// The log of the page.
    pub log: EpisodeLog,
    /// Pictures that came late, and the time by which the episode fell behind the clock, s.
    pub stalls: u64,
    /// See `stalls`.
    pub lost: f64,
}

/// The tables of these sessions: of those that are finished, or of all. Equal sessions give equal bytes.
pub fn collect(study: &PeopleStudy, sessions: &[StoredSession], with_unfinished: bool) -> Collected {
    let orders = orders(study);
    let mut collecting = Collecting {
        study,
        answers: Table::new("answers.csv", &ANSWERS),
        switches: Table::new("switches.csv", &SWITCHES),
        participants: Table::new("participants.csv", &PARTICIPANTS),
        responses: Table::new("responses.csv", &RESPONSES),
        people: Vec::new(),
        episodes: Vec::new(),
        carries: Vec::new(),
        left_out: Vec::new(),
    };
    let used: Vec<_> =
        sessions.iter().filter(|session| with_unfinished || session.finished.is_some()).collect();
    let unfinished = sessions.iter().filter(|session| session.finished.is_none()).count();
    if unfinished > 0 && !with_unfinished {
        collecting.left_out.push(format!("{unfinished} who did not finish"));
    }
    for session in sessions {
        let pages = &orders[session.place as usize % orders.len()];
        collecting.add(session, pages, with_unfinished || session.finished.is_some());
    }
    collecting.add_people();
    let Collecting { answers, switches, participants, responses, carries, left_out, .. } = collecting;
    let mut files: Vec<_> = [answers, switches, participants, responses].map(Table::finish).into();
    files.push(dictionary(study));
    files.push(("README.md".to_owned(), readme(study, used.len(), &left_out).into_bytes()));
    let of_files = study.worlds[..study.measured_worlds()].iter().filter(|world| !world.is_built_in);
    files.extend(of_files.map(|world| (world.name.clone(), world.world.text.clone().into_bytes())));
    Collected { files, carries, left_out, participants: used.len() }
}

struct Collecting<'a> {
    study: &'a PeopleStudy,
    answers: Table,
    switches: Table,
    participants: Table,
    responses: Table,
    /// The rows of participants, which still lack the group of their eta.
    people: Vec<Vec<String>>,
    /// Every walk with the eta that it allows.
    episodes: Vec<Episode>,
    carries: Vec<CollectedCarry>,
    left_out: Vec<String>,
}

impl Collecting<'_> {
    /// Adds a participant, and their answers if `is_used`.
    fn add(&mut self, session: &StoredSession, pages: &[Trial], is_used: bool) {
        let participant = &session.participant;
        let (mut consent, mut seen, mut pages_done, mut right) = (String::new(), String::new(), 0, 0);
        let mut flags = BTreeSet::new();
        let mut known = BTreeSet::new();
        for (trial, records) in &session.records {
            let done = records.iter().rev().find(|record| record.get("kind") == Some(&Value::from("done")));
            let Some(done) = done else { continue };
            pages_done += 1;
            let data = done.get("data").cloned().unwrap_or_default();
            let read: Result<Done, _> = serde_json::from_value(data);
            let added = match read {
                Ok(Done::Consent { version, order }) => {
                    (consent, seen) = (version, order.to_string());
                    Ok(())
                }
                _ if !is_used => Ok(()),
                Err(error) => Err(format!("not a record of the page: {error}")),
                Ok(Done::Instructions {}) => Ok(()),
                Ok(Done::Percentages(answer)) if answer.practice => Ok(()),
                Ok(Done::Switch(switch)) if switch.practice => Ok(()),
                Ok(Done::Percentages(answer)) => match known.insert((answer.world.clone(), None)) {
                    false => Err(format!("a second answer for {}", answer.world)),
                    true => self.percentages(participant, &answer, &mut flags),
                },
                Ok(Done::Switch(switch)) => {
                    let walk = format!("{} for the {}. time", switch.option, switch.repetition);
                    match known.insert((switch.world.clone(), Some(walk.clone()))) {
                        false => Err(format!("a second walk on option {walk} of {}", switch.world)),
                        true => self.switch(participant, &switch, &mut flags),
                    }
                }
                Ok(Done::Carry(carry)) if carry.practice => Ok(()),
                Ok(Done::Carry(carry)) => {
                    match known.insert((carry.world.clone(), Some(format!("method {}", carry.method)))) {
                        false => Err(format!("carried in {} with {} before", carry.world, carry.method)),
                        true => self.carry(participant, trial + 1, carry),
                    }
                }
                Ok(Done::Question { text, answers, right: is_right }) => {
                    right += u64::from(is_right);
                    if !is_right {
                        flags.insert(flags::NOT_RIGHT.0);
                    }
                    let answer = answers.last().cloned().unwrap_or_default();
                    let cells =
                        [participant.as_str(), "question", &text, &answer, &is_right.to_string(), "", ""];
                    self.responses.row(cells.map(str::to_owned).into());
                    Ok(())
                }
                Ok(Done::Scale { name, answers }) => {
                    let about = carry_before(self.study, pages, *trial);
                    self.scale(participant, &name, &answers, about);
                    Ok(())
                }
            };
            if let Err(why) = added {
                flags.insert(flags::LEFT_OUT.0);
                self.left_out.push(format!("{participant}, page {}: {why}", trial + 1));
            }
        }
        let flags = flags.into_iter().collect::<Vec<_>>().join(" ");
        let left_at = pages.get(pages_done as usize).filter(|_| session.finished.is_none());
        self.people.push(vec![
            participant.clone(),
            (session.place + 1).to_string(),
            seen,
            session.begun.clone(),
            session.finished.clone().unwrap_or_default(),
            consent,
            session.study.clone(),
            pages_done.to_string(),
            pages.len().to_string(),
            right.to_string(),
            left_at.map_or(String::new(), |page| page.words(self.study)),
            flags,
        ]);
    }

    /// Adds the rows of participants, with the group of their eta.
    fn add_people(&mut self) {
        let groups = groups::of_participants(&self.study.eta_groups, &self.episodes);
        for mut row in std::mem::take(&mut self.people) {
            row.push(groups.get(&row[0]).cloned().unwrap_or_default());
            self.participants.row(row);
        }
    }

    /// Adds the answers of a page of scales, and the means of its subscales if it has any.
    fn scale(
        &mut self,
        participant: &str,
        name: &str,
        answers: &[(String, f64)],
        [world, method]: [&str; 2],
    ) {
        let mut row = |item: &str, answer: String| {
            let cells = [participant, name, item, &answer, "", world, method];
            self.responses.row(cells.map(str::to_owned).into());
        };
        answers.iter().for_each(|(item, answer)| row(item, answer.to_string()));
        let scale = self.study.scales.iter().find(|scale| scale.name == name);
        let Some(scale) = scale.filter(|scale| scale.kind == ScaleKind::Fluency) else { return };
        let numbers: Vec<f64> = answers.iter().map(|(_, answer)| *answer).collect();
        for subscale in &SUBSCALES {
            let mean = subscale.mean(&numbers, scale.points);
            row(&format!("mean: {}", subscale.name), mean.map_or(String::new(), |mean| format!("{mean:.3}")));
        }
    }

    fn world(&self, name: &str) -> Result<&StudyWorld, String> {
        self.study.world(name).ok_or_else(|| format!("{name:?} is not a world of the study"))
    }

    /// Adds percentages that are one for each option and sum to 100.
    fn percentages(
        &mut self,
        participant: &str,
        answer: &Percentages,
        flags: &mut BTreeSet<&'static str>,
    ) -> Result<(), String> {
        let world = self.world(&answer.world)?;
        let names: Vec<&str> = answer.percent.iter().map(|(name, _)| name.as_str()).collect();
        if names != world.options {
            return Err(format!("the answer for {} is not for its options", answer.world));
        }
        let sum: f64 = answer.percent.iter().map(|(_, percent)| percent).sum();
        let is_percent = |(_, percent): &(String, f64)| (0.0..=100.0).contains(percent);
        if !answer.percent.iter().all(is_percent) || (sum - 100.0).abs() > SUM_TOLERANCE {
            return Err(format!("the percentages for {} sum to {sum}, not to 100", answer.world));
        }
        let mut rows = Vec::new();
        for (option, (name, percent)) in answer.percent.iter().enumerate() {
            let is_dominated = world.is_dominated(option);
            if is_dominated && *percent > MAX_DOMINATED_PERCENT {
                flags.insert(flags::DOMINATED.0);
            }
            rows.push(vec![
                participant.to_owned(),
                answer.world.clone(),
                name.clone(),
                percent.to_string(),
                is_dominated.to_string(),
                seconds(answer.ms),
                seconds(answer.hidden_ms),
            ]);
        }
        if answer.hidden_ms > 0.0 {
            flags.insert(flags::HIDDEN.0);
        }
        rows.into_iter().for_each(|row| self.answers.row(row));
        Ok(())
    }

    /// Adds a switch within the walk.
    fn switch(
        &mut self,
        participant: &str,
        switch: &Switch,
        flags: &mut BTreeSet<&'static str>,
    ) -> Result<(), String> {
        let world = self.world(&switch.world)?;
        let option = world.options.iter().position(|name| *name == switch.option);
        let walk =
            option.and_then(|option| Guidance::along_option(&world.set, &EpisodeSettings::default(), option));
        let Some(walk) = walk else {
            return Err(format!("{:?} is not an option of {}", switch.option, switch.world));
        };
        if let Some(step) = switch.step.filter(|step| *step >= walk.steps()) {
            return Err(format!("step {step} of a walk that has {}", walk.steps()));
        }
        if !(1..=self.study.switch_trials).contains(&switch.repetition) {
            return Err(format!("a walk shown for the {}. time", switch.repetition));
        }
        self.episodes.push(Episode {
            line: 0,
            participant: participant.to_owned(),
            world: switch.world.clone(),
            executed: Executed::Option(switch.option.clone()),
            step: switch.step,
            etas: walk.etas(switch.step),
        });
        if switch.stalls > 0 {
            flags.insert(flags::STALLED.0);
        }
        if switch.plays > 1 {
            flags.insert(flags::HIDDEN.0);
        }
        let number = |number: Option<u64>| number.map_or(String::new(), |number| number.to_string());
        self.switches.row(vec![
            participant.to_owned(),
            switch.world.clone(),
            switch.option.clone(),
            number(switch.step),
            switch.ms.map_or(String::new(), |ms| format!("{ms:.0}")),
            number(switch.frame),
            switch.plays.to_string(),
            switch.stalls.to_string(),
            switch.repetition.to_string(),
        ]);
        Ok(())
    }
}

impl Collecting<'_> {
    /// Adds an episode of the study's own scenario.
    fn carry(&mut self, participant: &str, page: u32, carry: Carry) -> Result<(), String> {
        let world = self.world(&carry.world)?;
        let method = self.study.methods.iter().find(|method| method.name() == carry.method);
        let method = *method.ok_or_else(|| format!("{:?} is not a method of the study", carry.method))?;
        // as text has it, which the page was given
        let expected = carry_scenario(world, method).and_then(|scenario| Scenario::parse(&scenario.text()?));
        let expected = expected.map_err(|error| error.to_string())?;
        let log: EpisodeLog =
            serde_json::from_str(&carry.log).map_err(|error| format!("not a log of an episode: {error}"))?;
        let scenario = log.checked("the log").map_err(|error| error.to_string())?;
        if scenario != expected {
            return Err(format!(
                "carried another scenario than that of {} with {}",
                carry.world, carry.method
            ));
        }
        self.carries.push(CollectedCarry {
            participant: participant.to_owned(),
            page,
            world: carry.world,
            method: carry.method,
            log,
            stalls: carry.stalls,
            lost: carry.lost_s,
        });
        Ok(())
    }
}

fn seconds(ms: f64) -> String {
    format!("{:.2}", ms / 1000.0)
}

/// World and method of the episode that the scales on a page are about; empty at the end of the study.
fn carry_before<'s>(study: &'s PeopleStudy, pages: &[Trial], trial: u32) -> [&'s str; 2] {
    let Some(before) = pages.get(..=trial as usize) else { return ["", ""] };
    let is_after = |scale: usize| study.scales[scale].is_after_carry;
    if !matches!(before.last(), Some(Trial::Scale { scale }) if is_after(*scale)) {
        return ["", ""];
    }
    match before.iter().rev().find(|page| !matches!(page, Trial::Scale { .. })) {
        Some(Trial::Carry { world, method, .. }) => [&study.worlds[*world].name, method],
        _ => ["", ""],
    }
}

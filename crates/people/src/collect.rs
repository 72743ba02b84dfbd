//! The tables of a study: what `cocarry fit` and `cocarry infer` read, who took part, and what every column means.

use crate::carry::carry_scenario;
use crate::order::orders;
use crate::store::StoredSession;
use crate::study::{Study, StudyWorld};
use cocarry::episode::Settings;
use cocarry::scenario::{EpisodeLog, Scenario};
use cocarry_studies::fit::Guidance;
use cocarry_studies::table::text_cell;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;

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
    step: Option<u64>,
    ms: Option<f64>,
    frame: Option<u64>,
    plays: u64,
    stalls: u64,
    longest_frame_ms: f64,
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

/// A column: its name, its unit, and what it means.
type Column = (&'static str, &'static str, &'static str);

const PARTICIPANT: Column = ("participant", "", "pseudonym; the same in all files");
const WORLD: Column = ("world", "", "built-in world, or world file relative to this folder");
const OPTION: Column = ("option", "", "name of the option in the world");

const ANSWERS: [Column; 7] = [
    PARTICIPANT,
    WORLD,
    OPTION,
    ("percent", "%", "how likely the participant would choose the option; the options of a world sum to 100"),
    (
        "longer_and_riskier",
        "",
        "whether the option is both longer and riskier than another one: eq. (2) never prefers it",
    ),
    ("answered_s", "s", "time from the display of the map to the answer"),
    ("hidden_s", "s", "of it, while the page was not visible"),
];
const SWITCHES: [Column; 8] = [
    PARTICIPANT,
    WORLD,
    OPTION,
    (
        "step",
        "planning steps of 0.2 s",
        "the step in which the participant asked to switch, from 0; empty: never",
    ),
    ("switched_ms", "ms", "the same as a time since the robot began to walk"),
    ("frame", "", "the number of pictures that had been shown until then"),
    ("plays", "", "how often the walk was begun: again after the page was hidden"),
    ("stalls", "", "the number of pictures that came more than 100 ms after the one before"),
];
const PARTICIPANTS: [Column; 11] = [
    PARTICIPANT,
    ("number", "", "the participant's number, from 1"),
    ("order", "", "the row of the Latin square, from 1"),
    ("begun_utc", "", "when the participant began, by the server's clock"),
    ("finished_utc", "", "when everything had arrived; empty: never"),
    ("consent_version", "", "the version of the consent that the participant accepted"),
    ("study_sha256", "", "digest of what the participant saw: it differs between versions of the study file"),
    ("pages_done", "", "the number of pages that the participant completed"),
    ("pages", "", "the number of all pages"),
    ("questions_right", "", "the number of questions answered rightly, in the attempts allowed"),
    ("flags", "", "what to look at before the participant is used; nobody is left out for a flag"),
];
const RESPONSES: [Column; 5] = [
    PARTICIPANT,
    ("page", "", "name of the scale; `question` for a question with a right answer"),
    ("item", "", "the scale's statement, or the question"),
    ("answer", "", "the number on the scale, or the last answer"),
    ("right", "", "whether the answer of a question is right"),
];

/// The table that the program writes when it has run the carries again.
const CARRIES: [Column; 11] = [
    PARTICIPANT,
    WORLD,
    ("method", "", "the robot's method"),
    ("recording", "", "the episode, run again from the page's log: a file in this folder"),
    ("outcome", "", "how the episode ended"),
    ("option", "", "the option that the team walked at the end"),
    ("duration_s", "s", "simulated time of the episode"),
    ("human_led_from_s", "s", "when the participant first led; empty: never"),
    (
        "differs_within_s",
        "s",
        "the second by which the episode run again differs from the page's; empty: it does not",
    ),
    ("stalls", "", "the number of pictures that came more than 100 ms after the one before"),
    ("behind_clock_s", "s", "the time by which the episode fell behind the clock"),
];

/// A table that is being written.
struct Table {
    name: &'static str,
    columns: &'static [Column],
    writer: csv::Writer<Vec<u8>>,
}

impl Table {
    fn new(name: &'static str, columns: &'static [Column]) -> Self {
        let mut table = Self { name, columns, writer: csv::Writer::from_writer(Vec::new()) };
        table.row(columns.iter().map(|column| column.0.to_owned()).collect());
        table
    }

    /// Adds a row, with no cell that a spreadsheet would take for a formula.
    fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.columns.len());
        let cells: Vec<_> = cells.iter().map(|cell| text_cell(cell).into_owned()).collect();
        self.writer.write_record(&cells).expect("a table in memory is always written");
    }

    fn finish(self) -> (String, Vec<u8>) {
        let bytes = self.writer.into_inner().expect("a table in memory is always written");
        (self.name.to_owned(), bytes)
    }
}

/// The tables of these sessions: of those that are finished, or of all. Equal sessions give equal bytes.
pub fn collect(study: &Study, sessions: &[StoredSession], with_unfinished: bool) -> Collected {
    let orders = orders(study);
    let mut collecting = Collecting {
        study,
        answers: Table::new("answers.csv", &ANSWERS),
        switches: Table::new("switches.csv", &SWITCHES),
        participants: Table::new("participants.csv", &PARTICIPANTS),
        responses: Table::new("responses.csv", &RESPONSES),
        carries: Vec::new(),
        left_out: Vec::new(),
    };
    let used: Vec<_> =
        sessions.iter().filter(|session| with_unfinished || session.finished.is_some()).collect();
    let unfinished = sessions.iter().filter(|session| session.finished.is_none()).count();
    if unfinished > 0 && !with_unfinished {
        collecting.left_out.push(format!("{unfinished} who did not finish"));
    }
    // all orders have as many pages
    let pages = orders.first().map_or(0, Vec::len);
    used.iter().for_each(|session| collecting.add(session, pages));
    let Collecting { answers, switches, participants, responses, carries, left_out, .. } = collecting;
    let mut files: Vec<_> = [answers, switches, participants, responses].map(Table::finish).into();
    files.push(dictionary());
    files.push(("README.md".to_owned(), readme(study, used.len(), &left_out).into_bytes()));
    let of_files = study.worlds[..study.measured_worlds()].iter().filter(|world| !world.is_built_in);
    files.extend(of_files.map(|world| (world.name.clone(), world.world.text.clone().into_bytes())));
    Collected { files, carries, left_out, participants: used.len() }
}

struct Collecting<'a> {
    study: &'a Study,
    answers: Table,
    switches: Table,
    participants: Table,
    responses: Table,
    carries: Vec<CollectedCarry>,
    left_out: Vec<String>,
}

impl Collecting<'_> {
    fn add(&mut self, session: &StoredSession, pages: usize) {
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
                Err(error) => Err(format!("not a record of the page: {error}")),
                Ok(Done::Instructions {}) => Ok(()),
                Ok(Done::Consent { version, order }) => {
                    (consent, seen) = (version, order.to_string());
                    Ok(())
                }
                Ok(Done::Percentages(answer)) if answer.practice => Ok(()),
                Ok(Done::Switch(switch)) if switch.practice => Ok(()),
                Ok(Done::Percentages(answer)) => match known.insert((answer.world.clone(), None)) {
                    false => Err(format!("a second answer for {}", answer.world)),
                    true => self.percentages(participant, &answer, &mut flags),
                },
                Ok(Done::Switch(switch)) => {
                    match known.insert((switch.world.clone(), Some(switch.option.clone()))) {
                        false => {
                            Err(format!("a second walk on option {} of {}", switch.option, switch.world))
                        }
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
                        flags.insert("question-not-right");
                    }
                    let answer = answers.last().cloned().unwrap_or_default();
                    let cells =
                        [participant.clone(), "question".to_owned(), text, answer, is_right.to_string()];
                    self.responses.row(cells.into());
                    Ok(())
                }
                Ok(Done::Scale { name, answers }) => {
                    for (item, answer) in answers {
                        let cells =
                            [participant.clone(), name.clone(), item, answer.to_string(), String::new()];
                        self.responses.row(cells.into());
                    }
                    Ok(())
                }
            };
            if let Err(why) = added {
                flags.insert("left-out");
                self.left_out.push(format!("{participant}, page {}: {why}", trial + 1));
            }
        }
        let flags = flags.into_iter().collect::<Vec<_>>().join(" ");
        self.participants.row(vec![
            participant.clone(),
            (session.place + 1).to_string(),
            seen,
            session.begun.clone(),
            session.finished.clone().unwrap_or_default(),
            consent,
            session.study.clone(),
            pages_done.to_string(),
            pages.to_string(),
            right.to_string(),
            flags,
        ]);
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
                flags.insert("longer-and-riskier-over-20");
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
            flags.insert("page-hidden");
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
        let walk = option.and_then(|option| Guidance::along_option(&world.set, &Settings::default(), option));
        let Some(walk) = walk else {
            return Err(format!("{:?} is not an option of {}", switch.option, switch.world));
        };
        if let Some(step) = switch.step.filter(|step| *step >= walk.steps()) {
            return Err(format!("step {step} of a walk that has {}", walk.steps()));
        }
        if switch.stalls > 0 || switch.longest_frame_ms > 500.0 {
            flags.insert("pictures-stalled");
        }
        if switch.plays > 1 {
            flags.insert("page-hidden");
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

/// What every column means.
fn dictionary() -> (String, Vec<u8>) {
    const COLUMNS: [Column; 4] =
        [("file", "", ""), ("column", "", ""), ("unit", "", ""), ("meaning", "", "")];
    let mut table = Table::new("dictionary.csv", &COLUMNS);
    let files: [(&str, &[Column]); 5] = [
        ("answers.csv", &ANSWERS),
        ("switches.csv", &SWITCHES),
        ("participants.csv", &PARTICIPANTS),
        ("responses.csv", &RESPONSES),
        ("carries.csv", &CARRIES),
    ];
    for (file, columns) in files {
        for (name, unit, meaning) in columns {
            table.row([file, name, unit, meaning].map(str::to_owned).into());
        }
    }
    table.finish()
}

fn readme(study: &Study, participants: usize, left_out: &[String]) -> String {
    let people = if participants == 1 { "participant" } else { "participants" };
    let mut text = format!(
        "# {}\n\nAnswers of {participants} {people}, written by cocarry {}. Every participant has a pseudonym; who they are is in \
         none of these files.\n\n",
        study.title.replace(['\n', '\r', '#', '<', '[', '`'], " "),
        env!("CARGO_PKG_VERSION"),
    );
    text += "| file | what it has |\n| --- | --- |\n\
        | answers.csv | the percentage that each participant gave to each option of each map |\n\
        | switches.csv | the step at which each participant would have stopped following a robot that leads on an option |\n\
        | participants.csv | a row for each participant: order, times, versions, flags |\n\
        | responses.csv | answers to scales and questions |\n\
        | carries.csv, carries/ | episodes in which participants carried, if they did, run again and recorded |\n\
        | dictionary.csv | what every column means, with its unit |\n\n";
    text += "```sh\ncocarry fit risk-weight answers.csv\ncocarry fit eta switches.csv\ncocarry infer answers.csv switches.csv\n```\n\n";
    text += "The walks are those of a point along each option at 0.5 m/s, as `cocarry fit eta` takes them. Answers were given on a page: \
        they are choices and their timing. A mouse is not a beam in the hands, and nothing here measures a force on a person.\n";
    if !left_out.is_empty() {
        text += "\nLeft out:\n\n";
        for line in left_out {
            // writing to a text does not fail
            let _ = writeln!(text, "- {}", line.replace(['<', '[', '`', '\n', '\r'], " "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::simulate;
    use crate::site::{Sink, Site};
    use crate::store::Store;
    use crate::study::TEMPLATE;
    use serde_json::{Map, json};

    fn study(folder: &std::path::Path) -> Study {
        let file = folder.join("study.toml");
        std::fs::write(&file, TEMPLATE).unwrap();
        Study::read(&file).unwrap()
    }

    fn file<'a>(collected: &'a Collected, name: &str) -> &'a str {
        let (_, bytes) = collected.files.iter().find(|(other, _)| other == name).unwrap();
        std::str::from_utf8(bytes).unwrap()
    }

    #[test]
    fn simulated_participants_are_collected_whole() {
        let folder = tempfile::tempdir().unwrap();
        let study = study(folder.path());
        let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
        let site = Site::new(&study, Sink::Server, None).unwrap();
        let truths = simulate(&study, &site.digest, &mut store, 5, 1).unwrap();
        // again, nothing changes
        assert_eq!(simulate(&study, &site.digest, &mut store, 5, 1).unwrap().len(), 5);
        let collected = collect(&study, &store.sessions().unwrap(), false);
        assert_eq!((collected.participants, collected.left_out.len()), (5, 0));
        let lines = |name| file(&collected, name).lines().count();
        // two worlds of four options
        assert_eq!([lines("answers.csv"), lines("switches.csv"), lines("participants.csv")], [41, 41, 6]);
        assert_eq!(lines("responses.csv"), 1 + 5 * (2 + 6 + 2));
        assert!(truths.iter().all(|truth| file(&collected, "answers.csv").contains(&truth.participant)));
        assert!(file(&collected, "README.md").contains("A mouse is not a beam"));
    }

    #[test]
    fn a_forged_answer_is_left_out_and_named_and_a_formula_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let study = study(folder.path());
        let record = |data: Value| -> Map<String, Value> {
            serde_json::from_value(json!({ "kind": "done", "data": data })).unwrap()
        };
        let percentages = |world: &str, percent: Value| {
            record(
                json!({ "task": "percentages", "world": world, "practice": false, "percent": percent, "ms": 10.0, "hidden_ms": 0.0 }),
            )
        };
        let switch = |option: &str, step: u64| {
            record(
                json!({ "task": "switch", "world": "environment-1", "option": option, "practice": false, "step": step,
                "ms": 1.0, "frame": 1, "plays": 1, "stalls": 0, "longest_frame_ms": 20.0 }),
            )
        };
        let whole = json!([["1", 10], ["2", 20], ["3", 30], ["4", 40]]);
        let records = vec![
            percentages("environment-1", whole.clone()),
            percentages("environment-1", whole.clone()),
            percentages("environment-4", json!([["1", 90], ["2", 20], ["3", 0], ["4", 0]])),
            percentages("elsewhere", whole),
            switch("1", 3),
            switch("2", 1_000_000),
            switch("9", 3),
            record(json!({ "task": "scale", "name": "=cmd()", "answers": [["=1+1", 3]] })),
            record(json!({ "task": "teapot" })),
        ];
        let session = StoredSession {
            participant: "p1".to_owned(),
            place: 0,
            study: "x".to_owned(),
            begun: "t".to_owned(),
            finished: None,
            records: (0..).zip(records.into_iter().map(|record| vec![record])).collect(),
        };
        let collected = collect(&study, std::slice::from_ref(&session), false);
        assert_eq!(
            (collected.participants, &*collected.left_out),
            (0, &["1 who did not finish".to_owned()][..])
        );
        let collected = collect(&study, &[session], true);
        let said =
            ["second answer", "sum to 110", "not a world", "step 1000000", "not an option", "not a record"];
        assert_eq!(collected.left_out.len(), said.len(), "{:?}", collected.left_out);
        for (line, said) in collected.left_out.iter().zip(said) {
            assert!(line.contains(said), "{line}: {said}");
        }
        assert_eq!(file(&collected, "answers.csv").lines().count(), 5);
        assert_eq!(file(&collected, "switches.csv").lines().nth(1), Some("p1,environment-1,1,3,1,1,1,0"));
        assert!(file(&collected, "responses.csv").contains("p1,'=cmd(),'=1+1,3,"));
        assert!(file(&collected, "participants.csv").lines().nth(1).unwrap().contains("left-out"));
    }
}

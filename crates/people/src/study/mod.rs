//! A study: what participants do, in which worlds, and what they read.

mod file;
mod fluency;
#[cfg(test)]
mod tests;

use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::Prospect;
use cocarry::world::World;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

pub(crate) use fluency::SUBSCALES;

/// A commented study file, to start from.
pub const TEMPLATE: &str = include_str!("../../../../assets/people/study.toml");

/// The largest number of participants.
pub const MAX_PARTICIPANTS: u64 = 100_000;
/// The longest name, title, code or address, characters.
const MAX_NAME: usize = 200;

/// What participants do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// They divide 100 % between the options of a world.
    Percentages,
    /// They say when they would stop following a robot that leads on an option.
    Switch,
    /// They carry along: the simulator runs in the page, and they are the human.
    Carry,
}

impl Task {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Percentages => "percentages",
            Self::Switch => "switch",
            Self::Carry => "carry",
        }
    }
}

/// A study.
#[derive(Clone, Debug)]
pub struct PeopleStudy {
    /// The name of its file.
    pub file: PathBuf,
    /// The title on every page.
    pub title: String,
    /// The largest number of participants.
    pub participants: u64,
    /// The worlds, in the order of the file; that of the practice is the last one.
    pub worlds: Vec<StudyWorld>,
    /// Whether the last world is for practice alone.
    pub has_practice: bool,
    /// The tasks, in their order.
    pub tasks: Vec<Task>,
    /// Whether participants see the worlds in different orders.
    pub has_latin_square: bool,
    /// Whether maps name the openings.
    pub shows_openings: bool,
    /// Parameters of the page's address that are kept; the first one identifies a person.
    pub platform_ids: Vec<String>,
    /// Version of the consent, and its text.
    pub consent: [String; 2],
    /// Instructions of the tasks, by their place in `tasks`.
    pub instructions: Vec<String>,
    /// How often each walk of a robot that leads is shown.
    pub switch_trials: u64,
    /// The eta (planning steps) by which participants are grouped, ascending; none without groups.
    pub eta_groups: Vec<f64>,
    /// The methods of the robot with which they carry, each in every world.
    pub methods: Vec<Method>,
    /// The questions with a right answer.
    pub questions: Vec<Question>,
    /// The scales.
    pub scales: Vec<Scale>,
    /// The end.
    pub end: End,
}

/// A world of a study.
#[derive(Clone, Debug)]
pub struct StudyWorld {
    /// Its name in tables: that of a built-in world, or of the file that `collect` writes.
    pub name: String,
    /// The world.
    pub world: World,
    /// Its options' paths.
    pub set: OptionSet,
    /// The names of the options.
    pub options: Vec<String>,
    /// Length and risk of each option.
    pub prospects: Vec<Prospect>,
    /// Whether it is built in, and needs no file beside the tables.
    pub is_built_in: bool,
}

impl StudyWorld {
    /// Whether an option is both longer and riskier than another one: whatever alpha and gamma a person has,
    /// eq. (2) never prefers it.
    pub fn is_dominated(&self, option: usize) -> bool {
        let Prospect { length, risk, .. } = self.prospects[option];
        self.prospects.iter().any(|other| other.length < length && other.risk < risk)
    }
}

/// A question with a right answer.
#[derive(Clone, Debug, Serialize)]
pub struct Question {
    /// The question.
    pub text: String,
    /// The answers to choose from.
    pub answers: Vec<String>,
    /// The index of the right one.
    pub right: usize,
    /// How often it is asked at most.
    pub attempts: u64,
    /// Whether it comes between the tasks, not before the first one.
    #[serde(skip)]
    pub is_between: bool,
}

/// A page of scales.
#[derive(Clone, Debug, Serialize)]
pub struct Scale {
    /// Its name in tables.
    pub name: String,
    /// The scales on it.
    pub kind: ScaleKind,
    /// The statements of a Likert scale, or of the fluency scale.
    pub statements: Vec<String>,
    /// The number of its points.
    pub points: u64,
    /// The words at its ends.
    pub ends: Vec<String>,
    /// Whether it comes after every episode in which a participant carried, not once at the end.
    #[serde(skip)]
    pub is_after_carry: bool,
}

impl Scale {
    /// What each of its answers is about, as tables name it.
    pub fn items(&self) -> Vec<&str> {
        match self.kind {
            ScaleKind::NasaTlx => NASA_TLX.to_vec(),
            ScaleKind::Likert | ScaleKind::Fluency => self.statements.iter().map(String::as_str).collect(),
        }
    }
}

/// The scales of the NASA Task Load Index, in its order. The page has its questions.
const NASA_TLX: [&str; 6] =
    ["mental demand", "physical demand", "temporal demand", "performance", "effort", "frustration"];

/// The kinds of scales.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScaleKind {
    /// The six raw scales of the NASA Task Load Index, from 0 to 100.
    NasaTlx,
    /// Statements, with a number of points each.
    Likert,
    /// The statements about fluency after Hoffman (2019), with means of their subscales.
    Fluency,
}

/// The end of a study.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// The text of the last page.
    #[serde(default)]
    pub text: String,
    /// The code that everybody gets; without it each participant gets one of their own.
    pub code: Option<String>,
    /// The address that the last page leads to.
    pub redirect: Option<String>,
}

impl PeopleStudy {
    /// The number of worlds whose answers count: the first ones.
    pub fn measured_worlds(&self) -> usize {
        self.worlds.len() - usize::from(self.has_practice)
    }

    /// The index of the world for practice.
    pub fn practice_world(&self) -> Option<usize> {
        self.has_practice.then(|| self.worlds.len() - 1)
    }

    /// Whether participants carry: the page then needs the simulator as a WebAssembly module.
    pub fn has_carry(&self) -> bool {
        self.tasks.contains(&Task::Carry)
    }

    /// How often a task is done in each world.
    pub fn trials(&self, task: Task) -> u64 {
        if task == Task::Switch { self.switch_trials } else { 1 }
    }

    /// A world whose answers count, by its name in tables.
    pub fn world(&self, name: &str) -> Option<&StudyWorld> {
        self.worlds[..self.measured_worlds()].iter().find(|world| world.name == name)
    }

    /// The database of its answers: beside the study file, with the extension `sqlite`.
    pub fn database(&self) -> PathBuf {
        self.file.with_extension("sqlite")
    }

    /// As [`PeopleStudy::database`], for simulated participants.
    pub fn simulated_database(&self) -> PathBuf {
        self.file.with_extension("simulated.sqlite")
    }
}

/// Whether a text is a name of letters, digits, - and _.
pub(crate) fn is_word(text: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    !text.is_empty() && text.len() <= MAX_NAME && text.chars().all(is_part)
}

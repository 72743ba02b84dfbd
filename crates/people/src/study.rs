//! A study file, read and checked, with its worlds loaded.

use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::located::{self, Source};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::{Prospect, RISK_WEIGHT};
use cocarry::world::World;
use cocarry_studies::fit::Situation;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A commented study file, to start from.
pub const TEMPLATE: &str = include_str!("../../../assets/people/study.toml");

/// The largest number of participants.
pub const MAX_PARTICIPANTS: u64 = 100_000;
/// The largest number of worlds, of questions, of scales, and of the statements or answers of one.
const MAX_ITEMS: usize = 24;
/// The longest text of a page, characters.
const MAX_TEXT: usize = 20_000;
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
pub struct Study {
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
    /// Whether an option is both longer and riskier than another one: whatever alpha and gamma a person has, eq. (2) never
    /// prefers it.
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
    /// The statements of a Likert scale.
    pub statements: Vec<String>,
    /// The number of its points.
    pub points: u64,
    /// The words at its ends.
    pub ends: Vec<String>,
}

impl Scale {
    /// What each of its answers is about, as tables name it.
    pub fn items(&self) -> Vec<&str> {
        match self.kind {
            ScaleKind::NasaTlx => NASA_TLX.to_vec(),
            ScaleKind::Likert => self.statements.iter().map(String::as_str).collect(),
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyText {
    title: Spanned<String>,
    participants: Spanned<u64>,
    worlds: Vec<Spanned<String>>,
    tasks: Spanned<Vec<Task>>,
    #[serde(default)]
    order: Order,
    #[serde(default)]
    show_openings: bool,
    #[serde(default)]
    platform_ids: Vec<Spanned<String>>,
    consent: ConsentText,
    practice: Option<PracticeText>,
    percentages: Option<InstructionsText>,
    switch: Option<InstructionsText>,
    carry: Option<CarryText>,
    #[serde(default)]
    question: Vec<QuestionText>,
    #[serde(default)]
    scale: Vec<ScaleText>,
    end: Spanned<End>,
}

#[derive(Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Order {
    #[default]
    LatinSquare,
    AsListed,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ConsentText {
    version: Spanned<String>,
    text: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PracticeText {
    world: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InstructionsText {
    text: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CarryText {
    text: Spanned<String>,
    methods: Spanned<Vec<Method>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QuestionText {
    text: Spanned<String>,
    answers: Spanned<Vec<String>>,
    right: Spanned<u64>,
    #[serde(default = "one")]
    attempts: u64,
    #[serde(default)]
    when: When,
}

fn one() -> u64 {
    1
}

#[derive(Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum When {
    #[default]
    Before,
    Between,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScaleText {
    name: Spanned<String>,
    kind: Spanned<ScaleKind>,
    #[serde(default)]
    statements: Vec<String>,
    points: Option<Spanned<u64>>,
    #[serde(default)]
    ends: Vec<String>,
}

impl Study {
    /// Reads a study file, with the worlds that it names.
    ///
    /// # Errors
    /// The file, the line, the key, the value, and what would be right.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = path.display().to_string();
        let text = located::read(&bounds::SETTINGS, path)?;
        let source = Checked(Source { file: &file, text: &text });
        let given: StudyText = source.0.parse("file of a study with people")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut worlds: Vec<StudyWorld> = Vec::new();
        source.count(&given.title, "worlds", given.worlds.len(), 1)?;
        for name in &given.worlds {
            let world = source.world(folder, name, "worlds")?;
            if worlds.iter().any(|other| other.name == world.name) {
                let expected = "a world whose name no other world of the study has";
                return Err(source.wrong(name, "worlds", format_args!("{:?}", name.get_ref()), expected));
            }
            worlds.push(world);
        }
        if let Some(practice) = &given.practice {
            worlds.push(source.world(folder, &practice.world, "practice.world")?);
        }
        let tasks = given.tasks.get_ref();
        let is_repeated = tasks.iter().enumerate().any(|(at, task)| tasks[..at].contains(task));
        if tasks.is_empty() || is_repeated {
            let written = source.written(&given.tasks);
            let expected = "a list of \"percentages\", \"switch\", \"carry\" or several of them, each once";
            return Err(source.wrong(&given.tasks, "tasks", written, expected));
        }
        let mut instructions = Vec::new();
        for task in tasks {
            let text = match task {
                Task::Percentages => given.percentages.as_ref().map(|table| &table.text),
                Task::Switch => given.switch.as_ref().map(|table| &table.text),
                Task::Carry => given.carry.as_ref().map(|table| &table.text),
            };
            let text = text.ok_or_else(|| {
                let name = task.name();
                Error::missing(
                    source.place(&given.tasks, ""),
                    format_args!("the table [{name}] with the instructions of the task, as `text`"),
                )
            })?;
            instructions.push(source.text(text, "text", MAX_TEXT)?);
        }
        if !(1..=MAX_PARTICIPANTS).contains(given.participants.get_ref()) {
            let expected = format!("a whole number from 1 to {MAX_PARTICIPANTS}");
            let found = *given.participants.get_ref();
            return Err(source.wrong(&given.participants, "participants", found, &expected));
        }
        for name in &given.platform_ids {
            if !is_word(name.get_ref()) {
                let expected = "the name of a parameter of an address: letters, digits, - and _";
                let found = format!("{:?}", name.get_ref());
                return Err(source.wrong(name, "platform_ids", found, expected));
            }
        }
        source.count(&given.title, "platform_ids", given.platform_ids.len(), 0)?;
        source.count(&given.title, "question", given.question.len(), 0)?;
        source.count(&given.title, "scale", given.scale.len(), 0)?;
        let version = source.text(&given.consent.version, "version", MAX_NAME)?;
        let consent = [version, source.text(&given.consent.text, "text", MAX_TEXT)?];
        let mut scales: Vec<Scale> = Vec::new();
        for scale in &given.scale {
            let read = source.scale(scale)?;
            if scales.iter().any(|other| other.name == read.name) {
                return Err(Error::duplicate(source.place(&scale.name, "name"), "scale"));
            }
            scales.push(read);
        }
        Ok(Self {
            file: path.to_owned(),
            title: source.text(&given.title, "title", MAX_NAME)?,
            participants: *given.participants.get_ref(),
            worlds,
            has_practice: given.practice.is_some(),
            tasks: tasks.clone(),
            has_latin_square: given.order == Order::LatinSquare,
            shows_openings: given.show_openings,
            platform_ids: given.platform_ids.into_iter().map(Spanned::into_inner).collect(),
            consent,
            instructions,
            methods: source.methods(given.carry.as_ref())?,
            questions: given.question.iter().map(|q| source.question(q)).collect::<Result<_, _>>()?,
            scales,
            end: source.end(given.end)?,
        })
    }

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

    /// A world whose answers count, by its name in tables.
    pub fn world(&self, name: &str) -> Option<&StudyWorld> {
        self.worlds[..self.measured_worlds()].iter().find(|world| world.name == name)
    }

    /// The database of its answers: beside the study file, with the extension `sqlite`.
    pub fn database(&self) -> PathBuf {
        self.file.with_extension("sqlite")
    }

    /// As [`Study::database`], for simulated participants.
    pub fn simulated_database(&self) -> PathBuf {
        self.file.with_extension("simulated.sqlite")
    }
}

/// Whether a text is a name of letters, digits, - and _.
pub(crate) fn is_word(text: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    !text.is_empty() && text.len() <= MAX_NAME && text.chars().all(is_part)
}

/// A study file, whose values are checked.
#[derive(Clone, Copy)]
struct Checked<'a>(Source<'a>);

impl<'a> Checked<'a> {
    fn place<T>(self, value: &Spanned<T>, item: &str) -> Place {
        self.0.place(value, item)
    }

    /// The error about a value.
    fn wrong<T>(self, at: &Spanned<T>, key: &str, found: impl std::fmt::Display, expected: &str) -> Error {
        Error::value(self.place(at, key), format_args!("{found}; it must be {expected}"))
    }

    /// A value as written.
    fn written<T>(self, value: &Spanned<T>) -> &'a str {
        self.0.text.get(value.span()).unwrap_or_default().trim()
    }

    /// A text that is not empty, and not too long.
    fn text(self, value: &Spanned<String>, key: &str, most: usize) -> Result<String, Error> {
        let text = value.get_ref().trim();
        let found = text.chars().count();
        if text.is_empty() || found > most {
            let found = format!("{found} characters");
            return Err(self.wrong(value, key, found, &format!("a text of 1 to {most} characters")));
        }
        Ok(text.to_owned())
    }

    /// The check of the number of values of a key; an error names the line of `at`.
    fn count<T>(self, at: &Spanned<T>, key: &str, found: usize, least: usize) -> Result<(), Error> {
        if (least..=MAX_ITEMS).contains(&found) {
            return Ok(());
        }
        let place = Place { line: None, ..self.place(at, key) };
        Err(Error::at(place, format_args!("{found} of them; there must be {least} to {MAX_ITEMS}")))
    }

    fn world(self, folder: &Path, name: &Spanned<String>, key: &str) -> Result<StudyWorld, Error> {
        let asked = name.get_ref();
        let path = folder.join(asked);
        let place = || self.place(name, key);
        let refused =
            |error: Error| Error::value(place(), format_args!("{asked:?}: cannot be used")).because(error);
        let mut world = cocarry_maps::find(&path, asked).map_err(refused)?;
        world.file.clone_from(asked);
        let is_built_in = !path.is_file();
        let name = if is_built_in {
            asked.clone()
        } else {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if !is_word(&stem) {
                let expected = "a file whose name has letters, digits, - and _ only";
                return Err(self.wrong(name, key, format_args!("{asked:?}"), expected));
            }
            format!("worlds/{stem}.toml")
        };
        let set = OptionSet::new(&world, RISK_WEIGHT).map_err(refused)?;
        let Situation { options, prospects, .. } = Situation::new(name.clone(), &set);
        Ok(StudyWorld { name, world, set, options, prospects, is_built_in })
    }

    /// The methods of the task `carry`; none without it.
    fn methods(self, given: Option<&CarryText>) -> Result<Vec<Method>, Error> {
        let Some(CarryText { methods, .. }) = given else { return Ok(Vec::new()) };
        let listed = methods.get_ref();
        let is_repeated = listed.iter().enumerate().any(|(at, method)| listed[..at].contains(method));
        match listed.is_empty() || is_repeated {
            false => Ok(listed.clone()),
            true => {
                let expected = "a list of methods of the robot, each once: see `cocarry run --help`";
                Err(self.wrong(methods, "methods", self.written(methods), expected))
            }
        }
    }

    fn question(self, given: &QuestionText) -> Result<Question, Error> {
        let answers = given.answers.get_ref();
        if !(2..=MAX_ITEMS).contains(&answers.len()) || answers.iter().any(|answer| answer.trim().is_empty())
        {
            let expected = format!("a list of 2 to {MAX_ITEMS} texts");
            return Err(self.wrong(&given.answers, "answers", self.written(&given.answers), &expected));
        }
        let right = usize::try_from(*given.right.get_ref()).unwrap_or(usize::MAX);
        if !(1..=answers.len()).contains(&right) {
            let expected = format!("the number of an answer, from 1 to {}", answers.len());
            return Err(self.wrong(&given.right, "right", right, &expected));
        }
        if !(1..=10).contains(&given.attempts) {
            let expected = "a whole number from 1 to 10";
            return Err(self.wrong(&given.right, "attempts", given.attempts, expected));
        }
        Ok(Question {
            text: self.text(&given.text, "text", MAX_TEXT)?,
            answers: answers.clone(),
            right: right - 1,
            attempts: given.attempts,
            is_between: given.when == When::Between,
        })
    }

    fn scale(self, given: &ScaleText) -> Result<Scale, Error> {
        let name = self.text(&given.name, "name", MAX_NAME)?;
        let kind = *given.kind.get_ref();
        let points = given.points.as_ref().map_or(7, |points| *points.get_ref());
        match kind {
            ScaleKind::NasaTlx => {
                if !given.statements.is_empty() || given.points.is_some() || !given.ends.is_empty() {
                    let place = self.place(&given.kind, "kind");
                    let sentence = "\"nasa-tlx\" has its own statements, points and ends; leave them out";
                    return Err(Error::value(place, sentence));
                }
            }
            ScaleKind::Likert => {
                let place = || self.place(&given.name, "");
                let is_filled = |texts: &[String]| texts.iter().all(|text| !text.trim().is_empty());
                let count = given.statements.len();
                if !(1..=MAX_ITEMS).contains(&count) || !is_filled(&given.statements) {
                    let needed = format_args!("`statements`: a list of 1 to {MAX_ITEMS} texts");
                    return Err(Error::missing(place(), needed));
                }
                if given.ends.len() != 2 || !is_filled(&given.ends) {
                    return Err(Error::missing(place(), "`ends`: the words at both ends of the scale"));
                }
                if let Some(given) = given.points.as_ref().filter(|p| !(2..=11).contains(p.get_ref())) {
                    return Err(self.wrong(given, "points", points, "a whole number from 2 to 11"));
                }
            }
        }
        let (statements, ends) = (given.statements.clone(), given.ends.clone());
        Ok(Scale { name, kind, statements, points, ends })
    }

    fn end(self, given: Spanned<End>) -> Result<End, Error> {
        let place = self.place(&given, "end");
        let end = given.into_inner();
        let item = |key: &str| Place { item: format!("end.{key}"), ..place.clone() };
        if let Some(code) = end.code.as_ref().filter(|code| !is_word(code)) {
            let expected = "letters, digits, - and _";
            return Err(Error::bad(item("code"), format_args!("{code:?}"), expected));
        }
        if let Some(address) = &end.redirect {
            let is_address = address.starts_with("https://") && address.len() <= 10 * MAX_NAME;
            if !is_address || address.contains(|c: char| c.is_whitespace() || c.is_control()) {
                let expected = "an address that begins with https://";
                return Err(Error::bad(item("redirect"), format_args!("{address:?}"), expected));
            }
        }
        if end.text.chars().count() > MAX_TEXT {
            return Err(Error::at(item("text"), format_args!("longer than {MAX_TEXT} characters")));
        }
        Ok(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Study, Error> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("study.toml");
        std::fs::write(&file, text).unwrap();
        Study::read(&file)
    }

    #[test]
    fn the_template_is_a_study() {
        let study = read(TEMPLATE).unwrap();
        assert_eq!(study.tasks, [Task::Percentages, Task::Switch]);
        assert_eq!((study.worlds.len(), study.practice_world()), (3, Some(2)));
        assert_eq!(study.worlds[0].options, ["1", "2", "3", "4"]);
        assert_eq!(study.questions.len() + study.scales.len(), 4);
    }

    #[test]
    fn an_error_has_its_place_its_value_and_what_would_be_right() {
        for (right, wrong, said) in [
            ("participants = 20 ", "participants = 0 ", ["participants = 0", "from 1 to 100000"]),
            ("tasks = [\"percentages\", \"switch\"]", "tasks = []", ["tasks = []", "\"percentages\""]),
            ("\"environment-4\"", "\"environment-9\"", ["worlds = \"environment-9\"", "environment-4"]),
            ("\"environment-4\"", "\"environment-1\"", ["worlds = \"environment-1\"", "no other world"]),
            ("right = 2 ", "right = 4 ", ["right = 4", "from 1 to 3"]),
            ("attempts = 3", "attempts = 0", ["attempts = 0", "from 1 to 10"]),
            ("points = 7", "points = 1", ["points = 1", "from 2 to 11"]),
            ("# code = \"C0FFEE\"", "code = \"<b>\"", ["end.code", "letters, digits"]),
            ("title = ", "titel = ", ["titel", "title"]),
            ("version = \"1\"", "version = \"\"", ["version", "1 to 200 characters"]),
        ] {
            assert!(TEMPLATE.contains(right), "{right}");
            let error = read(&TEMPLATE.replacen(right, wrong, 1)).unwrap_err();
            let mut text = error.to_string();
            let mut cause = std::error::Error::source(&error);
            while let Some(error) = cause {
                text += &format!(": {error}");
                cause = error.source();
            }
            assert!(text.contains("study.toml") && said.iter().all(|part| text.contains(part)), "{text}");
        }
    }

    #[test]
    fn an_option_that_is_longer_and_riskier_than_another_is_dominated() {
        let mut world = read(TEMPLATE).unwrap().worlds.swap_remove(0);
        world.prospects =
            [(10.0, 0.5), (12.0, 0.6), (12.0, 0.5), (14.0, 0.2)].map(|(l, r)| Prospect::new(l, r)).to_vec();
        let dominated: Vec<_> = (0..4).map(|option| world.is_dominated(option)).collect();
        assert_eq!(dominated, [false, true, false, false]);
    }
}

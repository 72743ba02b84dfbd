//! A study file, read and checked, with its worlds loaded.

use super::{
    End, MAX_NAME, MAX_PARTICIPANTS, PeopleStudy, Question, Scale, ScaleKind, StudyWorld, Task, fluency,
    is_word,
};
use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::located::{self, Source};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::RISK_WEIGHT;
use cocarry_studies::fit::Situation;
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

/// The largest number of worlds, of questions, of scales, and of the statements or answers of one.
const MAX_ITEMS: usize = 24;
/// The largest number of times that a walk is shown.
const MAX_TRIALS: u64 = 10;
/// The longest text of a page, characters.
const MAX_TEXT: usize = 20_000;

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
    switch: Option<SwitchText>,
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
struct SwitchText {
    text: Spanned<String>,
    trials: Option<Spanned<u64>>,
    eta_groups: Option<Spanned<Vec<f64>>>,
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
    after: Option<Spanned<Task>>,
}

impl PeopleStudy {
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
            if let Some(after) = scale.after.as_ref().filter(|after| !tasks.contains(after.get_ref())) {
                let expected = "left out, or \"carry\" among the tasks";
                return Err(source.wrong(after, "after", source.written(after), expected));
            }
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
            switch_trials: source.trials(given.switch.as_ref())?,
            eta_groups: source.eta_groups(given.switch.as_ref())?,
            methods: source.methods(given.carry.as_ref())?,
            questions: given.question.iter().map(|q| source.question(q)).collect::<Result<_, _>>()?,
            scales,
            end: source.end(given.end)?,
        })
    }
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

    /// How often each walk of the task `switch` is shown.
    fn trials(self, given: Option<&SwitchText>) -> Result<u64, Error> {
        let Some(trials) = given.and_then(|given| given.trials.as_ref()) else { return Ok(1) };
        match (1..=MAX_TRIALS).contains(trials.get_ref()) {
            true => Ok(*trials.get_ref()),
            false => {
                let expected = format!("a whole number from 1 to {MAX_TRIALS}");
                Err(self.wrong(trials, "trials", trials.get_ref(), &expected))
            }
        }
    }

    /// The eta of the groups, ascending.
    fn eta_groups(self, given: Option<&SwitchText>) -> Result<Vec<f64>, Error> {
        let Some(groups) = given.and_then(|given| given.eta_groups.as_ref()) else { return Ok(Vec::new()) };
        let etas = groups.get_ref();
        let is_eta = |eta: &f64| eta.is_finite() && *eta > 0.0;
        let ascend = etas.windows(2).all(|pair| pair[0] < pair[1]);
        if (2..=MAX_ITEMS).contains(&etas.len()) && etas.iter().all(is_eta) && ascend {
            return Ok(etas.clone());
        }
        let expected = "two or more numbers above 0, in planning steps, each larger than the one before";
        Err(self.wrong(groups, "eta_groups", self.written(groups), expected))
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
        let points = given.points.as_ref().map_or(fluency::POINTS, |points| *points.get_ref());
        if let Some(given) = given.points.as_ref().filter(|p| !(2..=11).contains(p.get_ref())) {
            return Err(self.wrong(given, "points", points, "a whole number from 2 to 11"));
        }
        let (statements, ends) = match kind {
            ScaleKind::Fluency => self.fluency(given)?,
            ScaleKind::NasaTlx => self.nasa_tlx(given)?,
            ScaleKind::Likert => self.likert(given)?,
        };
        if let Some(after) = given.after.as_ref().filter(|after| *after.get_ref() != Task::Carry) {
            let expected = "\"carry\", or left out: the scale then comes once, at the end";
            return Err(self.wrong(after, "after", self.written(after), expected));
        }
        Ok(Scale { name, kind, statements, points, ends, is_after_carry: given.after.is_some() })
    }

    /// Statements and ends of a fluency scale.
    fn fluency(self, given: &ScaleText) -> Result<(Vec<String>, Vec<String>), Error> {
        if !given.statements.is_empty() || !matches!(given.ends.len(), 0 | 2) {
            let place = self.place(&given.kind, "kind");
            let sentence =
                "\"fluency\" has its own statements; give no `statements`, and both `ends` or none";
            return Err(Error::value(place, sentence));
        }
        let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let ends = if given.ends.is_empty() { texts(&fluency::ENDS) } else { given.ends.clone() };
        Ok((texts(&fluency::STATEMENTS.map(|statement| statement.text)), ends))
    }

    /// The page has the statements and ends of a NASA-TLX scale.
    fn nasa_tlx(self, given: &ScaleText) -> Result<(Vec<String>, Vec<String>), Error> {
        if !given.statements.is_empty() || given.points.is_some() || !given.ends.is_empty() {
            let place = self.place(&given.kind, "kind");
            let sentence = "\"nasa-tlx\" has its own statements, points and ends; leave them out";
            return Err(Error::value(place, sentence));
        }
        Ok((Vec::new(), Vec::new()))
    }

    /// Statements and ends of a Likert scale.
    fn likert(self, given: &ScaleText) -> Result<(Vec<String>, Vec<String>), Error> {
        let place = || self.place(&given.name, "");
        let is_filled = |texts: &[String]| texts.iter().all(|text| !text.trim().is_empty());
        if !(1..=MAX_ITEMS).contains(&given.statements.len()) || !is_filled(&given.statements) {
            let needed = format_args!("`statements`: a list of 1 to {MAX_ITEMS} texts");
            return Err(Error::missing(place(), needed));
        }
        if given.ends.len() != 2 || !is_filled(&given.ends) {
            return Err(Error::missing(place(), "`ends`: the words at both ends of the scale"));
        }
        Ok((given.statements.clone(), given.ends.clone()))
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

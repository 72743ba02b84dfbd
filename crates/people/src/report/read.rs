//! The tables of a study, read from the folder that `cocarry study collect` writes.

use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::located;
use cocarry_studies::fit::{AnswerFile, SwitchFile, TableColumn, bad_cell, table_rows};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The tables of a study, with its participants in the order of their numbers.
#[derive(Clone, Debug)]
pub struct StudyTables {
    /// The study's title.
    pub title: String,
    /// Everybody who began.
    pub people: Vec<StudyPerson>,
    /// The answers of those who finished; `None` if there are none.
    pub answers: Option<AnswerFile>,
    /// Their switches.
    pub switches: Option<SwitchFile>,
    /// What was measured of the episodes in which they carried, and how they judged them.
    pub carried: Vec<Carried>,
}

/// A participant.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPerson {
    /// The pseudonym.
    pub name: String,
    /// The number, from 1.
    pub number: u64,
    /// Whether everything arrived.
    pub is_finished: bool,
    /// The number of pages done.
    pub pages_done: u64,
    /// What to look at before the participant is used.
    pub flags: Vec<String>,
    /// The page that was not done, in words; empty for who finished.
    pub left_at: String,
}

/// A measured value of an episode in which a participant carried.
#[derive(Clone, Debug, PartialEq)]
pub struct Carried {
    /// The pseudonym.
    pub participant: String,
    /// The world.
    pub world: String,
    /// The robot's method.
    pub method: String,
    /// What was measured: an index of [`MEASURES`], or the name of a scale.
    pub measure: Measure,
    /// The value.
    pub value: f64,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// One of [`MEASURES`].
    Episode(usize),
    /// The mean over the items of a scale.
    Scale(String),
}

/// What is measured of an episode: the column, its name with unit, and decimals.
pub const MEASURES: [(&str, &str, usize); 7] = [
    ("arrived", "arrived (share)", 2),
    ("duration_s", "time (s)", 1),
    ("human_led_s", "time led by the participant (s)", 1),
    ("transitions", "transitions of the lead", 2),
    ("walked_m", "path walked (m)", 2),
    ("hand_force_mean_n", "mean simulated force of the hand (N)", 2),
    ("peak_force_n", "peak simulated force in a grip (N)", 1),
];

/// The table by which a folder is known as that of `collect`.
const PARTICIPANTS: &str = "participants.csv";

impl StudyTables {
    /// Whether a folder has such tables.
    pub fn are_in(folder: &Path) -> bool {
        folder.join(PARTICIPANTS).is_file()
    }

    /// Reads them. Rows of people who did not finish are left out; tables may be in any order of people.
    ///
    /// # Errors
    /// The file, the line, the column and the value.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let mut people = people(&folder.join(PARTICIPANTS))?;
        people.sort_by_key(|person| person.number);
        let known: BTreeSet<&str> = people.iter().map(|person| person.name.as_str()).collect();
        let finished: Vec<String> =
            people.iter().filter(|person| person.is_finished).map(|person| person.name.clone()).collect();
        let check = |path: &Path, named: Vec<(String, u64)>| match named
            .into_iter()
            .find(|(name, _)| !known.contains(name.as_str()))
        {
            None => Ok(()),
            Some((name, line)) => {
                let place = Place::line(path.display().to_string(), line, "participant");
                Err(bad_cell(place, &name, &format!("a participant of {PARTICIPANTS}")))
            }
        };
        let existing = |name: &str| -> Result<Option<std::path::PathBuf>, Error> {
            let path = folder.join(name);
            Ok((path.is_file() && has_rows(&path)?).then_some(path))
        };
        let answers = existing("answers.csv")?
            .map(|path| {
                let file = AnswerFile::read(&path)?;
                check(&path, file.participants())?;
                Ok::<_, Error>(file.of(&finished))
            })
            .transpose()?;
        let switches = existing("switches.csv")?
            .map(|path| {
                let file = SwitchFile::read(&path)?;
                check(&path, file.participants())?;
                Ok::<_, Error>(file.of(&finished))
            })
            .transpose()?;
        let mut carried = Vec::new();
        for (name, read) in [("carries.csv", carries as Reader), ("responses.csv", scales as Reader)] {
            if let Some(path) = existing(name)? {
                let (rows, named) = read(&path)?;
                check(&path, named)?;
                carried.extend(rows);
            }
        }
        let places: BTreeMap<&String, usize> = finished.iter().zip(0..).collect();
        carried.retain(|row| places.contains_key(&row.participant));
        carried.sort_by(|a, b| {
            let key = |row: &Carried| (places[&row.participant], row.world.clone(), row.method.clone());
            (key(a), &a.measure).cmp(&(key(b), &b.measure))
        });
        Ok(Self { title: title(folder)?, people, answers, switches, carried })
    }
}

/// The study's title: that of the README in the folder, if there is one.
fn title(folder: &Path) -> Result<String, Error> {
    let path = folder.join("README.md");
    let text = if path.is_file() { located::read(&bounds::SETTINGS, &path)? } else { String::new() };
    let title = text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("A study with people");
    Ok(title.trim().to_owned())
}

/// Whether a table has more than its header.
fn has_rows(path: &Path) -> Result<bool, Error> {
    let text = located::read(&bounds::TABLE, path)?;
    let is_row = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    Ok(text.lines().filter(is_row).nth(1).is_some())
}

/// A whole number of a cell.
fn whole(file: &str, line: u64, column: &str, value: &str) -> Result<u64, Error> {
    value.parse().map_err(|_| bad_cell(Place::line(file, line, column), value, "a whole number"))
}

fn people(path: &Path) -> Result<Vec<StudyPerson>, Error> {
    let columns = [
        TableColumn::needed("participant"),
        TableColumn::needed("number"),
        TableColumn::needed("finished_utc"),
        TableColumn::needed("pages_done"),
        TableColumn::needed("flags"),
        TableColumn::optional("left_at"),
    ];
    let file = path.display().to_string();
    let mut people: Vec<StudyPerson> = Vec::new();
    let mut known = BTreeMap::new();
    for row in table_rows(path, columns)? {
        let [name, number, finished, pages_done, flags, left_at] = row.values;
        let place = |column: &str| Place::line(&file, row.line, column);
        if name.is_empty() {
            return Err(bad_cell(place("participant"), &name, "a name"));
        }
        if let Some(first) = known.insert(name.clone(), row.line) {
            let expected = format!("a participant whom line {first} does not have");
            return Err(bad_cell(place("participant"), &name, &expected));
        }
        people.push(StudyPerson {
            number: whole(&file, row.line, "number", &number)?,
            is_finished: !finished.is_empty(),
            pages_done: whole(&file, row.line, "pages_done", &pages_done)?,
            flags: flags.split_whitespace().map(str::to_owned).collect(),
            name,
            left_at,
        });
    }
    Ok(people)
}

/// The values of a table, and the participants that it names.
type Values = (Vec<Carried>, Vec<(String, u64)>);
/// The reader of a table.
type Reader = fn(&Path) -> Result<Values, Error>;

/// What was measured of the episodes.
fn carries(path: &Path) -> Result<Values, Error> {
    let columns = [
        TableColumn::needed("participant"),
        TableColumn::needed("world"),
        TableColumn::needed("method"),
        TableColumn::needed("outcome"),
        TableColumn::needed("duration_s"),
        TableColumn::optional("human_led_s"),
        TableColumn::optional("transitions"),
        TableColumn::optional("walked_m"),
        TableColumn::optional("hand_force_mean_n"),
        TableColumn::optional("peak_force_n"),
    ];
    let file = path.display().to_string();
    let (mut rows, mut named, mut known) = (Vec::new(), Vec::new(), BTreeMap::new());
    for line in table_rows(path, columns)? {
        let [participant, world, method, outcome, measured @ ..] = line.values;
        let episode = (participant.clone(), world.clone(), method.clone());
        if let Some(first) = known.insert(episode, line.line) {
            let expected = format!("an episode that line {first} does not have");
            return Err(bad_cell(Place::line(&file, line.line, "participant"), &participant, &expected));
        }
        named.push((participant.clone(), line.line));
        let mut add = |measure: usize, value: f64| {
            rows.push(Carried {
                participant: participant.clone(),
                world: world.clone(),
                method: method.clone(),
                measure: Measure::Episode(measure),
                value,
            });
        };
        add(0, f64::from(u8::from(outcome == "arrived")));
        for (measure, value) in (1..).zip(measured).filter(|(_, value)| !value.is_empty()) {
            add(measure, number(&file, line.line, MEASURES[measure].0, &value)?);
        }
    }
    Ok((rows, named))
}

/// A number of a cell that is not negative.
fn number(file: &str, line: u64, column: &str, value: &str) -> Result<f64, Error> {
    let number = value.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    let expected = "a number from 0 on, with a decimal point";
    number.ok_or_else(|| bad_cell(Place::line(file, line, column), value, expected))
}

/// What an item begins with that is the mean of a subscale.
const SUBSCALE: &str = "mean: ";

/// The means of the scales that were answered after carries: of their subscales, where they have some.
fn scales(path: &Path) -> Result<Values, Error> {
    let columns = [
        TableColumn::needed("participant"),
        TableColumn::needed("page"),
        TableColumn::needed("item"),
        TableColumn::needed("answer"),
        TableColumn::optional("world"),
        TableColumn::optional("method"),
    ];
    let file = path.display().to_string();
    let mut answers: BTreeMap<[String; 4], Vec<f64>> = BTreeMap::new();
    let (mut named, mut divided) = (Vec::new(), BTreeSet::new());
    for line in table_rows(path, columns)? {
        let [participant, page, item, answer, world, method] = line.values;
        named.push((participant.clone(), line.line));
        if !method.is_empty() && !answer.is_empty() {
            let answer = number(&file, line.line, "answer", &answer)?;
            let subscale = item.strip_prefix(SUBSCALE);
            let scale = subscale.map_or(page.clone(), |subscale| format!("{page}: {subscale}"));
            if subscale.is_some() {
                divided.insert(page);
            }
            answers.entry([participant, world, method, scale]).or_default().push(answer);
        }
    }
    answers.retain(|[.., scale], _| !divided.contains(scale));
    let mean = |([participant, world, method, page], answers): ([String; 4], Vec<f64>)| {
        let value = answers.iter().sum::<f64>() / answers.len() as f64;
        Carried { participant, world, method, measure: Measure::Scale(page), value }
    };
    Ok((answers.into_iter().map(mean).collect(), named))
}

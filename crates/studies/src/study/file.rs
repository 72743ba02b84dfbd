//! A study file, read and checked, with its worlds and robots loaded.

use super::cell::{Axes, Cell, MAX_RUN};
use super::humans::{Humans, Range};
use super::partners::Partners;
use super::source::{self, Source, get, number, whole};
use super::{Run, Seeds, SweepError};
use cocarry::error::Place;
use cocarry::preference::{Belief, Marginal};
use cocarry::robot::Robot;
use cocarry::scenario::{
    Applies, GivenRobot, GivenWorld, PERCEPTION, POSTURE, PlantKind, PreferenceChanges, SETTINGS, Setting,
    SettingKind, Value, one_of,
};
use cocarry::suggestion::Expected;
use std::num::NonZeroU64;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The name of the paper's ranges, the default humans of a study.
const PAPER: &str = "paper";
/// The name of the built-in robot.
const BUILT_IN: &str = "built-in";
/// The largest number of seeds of a run.
const MAX_SEEDS: u64 = 1_000_000_000;
/// The largest number of worlds, and of robots.
const MAX_FILES: usize = 1000;
/// The largest total length of the texts of worlds and robots, bytes.
const MAX_TEXT: usize = 64 << 20;

/// The keys of a run besides those of [`SETTINGS`]; a study has them too.
const RUN_KEYS: [&str; 7] =
    ["worlds", "plants", "humans", "preference_changes", "beliefs", "seeds", "robots"];
/// The keys of a study only.
const STUDY_KEYS: [&str; 5] = ["name", "note", "human", "belief", "run"];

/// The contents of a study file.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub worlds: Vec<(String, GivenWorld)>,
    pub robots: Vec<(String, GivenRobot, Vec<String>)>,
    pub humans: Vec<(String, Humans)>,
    pub beliefs: Vec<(String, Belief)>,
    pub runs: Vec<(Run, Place)>,
    /// The policies and humans that take the place of the file's.
    pub partners: Partners,
    /// Probable mistakes in worlds.
    pub world_warnings: Vec<String>,
    /// The total length of the texts of worlds and robots, bytes.
    text_bytes: usize,
}

/// A run that is being read.
#[derive(Clone)]
struct Draft {
    axes: Axes,
    /// The values given for each of [`SETTINGS`], with their places.
    given: Vec<Vec<(Value, Place)>>,
    /// The numbers of preference changes, with their places.
    changes: Vec<(PreferenceChanges, Place)>,
    seeds: Seeds,
}

pub(super) fn read(
    file: &str,
    text: &str,
    folder: &Path,
    seeds: Option<NonZeroU64>,
) -> Result<Contents, SweepError> {
    let source = Source { file, text };
    let table = source.parse()?;
    let table = table.get_ref();
    let run_keys: Vec<&str> = SETTINGS.iter().map(list_key).chain(RUN_KEYS).collect();
    source.only(table, &[&STUDY_KEYS[..], &run_keys].concat())?;
    for key in ["name", "note"] {
        source.list(table, key, &"a text".into(), source::text)?;
    }
    let mut contents = Contents::default();
    let standard = Belief::default();
    for (entry, place) in source.tables(table, "human")? {
        source.only(entry, &["name", "alpha", "gamma"])?;
        let name = source.text(entry, "name", "a name for these humans", &place)?;
        let humans = Humans {
            alpha: range(source, entry, "alpha", &place)?,
            gamma: range(source, entry, "gamma", &place)?,
        };
        add(&mut contents.humans, name, humans, place)?;
    }
    for (entry, place) in source.tables(table, "belief")? {
        source.only(entry, &["name", "alpha", "gamma"])?;
        let name = source.text(entry, "name", "a name for this belief", &place)?;
        let belief = Belief::Independent {
            alpha: marginal(source, entry, "alpha", &place)?,
            gamma: marginal(source, entry, "gamma", &place)?,
        };
        add(&mut contents.beliefs, name, belief, place)?;
    }
    if let (true, Belief::Independent { alpha, gamma }) = (contents.humans.is_empty(), &standard) {
        let humans = Humans { alpha: Range::Drawn(*alpha), gamma: Range::Drawn(*gamma) };
        contents.humans.push((PAPER.to_owned(), humans));
    }
    if contents.beliefs.is_empty() {
        contents.beliefs.push((PAPER.to_owned(), standard));
    }
    let mut draft = Draft {
        axes: Axes::default(),
        given: vec![Vec::new(); SETTINGS.len()],
        changes: Vec::new(),
        seeds: Seeds { first: 0, last: 0 },
    };
    draft.axes.humans = (0..contents.humans.len()).collect();
    draft.axes.beliefs = (0..contents.beliefs.len()).collect();
    contents.keys(source, folder, table, &mut draft)?;
    let runs = source.tables(table, "run")?;
    let whole_file = source.place(0..0, "study");
    if runs.is_empty() {
        has_use(source, table, &draft)?;
        contents.finish(source, draft, seeds, whole_file)?;
    } else {
        for (entry, place) in runs {
            source.only(entry, &run_keys)?;
            let mut draft = draft.clone();
            contents.keys(source, folder, entry, &mut draft)?;
            has_use(source, entry, &draft)?;
            contents.finish(source, draft, seeds, place)?;
        }
    }
    Ok(contents)
}

impl Contents {
    /// Reads the keys of a table into a run.
    fn keys(
        &mut self,
        source: Source,
        folder: &Path,
        table: &DeTable,
        run: &mut Draft,
    ) -> Result<(), SweepError> {
        let axes = &mut run.axes;
        let world = Expected::from("the name of a world file, relative to the study, or of a built-in world");
        if let Some(worlds) = source.list(table, "worlds", &world, source::text)? {
            axes.worlds = worlds.into_iter().map(|w| self.world(folder, w)).collect::<Result<_, _>>()?;
        }
        let robot = Expected::from("the name of a robot file, relative to the study, or \"built-in\"");
        if let Some(robots) = source.list(table, "robots", &robot.with_names([BUILT_IN]), source::text)? {
            axes.robots = robots.into_iter().map(|r| self.robot(folder, r)).collect::<Result<_, _>>()?;
        }
        pick(source, table, "humans", &self.humans, &mut axes.humans)?;
        pick(source, table, "beliefs", &self.beliefs, &mut axes.beliefs)?;
        let times = PreferenceChanges::expected();
        if let Some(changes) = source.list(table, "preference_changes", &times, changes)? {
            run.changes = changes;
        }
        let plants = one_of(&PlantKind::ALL.map(PlantKind::word));
        let plant = |value: &DeValue| value.as_str().and_then(PlantKind::named);
        replace(&mut axes.plants, source.list(table, "plants", &plants, plant)?);
        for (setting, given) in SETTINGS.iter().zip(&mut run.given) {
            let read = |written: &DeValue| value(setting, written);
            if let Some(values) = source.list(table, list_key(setting), &setting.expected(), read)? {
                *given = values;
            }
        }
        if let Some(value) = get(table, "seeds") {
            let expected = format!(
                "the number of seeds, from 1 to {MAX_SEEDS}, or a range such as {{ first = 100, last = 199 }}"
            );
            run.seeds = Seeds::read(value.get_ref()).ok_or_else(|| source.wrong("seeds", value, expected))?;
        }
        Ok(())
    }

    /// The index of a world, which is loaded if it is new.
    fn world(&mut self, folder: &Path, (name, place): (String, Place)) -> Result<usize, SweepError> {
        if let Some(known) = self.worlds.iter().position(|(other, _)| *other == name) {
            return Ok(known);
        }
        let path = folder.join(&name);
        let world = cocarry_maps::find(&path, &name);
        let mut world = world.map_err(|source| SweepError::named(place.clone(), source))?;
        // named as in the study, independent of the current directory
        world.file.clone_from(&name);
        self.text_bytes += world.text.len();
        self.world_warnings.extend(world.warnings());
        self.worlds.push((name, world.into()));
        self.check_files(place, self.worlds.len(), "worlds")?;
        Ok(self.worlds.len() - 1)
    }

    fn robot(&mut self, folder: &Path, (name, place): (String, Place)) -> Result<usize, SweepError> {
        if let Some(known) = self.robots.iter().position(|(other, ..)| *other == name) {
            return Ok(known);
        }
        let robot = if name == BUILT_IN { Robot::built_in() } else { Robot::load(&folder.join(&name)) };
        let mut robot = robot.map_err(|source| SweepError::named(place.clone(), source))?;
        let postures = robot.postures.iter().map(|p| p.name.clone()).collect();
        if name != BUILT_IN {
            let texts = &mut robot.texts;
            // named as in the study, independent of the current directory
            texts.file.clone_from(&name);
            if let Ok(relative) = Path::new(&texts.urdf_file).strip_prefix(folder) {
                texts.urdf_file = relative.display().to_string();
            }
        }
        self.text_bytes += robot.texts.text.len() + robot.texts.urdf.len();
        self.robots.push((name, robot.into(), postures));
        self.check_files(place, self.robots.len(), "robots")?;
        Ok(self.robots.len() - 1)
    }

    /// The check of the number of files of a kind, and of the length of all: one file may have many names.
    fn check_files(&self, place: Place, count: usize, what: &'static str) -> Result<(), SweepError> {
        if count > MAX_FILES {
            return Err(SweepError::too_many(place, MAX_FILES, what));
        }
        match self.text_bytes <= MAX_TEXT {
            true => Ok(()),
            false => Err(SweepError::too_many(place, MAX_TEXT, "bytes of worlds and robots")),
        }
    }

    /// Builds the cells of a run, and adds it.
    fn finish(
        &mut self,
        source: Source,
        mut run: Draft,
        seeds: Option<NonZeroU64>,
        place: Place,
    ) -> Result<(), SweepError> {
        if run.axes.worlds.is_empty() {
            return Err(SweepError::missing(
                place,
                "worlds",
                "a world file, relative to the study, or of a built-in world, or a list".to_owned(),
            ));
        }
        if let Some(count) = seeds {
            run.seeds.last = run.seeds.last.min(run.seeds.first.saturating_add(count.get() - 1));
        }
        self.changes(&mut run)?;
        let has_robot = run.axes.plants.iter().any(|plant| *plant != PlantKind::Point);
        if has_robot {
            if self.robots.is_empty() {
                let built_in = (BUILT_IN.to_owned(), source.place(0..0, "robots"));
                self.robot(Path::new(""), built_in)?;
            }
            self.postures(&run)?;
        }
        for (values, given) in run.axes.values.iter_mut().zip(run.given) {
            let given: Vec<_> = given.into_iter().map(|(value, _)| Some(value)).collect();
            if !given.is_empty() {
                *values = given;
            }
        }
        let (most, what) = (MAX_RUN, "combinations");
        let too_many = SweepError::too_many(place.clone(), most, what);
        let before: usize = self.runs.iter().map(|(run, _)| run.cells.len()).sum();
        let fits = |cells: &Vec<Cell>| before + cells.len() <= MAX_RUN;
        let mut cells: Vec<Cell> = run.axes.cells().filter(fits).ok_or(too_many)?;
        for cell in cells.iter_mut().filter(|cell| cell.plant != PlantKind::Point) {
            let first = || self.robots[cell.robot].2.first().cloned().map(Value::Text);
            cell.values[posture()] = cell.values[posture()].take().or_else(first);
        }
        self.runs.push((Run { cells, seeds: run.seeds }, place));
        Ok(())
    }

    /// The check that humans with preference changes have a parameter to draw again.
    fn changes(&self, run: &mut Draft) -> Result<(), SweepError> {
        let one = run.axes.humans.iter().map(|&at| &self.humans[at]).find(|(_, humans)| humans.are_one());
        let asked = run.changes.iter().find(|(changes, _)| *changes != PreferenceChanges::NONE);
        if let (Some((name, _)), Some((changes, place))) = (one, asked) {
            return Err(SweepError::value(
                place.clone(),
                changes.to_string(),
                format!("0 for the humans `{name}`, whose alpha and gamma are fixed numbers").into(),
            ));
        }
        if !run.changes.is_empty() {
            run.axes.changes = run.changes.iter().map(|(changes, _)| *changes).collect();
        }
        Ok(())
    }

    /// The check that every robot of the run has every posture of the run.
    fn postures(&self, run: &Draft) -> Result<(), SweepError> {
        for (name, place) in &run.given[posture()] {
            let name = name.to_string();
            let mut robots = run.axes.robots.iter().map(|&robot| &self.robots[robot]);
            if let Some((_, robot, known)) = robots.find(|(.., known)| !known.contains(&name)) {
                let quoted = known.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>();
                let expected = format!("a posture of {}: {}", robot.texts().file, quoted.join(", "));
                let expected = Expected::from(expected).with_names(known.iter().map(String::as_str));
                let (place, value) = (place.clone(), format!("{name:?}"));
                return Err(SweepError::value(place, value, expected));
            }
        }
        Ok(())
    }
}

/// The key of a setting in a study; plural for methods and postures.
fn list_key(setting: &Setting) -> &'static str {
    match setting.key {
        "method" => "methods",
        "posture" => "postures",
        key => key,
    }
}

/// The index of the posture in [`SETTINGS`].
fn posture() -> usize {
    SETTINGS.iter().position(|setting| setting.key == POSTURE.key).expect("the posture is a setting")
}

/// The value of a setting in a study file.
fn value(setting: &Setting, written: &DeValue) -> Option<Value> {
    let value = match setting.kind {
        SettingKind::Number(..) => number(written).map(Value::Number),
        SettingKind::Count(..) => whole(written).map(Value::Count),
        SettingKind::Flag(_) => written.as_bool().map(Value::Flag),
        SettingKind::Word(..) | SettingKind::Text(..) => {
            written.as_str().map(|text| Value::Text(text.to_owned()))
        }
    };
    value.filter(|value| setting.accepts(value))
}

/// An error for the first key of the run itself that applies to none of its plants.
fn has_use(source: Source, table: &DeTable, run: &Draft) -> Result<(), SweepError> {
    let is_idle = |applies: Applies| !run.axes.plants.iter().any(|plant| applies.is_on(*plant, true));
    for (key, _) in table {
        let setting = SETTINGS.iter().find(|setting| list_key(setting) == key.get_ref().as_ref());
        let robots = (key.get_ref() == "robots").then_some(Applies::Robot);
        if let Some(applies) = setting.map(|setting| setting.applies).or(robots).filter(|a| is_idle(*a)) {
            let (place, what) = (source.place(key.span(), key.get_ref().as_ref()), applies.what());
            return Err(SweepError::idle(place, what));
        }
    }
    Ok(())
}

/// The number of preference changes in a study file.
fn changes(value: &DeValue) -> Option<PreferenceChanges> {
    let word = value.as_str().filter(|word| *word == PreferenceChanges::ONCE_OR_TWICE);
    word.map(str::to_owned).or(whole(value).map(|times| times.to_string()))?.parse().ok()
}

fn replace<T>(values: &mut Vec<T>, read: Option<Vec<(T, Place)>>) {
    if let Some(read) = read {
        *values = read.into_iter().map(|(value, _)| value).collect();
    }
}

/// Values that are names defined in the study.
fn pick<T>(
    source: Source,
    table: &DeTable,
    key: &str,
    known: &[(String, T)],
    values: &mut Vec<usize>,
) -> Result<(), SweepError> {
    let read = |value: &DeValue| known.iter().position(|(name, _)| Some(name.as_str()) == value.as_str());
    let expected = Expected::one_of(known.iter().map(|(name, _)| name.as_str()));
    replace(values, source.list(table, key, &expected, read)?);
    Ok(())
}

fn add<T>(all: &mut Vec<(String, T)>, name: String, item: T, place: Place) -> Result<(), SweepError> {
    if all.iter().any(|(other, _)| *other == name) {
        return Err(SweepError::duplicate(Place { item: "name".to_owned(), ..place }, format!("{name:?}")));
    }
    all.push((name, item));
    Ok(())
}

const DISTRIBUTION: &str =
    "\"uniform(LOWER,UPPER)\" or \"normal(MEAN,STD,LOWER,UPPER)\" with 0 < LOWER < UPPER";
/// The source of one parameter of humans.
fn range(source: Source, table: &DeTable, key: &'static str, place: &Place) -> Result<Range, SweepError> {
    let expected = format!("{DISTRIBUTION}, or {PERCEPTION}");
    match get(table, key) {
        None => Err(SweepError::missing(place.clone(), key, expected)),
        Some(value) if value.get_ref().is_str() => marginal(source, table, key, place).map(Range::Drawn),
        Some(value) => number(value.get_ref())
            .filter(|v| PERCEPTION.contains(*v))
            .map(Range::Fixed)
            .ok_or_else(|| source.wrong(key, value, expected)),
    }
}

fn marginal(
    source: Source,
    table: &DeTable,
    key: &'static str,
    place: &Place,
) -> Result<Marginal, SweepError> {
    let missing = || SweepError::missing(place.clone(), key, DISTRIBUTION.to_owned());
    let value = get(table, key).ok_or_else(missing)?;
    let marginal = value.get_ref().as_str().and_then(|text| text.parse().ok());
    marginal.ok_or_else(|| source.wrong(key, value, DISTRIBUTION))
}

impl Seeds {
    fn read(value: &DeValue) -> Option<Self> {
        let seeds = match value.as_table() {
            None => Self { first: 0, last: whole(value)?.checked_sub(1)? },
            Some(table) if table.len() == 2 => Self {
                first: whole(get(table, "first")?.get_ref())?,
                last: whole(get(table, "last")?.get_ref())?,
            },
            Some(_) => return None,
        };
        (seeds.first <= seeds.last && seeds.last - seeds.first < MAX_SEEDS).then_some(seeds)
    }
}

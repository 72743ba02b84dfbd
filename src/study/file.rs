//! A study file, read and checked, with its worlds and robots loaded.

use super::cell::{Axes, Cell, LARGEST_RUN};
use super::humans::{Humans, Range};
use super::names::{self, AVOID, CRITERIA, METHODS, Names, PLANTS, POSES, Plants};
use super::source::{self, Source, get, number, whole};
use super::{Run, Seeds, SweepError};
use crate::paper;
use crate::preference::{Belief, Marginal};
use crate::robot::{Robot, RobotTexts};
use crate::scenario::{Redraws, WorldText};
use crate::world::{Place, World};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// What the paper's ranges are called where a study names none.
const PAPER: &str = "paper";
/// What the built-in robot is called.
const BUILT_IN: &str = "built-in";
/// The most seeds of a run.
const MOST_SEEDS: u64 = 1_000_000_000;

/// The keys of a run, which are those of a study too.
const RUN_KEYS: [&str; 21] = [
    "worlds",
    "plants",
    "methods",
    "eta",
    "initial_stubbornness",
    "risk_weight_m",
    "humans",
    "redraws",
    "beliefs",
    "period_s",
    "speed_m_per_s",
    "yaw_rate_rad_per_s",
    "max_steps",
    "seeds",
    "robots",
    "postures",
    "pose",
    "pose_criterion",
    "prepare_while_leading",
    "avoid",
    "sway_m",
];
/// Those of them that say something of a robot.
const ROBOT_KEYS: [&str; 6] =
    ["robots", "postures", "pose", "pose_criterion", "prepare_while_leading", "avoid"];
/// The keys of a study alone.
const STUDY_KEYS: [&str; 5] = ["name", "note", "human", "belief", "run"];

/// What a study file asks for.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub worlds: Vec<(String, WorldText)>,
    pub robots: Vec<(String, RobotTexts, Vec<String>)>,
    pub postures: Vec<String>,
    pub humans: Vec<(String, Humans)>,
    pub beliefs: Vec<(String, Belief)>,
    pub runs: Vec<(Run, Place)>,
}

/// A run while it is read.
#[derive(Clone)]
struct Draft {
    axes: Axes,
    /// The postures asked for, with their places.
    postures: Vec<(String, Place)>,
    /// How often humans are to change their mind, with the places.
    redraws: Vec<(Redraws, Place)>,
    seeds: Seeds,
}

pub(super) fn read(
    file: &str,
    text: &str,
    folder: &Path,
    seeds: Option<u64>,
) -> Result<Contents, SweepError> {
    let source = Source { file, text };
    let table = source.parse()?;
    let table = table.get_ref();
    source.only(table, &[&STUDY_KEYS[..], &RUN_KEYS].concat())?;
    for key in ["name", "note"] {
        source.list(table, key, "a text", source::text)?;
    }
    let mut contents = Contents::default();
    let standard = Belief::default();
    for (entry, place) in source.tables(table, "human")? {
        source.only(entry, &["name", "alpha", "gamma"])?;
        let name = source.text(entry, "name", "a text, by which runs name these humans", &place)?;
        let humans = Humans {
            alpha: range(source, entry, "alpha", &place)?,
            gamma: range(source, entry, "gamma", &place)?,
        };
        add(&mut contents.humans, name, humans, place)?;
    }
    for (entry, place) in source.tables(table, "belief")? {
        source.only(entry, &["name", "alpha", "gamma"])?;
        let name = source.text(entry, "name", "a text, by which runs name this belief", &place)?;
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
        postures: Vec::new(),
        redraws: Vec::new(),
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
            source.only(entry, &RUN_KEYS)?;
            let mut draft = draft.clone();
            contents.keys(source, folder, entry, &mut draft)?;
            has_use(source, entry, &draft)?;
            contents.finish(source, draft, seeds, place)?;
        }
    }
    Ok(contents)
}

impl Contents {
    /// Takes over the keys that stand in the table.
    fn keys(
        &mut self,
        source: Source,
        folder: &Path,
        table: &DeTable,
        run: &mut Draft,
    ) -> Result<(), SweepError> {
        let axes = &mut run.axes;
        let world = "the name of a world file, relative to the study, or one of \"environment-1\" to \"environment-4\"";
        if let Some(worlds) = source.list(table, "worlds", world, source::text)? {
            axes.worlds = worlds.into_iter().map(|w| self.world(folder, w)).collect::<Result<_, _>>()?;
        }
        let robot = "the name of a robot file, relative to the study, or \"built-in\"";
        if let Some(robots) = source.list(table, "robots", robot, source::text)? {
            axes.robots = robots.into_iter().map(|r| self.robot(folder, r)).collect::<Result<_, _>>()?;
        }
        if let Some(postures) = source.list(table, "postures", "the name of a posture", source::text)? {
            run.postures = postures;
        }
        pick(source, table, "humans", &self.humans, &mut axes.humans)?;
        let expected =
            format!("a whole number from 0 to {}, or \"{}\"", Redraws::MOST, Redraws::ONCE_OR_TWICE);
        if let Some(redraws) = source.list(table, "redraws", &expected, redraws)? {
            run.redraws = redraws;
        }
        pick(source, table, "beliefs", &self.beliefs, &mut axes.beliefs)?;
        named(source, table, "plants", PLANTS, &mut axes.plants)?;
        named(source, table, "methods", METHODS, &mut axes.methods)?;
        named(source, table, "pose", POSES, &mut axes.candidates)?;
        named(source, table, "pose_criterion", CRITERIA, &mut axes.criteria)?;
        named(source, table, "avoid", AVOID, &mut axes.avoid)?;
        let leading =
            source.list(table, "prepare_while_leading", "true or false", |value| value.as_bool())?;
        replace(&mut axes.prepare_while_leading, leading);
        // the bounds are those of a scenario
        for (key, values, least, most) in [
            ("eta", &mut axes.eta, f64::MIN_POSITIVE, 1e6),
            ("initial_stubbornness", &mut axes.initial_stubbornness, f64::MIN_POSITIVE, 1.0),
            ("risk_weight_m", &mut axes.risk_weight, 0.0, 1e6),
            ("period_s", &mut axes.period, 0.01, 60.0),
            ("speed_m_per_s", &mut axes.speed, 0.001, 10.0),
            ("yaw_rate_rad_per_s", &mut axes.yaw_rate, f64::MIN_POSITIVE, 1000.0),
            ("sway_m", &mut axes.sway, 0.0, 0.1),
        ] {
            let from = if least == f64::MIN_POSITIVE {
                "greater than 0 and at most".to_owned()
            } else {
                format!("from {least} to")
            };
            let expected = format!("a number {from} {most}");
            let read = |value: &DeValue| number(value).filter(|v| (least..=most).contains(v));
            replace(values, source.list(table, key, &expected, read)?);
        }
        let steps =
            |value: &DeValue| whole(value).filter(|steps| (1..=1_000_000_000).contains(steps)).map(Some);
        replace(
            &mut axes.max_steps,
            source.list(table, "max_steps", "a whole number from 1 to 1000000000", steps)?,
        );
        if let Some(value) = get(table, "seeds") {
            let expected = format!(
                "how many, a whole number from 1 to {MOST_SEEDS}, or from which to which, {{ first = 100, last = 199 }}"
            );
            run.seeds = Seeds::read(value.get_ref()).ok_or_else(|| source.wrong("seeds", value, expected))?;
        }
        Ok(())
    }

    /// The world's place, loaded if it is new.
    fn world(&mut self, folder: &Path, (name, place): (String, Place)) -> Result<usize, SweepError> {
        if let Some(known) = self.worlds.iter().position(|(other, _)| *other == name) {
            return Ok(known);
        }
        let path = folder.join(&name);
        let built_in = paper::environment(&name).filter(|_| !path.exists());
        let world = built_in.map_or_else(|| World::load(&path), |environment| environment.world());
        let world = world.map_err(|source| SweepError::World { place, source: Box::new(source) })?;
        // as the study names it, wherever it is run from
        self.worlds.push((name.clone(), WorldText { file: name, text: world.text }));
        Ok(self.worlds.len() - 1)
    }

    fn robot(&mut self, folder: &Path, (name, place): (String, Place)) -> Result<usize, SweepError> {
        if let Some(known) = self.robots.iter().position(|(other, ..)| *other == name) {
            return Ok(known);
        }
        let robot = if name == BUILT_IN { Robot::built_in() } else { Robot::load(&folder.join(&name)) };
        let robot = robot.map_err(|source| SweepError::Robot { place, source: Box::new(source) })?;
        let postures = robot.postures.iter().map(|p| p.name.clone()).collect();
        let mut texts = robot.texts;
        if name != BUILT_IN {
            // as the study names them, wherever it is run from
            texts.file.clone_from(&name);
            if let Ok(relative) = Path::new(&texts.urdf_file).strip_prefix(folder) {
                texts.urdf_file = relative.display().to_string();
            }
        }
        self.robots.push((name, texts, postures));
        Ok(self.robots.len() - 1)
    }

    /// Adds the run, its cells made.
    fn finish(
        &mut self,
        source: Source,
        mut run: Draft,
        seeds: Option<u64>,
        place: Place,
    ) -> Result<(), SweepError> {
        if run.axes.worlds.is_empty() {
            return Err(SweepError::Missing {
                place,
                key: "worlds",
                expected: "a world file, relative to the study, or one of \"environment-1\" to \"environment-4\", or a list",
            });
        }
        if let Some(count) = seeds {
            run.seeds.last = run.seeds.last.min(run.seeds.first.saturating_add(count - 1));
        }
        self.redraws(&mut run)?;
        let has_robot = run.axes.plants.iter().any(|plant| *plant != Plants::Point);
        if has_robot {
            if self.robots.is_empty() {
                let built_in = (BUILT_IN.to_owned(), source.place(0..0, "robots"));
                self.robot(Path::new(""), built_in)?;
            }
            self.postures(&mut run)?;
        }
        let too_many = SweepError::TooMany { place: place.clone(), most: LARGEST_RUN };
        let cells: Vec<Cell> = run.axes.cells().ok_or(too_many)?;
        self.runs.push((Run { cells, seeds: run.seeds }, place));
        Ok(())
    }

    /// Who is to change their mind must have something to change it to.
    fn redraws(&self, run: &mut Draft) -> Result<(), SweepError> {
        let one = run.axes.humans.iter().map(|&at| &self.humans[at]).find(|(_, humans)| humans.are_one());
        let asked = run.redraws.iter().find(|(redraws, _)| *redraws != Redraws::NONE);
        if let (Some((name, _)), Some((redraws, place))) = (one, asked) {
            return Err(SweepError::Value {
                place: place.clone(),
                value: redraws.to_string(),
                expected: format!(
                    "0 where humans are `{name}`, of whom alpha and gamma are given: there is nothing to redraw"
                ),
            });
        }
        if !run.redraws.is_empty() {
            run.axes.redraws = run.redraws.iter().map(|(redraws, _)| *redraws).collect();
        }
        Ok(())
    }

    /// Every robot of the run must have every posture of the run.
    fn postures(&mut self, run: &mut Draft) -> Result<(), SweepError> {
        let mut found = Vec::new();
        for (name, place) in &run.postures {
            for &robot in &run.axes.robots {
                let (_, texts, known) = &self.robots[robot];
                if !known.contains(name) {
                    return Err(SweepError::Value {
                        place: place.clone(),
                        value: format!("{name:?}"),
                        expected: format!("a posture of {}: {}", texts.file, known.join(", ")),
                    });
                }
            }
            let at = self.postures.iter().position(|other| other == name).unwrap_or_else(|| {
                self.postures.push(name.clone());
                self.postures.len() - 1
            });
            found.push(Some(at));
        }
        if !found.is_empty() {
            run.axes.postures = found;
        }
        Ok(())
    }
}

/// Refuses keys that the run's plants have no use for, where they stand in the run itself.
fn has_use(source: Source, table: &DeTable, run: &Draft) -> Result<(), SweepError> {
    let plants = &run.axes.plants;
    let is_idle = |key: &str| match key {
        "sway_m" => !plants.contains(&Plants::Rapier),
        key => ROBOT_KEYS.contains(&key) && plants.iter().all(|plant| *plant == Plants::Point),
    };
    match table.iter().find(|(key, _)| is_idle(key.get_ref())) {
        None => Ok(()),
        Some((key, _)) => {
            let what = if key.get_ref().as_ref() == "sway_m" { "a human's body" } else { "a robot" };
            Err(SweepError::Idle { place: source.place(key.span(), key.get_ref().as_ref()), what })
        }
    }
}

/// How often humans change their mind, as written.
fn redraws(value: &DeValue) -> Option<Redraws> {
    match value.as_str() {
        Some(word) => Some(Redraws::OnceOrTwice).filter(|_| word == Redraws::ONCE_OR_TWICE),
        None => whole(value).and_then(Redraws::times),
    }
}

fn replace<T>(values: &mut Vec<T>, read: Option<Vec<(T, Place)>>) {
    if let Some(read) = read {
        *values = read.into_iter().map(|(value, _)| value).collect();
    }
}

fn named<T: Copy + PartialEq>(
    source: Source,
    table: &DeTable,
    key: &str,
    known: &Names<T>,
    values: &mut Vec<T>,
) -> Result<(), SweepError> {
    let read = |value: &DeValue| value.as_str().and_then(|word| names::value(known, word));
    replace(values, source.list(table, key, &names::words(known), read)?);
    Ok(())
}

/// Values that the study itself has named.
fn pick<T>(
    source: Source,
    table: &DeTable,
    key: &str,
    known: &[(String, T)],
    values: &mut Vec<usize>,
) -> Result<(), SweepError> {
    let read = |value: &DeValue| known.iter().position(|(name, _)| Some(name.as_str()) == value.as_str());
    let names: Vec<_> = known.iter().map(|(name, _)| format!("{name:?}")).collect();
    replace(values, source.list(table, key, &format!("one of {}", names.join(", ")), read)?);
    Ok(())
}

fn add<T>(all: &mut Vec<(String, T)>, name: String, item: T, place: Place) -> Result<(), SweepError> {
    if all.iter().any(|(other, _)| *other == name) {
        return Err(SweepError::Twice {
            place: Place { item: "name".to_owned(), ..place },
            value: format!("{name:?}"),
        });
    }
    all.push((name, item));
    Ok(())
}

const DISTRIBUTION: &str =
    "\"uniform(LOWER,UPPER)\" or \"normal(MEAN,STD,LOWER,UPPER)\" with 0 < LOWER < UPPER";
const RANGE: &str = "\"uniform(LOWER,UPPER)\" or \"normal(MEAN,STD,LOWER,UPPER)\" with 0 < LOWER < UPPER, or a number greater than 0 and at most 10";

/// One parameter of humans.
fn range(source: Source, table: &DeTable, key: &'static str, place: &Place) -> Result<Range, SweepError> {
    match get(table, key) {
        None => Err(SweepError::Missing { place: place.clone(), key, expected: RANGE }),
        Some(value) if value.get_ref().is_str() => marginal(source, table, key, place).map(Range::Drawn),
        Some(value) => number(value.get_ref())
            .filter(|v| *v > 0.0 && *v <= 10.0)
            .map(Range::Fixed)
            .ok_or_else(|| source.wrong(key, value, RANGE)),
    }
}

fn marginal(
    source: Source,
    table: &DeTable,
    key: &'static str,
    place: &Place,
) -> Result<Marginal, SweepError> {
    let missing = || SweepError::Missing { place: place.clone(), key, expected: DISTRIBUTION };
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
        (seeds.first <= seeds.last && seeds.last - seeds.first < MOST_SEEDS).then_some(seeds)
    }
}

//! A file of switches, and the set of eta that each episode allows.

use super::table::{Column, NAME, bad_cell, check_counts, duplicate, named_worlds, read, rows_of};
use super::{Guidance, Set};
use cocarry::Error;
use cocarry::error::Place;
use cocarry::policy::Method;
use cocarry::scenario::PreparedScenario;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

/// A file of switches, not yet matched with its worlds.
#[derive(Clone, Debug)]
pub struct SwitchFile {
    file: String,
    rows: Vec<SwitchRow>,
}

#[derive(Clone, Debug)]
struct SwitchRow {
    line: u64,
    participant: String,
    world: String,
    executed: Executed,
    step: Option<u64>,
    step_text: String,
}

/// The robot's behaviour in an episode.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Executed {
    /// It walked the option of this name.
    Option(String),
    /// It chose by eq. (6), as in `cocarry run`.
    Mutual,
}

impl Executed {
    /// The form used in a file.
    pub fn name(&self) -> String {
        match self {
            Self::Option(name) => format!("option {name}"),
            Self::Mutual => Method::MUTUAL.name().to_owned(),
        }
    }
}

/// An episode with the eta that it allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Switch {
    /// Line in the file.
    pub line: u64,
    /// The participant.
    pub participant: String,
    /// World, by its name in the file.
    pub world: String,
    /// The robot's behaviour.
    pub executed: Executed,
    /// The step at which the participant asked to switch; `None` if never.
    pub step: Option<u64>,
    /// All eta that switch at this step; empty if none does.
    pub etas: Set,
}

impl SwitchFile {
    /// Reads a CSV file with the columns participant, world, step, and option or method (or both, one of them
    /// empty), and optionally trial.
    ///
    /// # Errors
    /// The line, the column and the value.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let columns = [
            Column::needed("participant"),
            Column::needed("world"),
            Column::optional("option"),
            Column::optional("method"),
            Column::needed("step"),
            Column::optional("trial"),
        ];
        let file = path.display().to_string();
        let mut rows: Vec<SwitchRow> = Vec::new();
        // the line of every episode
        let mut known = BTreeMap::new();
        for row in read(path, columns)? {
            let count = row.count(4);
            let [participant, world, option, method, step, trial] = row.values;
            let line = row.line;
            let cell = |column: &str, value: &str, expected: &str| {
                bad_cell(Place::line(&file, line, column), value, expected)
            };
            for (column, value) in [("participant", &participant), ("world", &world)] {
                if value.is_empty() {
                    return Err(cell(column, value, NAME));
                }
            }
            let executed = match (option.as_str(), method.as_str()) {
                ("", "") => return Err(cell("option", "", "an option's name, or a method")),
                ("", "mutual") => Executed::Mutual,
                ("", other) => {
                    return Err(cell(
                        "method",
                        other,
                        "mutual; with the other methods the human is not led or does not switch",
                    ));
                }
                (_, "") => Executed::Option(option),
                (_, other) => return Err(cell("method", other, "empty where an option is given")),
            };
            let is_never = step.is_empty() || ["NA", "NaN", "nan"].contains(&step.as_str());
            if count.is_none() && !is_never {
                return Err(cell("step", &step, "a whole number of steps, or empty for never"));
            }
            let episode = (participant.clone(), world.clone(), executed.clone(), trial);
            if let Some(first) = known.insert(episode, line) {
                let what = format!(
                    "participant `{participant}` in {world}, {} (a column `trial` distinguishes repetitions),",
                    executed.name()
                );
                return Err(duplicate(Place::line(file, line, ""), what, first));
            }
            let (step, step_text) = (count, step);
            rows.push(SwitchRow { line, participant, world, executed, step, step_text });
        }
        check_counts(&file, rows.iter().map(|row| (row.participant.as_str(), row.world.as_str())))?;
        Ok(Self { file, rows })
    }

    /// The worlds that the file names, each with the first line that does.
    pub fn worlds(&self) -> Vec<(String, u64)> {
        named_worlds(self.rows.iter().map(|row| (row.world.as_str(), row.line)))
    }

    /// The switches of these participants alone, in their order.
    pub fn of(&self, participants: &[String]) -> Self {
        Self { file: self.file.clone(), rows: rows_of(&self.rows, participants, |row| &row.participant) }
    }

    /// The participants that the file names, each with the first line that does.
    pub fn participants(&self) -> Vec<(String, u64)> {
        named_worlds(self.rows.iter().map(|row| (row.participant.as_str(), row.line)))
    }

    /// The eta allowed by every row, for the scenarios of these worlds (one for every name in
    /// [`SwitchFile::worlds`]). Their belief, c_r, phi(0) and walk are used; eta, method and human are not.
    ///
    /// # Errors
    /// An unknown option, or a step beyond the episode's end.
    pub fn matched(&self, worlds: &[(String, PreparedScenario)]) -> Result<Vec<Switch>, Error> {
        let worlds: BTreeMap<&str, _> =
            worlds.iter().map(|(name, prepared)| (name.as_str(), prepared)).collect();
        let mut known: BTreeMap<(&str, &Executed), Guidance> = BTreeMap::new();
        let mut switches = Vec::new();
        for row in &self.rows {
            let Some(prepared) = worlds.get(row.world.as_str()) else { continue };
            let guidance = match known.entry((&row.world, &row.executed)) {
                Entry::Occupied(guidance) => guidance.into_mut(),
                Entry::Vacant(place) => place.insert(self.guidance(row, prepared)?),
            };
            if row.step.is_some_and(|step| step >= guidance.steps()) {
                let (executed, last) = (row.executed.name(), guidance.steps().saturating_sub(1));
                let expected = format!("at most {last}, the last step of {executed} in {}", row.world);
                return Err(self.cell(row, "step", &row.step_text, expected));
            }
            switches.push(Switch {
                line: row.line,
                participant: row.participant.clone(),
                world: row.world.clone(),
                executed: row.executed.clone(),
                step: row.step,
                etas: guidance.etas(row.step),
            });
        }
        Ok(switches)
    }

    fn guidance(&self, row: &SwitchRow, prepared: &PreparedScenario) -> Result<Guidance, Error> {
        let Executed::Option(name) = &row.executed else { return Guidance::mutual(prepared) };
        let (set, settings) = (prepared.options(), &prepared.scenario().settings);
        let option = set.options().iter().position(|o| o.name == *name);
        option.and_then(|o| Guidance::along_option(set, settings, o)).ok_or_else(|| {
            let known: Vec<_> = set.options().iter().map(|o| format!("`{}`", o.name)).collect();
            self.cell(row, "option", name, format!("an option of {}: {}", row.world, known.join(", ")))
        })
    }

    fn cell(&self, row: &SwitchRow, column: &str, value: &str, expected: String) -> Error {
        bad_cell(Place::line(&self.file, row.line, column), value, &expected)
    }
}

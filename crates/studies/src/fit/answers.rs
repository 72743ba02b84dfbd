//! A file of participants' percentages, checked and normalised.

use super::table::{Column, NAME, bad_cell, check_counts, duplicate, named_worlds, read, rows_of};
use cocarry::Error;
use cocarry::episode::prospects;
use cocarry::error::Place;
use cocarry::options::OptionSet;
use cocarry::preference::Prospect;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest deviation of an answer's sum from 100, percent: the effect of rounding a few options.
pub const SUM_TOLERANCE: f64 = 1.0;

/// A file of answers, not yet matched with its worlds.
#[derive(Clone, Debug)]
pub struct AnswerFile {
    file: String,
    rows: Vec<AnswerRow>,
}

#[derive(Clone, Debug)]
struct AnswerRow {
    line: u64,
    participant: String,
    world: String,
    option: String,
    /// Percentage from 0 to 100.
    percent: f64,
}

/// An answer as read: line and percentage of every option.
type Given = Vec<Option<(u64, f64)>>;

/// A world as participants saw it: its options from the start.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Name of the world in the file.
    pub world: String,
    /// The options' names.
    pub options: Vec<String>,
    /// Length and risk of each option.
    pub prospects: Vec<Prospect>,
}

/// Complete answers that fit their worlds.
#[derive(Clone, Debug)]
pub struct Answers {
    /// The file of the answers.
    pub file: String,
    /// The worlds.
    pub situations: Vec<Situation>,
    /// The participants, in the order of the file.
    pub participants: Vec<String>,
    /// Shares by participant and world: one for every option, summing to 1; none where the participant was
    /// not asked.
    pub shares: Vec<Vec<Option<Vec<f64>>>>,
    /// Answers whose sum differed from 100 by more than the tolerance and was scaled: participant, world,
    /// percent.
    pub scaled: Vec<(String, String, f64)>,
}

impl Situation {
    /// A world's options from its start.
    pub fn new(world: String, set: &OptionSet) -> Self {
        let options = set.options().iter().map(|o| o.name.clone()).collect();
        Self { world, options, prospects: prospects(set, &set.begin()) }
    }
}

impl AnswerFile {
    /// Reads a CSV file with the columns participant, world, option and percent.
    ///
    /// # Errors
    /// The line, the column and the value.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let columns = ["participant", "world", "option", "percent"].map(Column::needed);
        let file = path.display().to_string();
        let mut rows = Vec::new();
        for row in read(path, columns)? {
            let cell = |column: &str, value: &str, expected: &str| {
                bad_cell(Place::line(&file, row.line, column), value, expected)
            };
            let [participant, world, option, percent] = &row.values;
            for (column, value) in [("participant", participant), ("world", world), ("option", option)] {
                if value.is_empty() {
                    return Err(cell(column, value, NAME));
                }
            }
            let number = row.number(3).filter(|p| (0.0..=100.0).contains(p));
            let Some(number) = number else {
                return Err(cell("percent", percent, "a number from 0 to 100, with a decimal point"));
            };
            rows.push(AnswerRow {
                line: row.line,
                participant: participant.clone(),
                world: world.clone(),
                option: option.clone(),
                percent: number,
            });
        }
        check_counts(&file, rows.iter().map(|row| (row.participant.as_str(), row.world.as_str())))?;
        Ok(Self { file, rows })
    }

    /// The worlds that the file names, each with the first line that does.
    pub fn worlds(&self) -> Vec<(String, u64)> {
        named_worlds(self.rows.iter().map(|row| (row.world.as_str(), row.line)))
    }

    /// The answers of these participants alone, in their order.
    pub fn of(&self, participants: &[String]) -> Self {
        Self { file: self.file.clone(), rows: rows_of(&self.rows, participants, |row| &row.participant) }
    }

    /// The participants that the file names, each with the first line that does.
    pub fn participants(&self) -> Vec<(String, u64)> {
        named_worlds(self.rows.iter().map(|row| (row.participant.as_str(), row.line)))
    }

    /// Matches the rows with the worlds; there must be one for every name in [`AnswerFile::worlds`]. Sums are
    /// scaled to 100 where they are off by no more than [`SUM_TOLERANCE`], or always if `normalise` is set.
    ///
    /// # Errors
    /// An unknown option, a duplicate or incomplete answer, percentages that do not sum to 100.
    pub fn matched(&self, situations: Vec<Situation>, normalise: bool) -> Result<Answers, Error> {
        let mut answers = Answers {
            file: self.file.clone(),
            situations,
            participants: Vec::new(),
            shares: Vec::new(),
            scaled: Vec::new(),
        };
        // by participant and world
        let mut given: Vec<Vec<Given>> = Vec::new();
        let mut known: BTreeMap<&str, usize> = BTreeMap::new();
        let worlds = answers.situations.iter().enumerate().map(|(w, s)| (s.world.clone(), w));
        let worlds: BTreeMap<String, usize> = worlds.collect();
        for row in &self.rows {
            let Some(&w) = worlds.get(&row.world) else { continue };
            let options = &answers.situations[w].options;
            let Some(o) = options.iter().position(|name| *name == row.option) else {
                let known: Vec<_> = options.iter().map(|name| format!("`{name}`")).collect();
                let expected = format!("an option of {}: {}", row.world, known.join(", "));
                return Err(bad_cell(Place::line(&self.file, row.line, "option"), &row.option, &expected));
            };
            let p = *known.entry(&row.participant).or_insert_with(|| {
                answers.participants.push(row.participant.clone());
                given.push(answers.situations.iter().map(|s| vec![None; s.options.len()]).collect());
                given.len() - 1
            });
            if let Some((first, _)) = given[p][w][o].replace((row.line, row.percent)) {
                let AnswerRow { participant, world, option, .. } = row;
                let what = format_args!("participant `{participant}` in {world}, option `{option}`,");
                return Err(duplicate(Place::line(&self.file, row.line, ""), what, first));
            }
        }
        for (p, given) in given.iter().enumerate() {
            let shares = (0..given.len()).map(|w| self.shares(&mut answers, p, w, &given[w], normalise));
            let shares = shares.collect::<Result<_, _>>()?;
            answers.shares.push(shares);
        }
        Ok(answers)
    }

    /// One answer as shares; `None` if there is no answer.
    fn shares(
        &self,
        answers: &mut Answers,
        participant: usize,
        situation: usize,
        given: &Given,
        normalise: bool,
    ) -> Result<Option<Vec<f64>>, Error> {
        let lines = || given.iter().flatten().map(|g| g.0);
        let Some((first, line)) = lines().min().zip(lines().max()) else { return Ok(None) };
        let (participant, situation) = (&answers.participants[participant], &answers.situations[situation]);
        if let Some(o) = given.iter().position(Option::is_none) {
            let (world, option) = (&situation.world, &situation.options[o]);
            let sentence = format_args!(
                "participant `{participant}` answers for {world}, but not for its option `{option}`; every option needs a row, 0 percent included"
            );
            return Err(Error::at(Place::line(&self.file, line, ""), sentence));
        }
        let percent: Vec<f64> = given.iter().flatten().map(|g| g.1).collect();
        let sum: f64 = percent.iter().sum();
        if (sum - 100.0).abs() > SUM_TOLERANCE + 1e-9 {
            if !normalise || sum <= 0.0 {
                let world = &situation.world;
                let sentence = format_args!(
                    "percent of participant `{participant}` in {world} (lines {first} to {line}) sums to {sum}; it must be 100 (within 1); --normalise scales every sum to 100"
                );
                return Err(Error::at(Place::line(&self.file, line, ""), sentence));
            }
            answers.scaled.push((participant.clone(), situation.world.clone(), sum));
        }
        Ok(Some(percent.into_iter().map(|p| p / sum).collect()))
    }
}

//! Means, deviations and intervals of a study's results, and paired comparisons over the same seeds, in one
//! pass. Memory grows with the number of combinations, not of rows.

use super::cell::MAX_RUN;
use super::results::Rows;
use super::{SweepError, row};
use crate::statistics::{self, Estimate, Moments, Paired};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The columns that are summarised: costs, which are compared too, then outcomes for the human.
pub const OUTCOMES: [&str; 7] = [
    "accumulated_objective_cost_m",
    "accumulated_control_cost",
    "accumulated_subjective_cost",
    "final_stubbornness",
    "final_discomfort",
    "share_off_preference",
    "preferred_option_switches",
];
/// The number of columns that are compared.
const COSTS: usize = 2;
/// The largest number of comparisons.
const MAX_PAIRS: usize = 1_000_000;
/// The columns of the human's choices: different values mean different choices.
const CHOICES: [&str; 4] = ["preferred_at_start", "first_option", "last_option", "option_change_count"];
/// The inputs that are compared, all others being equal: groups of columns that belong together.
const COMPARED: [&[&str]; 2] = [&["method"], &["pose", "pose_criterion", "prepare_while_leading"]];

/// The summary of a study's results.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The study's digest.
    pub study: String,
    /// The number of rows read.
    pub rows: u64,
    /// The number of episodes of the whole study.
    pub episodes: u64,
    /// The inputs that vary between rows.
    pub varied: Vec<String>,
    /// One group for every combination, in the order in which they appear.
    pub groups: Vec<Group>,
    /// One comparison for every cost and every two combinations that differ only in the method, or only in the
    /// choice of the pose.
    pub comparisons: Vec<Comparison>,
}

/// The episodes of one combination.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// The inputs by column; empty where they do not apply.
    pub inputs: BTreeMap<String, String>,
    /// Episodes.
    pub n: u64,
    /// Episodes that arrived. The costs are of these.
    pub arrived: u64,
    /// Costs and outcomes for the human, by column; `None` where the episodes have no such outcome.
    #[serde(flatten)]
    pub outcomes: BTreeMap<&'static str, Option<Estimate>>,
}

/// The comparison of two combinations that differ in one input, over the seeds with which both arrived.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The column of the compared cost.
    pub cost: &'static str,
    /// The first combination, by the compared input.
    pub first: String,
    /// The second combination.
    pub second: String,
    /// Their common inputs, as far as they vary in the study.
    pub inputs: BTreeMap<String, String>,
    /// The cost of the first minus that of the second, with the same seed; corrected for all tested
    /// comparisons of the summary.
    pub difference: Paired,
    /// The share of the pairs in which the first costs less.
    pub share_lower: f64,
}

/// The state of a combination while rows are read.
struct Cell {
    inputs: Vec<String>,
    n: u64,
    arrived: u64,
    outcomes: [Moments; OUTCOMES.len()],
    choices: Choices,
    /// Whether episodes with equal choices may differ by noise, since bodies sway.
    is_noisy: bool,
    /// Its class for each compared input: combinations of a class differ in this input only.
    classes: [usize; COMPARED.len()],
}

/// Whether the humans so far make the same choices.
#[derive(Default)]
struct Choices {
    first: Option<Vec<String>>,
    differ: bool,
}

impl Choices {
    fn add(&mut self, choices: &[String]) {
        let first = self.first.get_or_insert_with(|| choices.to_vec());
        self.differ |= first != choices;
    }
}

/// An episode that arrived.
struct End {
    cell: usize,
    outcomes: [Option<f64>; OUTCOMES.len()],
    choices: Vec<String>,
}

/// The differences of a pair of cells.
#[derive(Default)]
struct Differences {
    moments: Moments,
    lower: u64,
    choices: Choices,
}

/// A compared input, two cells and a cost.
type Pair = (usize, usize, usize, usize);

impl Cell {
    /// Whether the humans differ by more than noise.
    fn is_sample(&self) -> bool {
        self.choices.differ || !self.is_noisy
    }
}

/// The indices of the columns that are read.
struct Places {
    seed: usize,
    outcome: usize,
    outcomes: [usize; OUTCOMES.len()],
    choices: [usize; CHOICES.len()],
    plant: usize,
}

#[derive(Default)]
struct SummaryReader {
    cells: Vec<Cell>,
    known: BTreeMap<Vec<String>, usize>,
    classes: BTreeMap<(usize, Vec<String>), usize>,
    /// The pairs, by compared input, two cells, and cost.
    pairs: BTreeMap<Pair, Differences>,
    /// The present seed, and the costs of its episodes that arrived.
    seed: Option<String>,
    ends: Vec<End>,
}

impl Summary {
    /// Reads a file of results: of a whole study, a shard, or an unfinished sweep.
    ///
    /// # Errors
    /// [`SweepError`], which names the file and the line.
    pub fn load(path: &Path) -> Result<Self, SweepError> {
        let mut rows = Rows::open(path)?;
        let columns = row::columns();
        let at =
            |name: &str| columns.iter().position(|column| *column == name).expect("a column of the rows");
        let places = Places {
            seed: at("seed"),
            outcome: at("outcome"),
            outcomes: OUTCOMES.map(at),
            choices: CHOICES.map(at),
            plant: at("plant"),
        };
        let first_input = row::IDENTITY.len();
        let inputs = first_input..first_input + row::input_columns().count();
        let mut reader = SummaryReader::default();
        let mut first = None;
        let mut count = 0;
        while let Some(identity) = rows.next()? {
            let fields = rows.fields(columns.len())?;
            let begin = first.get_or_insert_with(|| identity.clone());
            if identity.arithmetic != begin.arithmetic {
                return Err(SweepError::other_arithmetic(
                    format!("{}: {}", rows.file, rows.position()),
                    identity.arithmetic,
                    "its first row".to_owned(),
                    begin.arithmetic.clone(),
                ));
            }
            if identity.study != begin.study || identity.episode != begin.episode + count {
                return Err(SweepError::row(
                    rows.position(),
                    rows.file,
                    format!("episode {} of study {}", identity.episode, identity.study),
                    format!("episode {} of study {}", begin.episode + count, begin.study),
                ));
            }
            count += 1;
            reader.add(&fields, inputs.clone(), &places);
            reader.check(&rows)?;
        }
        reader.end_of_seed();
        reader.check(&rows)?;
        let first = first.ok_or_else(|| SweepError::empty(rows.file.clone()))?;
        Ok(reader.summary(first.study, count, first.episodes))
    }
}

impl SummaryReader {
    fn add(
        &mut self,
        fields: &csv::StringRecord,
        inputs: std::ops::Range<usize>,
        &Places { seed, outcome, outcomes, choices, plant }: &Places,
    ) {
        if self.seed.as_deref() != Some(&fields[seed]) {
            self.end_of_seed();
            self.seed = Some(fields[seed].to_owned());
        }
        let cell = self.cell(inputs.map(|i| fields[i].to_owned()).collect());
        let outcomes = outcomes.map(|i| fields[i].parse::<f64>().ok().filter(|value| value.is_finite()));
        let this = &mut self.cells[cell];
        this.n += 1;
        this.is_noisy = &fields[plant] == row::with_bodies();
        if &fields[outcome] == row::arrived() {
            this.arrived += 1;
            for (moments, value) in this.outcomes.iter_mut().zip(outcomes) {
                value.into_iter().for_each(|value| moments.add(value, value.abs()));
            }
            let choices: Vec<String> = choices.iter().map(|&i| fields[i].to_owned()).collect();
            this.choices.add(&choices);
            self.ends.push(End { cell, outcomes, choices });
        }
    }

    fn cell(&mut self, inputs: Vec<String>) -> usize {
        if let Some(&known) = self.known.get(&inputs) {
            return known;
        }
        let classes = std::array::from_fn(|what| {
            let rest = row::input_columns().zip(&inputs);
            let rest =
                rest.filter(|(name, _)| !COMPARED[what].contains(name)).map(|(_, v)| v.clone()).collect();
            let next = self.classes.len();
            *self.classes.entry((what, rest)).or_insert(next)
        });
        self.cells.push(Cell {
            inputs: inputs.clone(),
            n: 0,
            arrived: 0,
            outcomes: [Moments::default(); OUTCOMES.len()],
            choices: Choices::default(),
            is_noisy: false,
            classes,
        });
        self.known.insert(inputs, self.cells.len() - 1);
        self.cells.len() - 1
    }

    /// The check that combinations and comparisons stay within their limits.
    fn check(&self, rows: &Rows) -> Result<(), SweepError> {
        match self.cells.len() > MAX_RUN || self.pairs.len() > MAX_PAIRS {
            true => Err(SweepError::row(
                rows.position(),
                rows.file.clone(),
                "too much for a summary".to_owned(),
                format!("the last of at most {MAX_RUN} combinations and {MAX_PAIRS} comparisons"),
            )),
            false => Ok(()),
        }
    }

    /// Compares the episodes of a finished seed.
    fn end_of_seed(&mut self) {
        let ends = std::mem::take(&mut self.ends);
        for what in 0..COMPARED.len() {
            let mut classes: BTreeMap<usize, Vec<&End>> = BTreeMap::new();
            for end in &ends {
                classes.entry(self.cells[end.cell].classes[what]).or_default().push(end);
            }
            for class in classes.values() {
                for (i, first) in class.iter().enumerate() {
                    for second in &class[i + 1..] {
                        self.compare(what, first, second);
                    }
                }
            }
        }
    }

    fn compare(&mut self, what: usize, a: &End, b: &End) {
        // then the check fails
        if self.pairs.len() > MAX_PAIRS {
            return;
        }
        let (a, b) = if a.cell <= b.cell { (a, b) } else { (b, a) };
        let both = [&a.choices[..], &b.choices[..]].concat();
        for cost in 0..COSTS {
            if let (Some(first), Some(second)) = (a.outcomes[cost], b.outcomes[cost]) {
                let pair = self.pairs.entry((what, a.cell, b.cell, cost)).or_default();
                pair.moments.add(first - second, first.abs().max(second.abs()));
                pair.lower += u64::from(first < second);
                pair.choices.add(&both);
            }
        }
    }

    fn summary(self, study: String, rows: u64, episodes: u64) -> Summary {
        let names: Vec<&str> = row::input_columns().collect();
        let is_varied = |i: &usize| self.cells.iter().any(|cell| cell.inputs[*i] != self.cells[0].inputs[*i]);
        let varied: Vec<usize> = (0..names.len()).filter(is_varied).collect();
        let group = |cell: &Cell| Group {
            inputs: names.iter().zip(&cell.inputs).map(|(name, v)| ((*name).to_owned(), v.clone())).collect(),
            n: cell.n,
            arrived: cell.arrived,
            outcomes: OUTCOMES
                .into_iter()
                .zip(cell.outcomes.iter().map(|moments| moments.estimate(cell.is_sample())))
                .collect(),
        };
        let comparison = |(&(what, first, second, cost), pair): (&Pair, &Differences)| {
            let [of_first, of_second] = [first, second].map(|cell| &self.cells[cell].inputs);
            let differs = |i: &usize| COMPARED[what].contains(&names[*i]) && of_first[*i] != of_second[*i];
            let differing: Vec<usize> = (0..names.len()).filter(differs).collect();
            let label = |values: &[String]| {
                let words = differing.iter().map(|&i| match values[i].as_str() {
                    "true" => names[i],
                    "false" => "",
                    word => word,
                });
                words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
            };
            let common = varied.iter().filter(|i| !COMPARED[what].contains(&names[**i]));
            Some(Comparison {
                cost: OUTCOMES[cost],
                first: label(of_first),
                second: label(of_second),
                inputs: common.map(|&i| (names[i].to_owned(), of_first[i].clone())).collect(),
                difference: Paired::of(&pair.moments, pair.choices.differ || !self.cells[first].is_noisy)?,
                share_lower: pair.lower as f64 / pair.moments.count() as f64,
            })
        };
        let mut comparisons: Vec<Comparison> = self.pairs.iter().filter_map(comparison).collect();
        statistics::correct(comparisons.iter_mut().map(|comparison| &mut comparison.difference));
        Summary {
            study,
            rows,
            episodes,
            varied: varied.iter().map(|i| names[*i].to_owned()).collect(),
            groups: self.cells.iter().map(group).collect(),
            comparisons,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_that_are_read_are_written() {
        let columns = row::columns();
        let compared = COMPARED.into_iter().flatten().copied();
        for name in ["seed", "outcome", "plant"].into_iter().chain(OUTCOMES).chain(CHOICES).chain(compared) {
            assert!(columns.contains(&name), "{name}");
        }
    }
}

//! The reader of summaries. The rows of one study are read in one pass: memory grows with the number of
//! combinations, not of rows. Rows of several studies are kept, about 200 bytes each, and paired by their seeds.

use super::cell::MAX_RUN;
use super::compared::Comparing;
use super::error::Position;
use super::origin::Origins;
use super::results::{Results, Rows};
use super::summary::{Comparison, OUTCOMES, Summary, SummaryGroup};
use super::{SweepError, row};
use crate::statistics::{self, Moments, Paired, UnitMoments};
use std::collections::BTreeMap;

/// The largest number of comparisons.
const MAX_PAIRS: usize = 1_000_000;
/// The columns of the human's choices: different values mean different choices.
const CHOICES: [&str; 4] = ["preferred_at_start", "first_option", "last_option", "option_change_count"];

/// The state of a combination while rows are read.
#[derive(Clone)]
struct Cell {
    inputs: Vec<String>,
    n: u64,
    arrived: u64,
    outcomes: [Moments; OUTCOMES.len()],
    choices: Choices,
    /// Whether episodes with equal choices may differ by noise, since bodies sway.
    is_noisy: bool,
    /// Its class for each kind of comparison: combinations of a class differ in what is compared only.
    classes: Vec<usize>,
    /// The first combination that differs in nothing but what is averaged over.
    condition: usize,
    /// Its first episode.
    first: EpisodeOrder,
}

/// Which episode it is: the file, the study, and its number in that study. Their order is that of combinations,
/// in whatever order another program left the rows.
type EpisodeOrder = (u32, usize, u64);

/// Whether the humans so far make the same choices.
#[derive(Clone, Default)]
struct Choices {
    first: Option<Vec<u32>>,
    differ: bool,
}

impl Choices {
    fn add(&mut self, choices: &[u32]) {
        let first = self.first.get_or_insert_with(|| choices.to_vec());
        self.differ |= first != choices;
    }
}

/// An episode.
#[derive(Clone)]
struct End {
    seed: u64,
    cell: usize,
    has_arrived: bool,
    /// The outcomes, then the compared quantities; NaN where there is none.
    values: Box<[f64]>,
    /// The human's choices, by number.
    choices: u32,
    /// Its file and its place there.
    place: (u32, Position),
}

/// The differences of a pair of conditions.
#[derive(Clone, Default)]
struct Differences {
    units: UnitMoments,
    /// The choices of the present human.
    present: Vec<u32>,
    choices: Choices,
}

/// A kind of comparison and two conditions; then a quantity.
type Pair = (usize, usize, usize);

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
    plant: usize,
    values: Vec<usize>,
    choices: [usize; CHOICES.len()],
    inputs: std::ops::Range<usize>,
}

impl Places {
    fn of(comparing: &Comparing) -> Self {
        let columns = row::columns();
        let at =
            |name: &str| columns.iter().position(|column| *column == name).expect("a column of the rows");
        let first = row::IDENTITY.len();
        Self {
            seed: at("seed"),
            outcome: at("outcome"),
            plant: at("plant"),
            values: OUTCOMES.iter().chain(comparing.quantities()).map(|name| at(name)).collect(),
            choices: CHOICES.map(at),
            inputs: first..first + row::input_columns().count(),
        }
    }
}

struct SummaryReader<'a> {
    comparing: &'a Comparing,
    places: Places,
    names: Vec<String>,
    cells: Vec<Cell>,
    known: BTreeMap<Vec<String>, usize>,
    classes: BTreeMap<(usize, Vec<String>), usize>,
    conditions: BTreeMap<Vec<String>, usize>,
    choices: BTreeMap<String, u32>,
    pairs: BTreeMap<(Pair, usize), Differences>,
    arrivals: BTreeMap<Pair, [u64; 4]>,
    /// The episodes that are not paired yet.
    ends: Vec<End>,
    /// Rows that repeat another.
    repeated: u64,
}

impl Summary {
    /// Reads results: of whole studies, shards, or unfinished sweeps, also of several, one after the other in
    /// a file, or in several files.
    ///
    /// # Errors
    /// [`SweepError`], which names the file and the line: a row is damaged, or one of the same combination and
    /// seed has other values.
    pub fn load(results: &[Results], comparing: &Comparing) -> Result<Self, SweepError> {
        match Self::read(results, comparing, true)? {
            Some(summary) => Ok(summary),
            // several studies: rows of a seed are apart
            None => Ok(Self::read(results, comparing, false)?.unwrap_or_else(|| unreachable!())),
        }
    }

    /// The same; with `in_order`, `None` if the rows are not those of one study in its order.
    fn read(results: &[Results], comparing: &Comparing, in_order: bool) -> Result<Option<Self>, SweepError> {
        let names = results.iter().map(Results::name).collect();
        let mut reader = SummaryReader::new(comparing, names);
        let mut origins = Origins::default();
        for (file, results) in results.iter().enumerate() {
            let mut rows = Rows::of(*results)?;
            while let Some(identity) = rows.next()? {
                let first = origins.arithmetic.get_or_insert_with(|| identity.arithmetic.clone());
                if *first != identity.arithmetic {
                    return Err(SweepError::other_arithmetic(
                        format!("{}: {}", rows.file, rows.position()),
                        identity.arithmetic,
                        "the first row".to_owned(),
                        first.clone(),
                    ));
                }
                let (study, episode, is_next) = origins.add(identity);
                if in_order && !is_next {
                    return Ok(None);
                }
                let fields = rows.checked_fields()?;
                reader.add(&fields, rows.position(), (file as u32, study, episode), in_order)?;
                reader.check(&rows)?;
            }
            rows.check_all()?;
            origins.unchecked += rows.unchecked;
        }
        reader.end()?;
        if origins.rows == 0 {
            return Err(SweepError::empty(reader.names.join(", ")));
        }
        Ok(Some(reader.summary(&origins)))
    }
}

impl<'a> SummaryReader<'a> {
    fn new(comparing: &'a Comparing, names: Vec<String>) -> Self {
        Self {
            comparing,
            places: Places::of(comparing),
            names,
            cells: Vec::new(),
            known: BTreeMap::new(),
            classes: BTreeMap::new(),
            conditions: BTreeMap::new(),
            choices: BTreeMap::new(),
            pairs: BTreeMap::new(),
            arrivals: BTreeMap::new(),
            ends: Vec::new(),
            repeated: 0,
        }
    }

    fn add(
        &mut self,
        fields: &csv::StringRecord,
        position: Position,
        order: EpisodeOrder,
        in_order: bool,
    ) -> Result<(), SweepError> {
        let place = (order.0, position);
        let seed = self.seed(&fields[self.places.seed], place)?;
        if in_order && self.ends.last().is_some_and(|last| last.seed != seed) {
            self.end_of_seed()?;
        }
        let inputs = self.places.inputs.clone().map(|i| fields[i].to_owned()).collect();
        let cell = self.cell(inputs, &fields[self.places.plant] == row::with_bodies(), order);
        let value = |&i: &usize| fields[i].parse::<f64>().ok().filter(|value| value.is_finite());
        let values = self.places.values.iter().map(|i| value(i).unwrap_or(f64::NAN)).collect();
        let choices: Vec<&str> = self.places.choices.iter().map(|&i| &fields[i]).collect();
        let next = self.choices.len() as u32;
        let choices = *self.choices.entry(choices.join("\0")).or_insert(next);
        let has_arrived = &fields[self.places.outcome] == row::arrived();
        self.ends.push(End { seed, cell, has_arrived, values, choices, place });
        Ok(())
    }

    fn seed(&self, text: &str, place: (u32, Position)) -> Result<u64, SweepError> {
        text.parse().map_err(|_| {
            let found = format!("of the seed `{}`", text.chars().take(60).collect::<String>());
            self.wrong_row(place, found, "of a seed that is a whole number of at least 0")
        })
    }

    fn wrong_row(&self, (file, position): (u32, Position), found: String, expected: &str) -> SweepError {
        SweepError::row(position, self.names[file as usize].clone(), found, expected.to_owned())
    }

    fn cell(&mut self, inputs: Vec<String>, is_noisy: bool, order: EpisodeOrder) -> usize {
        if let Some(&known) = self.known.get(&inputs) {
            let first = &mut self.cells[known].first;
            *first = order.min(*first);
            return known;
        }
        let without = |is_left_out: &dyn Fn(&str) -> bool| -> Vec<String> {
            let all = row::input_columns().zip(&inputs);
            all.filter(|(name, _)| !is_left_out(name)).map(|(_, value)| value.clone()).collect()
        };
        let class = |kind: usize| {
            let next = self.classes.len();
            let rest = without(&|name| self.comparing.is_by(kind, name));
            *self.classes.entry((kind, rest)).or_insert(next)
        };
        let classes = (0..self.comparing.kinds()).map(class).collect();
        let this = self.cells.len();
        let condition = without(&|name| self.comparing.is_over(name));
        let condition = *self.conditions.entry(condition).or_insert(this);
        self.cells.push(Cell {
            inputs: inputs.clone(),
            n: 0,
            arrived: 0,
            outcomes: [Moments::default(); OUTCOMES.len()],
            choices: Choices::default(),
            is_noisy,
            classes,
            condition,
            first: order,
        });
        self.known.insert(inputs, this);
        this
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

    /// Numbers combinations by their first episodes.
    fn renumber(&mut self) {
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by_key(|&cell| self.cells[cell].first);
        let mut numbers = vec![0; order.len()];
        order.iter().enumerate().for_each(|(to, &from)| numbers[from] = to);
        self.cells = order.iter().map(|&from| self.cells[from].clone()).collect();
        let mut conditions = BTreeMap::new();
        for (to, cell) in self.cells.iter_mut().enumerate() {
            cell.condition = *conditions.entry(cell.condition).or_insert(to);
        }
        self.ends.iter_mut().for_each(|end| end.cell = numbers[end.cell]);
    }

    /// Pairs all episodes that are left.
    fn end(&mut self) -> Result<(), SweepError> {
        self.renumber();
        let mut ends = std::mem::take(&mut self.ends);
        ends.sort_by_key(|end| end.seed);
        for seed in ends.chunk_by(|a, b| a.seed == b.seed) {
            self.ends = seed.to_vec();
            self.end_of_seed()?;
            if self.pairs.len() > MAX_PAIRS {
                let most = format!("the last of at most {MAX_PAIRS} comparisons");
                return Err(self.wrong_row(seed[0].place, "too much for a summary".to_owned(), &most));
            }
        }
        Ok(())
    }

    /// Counts and compares the episodes of a finished seed.
    fn end_of_seed(&mut self) -> Result<(), SweepError> {
        let mut ends = std::mem::take(&mut self.ends);
        ends.sort_by_key(|end| end.cell);
        let mut once: Vec<End> = Vec::new();
        for end in ends {
            match once.last().filter(|last| last.cell == end.cell) {
                None => once.push(end),
                Some(last) if last.is_equal(&end) => self.repeated += 1,
                Some(_) => {
                    let found =
                        format!("of a combination that has seed {} already, with other results", end.seed);
                    return Err(self.wrong_row(end.place, found, "another combination or seed"));
                }
            }
        }
        once.iter().for_each(|end| self.cells[end.cell].add(end));
        for kind in 0..self.comparing.kinds() {
            let mut classes: BTreeMap<usize, Vec<&End>> = BTreeMap::new();
            for end in &once {
                classes.entry(self.cells[end.cell].classes[kind]).or_default().push(end);
            }
            for class in classes.values() {
                for (i, first) in class.iter().enumerate() {
                    class[i + 1..].iter().for_each(|second| self.compare(kind, first, second));
                }
            }
        }
        self.pairs.values_mut().for_each(Differences::end_unit);
        Ok(())
    }

    fn compare(&mut self, kind: usize, a: &End, b: &End) {
        // then the check fails
        if self.pairs.len() > MAX_PAIRS {
            return;
        }
        let [first, second] = [a, b].map(|end| self.cells[end.cell].condition);
        let ((first, a), (second, b)) =
            if first <= second { ((first, a), (second, b)) } else { ((second, b), (first, a)) };
        let pair = (kind, first, second);
        let which = [[3, 2], [1, 0]][usize::from(a.has_arrived)][usize::from(b.has_arrived)];
        self.arrivals.entry(pair).or_default()[which] += 1;
        if which > 0 {
            return;
        }
        for quantity in 0..self.comparing.quantities().len() {
            let [first, second] = [a, b].map(|end| end.values[OUTCOMES.len() + quantity]);
            if first.is_finite() && second.is_finite() {
                let differences = self.pairs.entry((pair, quantity)).or_default();
                differences.units.add_pair(first, second);
                differences.present.extend([a.choices, b.choices]);
            }
        }
    }

    fn summary(self, origins: &Origins) -> Summary {
        let names: Vec<&str> = row::input_columns().collect();
        let is_varied = |i: &usize| self.cells.iter().any(|cell| cell.inputs[*i] != self.cells[0].inputs[*i]);
        let varied: Vec<usize> = (0..names.len()).filter(is_varied).collect();
        let group = |cell: &Cell| SummaryGroup {
            inputs: names.iter().zip(&cell.inputs).map(|(name, v)| ((*name).to_owned(), v.clone())).collect(),
            n: cell.n,
            arrived: cell.arrived,
            outcomes: OUTCOMES
                .into_iter()
                .zip(cell.outcomes.iter().map(|moments| moments.estimate(cell.is_sample())))
                .collect(),
        };
        let comparison = |(&(pair, quantity), found): (&(Pair, usize), &Differences)| {
            let (kind, first, second) = pair;
            let cells = [first, second].map(|cell| &self.cells[cell]);
            let [of_first, of_second] = cells.map(|cell| &cell.inputs);
            let is_by = |i: &usize| self.comparing.is_by(kind, names[*i]);
            let differs = |i: &usize| is_by(i) && of_first[*i] != of_second[*i];
            let differing: Vec<usize> = (0..names.len()).filter(differs).collect();
            let common = varied.iter().filter(|i| !is_by(i) && !self.comparing.is_over(names[**i]));
            let is_sample = found.choices.differ || !cells.iter().any(|cell| cell.is_noisy);
            Some(Comparison {
                cost: self.comparing.quantities()[quantity],
                first: label(&names, of_first, &differing),
                second: label(&names, of_second, &differing),
                inputs: common.map(|&i| (names[i].to_owned(), of_first[i].clone())).collect(),
                difference: Paired::of(found.units.moments(), is_sample)?,
                share_lower: found.units.share_below(),
                arrivals: self.arrivals[&pair],
            })
        };
        let mut comparisons: Vec<Comparison> = self.pairs.iter().filter_map(comparison).collect();
        statistics::correct(comparisons.iter_mut().map(|comparison| &mut comparison.difference));
        let studies: Vec<&str> = origins.studies.iter().map(|(study, _)| study.as_str()).collect();
        Summary {
            study: studies.join(" "),
            rows: origins.rows,
            episodes: origins.studies.iter().map(|(_, episodes)| episodes).sum(),
            varied: varied.iter().map(|i| names[*i].to_owned()).collect(),
            groups: self.cells.iter().map(group).collect(),
            comparisons,
            are_paired: !self.arrivals.is_empty(),
            notes: origins.notes(self.repeated),
        }
    }
}

impl Cell {
    fn add(&mut self, end: &End) {
        self.n += 1;
        if end.has_arrived {
            self.arrived += 1;
            let values = self.outcomes.iter_mut().zip(&end.values);
            values.filter(|(_, v)| v.is_finite()).for_each(|(moments, v)| moments.add(*v, v.abs()));
            self.choices.add(&[end.choices]);
        }
    }
}

impl End {
    fn is_equal(&self, other: &Self) -> bool {
        let bits = |end: &Self| end.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        (self.has_arrived, self.choices, bits(self)) == (other.has_arrived, other.choices, bits(other))
    }
}

impl Differences {
    fn end_unit(&mut self) {
        if !self.present.is_empty() {
            self.units.end_unit();
            self.choices.add(&self.present);
            self.present.clear();
        }
    }
}

/// A combination by the inputs that differ from another's: their words, and the names of flags. The code of a
/// partner is left out where the name tells which one it is.
fn label(names: &[&str], values: &[String], differing: &[usize]) -> String {
    let is_told = |name: &str| {
        let partner = match name {
            "policy_code" => "method",
            "human_code" => "human_model",
            _ => return false,
        };
        differing.iter().any(|&i| names[i] == partner)
    };
    let words = differing.iter().filter(|&&i| !is_told(names[i])).map(|&i| match values[i].as_str() {
        "true" => names[i],
        "false" => "",
        word => word,
    });
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_that_are_read_are_written() {
        let columns = row::columns();
        for name in ["seed", "outcome", "plant"].into_iter().chain(OUTCOMES).chain(CHOICES) {
            assert!(columns.contains(&name), "{name}");
        }
    }
}

//! The rows of a file of results in; mean, deviation and interval of the costs of every combination, and paired comparisons over the same
//! seeds, out. One pass; what is held grows with the combinations, not with the rows.

use super::results::Rows;
use super::{SweepError, row};
use crate::experiments::p_value_of_mean;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::collections::BTreeMap;
use std::path::Path;

/// The columns that are summed up.
const COSTS: [&str; 2] = ["accumulated_objective_cost_m", "control_cost"];
/// What is compared, all other inputs being equal: columns that belong together.
const COMPARED: [&[&str]; 2] = [&["method"], &["pose", "pose_criterion", "prepare_while_leading"]];

/// The results of a study, summed up.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The study's digest.
    pub study: String,
    /// Rows read.
    pub rows: u64,
    /// Episodes of the whole study.
    pub episodes: u64,
    /// Inputs that are not the same in all rows.
    pub varied: Vec<String>,
    /// One for every combination, in the order in which they appear.
    pub groups: Vec<Group>,
    /// One for every two combinations that differ in the method alone, or in the choice of the pose alone, and every cost.
    pub comparisons: Vec<Comparison>,
}

/// The episodes of one combination.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// The inputs by column; empty where not applicable.
    pub inputs: BTreeMap<String, String>,
    /// Episodes.
    pub n: u64,
    /// Those that arrived. Costs are of these.
    pub arrived: u64,
    /// The accumulated objective cost, m.
    pub accumulated_objective_cost_m: Option<Estimate>,
    /// The control cost C; none without a robot.
    pub control_cost: Option<Estimate>,
}

/// A mean, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Values.
    pub n: u64,
    /// Their mean.
    pub mean: f64,
    /// Their sample standard deviation; none of a single value.
    pub std: Option<f64>,
    /// The 95 % confidence interval of the mean (Student's t); none for a single value.
    pub interval: Option<[f64; 2]>,
}

/// Two combinations that differ in one thing, over the seeds with which both arrived.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The cost that is compared, by its column.
    pub cost: &'static str,
    /// One of the two, by what they differ in.
    pub first: String,
    /// The other.
    pub second: String,
    /// What they have in common, as far as it is varied.
    pub inputs: BTreeMap<String, String>,
    /// The cost of the first less that of the second, with the same seed.
    pub difference: Estimate,
    /// Two-sided p-value of the paired t-test that the difference is 0 in the mean; none for fewer than two pairs.
    pub p_value: Option<f64>,
    /// Share of the pairs in which the first costs less.
    pub share_lower: f64,
}

/// Mean and squared deviations of the values so far (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    n: u64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.n += 1;
        let before = value - self.mean;
        self.mean += before / self.n as f64;
        self.squares += before * (value - self.mean);
    }

    fn std(&self) -> Option<f64> {
        (self.n > 1).then(|| (self.squares / (self.n - 1) as f64).sqrt())
    }

    fn estimate(&self) -> Option<Estimate> {
        let Self { n, mean, .. } = *self;
        let std = self.std();
        let interval = std.and_then(|std| {
            let students_t = StudentsT::new(0.0, 1.0, (n - 1) as f64).ok()?;
            let half = students_t.inverse_cdf(0.975) * std / (n as f64).sqrt();
            Some([mean - half, mean + half])
        });
        (n > 0).then_some(Estimate { n, mean, std, interval })
    }
}

/// A combination while rows are read.
struct Cell {
    inputs: Vec<String>,
    n: u64,
    arrived: u64,
    costs: [Moments; COSTS.len()],
    /// The number of its class for each thing compared: those of a class differ in nothing else.
    classes: [usize; COMPARED.len()],
}

/// The cell of an episode that arrived, and what it has cost.
type End = (usize, [Option<f64>; COSTS.len()]);
/// What is compared, two cells and a cost.
type Pair = (usize, usize, usize, usize);

#[derive(Default)]
struct Reader {
    cells: Vec<Cell>,
    known: BTreeMap<Vec<String>, usize>,
    classes: BTreeMap<(usize, Vec<String>), usize>,
    /// By what is compared, the two cells, and the cost.
    pairs: BTreeMap<Pair, (Moments, u64)>,
    /// The seed under way, and what its episodes that arrived have cost.
    seed: Option<String>,
    ends: Vec<End>,
}

impl Summary {
    /// Reads a file of results: of a whole study, a shard, or one that is under way.
    ///
    /// # Errors
    /// [`SweepError`], which names the file and the line.
    pub fn load(path: &Path) -> Result<Self, SweepError> {
        let mut rows = Rows::open(path)?;
        let columns = row::columns();
        let at = |name: &str| columns.iter().position(|column| *column == name).unwrap_or_default();
        let (seed, outcome, costs) = (at("seed"), at("outcome"), COSTS.map(at));
        let first_input = row::IDENTITY.len();
        let inputs = first_input..first_input + row::input_columns().count();
        let mut reader = Reader::default();
        let mut first = None;
        let mut count = 0;
        while let Some(identity) = rows.next()? {
            let fields = fields(&rows, columns.len())?;
            let begin = first.get_or_insert_with(|| identity.clone());
            if identity.study != begin.study || identity.episode != begin.episode + count {
                return Err(SweepError::Line {
                    file: rows.file,
                    line: rows.number,
                    found: format!("episode {} of study {}", identity.episode, identity.study),
                    expected: format!("episode {} of study {}", begin.episode + count, begin.study),
                });
            }
            count += 1;
            reader.add(&fields, inputs.clone(), seed, outcome, costs);
        }
        reader.end_of_seed();
        let first = first.ok_or_else(|| SweepError::Empty { file: rows.file.clone() })?;
        Ok(reader.summary(first.study, count, first.episodes))
    }
}

/// The fields of the row read last.
fn fields(rows: &Rows, columns: usize) -> Result<csv::StringRecord, SweepError> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&rows.line[..]);
    let mut fields = csv::StringRecord::new();
    match reader.read_record(&mut fields) {
        Ok(true) if fields.len() == columns => Ok(fields),
        _ => Err(SweepError::Line {
            file: rows.file.clone(),
            line: rows.number,
            found: format!("{} fields", fields.len()),
            expected: format!("{columns} fields of text"),
        }),
    }
}

impl Reader {
    fn add(
        &mut self,
        fields: &csv::StringRecord,
        inputs: std::ops::Range<usize>,
        seed: usize,
        outcome: usize,
        costs: [usize; COSTS.len()],
    ) {
        if self.seed.as_deref() != Some(&fields[seed]) {
            self.end_of_seed();
            self.seed = Some(fields[seed].to_owned());
        }
        let cell = self.cell(inputs.map(|i| fields[i].to_owned()).collect());
        let costs = costs.map(|i| fields[i].parse::<f64>().ok().filter(|cost| cost.is_finite()));
        let this = &mut self.cells[cell];
        this.n += 1;
        if &fields[outcome] == row::arrived() {
            this.arrived += 1;
            for (moments, cost) in this.costs.iter_mut().zip(costs) {
                cost.into_iter().for_each(|cost| moments.add(cost));
            }
            self.ends.push((cell, costs));
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
        let costs = [Moments::default(); COSTS.len()];
        self.cells.push(Cell { inputs: inputs.clone(), n: 0, arrived: 0, costs, classes });
        self.known.insert(inputs, self.cells.len() - 1);
        self.cells.len() - 1
    }

    /// Compares the episodes of the seed that is over.
    fn end_of_seed(&mut self) {
        let ends = std::mem::take(&mut self.ends);
        for what in 0..COMPARED.len() {
            let mut classes: BTreeMap<usize, Vec<&End>> = BTreeMap::new();
            for end in &ends {
                classes.entry(self.cells[end.0].classes[what]).or_default().push(end);
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
        let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
        for cost in 0..COSTS.len() {
            if let (Some(first), Some(second)) = (a.1[cost], b.1[cost]) {
                let (moments, lower) = self.pairs.entry((what, a.0, b.0, cost)).or_default();
                moments.add(first - second);
                *lower += u64::from(first < second);
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
            accumulated_objective_cost_m: cell.costs[0].estimate(),
            control_cost: cell.costs[1].estimate(),
        };
        let comparison = |(&(what, first, second, cost), (moments, lower)): (&Pair, &(Moments, u64))| {
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
                cost: COSTS[cost],
                first: label(of_first),
                second: label(of_second),
                inputs: common.map(|&i| (names[i].to_owned(), of_first[i].clone())).collect(),
                difference: moments.estimate()?,
                p_value: moments.std().and_then(|std| p_value_of_mean(moments.mean, std, moments.n as f64)),
                share_lower: *lower as f64 / moments.n as f64,
            })
        };
        Summary {
            study,
            rows,
            episodes,
            varied: varied.iter().map(|i| names[*i].to_owned()).collect(),
            groups: self.cells.iter().map(group).collect(),
            comparisons: self.pairs.iter().filter_map(comparison).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::mean_and_std;

    #[test]
    fn closed_form_moments_are_those_of_all_values_at_once() {
        let values: Vec<f64> = (0..100).map(|i| 1e6 + f64::from(i * i % 37)).collect();
        let mut moments = Moments::default();
        values.iter().for_each(|v| moments.add(*v));
        let (mean, std) = mean_and_std(&values);
        assert!((moments.mean - mean).abs() < 1e-9 && (moments.std().unwrap() - std).abs() < 1e-9);
    }

    #[test]
    fn golden_the_interval_is_students() {
        // 1 to 5: mean 3, std 1.5811, t(0.975, 4) = 2.7764
        let mut moments = Moments::default();
        (1..=5).for_each(|v| moments.add(f64::from(v)));
        let [lower, upper] = moments.estimate().unwrap().interval.unwrap();
        assert!((lower - 1.03676).abs() < 1e-4 && (upper - 4.96324).abs() < 1e-4, "{lower} {upper}");
    }
}

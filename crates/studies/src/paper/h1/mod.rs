//! H1, Table I: the model's choice distribution next to the participants' answers and the paper's model
//! output.

pub mod section;
pub mod weight;

use super::ENVIRONMENTS;
use cocarry::Error;
use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor};
use serde::Serialize;

/// One cell of Table I.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChoiceRow {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// Option, by name.
    pub option: String,
    /// Mean answer of the participants, percent.
    pub human_percent: f64,
    /// The paper's model output, percent.
    pub paper_percent: f64,
    /// P_o of eq. (4) at the start, percent.
    pub ours_percent: f64,
}

/// Table I.
///
/// # Errors
/// If a built-in world is not valid.
pub fn table(predictor: &Predictor) -> Result<Vec<ChoiceRow>, Error> {
    let mut rows = Vec::new();
    let mut predictor = predictor.clone();
    let mut choice = ChoiceDistribution::default();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world()?, predictor.risk_weight())?;
        let prospects = prospects(&set, &set.begin());
        predictor.predict(&prospects, &mut choice);
        for (o, option) in set.options().iter().enumerate() {
            rows.push(ChoiceRow {
                environment: environment.number,
                option: option.name.clone(),
                human_percent: environment.human_percent[o],
                paper_percent: environment.model_percent[o],
                ours_percent: 100.0 * choice.probabilities()[o],
            });
        }
    }
    Ok(rows)
}

/// Mean and largest absolute difference between our figures and the paper's model output, percentage points.
pub fn differences(rows: &[ChoiceRow]) -> (f64, f64) {
    let off: Vec<f64> = rows.iter().map(|r| (r.ours_percent - r.paper_percent).abs()).collect();
    (off.iter().sum::<f64>() / off.len() as f64, off.iter().copied().fold(0.0, f64::max))
}

/// The fit of the models to the human column of one environment: mean absolute differences over its options,
/// percentage points.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// Between the answers and our figures.
    pub ours: f64,
    /// Between the answers and the paper's model.
    pub paper: f64,
    /// Between the answers and the best single choice by everyone: no fixed (alpha, gamma) is better.
    pub fixed: f64,
    /// Pairs of options with different answers.
    pub pairs: usize,
    /// Pairs of these that our figures put in the same order.
    pub ranked: usize,
}

/// The fit of the models to each environment's answers.
pub fn fits(rows: &[ChoiceRow]) -> Vec<Fit> {
    let environments = rows.chunk_by(|a, b| a.environment == b.environment);
    environments
        .map(|rows| {
            let column = |of: fn(&ChoiceRow) -> f64| rows.iter().map(of).collect::<Vec<_>>();
            let human = column(|r| r.human_percent);
            let Closeness { off, fixed, pairs, ranked } = closeness(&human, &column(|r| r.ours_percent));
            let paper = closeness(&human, &column(|r| r.paper_percent)).off;
            Fit { environment: rows[0].environment, ours: off, paper, fixed, pairs, ranked }
        })
        .collect()
}

/// How close a model's percentages for the options of a world are to people's mean answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closeness {
    /// Mean absolute difference, percentage points.
    pub off: f64,
    /// The same of the best single choice by everyone.
    pub fixed: f64,
    /// Pairs of options with different answers.
    pub pairs: usize,
    /// Pairs of these that the model puts in the same order.
    pub ranked: usize,
}

/// The closeness of a model's percentages to answers; both have one for each option.
pub fn closeness(human: &[f64], model: &[f64]) -> Closeness {
    let off = |model: &dyn Fn(usize) -> f64| -> f64 {
        human.iter().enumerate().map(|(i, h)| (model(i) - h).abs()).sum::<f64>() / human.len() as f64
    };
    let everyone = |option: usize| off(&|i| if i == option { 100.0 } else { 0.0 });
    let all = || (0..human.len()).flat_map(|a| (a + 1..human.len()).map(move |b| [a, b]));
    let same = |[a, b]: &[usize; 2]| (human[*a] - human[*b]) * (model[*a] - model[*b]) > 0.0;
    Closeness {
        off: off(&|i| model[i]),
        fixed: (0..human.len()).map(everyone).fold(f64::INFINITY, f64::min),
        pairs: all().filter(|[a, b]| human[*a] != human[*b]).count(),
        ranked: all().filter(same).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_fits_of_an_environment() {
        let row = |human_percent, paper_percent, ours_percent| ChoiceRow {
            environment: 7,
            option: String::new(),
            human_percent,
            paper_percent,
            ours_percent,
        };
        let fits = fits(&[row(60.0, 50.0, 55.0), row(30.0, 50.0, 20.0), row(10.0, 0.0, 25.0)]);
        // everyone chooses the first option: (40 + 30 + 10) / 3
        let expected =
            Fit { environment: 7, ours: 10.0, paper: 40.0 / 3.0, fixed: 80.0 / 3.0, pairs: 3, ranked: 2 };
        assert_eq!(fits, [expected]);
    }
}

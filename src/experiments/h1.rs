//! H1, Table I: the choice distribution of the model against the participants' answers and the paper's model output.

use super::paper::{BuiltInError, ENVIRONMENTS};
use crate::episode::prospects;
use crate::options::OptionSet;
use crate::preference::{ChoiceDistribution, Predictor};
use serde::Serialize;

/// One cell of Table I.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
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
pub fn table(predictor: &Predictor) -> Result<Vec<Row>, BuiltInError> {
    let mut rows = Vec::new();
    let mut predictor = predictor.clone();
    let mut choice = ChoiceDistribution::default();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world()?, predictor.risk_weight())?;
        let prospects = prospects(&set, &set.begin());
        predictor.predict(&prospects, &mut choice);
        for (o, option) in set.options().iter().enumerate() {
            rows.push(Row {
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
pub fn differences(rows: &[Row]) -> (f64, f64) {
    let off: Vec<f64> = rows.iter().map(|r| (r.ours_percent - r.paper_percent).abs()).collect();
    (off.iter().sum::<f64>() / off.len() as f64, off.iter().copied().fold(0.0, f64::max))
}

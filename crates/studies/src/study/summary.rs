//! Means, deviations and intervals of a study's results, and paired comparisons of the same humans.

use super::SweepError;
use super::compared::nothing;
use crate::statistics::{Estimate, Paired};
use serde::Serialize;
use std::collections::BTreeMap;

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
/// The number of columns that are compared unless others are asked for.
pub(super) const COSTS: usize = 2;

/// The summary of results.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The study's digest; of several studies, all, separated by spaces.
    pub study: String,
    /// The number of rows read.
    pub rows: u64,
    /// The number of episodes of the whole studies.
    pub episodes: u64,
    /// The inputs that vary between rows.
    pub varied: Vec<String>,
    /// One group for every combination, in the order in which they appear.
    pub groups: Vec<SummaryGroup>,
    /// One comparison for every quantity and every two combinations that differ only in what is compared.
    pub comparisons: Vec<Comparison>,
    /// Whether two episodes were paired.
    #[serde(skip)]
    pub(super) are_paired: bool,
    /// What a reader should know of the rows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// The episodes of one combination.
#[derive(Clone, Debug, Serialize)]
pub struct SummaryGroup {
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
    /// The column of the compared quantity.
    pub cost: &'static str,
    /// The first combination, by the compared input.
    pub first: String,
    /// The second combination.
    pub second: String,
    /// Their common inputs, as far as they vary in the results.
    pub inputs: BTreeMap<String, String>,
    /// The quantity of the first minus that of the second, with the same seed; corrected for all tested
    /// comparisons of the summary.
    pub difference: Paired,
    /// The share of the pairs in which the first is lower.
    pub share_lower: f64,
    /// The number of pairs of which both arrived, the first alone, the second alone, and none.
    pub arrivals: [u64; 4],
}

impl Summary {
    /// The inputs that vary and that combinations are named by: without those that repeat what a name tells.
    pub fn named(&self) -> Vec<&str> {
        let has_several = |name: &str, code: &str| {
            let mut codes: BTreeMap<&str, &str> = BTreeMap::new();
            self.groups.iter().any(|group| {
                let code = group.inputs[code].as_str();
                *codes.entry(&group.inputs[name]).or_insert(code) != code
            })
        };
        let is_named = |column: &&str| match *column {
            "humans_alpha" | "humans_gamma" | "belief_alpha" | "belief_gamma" => false,
            "policy_code" => has_several("method", column),
            "human_code" => has_several("human_model", column),
            _ => true,
        };
        self.varied.iter().map(String::as_str).filter(is_named).collect()
    }

    /// The check that there is something to compare by this input.
    ///
    /// # Errors
    /// No two combinations differ in it alone.
    pub fn check_compared(&self, names: &[String], by: &str) -> Result<(), SweepError> {
        match self.comparisons.is_empty() {
            true => Err(nothing(names, by, self.are_paired)),
            false => Ok(()),
        }
    }
}

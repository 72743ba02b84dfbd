//! The headline figures of a group of participants, side by side for all groups.

use super::Analysis;
use super::choices::Choices;
use super::groups::AnalysedGroup;
use super::methods::{Comparison, difference};
use cocarry::math;
use cocarry_studies::fit::{EtaFit, Inference, QUANTITIES};
use cocarry_studies::table::{Cell, Columns, Table};
use serde_json::Value;

/// A figure of a group.
struct Headline {
    key: String,
    name: String,
    shown: String,
    value: Option<f64>,
    interval: Option<[f64; 2]>,
}

impl Headline {
    /// A number with its interval.
    fn of(name: &str, value: Option<f64>, interval: Option<[f64; 2]>, decimals: usize) -> Self {
        let number = |value: f64| format!("{value:.decimals$}");
        let shown = match (value, interval) {
            (None, _) => "-".to_owned(),
            (Some(value), None) => number(value),
            (Some(value), Some([low, high])) => {
                format!("{} ({} to {})", number(value), number(low), number(high))
            }
        };
        Self { key: name.to_owned(), name: name.to_owned(), shown, value, interval }
    }
}

fn of_choices(choices: &Choices) -> Vec<Headline> {
    let [pairs, ranked] = choices.pairs();
    let mut order = Headline::of("pairs of options ranked as by people", Some(ranked as f64), None, 0);
    order.shown = format!("{ranked} of {pairs}");
    vec![Headline::of("P_o off the mean answers (points)", choices.off(), None, 1), order]
}

fn of_eta(fit: &EtaFit) -> Vec<Headline> {
    let walks: usize = fit.participants.iter().map(|eta| eta.episodes).sum();
    let stopped: usize = fit.participants.iter().map(|eta| eta.switches).sum();
    let mut censored =
        Headline::of("walks followed to the end (censored)", Some((walks - stopped) as f64), None, 0);
    censored.shown = format!("{} of {walks}", walks - stopped);
    let overall = fit.overall;
    vec![
        Headline::of("median of eta", overall.map(|all| all.median), fit.median_interval, 2),
        Headline::of("spread of eta (factor)", overall.map(|all| math::exp(all.log_std)), None, 2),
        censored,
    ]
}

fn of_inference(inference: &Inference) -> Vec<Headline> {
    let population =
        inference.population.iter().flat_map(|population| population.posterior.iter().zip(QUANTITIES));
    let mut all: Vec<Headline> = population
        .map(|(figure, name)| Headline::of(name, Some(figure.median), Some(figure.interval), 3))
        .collect();
    if let Some(held_out) = inference.held_out.iter().find(|row| row.world.is_none()) {
        let [own, prior] = [held_out.posterior, held_out.prior].map(|score| score.log_score);
        all.push(Headline::of("log score of held-out answers, own posterior", own, None, 3));
        all.push(Headline::of("log score of held-out answers, prior", prior, None, 3));
    }
    all
}

fn of_comparison(comparison: &Comparison) -> Headline {
    let [first, second] = &comparison.methods;
    let decimals = 2;
    let name = format!("{}: {first} - {second}", comparison.measure.key());
    let mean = comparison.paired.difference;
    let mut shown = difference(&comparison.paired, decimals);
    if let Some(p) = comparison.paired.p_holm {
        shown += &format!(", p {}", cocarry_studies::paper::pairs::rounded(Some(p)));
    }
    Headline { key: name.clone(), name, shown, value: Some(mean.mean), interval: mean.interval }
}

fn headlines(analysis: &Analysis) -> Vec<Headline> {
    let mut all = vec![Headline::of("participants", Some(analysis.people as f64), None, 0)];
    all.extend(analysis.choices.iter().flat_map(of_choices));
    all.extend(analysis.eta.iter().flat_map(of_eta));
    all.extend(analysis.inference.iter().flat_map(of_inference));
    all.extend(analysis.comparisons.iter().map(of_comparison));
    all
}

/// The headline figures of all groups, a column each.
pub(super) fn table(groups: &[(AnalysedGroup, Analysis)]) -> Table {
    let all: Vec<Vec<Headline>> = groups.iter().map(|(_, analysis)| headlines(analysis)).collect();
    let rows: Vec<&Headline> = all.first().into_iter().flatten().collect();
    let mut columns = Columns::of(&rows).text("figure", "figure", |row| row.name.clone());
    for ((group, _), own) in groups.iter().zip(&all) {
        let keys = ["value", "low", "high"].map(|part| format!("{}_{part}", group.key));
        let keys = keys.each_ref().map(String::as_str);
        columns = columns.column(&group.name, false, &keys, |row| {
            let found = own.iter().find(|headline| headline.key == row.key);
            let end = |which: usize| Value::from(found.and_then(|f| f.interval).map(|ends| ends[which]));
            Cell {
                shown: found.map_or("-".to_owned(), |found| found.shown.clone()),
                values: vec![found.and_then(|f| f.value).into(), end(0), end(1)],
            }
        });
    }
    let table = columns
        .table("headlines", "Headline figures, with and without flagged participants")
        .with_note("In parentheses: 95 % intervals. -: the group does not determine it.");
    match groups.len() {
        1 => table.with_note("Nobody who finished has a flag, so there is one column."),
        _ => table,
    }
}

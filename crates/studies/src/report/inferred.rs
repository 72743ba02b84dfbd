//! Tables of what was inferred about people, the same in every output.

use crate::fit::{Figure, Person, Population, QUANTITIES};
use crate::table::{Columns, Table};
use serde_json::Value;

/// An interval in words.
pub fn shown_interval([low, high]: [f64; 2], decimals: usize) -> String {
    format!("{low:.decimals$} to {high:.decimals$}")
}

/// Adds the columns of a figure for programs; a row without it has none.
fn figure<'a, R>(columns: Columns<'a, R>, key: &str, of: impl Fn(&R) -> Option<Figure>) -> Columns<'a, R> {
    let value = |number: Option<f64>| Value::from(number.filter(|n| n.is_finite()));
    let numbers = |f: Figure| {
        let ends = [f.interval, f.interval_50, f.interval_80].into_iter().flatten();
        [f.mean, f.std].into_iter().chain(ends).chain([f.median]).collect::<Vec<f64>>()
    };
    let parts = ["mean", "std", "low", "high", "low_50", "high_50", "low_80", "high_80", "median"];
    parts.iter().enumerate().fold(columns, |columns, (i, part)| {
        columns.data(&format!("{key}_{part}"), |row| value(of(row).map(|figure| numbers(figure)[i])))
    })
}

/// Adds median and intervals of a figure, for people.
pub fn figure_columns<'a, R>(
    columns: Columns<'a, R>,
    decimals: usize,
    of: impl Fn(&R) -> Figure,
) -> Columns<'a, R> {
    columns
        .derived("median", |row| format!("{:.decimals$}", of(row).median))
        .derived("50 %", |row| shown_interval(of(row).interval_50, decimals))
        .derived("80 %", |row| shown_interval(of(row).interval_80, decimals))
        .derived("95 %", |row| shown_interval(of(row).interval, decimals))
}

/// All figures of every participant, for programs.
pub fn people_columns(people: &[Person]) -> Columns<'_, Person> {
    let within = |which: usize| move |p: &Person| p.within_population.map(|figures| figures[which]);
    let columns = Columns::of(people)
        .text("participant", "participant", |p| p.participant.clone())
        .count("answers", "answers", |p| p.answers as u64)
        .count("sightings", "sightings", |p| p.sightings as u64);
    let columns = figure(columns, "alpha", |p| Some(p.alpha));
    let columns = figure(columns, "gamma", |p| Some(p.gamma))
        .data("correlation", |p| p.correlation)
        .data("information_nats", |p| p.information)
        .data("log_evidence", |p| p.log_evidence);
    let columns = figure(columns, "population_alpha", within(0));
    let columns = figure(columns, "population_gamma", within(1));
    let columns = columns.count("episodes", "episodes", |p| p.episodes as u64);
    figure(columns, "eta", |p| p.eta)
}

/// The quantities of a population, posterior and prior.
pub fn population_table(population: &Population) -> Table {
    let both = population.posterior.iter().zip(&population.prior).zip(QUANTITIES);
    let rows: Vec<(&str, Figure)> =
        both.flat_map(|((posterior, prior), name)| [(name, *posterior), ("  a priori", *prior)]).collect();
    let columns = Columns::of(&rows).text("over people", "quantity", |(name, _)| *name);
    figure_columns(figure(columns, "value", |(_, figure)| Some(*figure)), 3, |(_, figure)| *figure)
        .table("population", "The population of alpha and gamma")
        .with_note(format!(
            "Information of the answers about the population: {:.2} nats. Logarithm of their probability: {:.2}.",
            population.information, population.log_evidence
        ))
}

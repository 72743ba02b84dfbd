//! Tables of what was inferred.

use crate::output::table_with_notes;
use cocarry_studies::fit::{
    Answers, Figure, HeldOut, Inference, InferenceSettings, Means, Person, Population, QUANTITIES, Score,
};
use cocarry_studies::table::{Cell, Columns, Table};
use serde_json::{Value, json};

fn interval([low, high]: [f64; 2], decimals: usize) -> String {
    format!("{low:.decimals$} to {high:.decimals$}")
}

/// Adds mean, standard deviation and interval of a figure; a row without it has none.
fn figure<'a, R>(
    columns: Columns<'a, R>,
    name: &str,
    key: &str,
    decimals: usize,
    of: impl Fn(&R) -> Option<Figure>,
) -> Columns<'a, R> {
    let keys = ["mean", "std", "low", "high"].map(|part| format!("{key}_{part}"));
    let value = |number: Option<f64>| Value::from(number.filter(|n| n.is_finite()));
    columns
        .column(name, false, &[&keys[0], &keys[1]], |row| {
            let figure = of(row);
            let shown =
                figure.map_or("-".to_owned(), |f| format!("{:.decimals$} ± {:.decimals$}", f.mean, f.std));
            Cell { shown, values: vec![value(figure.map(|f| f.mean)), value(figure.map(|f| f.std))] }
        })
        .column("95 %", false, &[&keys[2], &keys[3]], |row| {
            let ends = of(row).map(|f| f.interval);
            let shown = ends.map_or("-".to_owned(), |ends| interval(ends, decimals));
            Cell { shown, values: vec![value(ends.map(|e| e[0])), value(ends.map(|e| e[1]))] }
        })
}

/// All figures of every participant, for programs.
pub(super) fn people(inference: &Inference) -> Table {
    let within = |which: usize| move |p: &Person| p.within_population.map(|figures| figures[which]);
    let columns = Columns::of(&inference.people)
        .text("participant", "participant", |p| p.participant.clone())
        .count("answers", "answers", |p| p.answers as u64)
        .count("looks", "looks", |p| p.looks as u64);
    let columns = figure(columns, "alpha", "alpha", 3, |p| Some(p.alpha));
    let columns = figure(columns, "gamma", "gamma", 3, |p| Some(p.gamma))
        .data("correlation", |p| p.correlation)
        .data("information_nats", |p| p.information)
        .data("log_evidence", |p| p.log_evidence);
    let columns = figure(columns, "alpha", "population_alpha", 3, within(0));
    let columns = figure(columns, "gamma", "population_gamma", 3, within(1));
    let columns = columns.count("episodes", "episodes", |p| p.episodes as u64);
    figure(columns, "eta", "eta", 2, |p| p.eta).table("people", "Participants")
}

/// What a terminal shows.
pub(super) fn tables(inference: &Inference, settings: &InferenceSettings) -> Vec<Table> {
    let mut tables = Vec::new();
    let answered: Vec<&Person> = inference.people.iter().filter(|p| p.answers + p.looks > 0).collect();
    if !answered.is_empty() {
        let columns = Columns::of(&answered)
            .text("participant", "participant", |p| p.participant.clone())
            .count("answers", "answers", |p| p.answers as u64);
        let columns = match answered.iter().any(|p| p.looks > 0) {
            true => columns.count("looks", "looks", |p| p.looks as u64),
            false => columns,
        };
        let columns = figure(columns, "alpha", "alpha", 2, |p| Some(p.alpha));
        let table = figure(columns, "gamma", "gamma", 2, |p| Some(p.gamma))
            .table("answers", "alpha and gamma of each participant, from their own answers");
        tables
            .push(table.with_note(format!("Lapse rate {}. mean ± standard deviation.", settings.lapse_rate)));
    }
    if inference.population.is_some() && !answered.is_empty() {
        let within = |which: usize| move |p: &&Person| p.within_population.map(|figures| figures[which]);
        let columns = Columns::of(&answered).text("participant", "participant", |p| p.participant.clone());
        let columns = figure(columns, "alpha", "alpha", 2, within(0));
        let table = figure(columns, "gamma", "gamma", 2, within(1))
            .table("within", "The same within the population, from everybody's answers");
        let note =
            format!("{} draws, seed {}.", settings.draws * cocarry_studies::fit::CHAINS, settings.seed);
        tables.push(table.with_note(note));
    }
    if let Some(population) = &inference.population {
        tables.push(of_population(population));
    }
    let watched: Vec<&Person> = inference.people.iter().filter(|p| p.episodes > 0).collect();
    if !watched.is_empty() {
        let columns = Columns::of(&watched)
            .text("participant", "participant", |p| p.participant.clone())
            .count("episodes", "episodes", |p| p.episodes as u64);
        let mut table = figure(columns, "eta", "eta", 2, |p| p.eta)
            .table("tolerances", "eta of each participant, from their own switches");
        if let Some(overall) = inference.tolerances.as_ref().and_then(|fit| fit.overall) {
            let interval = inference.tolerances.as_ref().and_then(|fit| fit.median_interval);
            let interval = interval
                .map_or(String::new(), |ends| format!(" (95 % interval {})", self::interval(ends, 2)));
            table = table.with_note(format!(
                "All, as in `cocarry fit eta`: log-normal, median {:.2}{interval}, standard deviation of the logarithm {:.2}.",
                overall.median, overall.log_std
            ));
        }
        tables.push(table);
    }
    if !inference.held_out.is_empty() {
        tables.push(of_held_out(&inference.held_out));
        let rows = Columns::of(&inference.checks)
            .text("world", "world", |row| row.world.clone())
            .text("option", "option", |row| row.option.clone())
            .number("answered", "answered", 2, |row| row.observed)
            .number("predicted", "predicted", 2, |row| row.expected)
            .number("rank", "rank", 3, |row| row.rank)
            .number("p", "p", 3, |row| row.p_value);
        tables.push(rows.table("checks", "Answers for each option, predicted from the other worlds").with_note(
            "rank: the probability of fewer choices than answered. Percentages scatter less than choices, so ranks near 0 and 1 are rarer than by chance. p: twice the smaller tail, not corrected for the number of options.",
        ));
    }
    tables
}

/// The quantities of a population, posterior and prior.
pub(super) fn of_population(population: &Population) -> Table {
    let rows: Vec<usize> = (0..QUANTITIES.len()).collect();
    let columns = Columns::of(&rows).text("over people", "quantity", |row| QUANTITIES[*row]);
    let columns = figure(columns, "posterior", "posterior", 3, |row| Some(population.posterior[*row]));
    figure(columns, "prior", "prior", 3, |row| Some(population.prior[*row]))
        .table("population", "The population of alpha and gamma")
        .with_note(format!(
            "Information of the answers about the population: {:.2} nats. Logarithm of their probability: {:.2}.",
            population.information, population.log_evidence
        ))
}

pub(super) fn population_json(population: &Population) -> Value {
    let quantity = |which: usize| {
        json!({
            "quantity": QUANTITIES[which],
            "posterior": population.posterior[which],
            "prior": population.prior[which],
        })
    };
    json!({
        "quantities": (0..QUANTITIES.len()).map(quantity).collect::<Vec<_>>(),
        "information_nats": population.information,
        "log_evidence": population.log_evidence,
    })
}

fn of_held_out(rows: &[HeldOut]) -> Table {
    let score = |score: Option<Score>| match score {
        None => "-".to_owned(),
        Some(Score { log_score, hits }) => {
            let log = log_score.map_or("-inf".to_owned(), |log| format!("{log:.3}"));
            format!("{log}, {:.0} %", 100.0 * hits)
        }
    };
    Columns::of(rows)
        .text("held out", "world", |row| row.world.clone().unwrap_or_else(|| "all".to_owned()))
        .count("answers", "answers", |row| row.answers as u64)
        .column("own posterior", false, &[], |row| Cell { shown: score(Some(row.posterior)), values: vec![] })
        .column("prior", false, &[], |row| Cell { shown: score(Some(row.prior)), values: vec![] })
        .column("fit", false, &[], |row| Cell { shown: score(row.fit), values: vec![] })
        .table("held_out", "Answers in a world, predicted from the others: mean log score, and share of hits")
        .with_note(
            "own posterior: of each participant, from their answers in the other worlds. prior: the belief. fit: c_r and lapse rate of the largest likelihood for everyone in the other worlds. A hit: the most probable option has the largest percentage.",
        )
}

/// What mean answers say.
pub(super) fn of_means(means: &Means, answers: &Answers, people: u64) -> String {
    let rows = Columns::of(&means.rows)
        .text("world", "world", |row| row.world.clone())
        .text("option", "option", |row| row.option.clone())
        .number("answered (%)", "answered_percent", 1, |row| row.answered_percent)
        .number("posterior (%)", "posterior_percent", 1, |row| row.posterior_percent)
        .number("prior (%)", "prior_percent", 1, |row| row.prior_percent);
    let rows = rows
        .table("rows", format!("Mean answers of {people} people, and what the populations give"))
        .with_note("posterior, prior: means over the populations, lapses included.");
    let scaled = scaled(answers);
    format!("{}{scaled}\n{}", table_with_notes(&of_population(&means.population)), table_with_notes(&rows))
}

/// The answers that were scaled.
fn scaled(answers: &Answers) -> String {
    let line = |(participant, world, sum): &(String, String, f64)| {
        format!("The answer of `{participant}` in {world} summed to {sum} %: scaled to 100 %.\n")
    };
    answers.scaled.iter().map(line).collect()
}

/// What was scaled or left out.
pub(super) fn notes(answers: Option<&Answers>, inference: &Inference) -> String {
    let lines = inference.tolerances.iter().flat_map(|fit| &fit.unexplained_lines);
    let lines: Vec<String> = lines.map(u64::to_string).collect();
    let left_out = match lines.is_empty() {
        true => String::new(),
        false => {
            format!("Left out: no eta explains a switch before any discomfort; line {}.\n", lines.join(", "))
        }
    };
    answers.map_or(String::new(), scaled) + &left_out
}

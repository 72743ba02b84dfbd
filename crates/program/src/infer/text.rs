//! Tables of what was inferred.

use crate::output::table_with_notes;
use cocarry_studies::fit::{
    Answers, Figure, HeldOut, Inference, InferenceSettings, Means, PerceptionScore, Person, Population,
    QUANTITIES, Score,
};
use cocarry_studies::report::{figure_columns, population_table, shown_interval};
use cocarry_studies::table::{Cell, Columns, Table};
use serde_json::{Value, json};

/// alpha or gamma of a participant.
struct Parameter<'a> {
    person: &'a Person,
    name: &'static str,
    figure: Figure,
}

/// The rows of alpha and gamma of every participant.
fn parameters<'a>(
    people: &[&'a Person],
    figures: impl Fn(&Person) -> Option<[Figure; 2]>,
) -> Vec<Parameter<'a>> {
    let of = |person: &&'a Person| {
        let person = *person;
        let named =
            figures(person).into_iter().flat_map(|figures| ["alpha", "gamma"].into_iter().zip(figures));
        named.map(move |(name, figure)| Parameter { person, name, figure }).collect::<Vec<_>>()
    };
    people.iter().flat_map(of).collect()
}

fn of_parameters<'a>(rows: &'a [Parameter<'a>], has_counts: bool) -> Columns<'a, Parameter<'a>> {
    // what belongs to both rows of a participant is in the first
    let once = |row: &Parameter, text: String| if row.name == "alpha" { text } else { String::new() };
    let name = |row: &Parameter| once(row, row.person.participant.clone());
    let mut columns = Columns::of(rows).text("participant", "participant", name);
    type Count = fn(&Person) -> usize;
    let counts: [(&str, Count); 2] = [("answers", |p| p.answers), ("sightings", |p| p.sightings)];
    for (heading, count) in counts.into_iter().filter(|_| has_counts) {
        if rows.iter().any(|row| count(row.person) > 0) {
            columns = columns.derived(heading, |row| once(row, count(row.person).to_string()));
        }
    }
    figure_columns(columns.text("parameter", "parameter", |row| row.name), 2, |row| row.figure)
}

/// The tables for a terminal.
pub(super) fn tables(inference: &Inference, settings: &InferenceSettings) -> Vec<Table> {
    let mut tables = Vec::new();
    let answered: Vec<&Person> = inference.people.iter().filter(|p| p.answers + p.sightings > 0).collect();
    if !answered.is_empty() {
        let rows = parameters(&answered, |p| Some([p.alpha, p.gamma]));
        let table = of_parameters(&rows, true)
            .table("answers", "alpha and gamma of each participant, from their own answers");
        tables.push(table.with_note(format!("Lapse rate {}. Central intervals.", settings.lapse_rate)));
    }
    if inference.population.is_some() && !answered.is_empty() {
        let rows = parameters(&answered, |p| p.within_population);
        let table = of_parameters(&rows, false)
            .table("within", "The same within the population, from everybody's answers");
        let note =
            format!("{} draws, seed {}.", settings.draws * cocarry_studies::fit::CHAINS, settings.seed);
        tables.push(table.with_note(note));
    }
    if let Some(population) = &inference.population {
        tables.push(population_table(population));
    }
    let watched: Vec<(&Person, Figure)> = inference.people.iter().filter_map(|p| Some((p, p.eta?))).collect();
    if !watched.is_empty() {
        let columns = Columns::of(&watched)
            .text("participant", "participant", |(p, _)| p.participant.clone())
            .count("episodes", "episodes", |(p, _)| p.episodes as u64);
        let mut table = figure_columns(columns, 2, |(_, eta)| *eta)
            .table("tolerances", "eta of each participant, from their own switches");
        if let Some(overall) = inference.tolerances.as_ref().and_then(|fit| fit.overall) {
            let interval = inference.tolerances.as_ref().and_then(|fit| fit.median_interval);
            let interval = interval
                .map_or(String::new(), |ends| format!(" (95 % interval {})", shown_interval(ends, 2)));
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

fn shown_score(Score { log_score, hits }: Score) -> String {
    let log = log_score.map_or("-inf".to_owned(), |log| format!("{log:.3}"));
    format!("{log}, {:.0} %", 100.0 * hits)
}

/// How well every perception of risk predicts.
pub(super) fn of_perceptions(rows: &[PerceptionScore], risk_weight: f64) -> Table {
    // two lines for each: with the given c_r, and with its own
    let lines: Vec<(&PerceptionScore, bool)> =
        rows.iter().flat_map(|row| [(row, true), (row, false)]).collect();
    let of = |(row, is_given): &(&PerceptionScore, bool)| match is_given {
        true => (format!("{risk_weight:.1}"), row.posterior, row.prior),
        false => {
            let [low, high] = row.fitted_risk_weights;
            let shown = if low == high { format!("{low:.1}") } else { format!("{low:.1} to {high:.1}") };
            (shown, row.fitted_posterior, row.fitted_prior)
        }
    };
    let cell = |shown: String| Cell { shown, values: vec![] };
    Columns::of(&lines)
        .text("perception", "perception", |(row, is_given)| {
            if *is_given { row.perception.clone() } else { "  its own c_r".to_owned() }
        })
        .column("c_r (m)", false, &[], move |line| cell(of(line).0))
        .column("own posterior", false, &[], move |line| cell(shown_score(of(line).1)))
        .column("prior", false, &[], move |line| cell(shown_score(of(line).2)))
        .table("perceptions", "The same by other perceptions of risk, all worlds: mean log score, and share of hits")
        .with_note(format!(
            "its own c_r: for each held-out world, the one under which the answers in the other worlds are most probable, of 25 from a sixteenth to 16 times {risk_weight} m. Best first by the own posterior with it."
        ))
}

fn of_held_out(rows: &[HeldOut]) -> Table {
    let score = |score: Option<Score>| score.map_or("-".to_owned(), shown_score);
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

/// The population inferred from mean answers.
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
    format!("{}{scaled}\n{}", table_with_notes(&population_table(&means.population)), table_with_notes(&rows))
}

/// The answers that were scaled.
fn scaled(answers: &Answers) -> String {
    let line = |(participant, world, sum): &(String, String, f64)| {
        format!("The answer of `{participant}` in {world} summed to {sum} %: scaled to 100 %.\n")
    };
    answers.scaled.iter().map(line).collect()
}

/// Sentences about answers that were scaled or left out.
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
